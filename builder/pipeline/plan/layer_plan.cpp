#include "builder/pipeline/plan/layer_plan.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <limits>

#include "builder/channels/all_channels.h"
#include "builder/channels/samples/wide_value.h"
#include "builder/pipeline/parallel/error_list.h"
#include "builder/pipeline/parallel/parallel.h"
#include "builder/pipeline/plan/build_state.h"
#include "builder/pipeline/plan/layer_kernel.h"
#include "builder/pipeline/sources/globe_turns.h"
#include "builder/pipeline/sources/layer_grid.h"
#include "builder/pipeline/sources/open_sources.h"
#include "builder/pipeline/sources/place_source.h"
#include "builder/pipeline/sources/plan_remarks.h"
#include "builder/pipeline/sources/sample_check.h"
#include "builder/pipeline/sources/source_facts.h"
#include "builder/pipeline/sources/stored_light.h"
#include "builder/pipeline/sources/stray_sources.h"
#include "builder/pipeline/sources/sure_cover.h"
#include "builder/pyramid/class_counts.h"
#include "builder/text/json_text.h"
#include "store/format/text.h"
#include "store/io/content_hash.h"
#include "store/io/hex.h"

namespace vt::pipeline {
namespace {

channels::ChannelSettings settings_for(const LayerRequest& request, const LayerInfo& info, bool samples_are_wide) {
  return {.channel = request.channel,
          .format = info.format,
          .transfer = info.transfer,
          .source_nodata = info.source_nodata,
          .samples_are_wide = samples_are_wide,
          .options = request.options};
}

// Numbers that the channel makes of such samples need more than floats.
bool needs_wide(const LayerRequest& request, const channels::SampleLayout& layout) {
  if (channels::kind_of(request.channel).find_option("input-scale") == nullptr) return channels::is_wide(layout.type);
  const auto given = [&](const char* name) {
    const auto number = channels::number_of(request.options, name, -1e300, 1e300);
    return number ? *number : std::nullopt;  // what is no number is refused later
  };
  return channels::is_wide(layout.type, given("input-scale").value_or(layout.scale.value_or(1.0)),
                           given("input-offset").value_or(layout.offset.value_or(0.0)));
}

// Two codecs whose blocks may lie in one layer.
bool writes_the_same(const channels::ChannelCodec& a, const channels::ChannelCodec& b) {
  const auto is_same = [](const channels::Part& x, const channels::Part& y) {
    return x.suffix == y.suffix && x.format == y.format && x.unit == y.unit && x.ranges == y.ranges && x.zero_is_nodata == y.zero_is_nodata;
  };
  return a.source_planes() == b.source_planes() && std::ranges::equal(a.rules(), b.rules()) &&
         std::ranges::equal(a.parts(), b.parts(), is_same);
}

// What the codec adds to a layer whose place and size are known: the meaning of its numbers, and the parts
// beside it.
void describe_parts(LayerPlan& plan) {
  for (const channels::Part& part : plan.codec->parts()) {
    LayerInfo info = plan.info;
    if (!part.suffix.empty()) {
      info.name += "/" + part.suffix;
      info.transfer = Transfer::kLinear;
    }
    info.is_point_sampled = plan.kernel.is_point && part.suffix.empty();  // what lies beside picked heights speaks of whole areas
    info.format = part.format;
    info.components = part.ranges;
    info.zero_is_nodata = part.zero_is_nodata;
    plan.parts.push_back(std::move(info));
  }
  plan.info = plan.parts.front();
}

// All of the layer but its place and size, and its format when the sources have a say in it. `first` is the
// first source's.
Result<LayerInfo> describe_layer(const LayerRequest& request, const channels::SampleLayout& first) {
  if (request.name.empty() || !store::is_plain_text(request.name))
    return fail(ErrorCode::kUsage, "a layer cannot be called \"" + request.name +
                                       "\": a name is UTF-8 without control characters and without characters that reorder text");
  LayerInfo info;
  info.name = request.name;
  info.channel = request.channel;
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  info.format = request.format.value_or(kind.usual_format(first.type, false));
  info.transfer = kind.transfer;
  if (request.tile_texels < 4 || request.tile_texels > 4096 || !std::has_single_bit(static_cast<unsigned>(request.tile_texels)))
    return fail(ErrorCode::kUsage, "tile size " + std::to_string(request.tile_texels) + " is not a power of two from 4 to 4096");
  info.tile_exponent = static_cast<std::uint8_t>(std::countr_zero(static_cast<unsigned>(request.tile_texels)));
  if (first.nodata && first.nodata->values().size() == 1) info.source_nodata = first.nodata->of(0);
  return info;
}

// Rasters with and without a place on the ground do not mix; a datum is never shifted silently.
Result<void> check_systems(const std::vector<OpenSource>& sources, const geo::Crs& crs, std::vector<std::string>& warnings) {
  Remarks datums("in another datum");
  for (const OpenSource& source : sources) {
    const bool has_place = source.crs.kind() != geo::CrsKind::kPixel;
    if (has_place != (crs.kind() != geo::CrsKind::kPixel))
      return fail(ErrorCode::kInvalidData, source.request.path.string() + ": is in " + source.crs.text() + ", the layer in " + crs.text() +
                                               "; pictures without a place on the ground do not mix with others");
    const geo::CrsDefinition& from = source.crs.definition();
    if (from.datum != crs.definition().datum)
      datums.add(source.request.path.string() + ": datum " + from.datum + " is taken as " + crs.definition().datum +
                 " without a shift, which can be off by metres");
  }
  datums.append_to(warnings);
  return {};
}

Result<void> check_frame(const LayerPlan& plan, const std::optional<DatasetFrame>& frame) {
  if (!frame || !frame->area) return {};
  const Area extent = plan.extent();
  if (extent.east > frame->area->west && extent.west < frame->area->east && extent.north > frame->area->south &&
      extent.south < frame->area->north)
    return {};
  return fail(ErrorCode::kInvalidData, "layer '" + plan.request.name + "' lies outside the store's area: " + area_text(extent) +
                                           ", the store's is " + area_text(*frame->area) + " (" + plan.crs.text() +
                                           "); check the source's coordinate system or choose another store");
}

std::string hash_of(std::string_view text) {
  store::ContentHasher hasher;
  hasher.add(std::as_bytes(std::span(text)));
  std::string digits;
  for (const std::byte byte : hasher.digest().bytes) digits += store::hex(std::to_integer<unsigned>(byte), 2);
  return digits;
}

// What a file holds decides; a hash says it in few bytes.
std::string option_in_settings(ChannelType channel, const std::string& name, const std::string& value) {
  const channels::OptionInfo* const option = channels::kind_of(channel).find_option(name);
  return option != nullptr && option->is_file ? hash_of(value) : value;
}

nlohmann::ordered_json part_in_settings(const channels::Part& part) {
  nlohmann::ordered_json json = {{"suffix", part.suffix}, {"format", format_info(part.format).name}};
  for (std::size_t c = 0; c < format_info(part.format).channels; ++c)
    json["ranges"].push_back({part.ranges[c].scale, part.ranges[c].offset});
  if (part.zero_is_nodata) json["zero_is_nodata"] = true;
  if (!part.metadata_json.empty()) json["metadata"] = hash_of(part.metadata_json);
  return json;
}

// The rules for what lies past the edges, as far as any tile of the layer depends on them. A rule that
// changes gets another name.
nlohmann::ordered_json edge_rules_of(const LayerPlan& plan) {
  const pyramid::LayerShape shape = plan.shape();
  const int coarsest = plan.info.finest.value;
  auto rules = nlohmann::ordered_json::array();
  if (shape.is_closed) rules.push_back("around the globe");
  if (coarsest > 0 && plan.kernel.taps > 2) rules.push_back("mirrored");
  const bool cuts_texels = shape.filled_column(coarsest) < 1.0 || shape.filled_row(coarsest) < 1.0;
  if (cuts_texels && plan.codec->centre_range() && !plan.kernel.is_point) rules.push_back("at centres");
  return rules;
}

nlohmann::ordered_json settings_of(const LayerPlan& plan, const std::vector<OpenSource>& sources, const std::vector<SourcePlaces>& places) {
  const LayerRequest& request = plan.request;
  nlohmann::ordered_json settings;
  settings["channel"] = channels::channel_name(request.channel);
  settings["format"] = format_info(plan.info.format).name;
  settings["kernel"] = plan.kernel.name;
  for (const auto& [name, value] : request.options) settings["options"][name] = option_in_settings(request.channel, name, value);
  // What the channel made of the first source as well: blocks of one layer cannot differ in it.
  for (const channels::Part& part : plan.codec->parts()) settings["parts"].push_back(part_in_settings(part));
  if (request.quality != encode::Quality::kNormal) settings["quality"] = encode::quality_name(request.quality);
  settings["compression"] = request.compression;
  settings["tile"] = request.tile_texels;
  settings["crs"] = plan.crs.text();
  settings["grid"] = {plan.info.grid.origin_x, plan.info.grid.origin_y, plan.info.grid.step_x, plan.info.grid.step_y};
  settings["size"] = {plan.info.data.width, plan.info.data.height};
  if (auto rules = edge_rules_of(plan); !rules.empty()) settings["edges"] = std::move(rules);
  if (plan.codec->rules_version() > 1) settings["rules"] = plan.codec->rules_version();
  if (request.range) settings["range"] = *request.range;
  if (plan.resampling != resample::Method::kBilinear) settings["resample"] = resample::method_name(plan.resampling);
  settings["sources"] = facts_of(sources, places);
  // A layer that was begun by other rules of resampling counts as one of other sources: an update finds by
  // their marks which blocks are.
  nlohmann::ordered_json& facts = settings["sources"];
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!places[i].placed.front().is_aligned) (facts.is_array() ? facts[i] : facts)["resampling_rules"] = resample::kWarpRules;
  return settings;
}

}  // namespace

