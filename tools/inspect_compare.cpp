#include "tools/inspect_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <vector>

#include "builder/channels/nodata.h"
#include "builder/channels/read_samples.h"
#include "builder/source/raster_source.h"
#include "store/sample_type.h"
#include "store/store_reader.h"
#include "store/vt_mapping.h"
#include "tools/inspect_common.h"
#include "tools/open_store.h"

namespace vt::inspect {

namespace {

// Differences of samples, gathered one pair at a time. Sums are doubles: a level of 10^10 samples still has six good digits.
class ErrorStatistics {
 public:
  void add(double a, double b) {
    const double error = std::abs(a - b);
    max_ = std::max(max_, error);
    sum_ += error;
    sum_of_squares_ += error * error;
    ++count_;
  }
  void add_equal(std::uint64_t count) { count_ += count; }

  [[nodiscard]] double max() const { return max_; }
  [[nodiscard]] double mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }
  [[nodiscard]] double rms() const { return count_ == 0 ? 0.0 : std::sqrt(sum_of_squares_ / static_cast<double>(count_)); }
  // Decibels; nothing when there is no error at all.
  [[nodiscard]] std::optional<double> psnr(double peak) const {
    if (rms() == 0.0) return std::nullopt;
    return 20.0 * std::log10(peak / rms());
  }

 private:
  std::uint64_t count_ = 0;
  double max_ = 0.0;
  double sum_ = 0.0;
  double sum_of_squares_ = 0.0;
};

struct LevelDifference {
  int level = 0;
  std::uint64_t tiles = 0;  // present on either side
  std::uint64_t differing_tiles = 0;
  std::uint64_t only_in_first = 0;
  std::uint64_t only_in_second = 0;
  std::uint64_t hole_mismatches = 0;  // samples that are a number on one side only
  ErrorStatistics values;             // codes, or the layer's unit
  ErrorStatistics linear;             // linear light, for sRGB layers

  [[nodiscard]] bool is_equal() const { return differing_tiles == 0 && only_in_first == 0 && only_in_second == 0; }
  [[nodiscard]] bool is_within(double tolerance) const {
    return only_in_first == 0 && only_in_second == 0 && hole_mismatches == 0 && values.max() <= tolerance;
  }
};

struct LayerDifference {
  std::string name;
  bool is_byte_format = false;
  bool is_srgb = false;
  std::vector<LevelDifference> levels;
};

struct Comparison {
  std::vector<std::string> mismatches;  // what makes tiles incomparable, or is not in both
  std::vector<LayerDifference> layers;

