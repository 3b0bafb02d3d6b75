#include "builder/pipeline/layer_plan.h"

#include <algorithm>
#include <bit>

#include "builder/pipeline/layer_grid.h"
#include "builder/pipeline/open_sources.h"
#include "builder/pipeline/parallel.h"
#include "builder/pipeline/place_source.h"

namespace vt::pipeline {
namespace {

// A mosaic can have a remark for each of its files; a person reads a few.
constexpr std::size_t kMostRemarks = 8;

std::string area_text(const Area& area) {
  return "west " + std::to_string(area.west) + " south " + std::to_string(area.south) + " east " + std::to_string(area.east) + " north " +
         std::to_string(area.north);
}

// A remark of one kind about many files, cut short.
class Remarks {
 public:
  explicit Remarks(std::string what) : what_(std::move(what)) {}
  void add(std::string text) {
    if (++count_ <= kMostRemarks) texts_.push_back(std::move(text));
  }
  void append_to(std::vector<std::string>& warnings) {
    std::ranges::move(texts_, std::back_inserter(warnings));
    if (count_ > kMostRemarks) warnings.push_back("and " + std::to_string(count_ - kMostRemarks) + " more files that are " + what_);
  }

 private:
  std::string what_;
  std::size_t count_ = 0;
  std::vector<std::string> texts_;
};

Result<pyramid::HalvingKernel> choose_kernel(const LayerRequest& request) {
  const bool is_color = request.channel == ChannelType::kColor;
  const std::string name = !request.kernel.empty() ? request.kernel : is_color ? "kaiser3" : "box";
  const auto kernel = pyramid::kernel_from_name(name);
  if (!kernel) return fail(ErrorCode::kUsage, "unknown kernel '" + name + "'; box and kaiser3 are known");
  if (!is_color && kernel->name != pyramid::box_kernel().name)
    return fail(ErrorCode::kUsage, "kernel " + name + " has negative lobes, which would put heights outside the range of the terrain; " +
                                       std::string(channel_info(request.channel).name) + " layers use box");
  return *kernel;
}

// All of the layer but its place and size.
Result<LayerInfo> describe_layer(const LayerRequest& request, const std::vector<OpenSource>& sources) {
  LayerInfo info;
  info.name = request.name;
  info.channel = request.channel;
  // Coverage has to be stored when there can be texels without data; an opaque format is the user's explicit wish.
  const bool may_be_empty = std::any_of(sources.begin(), sources.end(), [](const OpenSource& s) {
    return s.raster->info().alpha_band >= 0 || s.raster->info().nodata.has_value();
  });
  info.format = request.format.value_or(
      request.channel == ChannelType::kColor && may_be_empty ? TexelFormat::kRgba8 : channel_info(request.channel).default_format);
  info.transfer = request.channel == ChannelType::kColor ? Transfer::kSrgb : Transfer::kLinear;
  if (request.tile_texels < 4 || request.tile_texels > 4096 || !std::has_single_bit(static_cast<unsigned>(request.tile_texels)))
    return fail(ErrorCode::kUsage, "tile size " + std::to_string(request.tile_texels) + " is not a power of two from 4 to 4096");
  info.tile_exponent = static_cast<std::uint8_t>(std::countr_zero(static_cast<unsigned>(request.tile_texels)));
  const std::optional<double> nodata = sources.front().raster->info().nodata;
  if (nodata) info.source_nodata = *nodata;
  return info;
}

// Rasters with and without a place on the ground do not mix; a datum is never shifted silently.
Result<void> check_systems(const std::vector<OpenSource>& sources, const geo::Crs& crs, std::vector<std::string>& warnings) {
  Remarks datums("in another datum");
  for (const OpenSource& source : sources) {
    const bool has_place = source.crs.definition().projection != geo::Projection::kPixel;
    if (has_place != (crs.definition().projection != geo::Projection::kPixel))
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

// What a person should know about sources before a long build.
void remark_on(const std::vector<OpenSource>& sources, const std::vector<resample::PlacedSource>& placed, LayerPlan& plan) {
  Remarks resampled("resampled");
  Remarks ranges("taken as black at 0 and white at 65535");
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const OpenSource& source = sources[i];
    if (!placed[i].is_aligned)
      resampled.add(source.request.path.string() + ": resampled (bilinear), because " +
                    (plan.crs.same_coordinates(source.crs) ? "its grid is not the layer's"
                                                           : "it is in " + source.crs.text() + " and the layer in " + plan.crs.text()));
    if (plan.request.channel == ChannelType::kColor && source.raster->info().sample_type == SampleType::kUint16 && !plan.request.range)
      ranges.add(source.request.path.string() +
                 ": 0 is taken as black and 65535 as white; if the picture comes out dark, give --range LOW,HIGH");
  }
  resampled.append_to(plan.warnings);
  ranges.append_to(plan.warnings);
}

nlohmann::ordered_json settings_of(const LayerPlan& plan, const std::vector<OpenSource>& sources) {
  const LayerRequest& request = plan.request;
  nlohmann::ordered_json settings;
  settings["channel"] = channel_info(request.channel).name;
  settings["format"] = format_info(plan.info.format).name;
  settings["kernel"] = plan.kernel.name;
  settings["compression"] = request.compression;
  settings["tile"] = request.tile_texels;
  settings["crs"] = plan.crs.text();
  settings["grid"] = {plan.info.grid.origin_x, plan.info.grid.origin_y, plan.info.grid.step_x, plan.info.grid.step_y};
  settings["size"] = {plan.info.data.width, plan.info.data.height};
  if (request.range) settings["range"] = *request.range;
  settings["sources"] = facts_of(sources);
  return settings;
}

}  // namespace

Area LayerPlan::extent() const {
  return {info.grid.origin_x, info.grid.origin_y - static_cast<double>(info.data.height) * info.grid.step_y,
          info.grid.origin_x + static_cast<double>(info.data.width) * info.grid.step_x, info.grid.origin_y};
}

Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame, const PlanOptions& options) {
  if (request.sources.empty()) return fail(ErrorCode::kUsage, "layer '" + request.name + "' has no sources");
  LayerPlan plan;
  plan.request = request;
  VT_ASSIGN(plan.kernel, choose_kernel(request));
  VT_ASSIGN(plan.compression, store::parse_compression(request.compression));

  const int threads = thread_count(options.threads);
  const SharedReading shared{
      .cache = std::make_shared<source::BlockCache>(options.source_cache_bytes),
      .files = std::make_shared<source::FilePool>(),
      .scratch = options.scratch_folder.empty() ? nullptr : std::make_shared<source::ScratchFile>(options.scratch_folder)};
  VT_ASSIGN(const std::vector<OpenSource> sources, open_sources(request.sources, shared, threads));
  if (frame && request.crs && !frame->crs.same_coordinates(*request.crs))
    return fail(ErrorCode::kUsage,
                "the store is in " + frame->crs.text() + ", a layer of it cannot be in " + request.crs->text() + "; leave --crs out");
  plan.crs = frame ? frame->crs : request.crs.value_or(sources.front().crs);
  VT_CHECK(check_systems(sources, plan.crs, plan.warnings));

  VT_ASSIGN(plan.info, describe_layer(request, sources));
  std::vector<Bounds> bounds(sources.size());
  VT_CHECK(for_each_index(sources.size(), threads, [&](std::size_t i) -> Result<void> {
    VT_ASSIGN(bounds[i], bounds_in(plan.crs, sources[i]));
    return {};
  }));
  Bounds all;
  for (const Bounds& one : bounds) all.add(one);
  VT_ASSIGN(plan.info.grid, choose_grid(request, plan.crs, sources.front(), all));
  VT_CHECK(set_size(all, plan.info));
  VT_CHECK(check_frame(plan, frame));

  std::vector<resample::PlacedSource> placed(sources.size());
  VT_CHECK(for_each_index(sources.size(), threads, [&](std::size_t i) -> Result<void> {
    VT_ASSIGN(placed[i], place_source(request, plan.info, plan.crs, sources[i], bounds[i]));
    return {};
  }));
  CodecShelf codecs;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    auto codec = codecs.codec_for(plan.info, placed[i].layout);
    if (!codec) return fail(codec.error().code, sources[i].request.path.string() + ": " + codec.error().message);
    placed[i].codec = std::move(*codec);
  }
  remark_on(sources, placed, plan);
  plan.settings = settings_of(plan, sources);
  plan.sampler = std::make_shared<const resample::BaseSampler>(std::move(placed), plan.info.data.width, plan.info.data.height);
  return plan;
}

}  // namespace vt::pipeline
