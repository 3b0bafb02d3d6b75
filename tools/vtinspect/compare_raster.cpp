// vtinspect compare of a layer's finest level with a raster. The raster is understood in one of two ways. As
// a *source*: its samples go the way of the layer's own sources, through the same channel, settings,
// resampling, format and block encoder, and what comes out is held against what is stored; so whatever the
// format loses is lost on both sides. As *values*: its samples are what the layer's texels are worth, as
// `extract` writes them. A raster that is equal in either way is equal; of one that is not, the way in which
// less differs is shown.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/pipeline/plan/planned_tile.h"
#include "builder/source/raster_source.h"
#include "builder/source/sample_type.h"
#include "builder/text/json_text.h"
#include "store/store_reader.h"
#include "store/texel/texel_decoder.h"
#include "tools/cli/open_store.h"
#include "tools/vtbuild/built_request.h"
#include "tools/vtinspect/comparison.h"

namespace vt::inspect {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// What both readings start from.
struct Sides {
  const CompareOptions& options;
  const store::StoreReader& reader;
  const LayerInfo& layer;
  const source::RasterInfo& raster;
  geo::Crs crs;
  // Where the raster's first sample lies in the layer, if its samples are the layer's texels; otherwise why
  // they are not.
  std::optional<TexelRect> raster_at;
  std::string off_grid;
};

// One way to understand the raster. kUnsupported and others: it does not apply, and why.
struct Finding {
  RasterReading reading;
  LevelDifference difference;
  std::string misfit;
  bool was_placed_so = false;  // a source of the layer lies in the very same place

  [[nodiscard]] std::uint64_t differing() const { return difference.differing_texels; }
};

// Where the raster's first sample lies, counted in the layer's finest texels from the data's north-west
// corner. Nothing, with the reason in `problem`, when the raster's samples are not the layer's texels.
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
  // The steps may differ by less than a thousandth of a texel over the whole raster, and the origins by as
  // much.
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

// Every tile of the finest level that has a part in `compared`, which counts from the data rectangle's
// corner.
template <class Visit>
Result<void> for_each_tile_in(const LayerInfo& layer, const TexelRect& compared, cli::ProgressMode mode, const Visit& visit) {
  const TexelRect place{layer.data.x + compared.x, layer.data.y + compared.y, compared.width, compared.height};
  const TexelRect tiles = coarser(place, layer.tile_exponent);
  const std::int64_t edge = layer.tile_texels();
  cli::Progress progress({.mode = mode, .title = "comparing", .unit = "rows", .total = static_cast<std::uint64_t>(compared.height)});
  progress.update(0);
  for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y) {
    for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
      if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "compare: stopped");
      const TileId tile{layer.finest, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
      VT_CHECK(visit(tile, intersect(rect_of(tile, layer.tile_exponent), place)));
    }
    progress.update(static_cast<std::uint64_t>(std::min((y + 1) * edge, place.bottom()) - place.y));
  }
  progress.finish();
  return {};
}

// Samples of a tile as decode_texels() gives them, and how texels without data are told from others.
class Samples {
 public:
  explicit Samples(const LayerInfo& layer)
      : layer_(layer),
        channels_(format_info(layer.format).channels),
        absent_(absent_texels(layer, layer.finest)),
        has_coverage_(has_coverage_channel(layer)),
        numbers_(std::size_t{layer.tile_texels()} * layer.tile_texels() * channels_) {
    const bool has_nan = nodata_sample(format_info(layer.format).samples) == NodataSample::kNan;
    says_void_ = layer.zero_is_nodata || absent_.code_of_none || has_coverage_ || (has_nan && std::isnan(absent_.value));
    // Absent tiles of bytes are worth 0, which is a colour only inside tiles.
    absent_is_void_ = !absent_.is_data && (absent_.code_of_none || std::isnan(absent_.value) || !layout_of(layer).is_float);
    for (std::size_t c = 0; c < channels_; ++c) {
      const ComponentRange& range = layer.components[c];
      of_absent_[c] = static_cast<float>((static_cast<double>(absent_.value) - range.offset) / range.scale);
    }
  }