Area LayerPlan::extent() const {
  return {info.grid.origin_x, info.grid.origin_y - static_cast<double>(info.data.height) * info.grid.step_y,
          info.grid.origin_x + static_cast<double>(info.data.width) * info.grid.step_x, info.grid.origin_y};
}

// As many as the counts of the coarsest level's texels have bits for, see pyramid/class_counts.h.
int area_exponent(const LayerPlan& plan) {
  constexpr int kWanted = 16;
  if (!plan.sampler || !plan.sampler->counts_areas()) return 0;
  return std::clamp(pyramid::kMostAreaBits - 2 * int{plan.info.finest.value}, 1, kWanted);
}

namespace {

Result<void> check_asked_crs(const LayerRequest& request, const std::optional<DatasetFrame>& frame) {
  if (!frame || !request.crs || frame->crs.same_coordinates(*request.crs)) return {};
  return fail(ErrorCode::kUsage,
              "the store is in " + frame->crs.text() + ", a layer of it cannot be in " + request.crs->text() + "; leave `crs` out");
}

// The grid, the size and the place in the store.
Result<void> lay_out(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const OpenSource* first, double first_moved_x,
                     const Bounds& bounds, LayerPlan& plan) {
  VT_ASSIGN(plan.info.grid, choose_grid(request, plan.crs, first, first_moved_x, bounds));
  VT_CHECK(set_size(bounds, plan.info));
  plan.is_closed = closes_around_globe(plan.crs, plan.info.data.width, plan.info.grid.step_x);
  return check_frame(plan, frame);
}

// The area of the layers that this one has to lie over.
std::optional<Bounds> store_area(const std::optional<DatasetFrame>& frame) {
  if (!frame || (!frame->area && !frame->planned)) return std::nullopt;
  const Area& area = frame->area ? *frame->area : *frame->planned;
  return Bounds{area.west, area.south, area.east, area.north};
}

// The smallest rectangle that holds both.
TexelRect around(const TexelRect& a, const TexelRect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const std::int64_t x = std::min(a.x, b.x);
  const std::int64_t y = std::min(a.y, b.y);
  return {x, y, std::max(a.right(), b.right()) - x, std::max(a.bottom(), b.bottom()) - y};
}

// What the user asks for, in the turn that the store counts in.
Result<Bounds> asked_bounds(const Area& area, const geo::Crs& crs, const std::optional<DatasetFrame>& frame) {
  VT_ASSIGN(const Bounds bounds, bounds_of(area, crs));
  const std::optional<Bounds> store = store_area(frame);
  if (!store || !crs.turn()) return bounds;
  const std::vector<int> turns = turns_into(bounds, *store, *crs.turn());
  return turns.empty() ? bounds : moved_by(bounds, turns.front() * *crs.turn());
}

// Where the sources of a layer lie, and all of it.
struct SourceBounds {
  std::vector<Bounds> own;       // of each source, where it says it lies
  std::vector<Bounds> together;  // the same, in the turns in which they make one layer
  Bounds all;
  double first_moved_x = 0.0;
};
Result<SourceBounds> find_bounds(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const geo::Crs& crs,
                                 const std::vector<OpenSource>& sources, int threads) {
  SourceBounds found;
  if (request.area) {
    VT_ASSIGN(found.all, asked_bounds(*request.area, crs, frame));
  }
  found.own.resize(sources.size());
  ErrorList errors(sources.size());
  VT_CHECK(for_each_index(sources.size(), threads, [&](std::size_t i) -> Result<void> {
    auto bounds = bounds_in(crs, sources[i]);
    // When a source reaches where the layer's CRS has no answer, as the whole Earth does for most, the
    // layer's area is what can be seen.
    if (!bounds && request.area && reaches_into(found.all, crs, sources[i])) bounds = found.all;
    if (bounds) {
      found.own[i] = *bounds;
    } else {
      errors.set(i, bounds.error());
    }
    return {};
  }));
  VT_CHECK(errors.result());
  found.together = found.own;
  if (request.area) return found;
  if (!crs.turn()) {
    for (const Bounds& one : found.own) found.all.add(one);
    return found;
  }
  const Gathering gathering = gathered(found.own, *crs.turn(), store_area(frame));
  for (std::size_t i = 0; i < sources.size(); ++i) found.together[i] = moved_by(found.own[i], gathering.turns[i] * *crs.turn());
  found.all = gathering.bounds;
  found.first_moved_x = gathering.turns.front() * *crs.turn();
  return found;
}

Result<void> give_codecs(const channels::ChannelSettings& settings, const std::vector<OpenSource>& sources,
                         std::vector<SourcePlaces>& places) {
  CodecShelf codecs;
  for (std::size_t i = 0; i < places.size(); ++i) {
    auto codec = codecs.codec_for(settings, places[i].placed.front().layout);
    if (!codec) return fail(codec.error().code, sources[i].request.path.string() + ": " + codec.error().message);
    for (resample::PlacedSource& placed : places[i].placed) placed.codec = *codec;
  }
  return {};
}

// The layer of that name and channel that is in the store.
const LayerInfo* stored_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame) {
  if (!frame) return nullptr;
  const auto found = frame->layers.find(request.name);
  return found != frame->layers.end() && found->second.channel == request.channel ? &found->second : nullptr;
}