  [[nodiscard]] bool is_equal() const {
    return mismatches.empty() && std::all_of(layers.begin(), layers.end(), [](const LayerDifference& layer) {
             return std::all_of(layer.levels.begin(), layer.levels.end(), [](const LevelDifference& level) { return level.is_equal(); });
           });
  }
  [[nodiscard]] bool is_within(double tolerance) const {
    return mismatches.empty() && std::all_of(layers.begin(), layers.end(), [&](const LayerDifference& layer) {
             return std::all_of(layer.levels.begin(), layer.levels.end(),
                                [&](const LevelDifference& level) { return level.is_within(tolerance); });
           });
  }
};

double sample_at(std::span<const std::byte> texels, std::size_t index, bool is_float) {
  if (!is_float) return std::to_integer<int>(texels[index]);
  float value = 0.0F;
  std::memcpy(&value, &texels[index * sizeof value], sizeof value);
  return double{value};
}

// One sample of both sides. Two holes are equal.
void add_pair(LevelDifference& difference, double a, double b, bool is_srgb_code) {
  if (std::isnan(a) && std::isnan(b)) return;
  if (std::isnan(a) != std::isnan(b)) {
    ++difference.hole_mismatches;
    return;
  }
  // Equal infinities have no difference, and their subtraction is no number.
  if (a == b) {
    difference.values.add_equal(1);
  } else {
    difference.values.add(a, b);
  }
  if (is_srgb_code) {
    const auto& light = linear_from_srgb();
    difference.linear.add(light[static_cast<std::size_t>(a)], light[static_cast<std::size_t>(b)]);
  }
}

// Why tiles of the two layers cannot be held side by side; "" when they can.
std::string grid_mismatch(const LayerInfo& a, const LayerInfo& b) {
  if (a.channel != b.channel) {
    return fmt::format("layer {}: channel {} and {}", a.name, channel_info(a.channel).name, channel_info(b.channel).name);
  }
  if (a.format != b.format) {
    return fmt::format("layer {}: format {} and {}", a.name, format_info(a.format).name, format_info(b.format).name);
  }
  if (a.transfer != b.transfer) {
    return fmt::format("layer {}: transfer {} and {}", a.name, transfer_name(a.transfer), transfer_name(b.transfer));
  }
  if (a.tile_exponent != b.tile_exponent) return fmt::format("layer {}: tiles of {} and {}", a.name, a.tile_texels(), b.tile_texels());
  if (a.finest != b.finest) return fmt::format("layer {}: finest level {} and {}", a.name, int{a.finest.value}, int{b.finest.value});
  if (a.data != b.data) {
    return fmt::format("layer {}: data {} x {} at {},{} and {} x {} at {},{}", a.name, a.data.width, a.data.height, a.data.x, a.data.y,
                       b.data.width, b.data.height, b.data.x, b.data.y);
  }
  if (a.grid != b.grid) {
    return fmt::format("layer {}: grid origin {}, {} step {}, {} and origin {}, {} step {}, {}", a.name, cli::format_exact(a.grid.origin_x),
                       cli::format_exact(a.grid.origin_y), cli::format_exact(a.grid.step_x), cli::format_exact(a.grid.step_y),
                       cli::format_exact(b.grid.origin_x), cli::format_exact(b.grid.origin_y), cli::format_exact(b.grid.step_x),
                       cli::format_exact(b.grid.step_y));
  }
  if (a.components != b.components || a.zero_is_nodata != b.zero_is_nodata)
    return fmt::format("layer {}: its samples are not worth the same (component ranges)", a.name);
  return "";
}

// Two layers on one grid.
class LayerComparer {
 public:
  LayerComparer(const store::StoreReader& first, const LayerInfo& a, const store::StoreReader& second, const LayerInfo& b)
      : first_(first),
        second_(second),
        a_(a),
        b_(b),
        layout_(layout_of(a)),
        payload_a_(a.tile_payload_bytes()),
        payload_b_(payload_a_.size()),
        texels_a_(std::size_t{a.tile_texels()} * a.tile_texels() * layout_.texel_bytes()),
        texels_b_(texels_a_.size()) {}

  [[nodiscard]] Result<LevelDifference> compare(Level level, cli::Progress& progress, std::uint64_t& tiles_done) {
    LevelDifference difference;
    difference.level = level.value;
    const TexelRect tiles = a_.tile_rect(level);
    for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y) {
      if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "compare: stopped");
      for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
        VT_CHECK(compare_tile({level, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)}, difference));
        progress.update(++tiles_done);
      }
    }
    return difference;
  }

 private:
  [[nodiscard]] Result<void> compare_tile(TileId tile, LevelDifference& difference) {
    VT_ASSIGN(const store::TileLookup in_first, first_.lookup(a_.id, tile));
    VT_ASSIGN(const store::TileLookup in_second, second_.lookup(b_.id, tile));
    const bool has_first = in_first.kind != store::TileKind::kAbsent;
    const bool has_second = in_second.kind != store::TileKind::kAbsent;
    if (!has_first && !has_second) return {};
    ++difference.tiles;
    if (has_first != has_second) {
      ++(has_first ? difference.only_in_first : difference.only_in_second);
      return {};
    }
    if (a_.holds_blobs()) {
      VT_CHECK(first_.read_blob(a_.id, tile, payload_a_));
      VT_CHECK(second_.read_blob(b_.id, tile, payload_b_));
      difference.differing_tiles += payload_a_ == payload_b_ ? 0 : 1;
      return {};
    }
    VT_CHECK(first_.read(a_.id, tile, payload_a_));
    VT_CHECK(second_.read(b_.id, tile, payload_b_));
    add_texels(tile, payload_a_ == payload_b_, difference);
    return {};
  }

  void add_texels(TileId tile, bool is_equal, LevelDifference& difference) {
    const TexelRect place = rect_of(tile, a_.tile_exponent);
    const TexelRect part = intersect(place, a_.data_rect(tile.level));
    const bool is_srgb = a_.transfer == Transfer::kSrgb && !layout_.is_float;
    if (is_equal) {
      const auto texels = static_cast<std::uint64_t>(part.width * part.height);
      difference.values.add_equal(texels * static_cast<std::uint64_t>(layout_.channels));
      if (is_srgb) difference.linear.add_equal(texels * 3);
      return;
    }
    ++difference.differing_tiles;
    decode_tile(a_, payload_a_, texels_a_);
    decode_tile(b_, payload_b_, texels_b_);
    const auto channels = static_cast<std::size_t>(layout_.channels);
    for (std::int64_t y = part.y - place.y; y < part.bottom() - place.y; ++y) {
      for (std::int64_t x = part.x - place.x; x < part.right() - place.x; ++x) {
        const std::size_t at = static_cast<std::size_t>(y * place.width + x) * channels;
        for (std::size_t channel = 0; channel < channels; ++channel) {
          add_pair(difference, sample_at(texels_a_, at + channel, layout_.is_float), sample_at(texels_b_, at + channel, layout_.is_float),
                   is_srgb && channel < 3);
        }
      }
    }
  }

  const store::StoreReader& first_;
  const store::StoreReader& second_;
  const LayerInfo& a_;
  const LayerInfo& b_;
  TexelLayout layout_;
  std::vector<std::byte> payload_a_;
  std::vector<std::byte> payload_b_;
  std::vector<std::byte> texels_a_;
  std::vector<std::byte> texels_b_;
};

