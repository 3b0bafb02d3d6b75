#include "tools/vtinspect/mosaic.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "tools/pictures/picture_writer.h"
#include "tools/vtinspect/display.h"
#include "tools/vtinspect/layer_values.h"

namespace vt::inspect {

namespace {

constexpr std::int64_t kCell = 512;  // texels along the longer side of a cell
constexpr std::int64_t kGap = 1;
using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb kBackground = {119, 119, 119};  // 18 % grey in sRGB: neither darkens nor brightens what lies on it
constexpr Rgb kGapColor = {70, 70, 70};

// What one cell shows.
struct Cell {
  TexelRect shown;  // in the level's padded square
  std::int64_t enlarge = 1;
  std::vector<float> values;             // interleaved, 0..255 for byte formats
  std::vector<std::uint8_t> is_present;  // per texel
};

Result<Cell> read_cell(const store::StoreReader& reader, const LayerInfo& layer, Level level, std::int64_t cell_width,
                       std::int64_t cell_height) {
  const TexelRect data = layer.data_rect(level);
  Cell cell;
  cell.shown = {data.x, data.y, std::min(data.width, cell_width), std::min(data.height, cell_height)};
  // The middle texels of all levels lie over the same place on the ground.
  cell.shown.x += (data.width - cell.shown.width) / 2;
  cell.shown.y += (data.height - cell.shown.height) / 2;
  cell.enlarge = std::max<std::int64_t>(1, std::min(cell_width / cell.shown.width, cell_height / cell.shown.height));

  const TexelLayout layout = layout_of(layer);
  const auto count = static_cast<std::size_t>(cell.shown.width * cell.shown.height);
  const std::size_t samples = count * static_cast<std::size_t>(layout.channels);
  std::vector<std::byte> texels(count * layout.texel_bytes());
  cell.is_present.resize(count);
  cell.values.resize(samples);
  VT_CHECK(LevelReader(reader, layer, level).read(cell.shown, texels, cell.is_present));
  if (layout.is_float) {
    std::memcpy(cell.values.data(), texels.data(), texels.size());
  } else {
    for (std::size_t i = 0; i < samples; ++i) cell.values[i] = static_cast<float>(std::to_integer<int>(texels[i]));
  }
  return cell;
}

// One range for all cells, so that levels can be compared.
ValueRange range_of(const std::vector<Cell>& cells, const LayerInfo& layer, const Display& display) {
  if (display.fixed_range()) return *display.fixed_range();
  const auto channels = static_cast<std::size_t>(layout_of(layer).channels);
  RangeFinder finder(layer);
  for (const Cell& cell : cells)
    for (std::size_t at = 0; at < cell.values.size(); at += channels)
      finder.add(std::span<const float>(display.shown(std::span(cell.values).subspan(at, channels))).first(display.channels_with_values()));
  return finder.range();
}

Rgb color_of(const LayerInfo& layer, const Cell& cell, std::size_t texel, const Display& display, const ValueRange& range) {
  const auto channels = static_cast<std::size_t>(layout_of(layer).channels);
  if (cell.is_present[texel] == 0) return kBackground;
  const std::span<const float> values = std::span(cell.values).subspan(texel * channels, channels);
  const bool is_float = layout_of(layer).is_float;
  const float coverage = has_coverage_channel(layer) ? values[3] / (is_float ? 1.0F : 255.0F) : 1.0F;
  const std::array<float, 3> seen = display.shown(values);
  Rgb color = kBackground;
  for (std::size_t i = 0; i < color.size(); ++i) {
    const float value = seen[display.channels() == 1 ? 0 : i];
    if (!std::isfinite(value)) return kBackground;
    const float over = display.tone(value, range) * coverage + static_cast<float>(kBackground[i]) * (1.0F - coverage);
    color[i] = static_cast<std::uint8_t>(std::lround(over));
  }
  return color;
}

}  // namespace

Result<std::string> write_mosaic(const store::StoreReader& reader, const LayerInfo& layer, const std::filesystem::path& output) {
  // All cells have the shape of the data, so that whole levels fill theirs.
  const auto longer = static_cast<double>(std::max(layer.data.width, layer.data.height));
  const auto side = [&](std::int64_t texels) {
    return std::max<std::int64_t>(1, std::llround(static_cast<double>(kCell) * static_cast<double>(texels) / longer));
  };
  const std::int64_t cell_width = side(layer.data.width);
  const std::int64_t cell_height = side(layer.data.height);

  std::vector<Cell> cells;
  for (int value = 0; value <= layer.finest.value; ++value) {
    VT_ASSIGN(Cell cell, read_cell(reader, layer, Level{static_cast<std::uint8_t>(value)}, cell_width, cell_height));
    cells.push_back(std::move(cell));
  }
  const Display display(layer);
  const ValueRange range = range_of(cells, layer, display);

  const auto count = static_cast<std::int64_t>(cells.size());
  // About twice as wide as high, then no wider than that many rows need.
  const double square = std::sqrt(2.0 * static_cast<double>(count * cell_height) / static_cast<double>(cell_width));
  const auto widest = std::clamp<std::int64_t>(std::llround(std::ceil(square)), 1, count);
  const std::int64_t rows = (count + widest - 1) / widest;
  const std::int64_t columns = (count + rows - 1) / rows;

  cli::PictureSpec spec;
  spec.width = kGap + columns * (cell_width + kGap);
  spec.height = kGap + rows * (cell_height + kGap);
  spec.channels = 3;
  spec.is_srgb = layer.transfer == Transfer::kSrgb;
  std::vector<std::byte> sheet(static_cast<std::size_t>(spec.width * spec.height * 3));
  const auto put = [&](std::int64_t x, std::int64_t y, const Rgb& color) {
    std::memcpy(&sheet[static_cast<std::size_t>((y * spec.width + x) * 3)], color.data(), color.size());
  };
  for (std::int64_t y = 0; y < spec.height; ++y) {
    for (std::int64_t x = 0; x < spec.width; ++x) {
      const bool is_gap = x % (cell_width + kGap) < kGap || y % (cell_height + kGap) < kGap;
      put(x, y, is_gap ? kGapColor : kBackground);
    }
  }

  int whole = 0;
  for (std::int64_t index = 0; index < count; ++index) {
    const Cell& cell = cells[static_cast<std::size_t>(index)];
    const std::int64_t width = cell.shown.width * cell.enlarge;
    const std::int64_t height = cell.shown.height * cell.enlarge;
    const std::int64_t left = kGap + (index % columns) * (cell_width + kGap) + (cell_width - width) / 2;
    const std::int64_t top = kGap + (index / columns) * (cell_height + kGap) + (cell_height - height) / 2;
    for (std::int64_t y = 0; y < height; ++y) {
      for (std::int64_t x = 0; x < width; ++x) {
        const auto texel = static_cast<std::size_t>(y / cell.enlarge * cell.shown.width + x / cell.enlarge);
        put(left + x, top + y, color_of(layer, cell, texel, display, range));
      }
    }
    const TexelRect data = layer.data_rect(Level{static_cast<std::uint8_t>(index)});
    whole += cell.shown == data ? 1 : 0;
  }

  VT_ASSIGN(const auto picture, cli::create_picture(output, spec));
  VT_CHECK(picture->write_rows(sheet, spec.height));
  VT_CHECK(picture->finish());
  std::string text = fmt::format("levels 0 to {} of layer {}", int{layer.finest.value}, layer.name);
  if (whole < static_cast<int>(count)) text += fmt::format("; from level {} on, the middle {} x {} texels", whole, cell_width, cell_height);
  if (layout_of(layer).is_float) text += fmt::format("; {:g} is black, {:g} white", range.min, range.max);
  return text;
}

}  // namespace vt::inspect