// The files that a layer was begun with are those of the request, by their names.
bool names_the_sources_of(const LayerRequest& request, const LayerInfo& layer) {
  const auto metadata = text::json_or_null(layer.metadata_json);
  if (!metadata.is_object() || !metadata.contains("settings") || !metadata["settings"].is_object()) return false;
  const auto sources = metadata["settings"].value("sources", nlohmann::ordered_json());
  if (!sources.is_array() || sources.size() != request.sources.size()) return false;
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (!sources[i].is_object() || !sources[i].contains("path") || sources[i]["path"] != request.sources[i].path.filename().string())
      return false;
  return true;
}

// A layer that is there keeps its scale, whatever its sources are now. One that never came to its end is
// there for nobody but the command that began it.
Result<double> stored_light_of(const LayerRequest& request, const LayerInfo* stored, std::span<const SourcePlaces> places) {
  if (stored != nullptr && (was_ever_complete(*stored) || names_the_sources_of(request, *stored))) return stored->components[0].scale;
  return choose_stored_light(places);
}

Result<void> plan_with_sources(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const PlanOptions& options,
                               LayerPlan& plan) {
  const int threads = thread_count(options.threads);
  const SharedReading shared{std::make_shared<source::BlockCache>(options.source_cache_bytes), std::make_shared<source::FilePool>(),
                             options.scratch_folder.empty() ? nullptr : std::make_shared<source::ScratchFile>(options.scratch_folder)};
  VT_ASSIGN(const std::vector<OpenSource> sources, open_sources(request, shared, threads));
  VT_CHECK(check_asked_crs(request, frame));
  plan.crs = frame ? frame->crs : request.crs.value_or(sources.front().crs);
  VT_CHECK(check_systems(sources, plan.crs, plan.warnings));

  std::vector<ChosenSamples> samples(sources.size());
  ErrorList choosing(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (auto chosen = choose_samples(request, sources[i])) {
      samples[i] = *std::move(chosen);
    } else {
      choosing.set(i, chosen.error());
    }
  }
  VT_CHECK(choosing.result());
  const channels::SampleLayout& first = samples.front().layout;
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  VT_ASSIGN(plan.info, describe_layer(request, first));
  VT_ASSIGN(const SourceBounds bounds, find_bounds(request, frame, plan.crs, sources, threads));
  const Strays strays = find_strays(plan.crs, sources, bounds.together);
  if (options.existing != nullptr) {
    plan.info.grid = options.existing->grid;
    plan.info.data = options.existing->data;
    plan.info.finest = options.existing->finest;
    plan.info.source_nodata = options.existing->source_nodata;
    plan.is_closed = closes_around_globe(plan.crs, plan.info.data.width, plan.info.grid.step_x);
  } else if (auto laid_out = lay_out(request, frame, &sources.front(), bounds.first_moved_x, bounds.all, plan); !laid_out) {
    return fail(laid_out.error().code, laid_out.error().message + strays.as_reason());
  }
  strays.append_to(plan.warnings);

  const LayerGround ground(plan.info, plan.crs);
  std::vector<SourcePlaces> places(sources.size());
  VT_CHECK(for_each_index(sources.size(), threads, [&](std::size_t i) -> Result<void> {
    places[i] = place_source(samples[i], plan.resampling, ground, sources[i], bounds.own[i]);
    return {};
  }));
  const LayerInfo* const stored = stored_layer(request, frame);
  if (!request.format) {
    // A layer that is there keeps its format when its sources come to cover more of it, or less.
    const bool has_cover_in_format = kind.usual_format(first.type, true) != kind.usual_format(first.type, false);
    const bool keeps_format = has_cover_in_format && stored != nullptr && was_ever_complete(*stored);
    plan.info.format =
        keeps_format ? stored->format : kind.usual_format(first.type, !is_surely_covered(plan.info, plan.crs, sources, places));
  }
  const bool samples_are_wide = std::ranges::any_of(samples, [&](const ChosenSamples& one) { return needs_wide(request, one.layout); });
  channels::ChannelSettings settings = settings_for(request, plan.info, samples_are_wide);
  VT_CHECK(give_codecs(settings, sources, places));
  VT_CHECK(check_samples(request, places));
  if (kind.chooses_stored_light(plan.info.format, request.options)) {
    VT_ASSIGN(settings.stored_light, stored_light_of(request, options.existing != nullptr ? options.existing : stored, places));
    if (settings.stored_light != 1.0) VT_CHECK(give_codecs(settings, sources, places));
  }
  const auto codec_of = [&](std::size_t i) { return places[i].placed.front().codec; };
  plan.codec = codec_of(0);
  if (!plan.codec->keeps_numbers()) plan.info.source_nodata = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 1; i < places.size(); ++i)
    if (!writes_the_same(*plan.codec, *codec_of(i)))
      return fail(ErrorCode::kInvalidData,
                  sources[i].request.path.string() + ": its samples make other texels than those of " +
                      sources.front().request.path.string() +
                      " (another number of bands, another unit, or codes that would mean something else); they cannot be one layer");
  describe_parts(plan);
  for (const SourcePlaces& one : places)
    for (const resample::PlacedSource& source : one.placed) plan.covered = around(plan.covered, source.covered);
  plan.source_load = load_of(sources, places, plan.info, options.source_cache_bytes);
  remark_on(request, plan.crs, sources, places, plan.warnings);
  plan.settings = settings_of(plan, sources, places);
  std::vector<resample::PlacedSource> placed;
  for (SourcePlaces& one : places) std::ranges::move(one.placed, std::back_inserter(placed));
  plan.sampler = std::make_shared<const resample::BaseSampler>(std::move(placed), plan.info.data.width, plan.info.data.height);
  plan.source_load.counts_areas = plan.sampler->counts_areas();
  return {};
}