LayerDifference empty_difference(const LayerInfo& layer) {
  const bool is_byte_format = !layout_of(layer).is_float;
  return {layer.name, is_byte_format, is_byte_format && layer.transfer == Transfer::kSrgb, {}};
}

std::uint64_t tiles_of(const LayerInfo& layer) {
  std::uint64_t tiles = 0;
  for (int level = 0; level <= layer.finest.value; ++level) {
    const TexelRect rect = layer.tile_rect(Level{static_cast<std::uint8_t>(level)});
    tiles += static_cast<std::uint64_t>(rect.width) * static_cast<std::uint64_t>(rect.height);
  }
  return tiles;
}

Result<Comparison> compare_stores(const CompareOptions& options) {
  VT_ASSIGN(const store::StoreReader first, cli::open_store("vtinspect", options.first));
  VT_ASSIGN(const store::StoreReader second, cli::open_store("vtinspect", options.second));
  std::vector<const LayerInfo*> wanted;
  if (options.layer.empty()) {
    for (const LayerInfo& layer : first.layers()) {
      if (layer.role == LayerRole::kTexture || options.all) wanted.push_back(&layer);
    }
  } else {
    VT_ASSIGN(const LayerInfo* const layer, choose_layer(first, options.layer));
    wanted.push_back(layer);
  }

  Comparison comparison;
  if (first.description().area != second.description().area) comparison.mismatches.emplace_back("the areas differ");
  if (options.layer.empty()) {
    for (const LayerInfo& layer : second.layers()) {
      const bool counts = layer.role == LayerRole::kTexture || options.all;
      if (counts && first.find_layer(layer.name) == nullptr) {
        comparison.mismatches.push_back(fmt::format("layer {}: only in {}", layer.name, options.second.string()));
      }
    }
  }
  cli::Progress progress({.mode = options.progress, .title = "comparing", .unit = "tiles"});
  std::uint64_t total = 0;
  for (const LayerInfo* layer : wanted) total += tiles_of(*layer);
  progress.set_total(total);
  progress.update(0);
  std::uint64_t tiles_done = 0;
  for (const LayerInfo* layer : wanted) {
    const LayerInfo* const other = second.find_layer(layer->name);
    if (other == nullptr) {
      comparison.mismatches.push_back(fmt::format("layer {}: only in {}", layer->name, options.first.string()));
      continue;
    }
    if (std::string mismatch = grid_mismatch(*layer, *other); !mismatch.empty()) {
      comparison.mismatches.push_back(std::move(mismatch));
      continue;
    }
    LayerDifference difference = empty_difference(*layer);
    LayerComparer comparer(first, *layer, second, *other);
    for (int value = 0; value <= layer->finest.value; ++value) {
      VT_ASSIGN(LevelDifference level, comparer.compare(Level{static_cast<std::uint8_t>(value)}, progress, tiles_done));
      difference.levels.push_back(level);
    }
    comparison.layers.push_back(std::move(difference));
  }
  progress.finish();
  return comparison;
}