  // A tile's payload; empty: there is none, and its texels are what those of one would be.
  void decode(std::span<const std::byte> payload) {
    is_absent_ = payload.empty();
    if (!is_absent_) store::decode_texels(layer_.format, payload, layer_.tile_texels(), layer_.tile_texels(), numbers_);
  }
  // The numbers of texel `at` of the tile.
  [[nodiscard]] const float* of(std::size_t at) const { return is_absent_ ? of_absent_.data() : &numbers_[at * channels_]; }
  [[nodiscard]] bool is_void(std::size_t at) const {
    if (is_absent_) return absent_is_void_;
    const float* samples = of(at);
    if (std::isnan(samples[0]) || (layer_.zero_is_nodata && samples[0] == 0.0F)) return true;
    if (absent_.code_of_none && static_cast<double>(samples[0]) == *absent_.code_of_none) return true;
    return has_coverage_ && samples[3] == 0.0F;
  }
  // Texels of the format can say that they are without data.
  [[nodiscard]] bool says_void() const { return says_void_; }
  // In the layer's unit, or codes where those are what the layer means.
  [[nodiscard]] double value(std::size_t at, std::size_t channel) const {
    const ComponentRange& range = layer_.components[channel];
    const double sample = of(at)[channel];
    return range == ComponentRange() ? sample : range.offset + range.scale * sample;
  }
  [[nodiscard]] std::size_t channels() const { return channels_; }

 private:
  const LayerInfo& layer_;
  std::size_t channels_;
  AbsentTexels absent_;
  bool has_coverage_;
  bool says_void_ = false;
  bool absent_is_void_ = true;
  std::array<float, 4> of_absent_{};
  std::vector<float> numbers_;
  bool is_absent_ = true;
};

// What would be stored of the raster against what is stored.
class SourceComparer {
 public:
  SourceComparer(const Sides& sides, const pipeline::LayerPlan& plan, std::size_t part)
      : sides_(sides),
        layer_(sides.layer),
        plan_(plan),
        part_(part),
        tiles_(plan, part),
        stored_(layer_),
        wanted_(layer_),
        payload_(layer_.tile_payload_bytes()),
        is_block_(format_info(layer_.format).block_edge > 1),
        is_class_(empty_difference(layer_).is_class),
        is_srgb_(empty_difference(layer_).is_srgb),
        is_zero_without_data_(channels::kind_of(layer_.channel).absent == channels::Absent::kZero) {
    for (const channels::Measure& measure : plan.codec->measures()) {
      is_measured_.push_back(measure.part == part);
      if (measure.part == part) finding_.difference.measured.push_back({measure.name, measure.unit, {}});
    }
    finding_.reading.as_source = true;
    finding_.difference.level = layer_.finest.value;
  }

  [[nodiscard]] Result<Finding> compare(const TexelRect& compared) {
    finding_.reading.compared = compared;
    VT_CHECK(for_each_tile_in(layer_, compared, sides_.options.progress,
                              [&](TileId tile, const TexelRect& part) { return compare_tile(tile, part); }));
    return std::move(finding_);
  }

 private:
  [[nodiscard]] Result<void> compare_tile(TileId tile, const TexelRect& part) {
    VT_CHECK(tiles_.make(tile, planned_));
    const auto read = sides_.reader.read(layer_.id, tile, payload_);
    if (!read && read.error().code != ErrorCode::kNotFound) return tl::unexpected(read.error());
    const bool is_there = read.has_value();
    if (!is_there && planned_.is_empty) return {};
    LevelDifference& difference = finding_.difference;
    ++difference.tiles;
    stored_.decode(is_there ? std::span<const std::byte>(payload_) : std::span<const std::byte>());
    wanted_.decode(planned_.payload);
    if (finding_.misfit.empty()) finding_.misfit = planned_.misfit;
    difference.texels += static_cast<std::uint64_t>(part.width * part.height);
    const std::uint64_t before = difference.differing_texels;
    const bool is_same = is_there && !planned_.is_empty && planned_.misfits.empty() && payload_ == planned_.payload;
    if (!is_same && is_block_) find_losses();
    const TexelRect place = rect_of(tile, layer_.tile_exponent);
    for (std::int64_t y = part.y; y < part.bottom(); ++y)
      for (std::int64_t x = part.x; x < part.right(); ++x) {
        const auto at = static_cast<std::size_t>((y - place.y) * place.width + (x - place.x));
        const auto in_data = static_cast<std::size_t>((y - planned_.rect.y) * planned_.rect.width + (x - planned_.rect.x));
        add_texel(at, in_data, is_same);
      }
    if (difference.differing_texels > before) ++difference.differing_tiles;
    return {};
  }

