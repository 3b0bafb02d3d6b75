#include "builder/resample/grid/placed_source.h"

#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <string>

namespace vt::resample {
namespace {

// A new number whenever the same samples on the layer's own grid would become other texels: blocks built by
// older rules are then built again.
constexpr std::int64_t kRules = 1;

// Numbers in a fixed byte order, so that every machine comes to the same hash.
class Mark {
 public:
  void add(std::int64_t value) {
    for (int shift = 0; shift < 64; shift += 8) bytes_.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> shift & 0xFF));
  }
  void add(double value) { add(std::bit_cast<std::int64_t>(value)); }
  void add(const std::string& text) {
    add(static_cast<std::int64_t>(text.size()));
    bytes_ += text;
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

 private:
  std::string bytes_;
};

void add_layout(const channels::SampleLayout& layout, Mark& mark) {
  mark.add(static_cast<std::int64_t>(layout.type));
  mark.add(std::int64_t{layout.value_bands});
  mark.add(std::int64_t{layout.has_alpha ? 1 : 0});
  mark.add(std::int64_t{layout.nodata ? 1 : 0});
  mark.add(layout.nodata ? layout.nodata->of(0) : 0.0);
  mark.add(std::int64_t{layout.range ? 1 : 0});
  for (const double edge : layout.range.value_or(std::array<double, 2>{})) mark.add(edge);
  // What most layouts do not have leaves their marks as they always were.
  const auto add_if = [&](const char* name, const std::optional<double>& value) {
    if (!value) return;
    mark.add(std::string(name));
    mark.add(*value);
  };
  const bool has_fraction = layout.nodata && layout.nodata->of(0) != std::trunc(layout.nodata->of(0));
  if (has_fraction && !is_floating_point(layout.type)) mark.add(std::string("nodata without its fraction"));
  if (layout.nodata && is_floating_point(layout.type)) mark.add(std::string("nodata within a few steps of a float"));
  if (layout.nodata && layout.nodata->values().size() > 1)
    for (const double value : layout.nodata->values()) add_if("nodata", value);
  add_if("full value", layout.value_full_scale);
  add_if("full alpha", layout.alpha_full_scale);
  add_if("scale", layout.scale);
  add_if("offset", layout.offset);
  if (!layout.unit.empty()) {
    mark.add(std::string("unit"));
    mark.add(layout.unit);
  }
}

// What a window of a compressed file adds are the blocks that it touches: only together with its place do
// they say which samples are meant.
void add_window(const source::Window& window, store::ContentHasher& content) {
  Mark mark;
  for (const std::int64_t number : {window.x, window.y, window.width, window.height}) mark.add(number);
  content.add(mark.bytes());
}

}  // namespace

std::string_view method_name(Method method) { return method == Method::kNearest ? "nearest" : "bilinear"; }

std::optional<Method> method_from_name(std::string_view name) {
  for (const Method method : {Method::kBilinear, Method::kNearest})
    if (method_name(method) == name) return method;
  return std::nullopt;
}

bool PlacedSource::is_opaque() const {
  const bool may_be_nan = layout.type == SampleType::kFloat32 || layout.type == SampleType::kFloat64;
  return !may_be_nan && !layout.has_alpha && !layout.nodata;
}

Result<void> PlacedSource::read(const source::Window& window, std::span<std::byte> out, std::size_t row_pitch_bytes,
                                store::ContentHasher* content) const {
  if (content != nullptr) add_window(window, *content);
  return raster->read(window, bands, out, row_pitch_bytes, content);
}

Result<void> PlacedSource::hash(const source::Window& window, store::ContentHasher& content) const {
  add_window(window, content);
  return raster->hash(window, bands, content);
}

void add_mark(const PlacedSource& source, const TexelRect& part, const TexelRect& window, store::ContentHasher& content) {
  Mark mark;
  mark.add(kRules);
  mark.add(static_cast<std::int64_t>(source.bands.size()));
  for (const int band : source.bands) mark.add(std::int64_t{band});
  add_layout(source.layout, mark);
  for (const std::int64_t edge : {part.x - window.x, part.y - window.y, part.width, part.height}) mark.add(edge);
  mark.add(std::int64_t{1});  // the samples are not moved
  content.add(mark.bytes());
}

void add_warp_mark(const GridWarp& warp, Method method, const TexelRect& part, store::ContentHasher& content) {
  Mark mark;
  mark.add(std::int64_t{kWarpRules});
  // The lattice of the warp is fixed to the layer's grid.
  for (const std::int64_t edge : {part.x, part.y, part.width, part.height}) mark.add(edge);
  mark.add(warp.facts());
  mark.add(static_cast<std::int64_t>(method));
  content.add(mark.bytes());
}

}  // namespace vt::resample