// Where the raster's first sample lies, counted in the layer's finest texels from the data's north-west corner. Nothing, with the reason in
// `problem`, when the raster's samples are not the layer's texels.
std::optional<TexelRect> raster_in_layer(const source::RasterInfo& raster, const LayerInfo& layer, const geo::Crs& crs,
                                         std::string& problem) {
  if (!raster.has_transform) {
    // Without a place, only the same size can mean the same texels.
    if (raster.width == layer.data.width && raster.height == layer.data.height) return TexelRect{0, 0, raster.width, raster.height};
    problem = fmt::format("the raster has no georeference and is {} x {}, the layer {} x {}", raster.width, raster.height, layer.data.width,
                          layer.data.height);
    return std::nullopt;
  }
  if (raster.crs && !raster.crs->same_coordinates(crs)) {
    problem = fmt::format("the raster is in {}, the store in {}", raster.crs->text(), crs.text());
    return std::nullopt;
  }
  const geo::GeoTransform& transform = raster.transform;
  const double column = (transform.x0 - layer.grid.origin_x) / layer.grid.step_x;
  const double row = (layer.grid.origin_y - transform.y0) / layer.grid.step_y;
  // The steps may differ by less than a thousandth of a texel over the whole raster, and the origins by as much.
  constexpr double kSlack = 1e-3;
  const bool same_steps = transform.is_north_up() &&
                          std::abs(transform.x_column / layer.grid.step_x - 1.0) * static_cast<double>(raster.width) <= kSlack &&
                          std::abs(-transform.y_row / layer.grid.step_y - 1.0) * static_cast<double>(raster.height) <= kSlack;
  constexpr double kFarthest = 1e15;  // beyond it a double has no whole numbers to spare
  if (!same_steps || !(std::abs(column) < kFarthest) || !(std::abs(row) < kFarthest) || std::abs(column - std::round(column)) > kSlack ||
      std::abs(row - std::round(row)) > kSlack) {
    problem =
        fmt::format("the raster's grid (origin {}, {} step {}, {}) is not the layer's (origin {}, {} step {}, {})",
                    cli::format_exact(transform.x0), cli::format_exact(transform.y0), cli::format_exact(transform.x_column),
                    cli::format_exact(-transform.y_row), cli::format_exact(layer.grid.origin_x), cli::format_exact(layer.grid.origin_y),
                    cli::format_exact(layer.grid.step_x), cli::format_exact(layer.grid.step_y));
    return std::nullopt;
  }
  return TexelRect{std::llround(column), std::llround(row), raster.width, raster.height};
}

class RasterComparer {
 public:
  RasterComparer(const store::StoreReader& reader, const LayerInfo& layer, const source::RasterSource& raster)
      : layer_(layer), raster_(raster), layout_(layout_of(layer)), level_(reader, layer, layer.finest) {}