// From what is declared alone; nothing is opened.
Result<void> plan_without_sources(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const PlanOptions& options,
                                  const std::string& missing, LayerPlan& plan) {
  std::string needed;
  if (!request.area) needed += ", an area";
  if (!request.gsd_m) needed += ", a gsd";
  if (!request.crs && !frame) needed += ", a crs";
  if (!request.expected) needed += ", expected samples (\"expect\")";
  if (!needed.empty())
    return fail(ErrorCode::kInvalidData,
                "layer '" + request.name + "': " + missing + "; to be planned without them it needs" + needed.substr(1));
  VT_CHECK(check_asked_crs(request, frame));
  plan.crs = frame ? frame->crs : *request.crs;

  const ExpectedSamples& expected = *request.expected;
  VT_ASSIGN(const Bounds bounds, asked_bounds(*request.area, plan.crs, frame));
  const channels::SampleLayout layout{.type = expected.type,
                                      .value_bands = expected.bands,
                                      .has_alpha = expected.has_alpha,
                                      .nodata = expected.nodata,
                                      .range = request.range};
  VT_ASSIGN(plan.info, describe_layer(request, layout));
  if (!request.format)
    plan.info.format = channels::kind_of(request.channel).usual_format(expected.type, expected.has_alpha || expected.nodata.has_value());
  VT_CHECK(lay_out(request, frame, nullptr, 0.0, bounds, plan));
  auto codec = CodecShelf().codec_for(settings_for(request, plan.info, needs_wide(request, layout)), layout);
  if (!codec) return fail(codec.error().code, "layer '" + request.name + "': " + codec.error().message);
  plan.codec = std::move(*codec);
  describe_parts(plan);
  plan.source_load = expected_load(request, layout, plan.info, options.source_cache_bytes);
  plan.warnings.push_back("layer '" + request.name + "': " + missing + "; planned from its area, gsd, crs and expected samples");
  return {};
}

}  // namespace

Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const PlanOptions& options) {
  LayerPlan plan;
  plan.request = request;
  VT_CHECK(channels::check_options(request.channel, request.options));
  VT_ASSIGN(plan.kernel, choose_kernel(request));
  VT_ASSIGN(plan.resampling, choose_resampling(request));
  VT_ASSIGN(plan.compression, store::parse_compression(request.compression));
  const std::string missing = missing_text(request);
  if (missing.empty()) {
    VT_CHECK(plan_with_sources(request, frame, options, plan));
  } else if (options.may_lack_sources && (request.expected || request.sources.empty())) {
    VT_CHECK(plan_without_sources(request, frame, options, missing, plan));
  } else {
    const ErrorCode code = request.sources.empty() ? ErrorCode::kUsage : ErrorCode::kIo;
    return fail(code, "layer '" + request.name + "' cannot be built without its sources: " + missing);
  }
  return plan;
}

}  // namespace vt::pipeline