  void add_texel(std::size_t at, std::size_t in_data, bool is_same) {
    LevelDifference& difference = finding_.difference;
    if (!planned_.misfits.empty() && planned_.misfits[in_data] != 0) {
      ++difference.misfits;
      ++difference.differing_texels;
      return;
    }
    const bool has_raster = weight_of(in_data) > 0.0F;
    const bool stored_is_void = stored_.is_void(at);
    const bool wanted_is_void = wanted_.is_void(at);
    if (stored_is_void && wanted_is_void) return;
    // Where the format cannot say so, a texel without data shows something of its neighbours.
    if (!has_raster && !wanted_.says_void() && !is_zero_without_data_) return;
    if (stored_is_void != wanted_is_void) {
      ++(stored_is_void ? difference.data_only_in_second : difference.data_only_in_first);
      ++difference.differing_texels;
      return;
    }
    bool differs = false;
    for (std::size_t c = 0; c < stored_.channels(); ++c) {
      const double stored = stored_.value(at, c);
      const double wanted = wanted_.value(at, c);
      differs = differs || !(stored == wanted);
      add_pair(difference, stored, wanted, is_class_, is_srgb_ && c < 3);
    }
    if (differs && is_block_ && !is_same) differs = is_beyond_loss(at, in_data);
    difference.differing_texels += differs ? 1 : 0;
    if (has_raster)
      measure(stored_.of(at), in_data, [&](std::size_t m, const channels::ErrorSum& error) { difference.measured[m].error += error; });
  }

  [[nodiscard]] channels::ConstPlaneRow planes_of(std::size_t in_data) const {
    const auto width = static_cast<std::size_t>(planned_.rect.width);
    const auto planes = static_cast<std::size_t>(plan_.codec->planes());
    channels::ConstPlaneRow row{};
    for (std::size_t p = 0; p < planes; ++p) row[p] = &planned_.planes[(in_data / width * planes + p) * width + in_data % width];
    return row;
  }
  [[nodiscard]] float weight_of(std::size_t in_data) const {
    return *planes_of(in_data)[static_cast<std::size_t>(plan_.codec->weight_plane())];
  }

  // The channel's own errors of one texel's samples against the raster.
  template <class Take>
  void measure(const float* samples, std::size_t in_data, const Take& take) {
    sums_.assign(is_measured_.size(), {});
    plan_.codec->add_errors(part_, planes_of(in_data), samples, 1, sums_);
    std::size_t m = 0;
    for (std::size_t i = 0; i < sums_.size(); ++i)
      if (is_measured_[i]) take(m++, sums_[i]);
  }

  // For each texel of the planned tile, how much the format loses of it at most within its block: first
  // coverage, then each measure.
  void find_losses() {
    const auto width = static_cast<std::size_t>(planned_.rect.width);
    const auto height = static_cast<std::size_t>(planned_.rect.height);
    const std::size_t kinds = 1 + finding_.difference.measured.size();
    losses_.assign(width * height * kinds, 0.0);
    if (planned_.is_empty) return;
    const auto edge = static_cast<std::size_t>(layer_.tile_texels());
    const auto west = static_cast<std::size_t>(planned_.rect.x) & (edge - 1);
    const auto north = static_cast<std::size_t>(planned_.rect.y) & (edge - 1);
    const auto block = static_cast<std::size_t>(format_info(layer_.format).block_edge);
    std::vector<double> of_block(kinds * (edge / block) * (edge / block), 0.0);
    const auto block_of = [&](std::size_t in_data) {
      return ((north + in_data / width) / block * (edge / block) + (west + in_data % width) / block) * kinds;
    };
    for (std::size_t i = 0; i < width * height; ++i) {
      const float* samples = wanted_.of((north + i / width) * edge + west + i % width);
      double* most = &of_block[block_of(i)];
      most[0] = std::max(most[0], coverage_error(samples, i));
      if (weight_of(i) > 0.0F)
        measure(samples, i, [&](std::size_t m, const channels::ErrorSum& error) { most[1 + m] = std::max(most[1 + m], error.largest); });
    }
    for (std::size_t i = 0; i < width * height; ++i) std::copy_n(&of_block[block_of(i)], kinds, &losses_[i * kinds]);
  }

