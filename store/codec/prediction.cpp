#include "store/codec/prediction.h"

#include <algorithm>
#include <cassert>

#include "store/codec/prediction_bytes.h"
#include "store/codec/prediction_choice.h"
#include "store/codec/prediction_words.h"

namespace vt::store {
namespace {

const std::uint8_t* bytes_of(std::span<const std::byte> bytes) { return reinterpret_cast<const std::uint8_t*>(bytes.data()); }
std::uint8_t* bytes_of(std::span<std::byte> bytes) { return reinterpret_cast<std::uint8_t*>(bytes.data()); }

TileShape::Samples samples_of(TexelFormat format) {
  switch (format_info(format).samples) {
    case SampleKind::kUnorm8:
      return TileShape::Samples::kUint8;
    case SampleKind::kUnorm16:
      return TileShape::Samples::kUint16;
    case SampleKind::kHalf:
      return TileShape::Samples::kFloat16;
    case SampleKind::kFloat:
      return TileShape::Samples::kFloat32;
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      return TileShape::Samples::kOpaque;
  }
  __builtin_unreachable();
}

}  // namespace

TileShape tile_shape(TexelFormat format, std::size_t edge_texels) {
  return {.samples = samples_of(format), .width = edge_texels, .height = edge_texels, .channels = format_info(format).channels};
}

Prediction choose_prediction(std::span<const std::byte> raw, const TileShape& shape) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes());
  if (shape.width < 2 || shape.height < 2) {
    // Nothing to sample, and next to nothing to gain.
    Prediction prediction;
    std::fill_n(prediction.predictors.begin(), shape.channels, Predictor::kAverage);
    return prediction;
  }
  switch (shape.samples) {
    case TileShape::Samples::kUint8:
      return choose_for_bytes(bytes_of(raw), shape);
    case TileShape::Samples::kUint16:
      return choose_for_words<std::uint16_t>(WordOrder::kInteger, bytes_of(raw), shape);
    case TileShape::Samples::kFloat16:
      return choose_for_words<std::uint16_t>(WordOrder::kFloat, bytes_of(raw), shape);
    case TileShape::Samples::kFloat32:
      return choose_for_words<std::uint32_t>(WordOrder::kFloat, bytes_of(raw), shape);
    case TileShape::Samples::kOpaque:
      break;
  }
  return {};
}

void split_into_residuals(std::span<const std::byte> raw, const TileShape& shape, const Prediction& prediction,
                          std::span<std::byte> planes) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes() && planes.size() == shape.raw_bytes());
  if (raw.empty()) return;
  switch (shape.samples) {
    case TileShape::Samples::kUint8:
      return split_bytes(bytes_of(raw), shape, prediction, bytes_of(planes));
    case TileShape::Samples::kUint16:
      return split_words<std::uint16_t>(WordOrder::kInteger, bytes_of(raw), shape, prediction, bytes_of(planes));
    case TileShape::Samples::kFloat16:
      return split_words<std::uint16_t>(WordOrder::kFloat, bytes_of(raw), shape, prediction, bytes_of(planes));
    case TileShape::Samples::kFloat32:
      return split_words<std::uint32_t>(WordOrder::kFloat, bytes_of(raw), shape, prediction, bytes_of(planes));
    case TileShape::Samples::kOpaque:
      break;
  }
}

void join_residuals(std::span<const std::byte> planes, const TileShape& shape, const Prediction& prediction, std::span<std::byte> raw) {
  assert(shape.is_predictable() && raw.size() == shape.raw_bytes() && planes.size() == shape.raw_bytes());
  if (raw.empty()) return;
  switch (shape.samples) {
    case TileShape::Samples::kUint8:
      return join_bytes(bytes_of(planes), shape, prediction, bytes_of(raw));
    case TileShape::Samples::kUint16:
      return join_words<std::uint16_t>(WordOrder::kInteger, bytes_of(planes), shape, prediction, bytes_of(raw));
    case TileShape::Samples::kFloat16:
      return join_words<std::uint16_t>(WordOrder::kFloat, bytes_of(planes), shape, prediction, bytes_of(raw));
    case TileShape::Samples::kFloat32:
      return join_words<std::uint32_t>(WordOrder::kFloat, bytes_of(planes), shape, prediction, bytes_of(raw));
    case TileShape::Samples::kOpaque:
      break;
  }
}

}  // namespace vt::store
