#include "builder/pyramid/plane_carry.h"

#include <string>

#include "store/codec/prediction.h"

namespace vt::pyramid {
namespace {

constexpr store::Prediction kGradient{.predictors = {store::Predictor::kGradient}};

store::TileShape shape_of_plane(std::size_t edge) {
  return {.samples = store::TileShape::Samples::kFloat32, .width = edge, .height = edge, .channels = 1};
}

}  // namespace

void pack_carry(std::span<const float> floats, std::size_t planes, std::size_t edge, std::vector<std::byte>& out) {
  const store::TileShape shape = shape_of_plane(edge);
  const std::span<const std::byte> raw = std::as_bytes(floats);
  out.resize(planes * shape.raw_bytes());
  for (std::size_t p = 0; p < planes; ++p)
    store::split_into_residuals(raw.subspan(p * shape.raw_bytes(), shape.raw_bytes()), shape, kGradient,
                                std::span(out).subspan(p * shape.raw_bytes(), shape.raw_bytes()));
}

Result<void> unpack_carry(std::span<const std::byte> bytes, std::size_t planes, std::size_t edge, std::span<float> floats) {
  const store::TileShape shape = shape_of_plane(edge);
  if (bytes.size() != planes * shape.raw_bytes())
    return fail(ErrorCode::kCorrupt, "a tile of carry has " + std::to_string(bytes.size()) + " bytes, " +
                                         std::to_string(planes * shape.raw_bytes()) + " are right");
  const std::span<std::byte> raw = std::as_writable_bytes(floats);
  for (std::size_t p = 0; p < planes; ++p)
    store::join_residuals(bytes.subspan(p * shape.raw_bytes(), shape.raw_bytes()), shape, kGradient,
                          raw.subspan(p * shape.raw_bytes(), shape.raw_bytes()));
  return {};
}

}  // namespace vt::pyramid