  [[nodiscard]] double coverage_error(const float* samples, std::size_t in_data) const {
    if (!has_coverage_channel(layer_)) return 0.0;
    return std::abs(static_cast<double>(samples[3]) - 255.0 * std::clamp(static_cast<double>(weight_of(in_data)), 0.0, 1.0));
  }

  // Blocks of another choice of colours can be as good. A texel is another one when it is more than twice as
  // far from the raster as what would be stored of it is at its block's worst texel.
  [[nodiscard]] bool is_beyond_loss(std::size_t at, std::size_t in_data) {
    constexpr double kTwice = 2.0;
    const std::size_t kinds = 1 + finding_.difference.measured.size();
    const double* loss = &losses_[in_data * kinds];
    bool is_beyond = coverage_error(stored_.of(at), in_data) > kTwice * loss[0];
    measure(stored_.of(at), in_data,
            [&](std::size_t m, const channels::ErrorSum& error) { is_beyond = is_beyond || error.largest > kTwice * loss[1 + m]; });
    return is_beyond;
  }

  const Sides& sides_;
  const LayerInfo& layer_;
  const pipeline::LayerPlan& plan_;
  std::size_t part_;
  pipeline::PlannedTiles tiles_;
  pipeline::PlannedTile planned_;
  Samples stored_;
  Samples wanted_;
  std::vector<std::byte> payload_;
  bool is_block_;
  bool is_class_;
  bool is_srgb_;
  bool is_zero_without_data_;      // what is not known is 0, as of masks and of light without coverage
  std::vector<bool> is_measured_;  // of the codec's measures, those of the part
  std::vector<channels::ErrorSum> sums_;
  std::vector<double> losses_;
  Finding finding_;
};

// The layer that the chosen one is a part of, or itself.
const LayerInfo& owner_of(const store::StoreReader& reader, const LayerInfo& layer) {
  const LayerInfo* owner = layer.is_part ? reader.find_layer(layer.owner) : &layer;
  return owner == nullptr ? layer : *owner;
}

// What the raster would be as the layer's only source. Where the layer's sources had bands chosen that this
// raster does not have, all of its own are taken; where a raster has no place but the layer's size, it gets
// the layer's place.
Result<pipeline::LayerPlan> plan_of_raster(const Sides& sides, const LayerInfo& owner) {
  const Area& area = sides.reader.description().area;
  auto known = tools::built_request(sides.reader, owner, {sides.crs, area}, sides.options.second);
  if (!known) return fail(ErrorCode::kUnsupported, known.error().message);  // the raster may hold values all the same
  pipeline::LayerRequest request = std::move(*known);
  pipeline::SourceRequest& source = request.sources.front();
  if (std::ranges::any_of(source.bands, [&](int band) { return band > sides.raster.bands; })) source.bands.clear();
  if (!sides.raster.has_transform && sides.raster_at) {
    const GridPlacement& grid = owner.grid;
    source.extent = Area{grid.origin_x, grid.origin_y - static_cast<double>(owner.data.height) * grid.step_y,
                         grid.origin_x + static_cast<double>(owner.data.width) * grid.step_x, grid.origin_y};
  }
  return pipeline::plan_layer(request, pipeline::DatasetFrame{sides.crs, area},
                              {.existing = &owner, .threads = 1, .scratch_folder = std::filesystem::temp_directory_path()});
}

// Two layers whose texels mean the same.
bool means_the_same(const LayerInfo& a, const LayerInfo& b) {
  return a.format == b.format && a.components == b.components && a.zero_is_nodata == b.zero_is_nodata;
}