  // `overlap` is in texels from the data's corner, `raster_at` is where the raster's first sample lies in the same terms.
  [[nodiscard]] Result<LevelDifference> compare(const TexelRect& overlap, const TexelRect& raster_at, cli::Progress& progress) {
    LevelDifference difference;
    difference.level = layer_.finest.value;
    const std::int64_t tile = layer_.tile_texels();
    // Blocks are the layer's own tiles, so a block that differs is a tile that differs.
    const TexelRect place{layer_.data.x + overlap.x, layer_.data.y + overlap.y, overlap.width, overlap.height};
    const TexelRect tiles = coarser(place, layer_.tile_exponent);
    for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y) {
      if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "compare: stopped");
      for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
        VT_CHECK(compare_block(intersect({x * tile, y * tile, tile, tile}, place), raster_at, difference));
      }
      progress.update(static_cast<std::uint64_t>(std::min((y + 1) * tile, place.bottom()) - place.y));
    }
    return difference;
  }

 private:
  [[nodiscard]] Result<void> compare_block(const TexelRect& block, const TexelRect& raster_at, LevelDifference& difference) {
    const auto count = static_cast<std::size_t>(block.width * block.height);
    const auto channels = static_cast<std::size_t>(layout_.channels);
    texels_.resize(count * layout_.texel_bytes());
    is_present_.resize(count);
    VT_CHECK(level_.read(block, texels_, is_present_));

    const source::RasterInfo& info = raster_.info();
    const bool with_alpha = info.alpha_band >= 0;
    std::vector<int> bands(channels);
    std::iota(bands.begin(), bands.end(), 0);
    if (with_alpha) bands.push_back(info.alpha_band);
    const std::size_t sample_size = sample_bytes(info.sample_type);
    samples_.resize(count * bands.size() * sample_size);
    const source::Window window{block.x - layer_.data.x - raster_at.x, block.y - layer_.data.y - raster_at.y, block.width, block.height};
    VT_CHECK(raster_.read(window, bands, samples_, static_cast<std::size_t>(block.width) * bands.size() * sample_size));

    ++difference.tiles;
    LevelDifference in_block;
    for (std::size_t texel = 0; texel < count; ++texel) add_texel(texel, bands.size(), with_alpha, in_block, difference);
    if (in_block.values.max() > 0.0 || in_block.hole_mismatches > 0) ++difference.differing_tiles;
    return {};
  }

  void add_texel(std::size_t texel, std::size_t bands, bool with_alpha, LevelDifference& in_block, LevelDifference& difference) {
    const auto channels = static_cast<std::size_t>(layout_.channels);
    const source::RasterInfo& info = raster_.info();
    const std::size_t sample_size = sample_bytes(info.sample_type);
    const auto raster_value = [&](std::size_t band) {
      return channels::read_sample(info.sample_type, &samples_[(texel * bands + band) * sample_size]);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    // Where there is no measurement a value means nothing, so neither side's is looked at.
    const bool raster_has = !with_alpha || raster_value(bands - 1) > 0.0;
    const bool store_has =
        is_present_[texel] != 0 && (!has_coverage_channel(layer_) || std::to_integer<int>(texels_[texel * channels + 3]) > 0);
    for (std::size_t channel = 0; channel < channels; ++channel) {
      const double stored = store_has ? sample_at(texels_, texel * channels + channel, layout_.is_float) : nan;
      double given = raster_has ? raster_value(channel) : nan;
      const auto& nodata = info.meaning[channel].nodata;
      if (nodata && channels::nodata_range(info.sample_type, *nodata).contains(given)) given = nan;
      // Byte formats without coverage have no way to say "no data", so a hole in the raster is compared with nothing.
      if (std::isnan(given) && !layout_.is_float && !has_coverage_channel(layer_)) continue;
      const bool is_light = layer_.transfer == Transfer::kSrgb && !layout_.is_float && channel < 3 && given >= 0.0 && given <= 255.0;
      add_pair(in_block, stored, given, false);
      add_pair(difference, stored, given, is_light);
    }
  }

  const LayerInfo& layer_;
  const source::RasterSource& raster_;
  TexelLayout layout_;
  LevelReader level_;
  std::vector<std::byte> texels_;
  std::vector<std::uint8_t> is_present_;
  std::vector<std::byte> samples_;
};

Result<Comparison> compare_with_raster(const CompareOptions& options) {
  VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtinspect", options.first));
  VT_ASSIGN(const LayerInfo* const layer, choose_layer(reader, options.layer));
  VT_ASSIGN(const geo::Crs crs, crs_of(reader));
  VT_ASSIGN(const std::unique_ptr<source::RasterSource> raster, source::open_raster(options.second));
  const source::RasterInfo& info = raster->info();

  Comparison comparison;
  const TexelLayout layout = layout_of(*layer);
  if (info.bands < layout.channels) {
    comparison.mismatches.push_back(
        fmt::format("the raster has {} bands, layer {} has {} channels", info.bands, layer->name, layout.channels));
    return comparison;
  }
  std::string problem;
  const auto raster_at = raster_in_layer(info, *layer, crs, problem);
  if (!raster_at) {
    comparison.mismatches.push_back(problem);
    return comparison;
  }
  const TexelRect overlap = intersect(*raster_at, {0, 0, layer->data.width, layer->data.height});
  if (overlap.empty()) {
    comparison.mismatches.emplace_back("the raster and the layer do not overlap");
    return comparison;
  }
  LayerDifference difference = empty_difference(*layer);
  cli::Progress progress(
      {.mode = options.progress, .title = "comparing", .unit = "rows", .total = static_cast<std::uint64_t>(overlap.height)});
  progress.update(0);
  VT_ASSIGN(LevelDifference level, RasterComparer(reader, *layer, *raster).compare(overlap, *raster_at, progress));
  progress.finish();
  difference.levels.push_back(level);
  comparison.layers.push_back(std::move(difference));
  return comparison;
}