// The sources in a layer's settings: a list, or what stands for a long one.
nlohmann::ordered_json sources_in(const nlohmann::ordered_json& settings) {
  return settings.is_object() && settings.contains("sources") ? settings["sources"] : nlohmann::ordered_json();
}

// The settings that the layer was built with; null when it does not have them.
nlohmann::ordered_json settings_of(const LayerInfo& owner) {
  const nlohmann::ordered_json metadata = text::json_or_null(owner.metadata_json);
  return metadata.is_object() && metadata.contains("settings") ? metadata["settings"] : nlohmann::ordered_json();
}

// A source of the layer lies exactly where the raster does, or there are more of them than its settings list.
bool was_placed_so(const nlohmann::ordered_json& of_layer, const nlohmann::ordered_json& of_raster) {
  const nlohmann::ordered_json sources = sources_in(of_layer);
  const nlohmann::ordered_json raster = sources_in(of_raster);
  if (!sources.is_array()) return sources.is_object();
  return std::ranges::any_of(sources, [&](const nlohmann::ordered_json& source) {
    return source.is_object() && source.contains("transform") && source["transform"] == raster[0]["transform"];
  });
}

std::size_t source_count(const nlohmann::ordered_json& of_layer) {
  const nlohmann::ordered_json sources = sources_in(of_layer);
  if (sources.is_array()) return sources.size();
  return sources.is_object() && sources.contains("count") && sources["count"].is_number_unsigned() ? sources["count"].get<std::size_t>()
                                                                                                   : 0;
}

Result<Finding> compare_as_source(const Sides& sides) {
  const LayerInfo& owner = owner_of(sides.reader, sides.layer);
  VT_ASSIGN(const pipeline::LayerPlan plan, plan_of_raster(sides, owner));
  const auto found = std::ranges::find(plan.parts, sides.layer.name, &LayerInfo::name);
  if (found == plan.parts.end())
    return fail(ErrorCode::kUnsupported, fmt::format("the raster would not make a layer {}", sides.layer.name));
  if (!means_the_same(*found, sides.layer))
    return fail(ErrorCode::kUnsupported, fmt::format("the raster's samples would be other codes than those of layer {}", sides.layer.name));
  const auto part = static_cast<std::size_t>(found - plan.parts.begin());
  if (plan.codec->parts()[part].starts_above_base)
    return fail(ErrorCode::kUnsupported, fmt::format("layer {} has nothing to compare at its finest level", sides.layer.name));
  const TexelRect compared = intersect(plan.covered, {0, 0, owner.data.width, owner.data.height});
  if (compared.empty()) return fail(ErrorCode::kNotFound, "the raster and the layer do not overlap");
  VT_ASSIGN(Finding finding, SourceComparer(sides, plan, part).compare(compared));
  finding.was_placed_so = was_placed_so(settings_of(owner), plan.settings);
  return finding;
}

// The raster's samples against the values of the layer's texels.
class ValueComparer {
 public:
  ValueComparer(const Sides& sides, const source::RasterSource& raster)
      : sides_(sides),
        layer_(sides.layer),
        raster_(raster),
        layout_(layout_of(layer_)),
        level_(sides.reader, layer_, layer_.finest),
        absent_(absent_texels(layer_, layer_.finest)),
        is_class_(empty_difference(layer_).is_class) {
    bands_.resize(static_cast<std::size_t>(layout_.channels));
    std::iota(bands_.begin(), bands_.end(), 0);
    if (raster.info().alpha_band >= 0) bands_.push_back(raster.info().alpha_band);
    finding_.difference.level = layer_.finest.value;
  }

  [[nodiscard]] Result<Finding> compare(const TexelRect& compared) {
    finding_.reading.compared = compared;
    VT_CHECK(
        for_each_tile_in(layer_, compared, sides_.options.progress, [&](TileId, const TexelRect& part) { return compare_block(part); }));
    return std::move(finding_);
  }

 private:
  [[nodiscard]] Result<void> compare_block(const TexelRect& block) {
    const auto count = static_cast<std::size_t>(block.width * block.height);
    texels_.resize(count * layout_.texel_bytes());
    is_present_.resize(count);
    VT_CHECK(level_.read(block, texels_, is_present_));
    const std::size_t pitch = bands_.size() * sample_bytes(raster_.info().sample_type);
    samples_.resize(count * pitch);
    const source::Window window{block.x - layer_.data.x - sides_.raster_at->x, block.y - layer_.data.y - sides_.raster_at->y, block.width,
                                block.height};
    VT_CHECK(raster_.read(window, bands_, samples_, static_cast<std::size_t>(block.width) * pitch));
    LevelDifference& difference = finding_.difference;
    ++difference.tiles;
    difference.texels += count;
    const std::uint64_t before = difference.differing_texels;
    for (std::size_t texel = 0; texel < count; ++texel) add_texel(texel);
    if (difference.differing_texels > before) ++difference.differing_tiles;
    return {};
  }

  // NaN where there are no data.
  [[nodiscard]] double stored(std::size_t texel, std::size_t channel) const {
    const auto channels = static_cast<std::size_t>(layout_.channels);
    const bool has_value = is_present_[texel] != 0 || (layout_.is_float && !absent_.code_of_none);
    if (!has_value) return kNone;
    if (has_coverage_channel(layer_) && sample_at(texels_, texel * channels + 3, layout_.is_float) == 0.0) return kNone;
    const double value = sample_at(texels_, texel * channels + channel, layout_.is_float);
    return absent_.code_of_none == value ? kNone : value;
  }
  [[nodiscard]] double given(std::size_t texel, std::size_t channel) const {
    const source::RasterInfo& info = raster_.info();
    const std::size_t size = sample_bytes(info.sample_type);
    const auto value = [&](std::size_t band) {
      return channels::read_sample(info.sample_type, &samples_[(texel * bands_.size() + band) * size]);
    };
    if (info.alpha_band >= 0 && !(value(bands_.size() - 1) > 0.0)) return kNone;
    const double sample = value(channel);
    const auto& nodata = info.meaning[channel].nodata;
    const bool is_none = (nodata && channels::nodata_range(info.sample_type, *nodata).contains(sample)) || absent_.code_of_none == sample;
    return is_none ? kNone : sample;
  }

  void add_texel(std::size_t texel) {
    LevelDifference& difference = finding_.difference;
    // Opaque colours have no way to say "no data", so a hole in the raster is compared with nothing there.
    const bool says_void = layout_.is_float || has_coverage_channel(layer_) || absent_.code_of_none || is_present_[texel] == 0;
    bool differs = false;
    bool only_stored = false;
    bool only_given = false;
    for (std::size_t channel = 0; channel < static_cast<std::size_t>(layout_.channels); ++channel) {
      const double a = stored(texel, channel);
      const double b = given(texel, channel);
      if (std::isnan(a) && std::isnan(b)) continue;
      if (std::isnan(b) && !says_void) continue;
      only_stored = only_stored || std::isnan(b);
      only_given = only_given || std::isnan(a);
      differs = differs || !(a == b);
      const bool is_light = layer_.transfer == Transfer::kSrgb && !layout_.is_float && channel < 3 && b >= 0.0 && b <= 255.0;
      if (!std::isnan(a) && !std::isnan(b)) add_pair(difference, a, b, is_class_, is_light);
    }
    difference.differing_texels += differs ? 1 : 0;
    difference.data_only_in_first += only_stored ? 1 : 0;
    difference.data_only_in_second += only_given && !only_stored ? 1 : 0;
  }

  const Sides& sides_;
  const LayerInfo& layer_;
  const source::RasterSource& raster_;
  TexelLayout layout_;
  LevelReader level_;
  AbsentTexels absent_;
  bool is_class_;
  std::vector<int> bands_;
  std::vector<std::byte> texels_;
  std::vector<std::uint8_t> is_present_;
  std::vector<std::byte> samples_;
  Finding finding_;
};