nlohmann::ordered_json number_or_null(const std::optional<double>& number) {
  return number ? nlohmann::ordered_json(*number) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json to_json(const CompareOptions& options, const Comparison& comparison) {
  nlohmann::ordered_json json = {
      {"first", options.first.string()},
      {"second", options.second.string()},
      {"equal", comparison.is_equal()},
      {"tolerance", options.tolerance},
      {"within_tolerance", comparison.is_within(options.tolerance)},
      {"mismatches", comparison.mismatches},
      {"layers", nlohmann::ordered_json::array()},
  };
  for (const LayerDifference& layer : comparison.layers) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelDifference& level : layer.levels) {
      levels.push_back({
          {"level", level.level},
          {"tiles", level.tiles},
          {"differing_tiles", level.differing_tiles},
          {"only_in_first", level.only_in_first},
          {"only_in_second", level.only_in_second},
          {"hole_mismatches", level.hole_mismatches},
          {"max_error", level.values.max()},
          {"mean_error", level.values.mean()},
          {"rms_error", level.values.rms()},
          {"psnr_codes_db", layer.is_byte_format ? number_or_null(level.values.psnr(255.0)) : nullptr},
          {"psnr_linear_db", layer.is_srgb ? number_or_null(level.linear.psnr(1.0)) : nullptr},
      });
    }
    json["layers"].push_back({{"name", layer.name}, {"levels", levels}});
  }
  return json;
}

std::string to_text(const CompareOptions& options, const Comparison& comparison) {
  std::string text;
  for (const std::string& mismatch : comparison.mismatches) text += mismatch + "\n";
  for (const LayerDifference& layer : comparison.layers) {
    const bool is_equal =
        std::all_of(layer.levels.begin(), layer.levels.end(), [](const LevelDifference& level) { return level.is_equal(); });
    if (is_equal) {
      text += fmt::format("layer {}: equal\n", layer.name);
      continue;
    }
    constexpr std::string_view kRow = "  {:>5} {:>9} {:>9} {:>9} {:>9} {:>9}  {:>12} {:>12} {:>12}  {:>10} {:>10}\n";
    text += fmt::format("layer {}:\n", layer.name);
    text += fmt::format(fmt::runtime(kRow), "level", "tiles", "differing", "only 1st", "only 2nd", "holes", "max error", "mean error",
                        "rms error", "PSNR codes", "PSNR light");
    for (const LevelDifference& level : layer.levels) {
      const auto decibels = [](bool applies, const std::optional<double>& psnr) {
        return !applies ? std::string("-") : psnr ? fmt::format("{:.2f} dB", *psnr) : std::string("no error");
      };
      text += fmt::format(fmt::runtime(kRow), level.level, level.tiles, level.differing_tiles, level.only_in_first, level.only_in_second,
                          level.hole_mismatches, fmt::format("{:.6g}", level.values.max()), fmt::format("{:.6g}", level.values.mean()),
                          fmt::format("{:.6g}", level.values.rms()), decibels(layer.is_byte_format, level.values.psnr(255.0)),
                          decibels(layer.is_srgb, level.linear.psnr(1.0)));
    }
  }
  if (comparison.is_equal()) {
    text += "equal\n";
  } else if (comparison.is_within(options.tolerance)) {
    text += fmt::format("different, but within the tolerance of {:g}\n", options.tolerance);
  } else {
    text += "different\n";
  }
  return text;
}

}  // namespace

Result<int> run_compare(const CompareOptions& options) {
  if (!(options.tolerance >= 0.0)) return fail(ErrorCode::kUsage, "compare: --tolerance must not be negative");
  const std::string suffix = options.second.extension().string();
  const bool with_raster = suffix == ".tif" || suffix == ".tiff";
  VT_ASSIGN(const Comparison comparison, with_raster ? compare_with_raster(options) : compare_stores(options));
  if (options.json) {
    cli::print_json(to_json(options, comparison));
  } else {
    cli::print(to_text(options, comparison));
  }
  return comparison.is_within(options.tolerance) ? 0 : cli::exit_code(ErrorCode::kInvalidData);
}

}  // namespace vt::inspect