Result<Finding> compare_as_values(const Sides& sides, const source::RasterSource& raster) {
  const TexelLayout layout = layout_of(sides.layer);
  if (!sides.raster_at) return fail(ErrorCode::kUnsupported, sides.off_grid);
  if (sides.raster.bands < layout.channels)
    return fail(ErrorCode::kUnsupported,
                fmt::format("the raster has {} bands, layer {} has {} channels", sides.raster.bands, sides.layer.name, layout.channels));
  const TexelRect compared = intersect(*sides.raster_at, {0, 0, sides.layer.data.width, sides.layer.data.height});
  if (compared.empty()) return fail(ErrorCode::kNotFound, "the raster and the layer do not overlap");
  return ValueComparer(sides, raster).compare(compared);
}

// What a difference may come from.
void add_reasons(const Sides& sides, const Result<Finding>& as_source, const Finding& finding, Comparison& comparison) {
  if (!as_source) comparison.remarks.push_back("not compared as a source of the layer: " + as_source.error().message);
  if (finding.difference.misfits > 0)
    comparison.remarks.push_back(
        fmt::format("{} texels of the raster hold what the layer's format cannot: {}", finding.difference.misfits, finding.misfit));
  const std::size_t count = source_count(settings_of(owner_of(sides.reader, sides.layer)));
  if (count > 1)
    comparison.remarks.push_back(
        fmt::format("the layer has {} sources; where others lie over this one or beside it, its texels are theirs", count));
  if (sides.layer.state != LayerState::kComplete)
    comparison.remarks.push_back("the layer is not complete; what its build has not come to yet is absent");
}

}  // namespace

Result<Comparison> compare_with_raster(const CompareOptions& options) {
  VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtinspect", options.first));
  VT_ASSIGN(const LayerInfo* const layer, choose_layer(reader, options.layer));
  if (format_info(layer->format).samples == SampleKind::kOpaque || layer->role == LayerRole::kCarry)
    return fail(ErrorCode::kUsage,
                fmt::format("{}: layer {} holds no numbers that a raster could have", options.first.string(), layer->name));
  VT_ASSIGN(const geo::Crs crs, crs_of(reader));
  const source::OpenOptions open{.as_numbers = !channels::kind_of(layer->channel).reads_colors};
  VT_ASSIGN(const std::unique_ptr<source::RasterSource> raster, source::open_raster(options.second, open));
  Sides sides{options, reader, *layer, raster->info(), crs, std::nullopt, ""};
  sides.raster_at = raster_in_layer(raster->info(), *layer, crs, sides.off_grid);

  // What cannot be read, or was stopped, is no difference.
  const auto is_final = [](const Result<Finding>& finding) {
    if (finding) return false;
    const ErrorCode code = finding.error().code;
    return code == ErrorCode::kCancelled || code == ErrorCode::kIo || code == ErrorCode::kCorrupt || code == ErrorCode::kInternal;
  };
  auto as_source = compare_as_source(sides);
  if (is_final(as_source)) return tl::unexpected(as_source.error());
  const bool is_settled = as_source && as_source->differing() == 0;
  Result<Finding> as_values = fail(ErrorCode::kUnsupported, "");
  if (!is_settled) as_values = compare_as_values(sides, *raster);
  if (is_final(as_values)) return tl::unexpected(as_values.error());

  Comparison comparison;
  if (!as_source && !as_values) {
    comparison.mismatches.push_back(as_values.error().message);
    if (as_source.error().message != as_values.error().message) comparison.mismatches.push_back(as_source.error().message);
    return comparison;
  }
  const bool values_win = as_values && (!as_source || as_values->differing() < as_source->differing());
  Finding& finding = values_win ? *as_values : *as_source;
  if (!sides.raster_at && finding.was_placed_so)
    comparison.remarks.push_back(sides.off_grid + "; it was resampled, as the layer's source was that lies in the same place");
  else if (!sides.raster_at)
    comparison.mismatches.push_back(sides.off_grid +
                                    "; it was resampled as a build would, and no source of the layer lies in the same place");
  if (finding.differing() > 0) add_reasons(sides, as_source, finding, comparison);
  comparison.raster = finding.reading;
  LayerDifference difference = empty_difference(*layer);
  difference.levels.push_back(std::move(finding.difference));
  comparison.layers.push_back(std::move(difference));
  return comparison;
}

}  // namespace vt::inspect
