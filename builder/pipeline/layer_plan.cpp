#include "builder/pipeline/layer_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>

#include "builder/pyramid/block_cascade.h"
#include "builder/source/block_cache.h"
#include "store/content_hash.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// Texels by which a source's grid may miss the layer's and still count as the same grid: far below what resampling could express.
constexpr double kGridTolerance = 1e-4;

std::string area_text(const Area& area) {
  return "west " + std::to_string(area.west) + " south " + std::to_string(area.south) + " east " + std::to_string(area.east) + " north " +
         std::to_string(area.north);
}

struct OpenSource {
  SourceRequest request;
  std::shared_ptr<const source::RasterSource> raster;
  geo::Crs crs;
};

// Parts of a file are enough to tell it from another, or from itself before an edit that moved anything: a file is read whole only to be
// built.
constexpr std::size_t kFingerprintPieces = 64;
constexpr std::size_t kFingerprintPieceBytes = std::size_t{64} << 10;

// Hash of evenly spaced pieces of the file, as 16 hex digits; all of it when it is small. Content, not clocks: a copied file is the same
// source.
std::string content_fingerprint(const std::filesystem::path& path, std::uintmax_t file_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> pieces;
  std::vector<char> piece(kFingerprintPieceBytes);
  const std::uintmax_t stride = std::max<std::uintmax_t>(kFingerprintPieceBytes, file_bytes / kFingerprintPieces);
  for (std::uintmax_t at = 0; at < file_bytes; at += stride) {
    // The last piece ends where the file ends.
    const std::uintmax_t from = at + stride >= file_bytes && file_bytes > kFingerprintPieceBytes ? file_bytes - kFingerprintPieceBytes : at;
    file.seekg(static_cast<std::streamoff>(from));
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    pieces.insert(pieces.end(), piece.begin(), piece.begin() + file.gcount());
    file.clear();
  }
  return store::content_hash(std::as_bytes(std::span(pieces)));
}

Result<OpenSource> open_source(const SourceRequest& request, const std::shared_ptr<source::BlockCache>& cache) {
  source::OpenOptions options;
  options.crs = request.crs;
  options.extent = request.extent;
  options.nodata = request.nodata;
  options.cache = cache;
  VT_ASSIGN(std::unique_ptr<source::RasterSource> raster, source::open_raster(request.path, options));
  const RasterInfo& info = raster->info();
  geo::Crs crs;
  if (info.crs) {
    crs = *info.crs;
  } else if (request.fallback_crs) {
    crs = *request.fallback_crs;
  } else {
    const std::string why = info.crs_problem.empty() ? "no coordinate reference system in the file" : info.crs_problem;
    return fail(ErrorCode::kInvalidData, request.path.string() + ": " + why + "; give one, for example --crs EPSG:4326" +
                                             (info.has_transform ? "" : " --extent WEST,SOUTH,EAST,NORTH") +
                                             ", or --crs pixel for a picture without a place on the ground");
  }
  const bool is_pixel = crs.definition().projection == geo::Projection::kPixel;
  if (!info.has_transform && !is_pixel)
    return fail(
        ErrorCode::kInvalidData,
        request.path.string() + ": the file does not say where it lies; give --extent WEST,SOUTH,EAST,NORTH in units of " + crs.text());
  return OpenSource{request, std::move(raster), crs};
}

// Pictures without any place on the ground lie with their lower left corner at (0, 0), one unit a sample.
geo::GeoTransform transform_of(const RasterInfo& info) {
  if (info.has_transform) return info.transform;
  return {0.0, 1.0, 0.0, static_cast<double>(info.height), 0.0, -1.0};
}

struct Bounds {
  double west = INFINITY, south = INFINITY, east = -INFINITY, north = -INFINITY;
  void add(Point2 p) {
    west = std::min(west, p.x);
    east = std::max(east, p.x);
    south = std::min(south, p.y);
    north = std::max(north, p.y);
  }
};

Result<Point2> convert(const geo::Crs& to, const geo::Crs& from, Point2 p) {
  if (to.same_coordinates(from)) return p;
  VT_ASSIGN(const Point2 lonlat, from.lonlat_from_crs(p));
  return to.crs_from_lonlat(lonlat);
}

// Outer bounds of a source in the layer's CRS. Edges may bulge when reprojected, so they are followed in small steps.
Result<Bounds> bounds_in(const geo::Crs& crs, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const geo::GeoTransform transform = transform_of(info);
  const int steps = crs.same_coordinates(source.crs) ? 1 : 64;
  const auto width = static_cast<double>(info.width);
  const auto height = static_cast<double>(info.height);
  Bounds bounds;
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    for (const Point2 corner : {Point2{f * width, 0.0}, Point2{f * width, height}, Point2{0.0, f * height}, Point2{width, f * height}}) {
      auto p = convert(crs, source.crs, transform.crs_from_raster(corner));
      if (!p)
        return fail(ErrorCode::kInvalidData,
                    source.request.path.string() + ": cannot be placed in " + crs.text() + ": " + p.error().message);
      bounds.add(*p);
    }
  }
  return bounds;
}

// Texel size in the layer's CRS that keeps the source's own resolution at its centre.
Result<Point2> native_step(const geo::Crs& crs, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const geo::GeoTransform transform = transform_of(info);
  const Point2 centre{static_cast<double>(info.width) / 2, static_cast<double>(info.height) / 2};
  VT_ASSIGN(const Point2 here, convert(crs, source.crs, transform.crs_from_raster(centre)));
  VT_ASSIGN(const Point2 east, convert(crs, source.crs, transform.crs_from_raster({centre.x + 1, centre.y})));
  VT_ASSIGN(const Point2 south, convert(crs, source.crs, transform.crs_from_raster({centre.x, centre.y + 1})));
  return Point2{std::hypot(east.x - here.x, south.x - here.x), std::hypot(east.y - here.y, south.y - here.y)};
}

// A ground sample distance in CRS units: metres of the grid where the CRS is projected (a UTM image "of 0.5 m" has texels of 0.5 grid
// metres), metres on the ground at the centre where it is in degrees.
Result<Point2> step_of_gsd(const geo::Crs& crs, double gsd_m, const Bounds& bounds) {
  if (!(gsd_m > 0.0) || !std::isfinite(gsd_m)) return fail(ErrorCode::kUsage, "the ground sample distance must be greater than 0 metres");
  switch (crs.definition().projection) {
    case geo::Projection::kPixel:
      return Point2{gsd_m, gsd_m};
    case geo::Projection::kTransverseMercator:
    case geo::Projection::kWebMercator:
      return Point2{gsd_m / crs.definition().metres_per_unit, gsd_m / crs.definition().metres_per_unit};
    case geo::Projection::kGeographic:
      break;
  }
  VT_ASSIGN(const Point2 metres, crs.metres_per_unit_at({(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2}));
  return Point2{gsd_m / metres.x, gsd_m / metres.y};
}

Result<GridPlacement> choose_grid(const LayerRequest& request, const geo::Crs& crs, const OpenSource& first, const Bounds& bounds) {
  const geo::GeoTransform transform = transform_of(first.raster->info());
  GridPlacement grid;
  std::optional<Point2> asked_step;
  if (request.gsd_m) {
    VT_ASSIGN(asked_step, step_of_gsd(crs, *request.gsd_m, bounds));
  }
  const auto is_own_step = [&] {
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-6 * b; };
    return !asked_step || (same(asked_step->x, transform.x_column) && same(asked_step->y, -transform.y_row));
  };
  const bool own_grid = transform.is_north_up() && crs.same_coordinates(first.crs) && is_own_step();
  if (own_grid) {
    grid.step_x = transform.x_column;
    grid.step_y = -transform.y_row;
    // On the first source's own grid lines, moved outward by whole texels to cover the others.
    grid.origin_x = transform.x0 + std::floor((bounds.west - transform.x0) / grid.step_x + kGridTolerance) * grid.step_x;
    grid.origin_y = transform.y0 - std::floor((transform.y0 - bounds.north) / grid.step_y + kGridTolerance) * grid.step_y;
    return grid;
  }
  Point2 step;
  if (asked_step) {
    step = *asked_step;
  } else {
    VT_ASSIGN(step, native_step(crs, first));
  }
  grid.step_x = step.x;
  grid.step_y = step.y;
  grid.origin_x = bounds.west;
  grid.origin_y = bounds.north;
  return grid;
}

// Which bands a channel reads, as indices, the coverage band last.
Result<std::vector<int>> choose_bands(ChannelType channel, const OpenSource& source, bool with_alpha) {
  const RasterInfo& info = source.raster->info();
  std::vector<int> bands;
  for (int band : source.request.bands) {
    if (band < 1 || band > info.bands)
      return fail(ErrorCode::kUsage, source.request.path.string() + ": band " + std::to_string(band) + " asked for, the file has 1 to " +
                                         std::to_string(info.bands));
    bands.push_back(band - 1);
  }
  if (bands.empty()) {
    const int values = info.bands - (info.alpha_band >= 0 ? 1 : 0);
    const int wanted = channel == ChannelType::kColor ? (values >= 3 ? 3 : 1) : 1;
    for (int b = 0; b < info.bands && static_cast<int>(bands.size()) < wanted; ++b)
      if (b != info.alpha_band) bands.push_back(b);
  }
  // A coverage band that was named among the others is not taken twice.
  if (with_alpha) {
    std::erase(bands, info.alpha_band);
    bands.push_back(info.alpha_band);
  }
  return bands;
}

Result<resample::PlacedSource> place_source(const LayerRequest& request, const LayerInfo& layer, const geo::Crs& crs,
                                            const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  resample::PlacedSource placed;
  placed.raster = source.raster;

  channels::SampleLayout layout;
  layout.type = info.sample_type;
  layout.has_alpha = info.alpha_band >= 0 && layer.channel == ChannelType::kColor;
  layout.nodata = info.nodata;
  layout.range = request.range;
  VT_ASSIGN(placed.bands, choose_bands(layer.channel, source, layout.has_alpha));
  layout.value_bands = static_cast<int>(placed.bands.size()) - (layout.has_alpha ? 1 : 0);
  placed.layout = layout;
  auto codec = channels::make_codec(layer.channel, layout, layer.transfer, layer.format);
  if (!codec) return fail(codec.error().code, source.request.path.string() + ": " + codec.error().message);
  placed.codec = std::move(*codec);

  const geo::GeoTransform transform = transform_of(info);
  const TexelRect whole{0, 0, layer.data.width, layer.data.height};
  if (transform.is_north_up() && crs.same_coordinates(source.crs)) {
    const double column = (transform.x0 - layer.grid.origin_x) / layer.grid.step_x;
    const double row = (layer.grid.origin_y - transform.y0) / layer.grid.step_y;
    const auto width = static_cast<double>(info.width);
    const auto height = static_cast<double>(info.height);
    const auto is_near = [](double a, double b) { return std::abs(a - b) <= kGridTolerance; };
    const double end_column = (transform.x0 + width * transform.x_column - layer.grid.origin_x) / layer.grid.step_x;
    const double end_row = (layer.grid.origin_y - (transform.y0 + height * transform.y_row)) / layer.grid.step_y;
    if (is_near(column, std::round(column)) && is_near(row, std::round(row)) && is_near(end_column, std::round(column) + width) &&
        is_near(end_row, std::round(row) + height)) {
      placed.is_aligned = true;
      placed.offset_x = std::llround(column);
      placed.offset_y = std::llround(row);
      placed.covered = intersect({placed.offset_x, placed.offset_y, info.width, info.height}, whole);
      return placed;
    }
  }
  placed.warp = std::make_shared<const resample::GridWarp>(layer.grid, crs, transform, source.crs);
  VT_ASSIGN(const Bounds bounds, bounds_in(crs, source));
  const auto x0 = static_cast<std::int64_t>(std::floor((bounds.west - layer.grid.origin_x) / layer.grid.step_x)) - 1;
  const auto x1 = static_cast<std::int64_t>(std::ceil((bounds.east - layer.grid.origin_x) / layer.grid.step_x)) + 1;
  const auto y0 = static_cast<std::int64_t>(std::floor((layer.grid.origin_y - bounds.north) / layer.grid.step_y)) - 1;
  const auto y1 = static_cast<std::int64_t>(std::ceil((layer.grid.origin_y - bounds.south) / layer.grid.step_y)) + 1;
  placed.covered = intersect({x0, y0, x1 - x0, y1 - y0}, whole);
  return placed;
}

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

nlohmann::ordered_json source_facts(const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  std::error_code ignored;
  nlohmann::ordered_json json;
  json["path"] = source.request.path.filename().string();
  const std::uintmax_t file_bytes = std::filesystem::file_size(source.request.path, ignored);
  json["file_bytes"] = file_bytes;
  json["content"] = content_fingerprint(source.request.path, file_bytes);
  json["width"] = info.width;
  json["height"] = info.height;
  json["bands"] = source.request.bands;
  json["sample_type"] = sample_name(info.sample_type);
  json["compression"] = info.compression;
  json["crs"] = source.crs.text();
  const geo::GeoTransform t = transform_of(info);
  json["transform"] = {t.x0, t.x_column, t.x_row, t.y0, t.y_column, t.y_row};
  if (info.nodata)
    json["nodata"] =
        std::isfinite(*info.nodata) ? nlohmann::ordered_json(*info.nodata) : nlohmann::ordered_json(std::to_string(*info.nodata));
  return json;
}

Result<LayerInfo> describe_layer(const LayerRequest& request, const geo::Crs& crs, const std::vector<OpenSource>& sources) {
  LayerInfo info;
  info.name = request.name;
  info.channel = request.channel;
  const RasterInfo& first = sources.front().raster->info();
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
  if (first.nodata) info.source_nodata = *first.nodata;

  Bounds bounds;
  for (const OpenSource& source : sources) {
    VT_ASSIGN(const Bounds one, bounds_in(crs, source));
    bounds.add({one.west, one.south});
    bounds.add({one.east, one.north});
  }
  VT_ASSIGN(info.grid, choose_grid(request, crs, sources.front(), bounds));
  const double columns = (bounds.east - info.grid.origin_x) / info.grid.step_x;
  const double rows = (info.grid.origin_y - bounds.south) / info.grid.step_y;
  const double limit = std::ldexp(1.0, kMaxVtExponent);
  if (!(columns > 0.0) || !(rows > 0.0) || columns > limit || rows > limit)
    return fail(ErrorCode::kInvalidData, "the finest level would have " + std::to_string(columns) + " x " + std::to_string(rows) +
                                             " texels; 1 to 2^31 are possible. Check --gsd, --crs and --extent");
  info.data.width = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(columns - kGridTolerance)));
  info.data.height = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(rows - kGridTolerance)));
  const std::int64_t longest = std::max(info.data.width, info.data.height);
  while ((std::int64_t{1} << info.vt_exponent()) < longest) ++info.finest.value;
  if (info.vt_exponent() > kMaxVtExponent)
    return fail(ErrorCode::kInvalidData, "the finest level needs more than 2^31 texels along an edge");
  return info;
}

}  // namespace

Area LayerPlan::extent() const {
  return {info.grid.origin_x, info.grid.origin_y - static_cast<double>(info.data.height) * info.grid.step_y,
          info.grid.origin_x + static_cast<double>(info.data.width) * info.grid.step_x, info.grid.origin_y};
}

Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame, std::size_t source_cache_bytes) {
  if (request.sources.empty()) return fail(ErrorCode::kUsage, "layer '" + request.name + "' has no sources");
  LayerPlan plan;
  plan.request = request;
  VT_ASSIGN(plan.kernel, choose_kernel(request));
  VT_ASSIGN(plan.compression, store::parse_compression(request.compression));

  const auto cache = std::make_shared<source::BlockCache>(source_cache_bytes);
  std::vector<OpenSource> sources;
  for (const SourceRequest& source : request.sources) {
    VT_ASSIGN(OpenSource open, open_source(source, cache));
    sources.push_back(std::move(open));
  }
  if (frame && request.crs && !frame->crs.same_coordinates(*request.crs))
    return fail(ErrorCode::kUsage,
                "the store is in " + frame->crs.text() + ", a layer of it cannot be in " + request.crs->text() + "; leave --crs out");
  plan.crs = frame ? frame->crs : request.crs.value_or(sources.front().crs);
  for (const OpenSource& source : sources) {
    const bool has_place = source.crs.definition().projection != geo::Projection::kPixel;
    if (has_place != (plan.crs.definition().projection != geo::Projection::kPixel))
      return fail(ErrorCode::kInvalidData, source.request.path.string() + ": is in " + source.crs.text() + ", the layer in " +
                                               plan.crs.text() + "; pictures without a place on the ground do not mix with others");
    const geo::CrsDefinition& from = source.crs.definition();
    if (from.datum != plan.crs.definition().datum)
      plan.warnings.push_back(source.request.path.string() + ": datum " + from.datum + " is taken as " + plan.crs.definition().datum +
                              " without a shift, which can be off by metres");
  }

  VT_ASSIGN(plan.info, describe_layer(request, plan.crs, sources));
  if (frame && frame->area) {
    const Area extent = plan.extent();
    if (extent.east <= frame->area->west || extent.west >= frame->area->east || extent.north <= frame->area->south ||
        extent.south >= frame->area->north)
      return fail(ErrorCode::kInvalidData, "layer '" + request.name + "' lies outside the store's area: " + area_text(extent) +
                                               ", the store's is " + area_text(*frame->area) + " (" + plan.crs.text() +
                                               "); check the source's coordinate system or choose another store");
  }
  std::vector<resample::PlacedSource> placed;
  for (const OpenSource& source : sources) {
    VT_ASSIGN(resample::PlacedSource one, place_source(request, plan.info, plan.crs, source));
    if (!one.is_aligned)
      plan.warnings.push_back(source.request.path.string() + ": resampled (bilinear), because " +
                              (plan.crs.same_coordinates(source.crs)
                                   ? "its grid is not the layer's"
                                   : "it is in " + source.crs.text() + " and the layer in " + plan.crs.text()));
    if (request.channel == ChannelType::kColor && source.raster->info().sample_type == SampleType::kUint16 && !request.range)
      plan.warnings.push_back(source.request.path.string() +
                              ": 0 is taken as black and 65535 as white; if the picture comes out dark, give --range LOW,HIGH");
    placed.push_back(std::move(one));
  }
  plan.sampler = std::make_shared<const resample::BaseSampler>(std::move(placed), plan.info.data.width, plan.info.data.height);

  plan.settings["channel"] = channel_info(request.channel).name;
  plan.settings["format"] = format_info(plan.info.format).name;
  plan.settings["kernel"] = plan.kernel.name;
  plan.settings["compression"] = request.compression;
  plan.settings["tile"] = request.tile_texels;
  plan.settings["crs"] = plan.crs.text();
  plan.settings["grid"] = {plan.info.grid.origin_x, plan.info.grid.origin_y, plan.info.grid.step_x, plan.info.grid.step_y};
  plan.settings["size"] = {plan.info.data.width, plan.info.data.height};
  if (request.range) plan.settings["range"] = *request.range;
  for (const OpenSource& source : sources) plan.settings["sources"].push_back(source_facts(source));
  return plan;
}

TexelRect Tier::block(std::int64_t index) const {
  return {(first_column + index % columns) * block_texels, (first_row + index / columns) * block_texels, block_texels, block_texels};
}

TileId Tier::carry_tile(std::int64_t index) const {
  return {Level{static_cast<std::uint8_t>(base.value - outputs)}, static_cast<std::uint32_t>(first_column + index % columns),
          static_cast<std::uint32_t>(first_row + index / columns)};
}

std::int64_t Tier::block_of_carry(TileId tile) const { return (tile.y - first_row) * columns + (tile.x - first_column); }

std::vector<Tier> plan_tiers(const LayerInfo& info, int levels) {
  std::vector<Tier> tiers;
  for (int base = info.finest.value; base >= 0; base -= levels) {
    Tier tier;
    tier.base = Level{static_cast<std::uint8_t>(base)};
    tier.has_carry = base >= levels;
    tier.outputs = tier.has_carry ? levels : base + 1;
    tier.data = info.data_rect(tier.base);
    tier.block_texels = std::int64_t{info.tile_texels()} << (tier.has_carry ? levels : base);
    tier.first_column = tier.data.x / tier.block_texels;
    tier.first_row = tier.data.y / tier.block_texels;
    tier.columns = (tier.data.right() + tier.block_texels - 1) / tier.block_texels - tier.first_column;
    tier.rows = (tier.data.bottom() + tier.block_texels - 1) / tier.block_texels - tier.first_row;
    tiers.push_back(tier);
    if (!tier.has_carry) break;
  }
  return tiers;
}

std::size_t worker_bytes(const LayerPlan& plan, int levels) {
  const auto tile = static_cast<std::size_t>(plan.info.tile_texels());
  const auto planes = static_cast<std::size_t>(plan.sampler->codec().planes());
  const std::size_t texel = format_info(plan.sampler->codec().texel_format()).block_bytes;
  const std::size_t width = (tile << levels) + static_cast<std::size_t>(plan.kernel.reach() * 2) * ((std::size_t{1} << levels) - 1) + 64;
  const std::size_t ring =
      static_cast<std::size_t>(plan.kernel.taps + 4) * planes * width * sizeof(float) * 2;  // all levels: twice the base
  const std::size_t bands = 2 * tile * width * texel;
  const std::size_t payloads = bands / 2;                               // tiles on their way into the store
  const std::size_t chunk = 64 * width * (planes + 2) * sizeof(float);  // source rows, or a carry band
  const std::size_t carry = tile * width * planes * sizeof(float) / (plan.info.finest.value >= levels ? 1 : 4);
  return ring + bands + payloads + chunk + carry;
}

Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes) {
  const int widest = std::max(1, 12 - int{plan.info.tile_exponent});
  const std::size_t fixed = std::size_t{24} << 20;  // program, libraries, the store's index pages
  for (int levels = widest; levels >= 1; --levels)
    if (fixed + static_cast<std::size_t>(threads) * worker_bytes(plan, levels) <= memory_bytes) return levels;
  const std::size_t least = fixed + static_cast<std::size_t>(threads) * worker_bytes(plan, 1);
  return fail(ErrorCode::kUsage, "--memory " + std::to_string(memory_bytes >> 20) + "M is too little for " + std::to_string(threads) +
                                     " threads; this layer needs at least " + std::to_string((least >> 20) + 1) + "M, or fewer --threads");
}

PlanCost plan_cost(const LayerInfo& info) {
  PlanCost cost;
  for (int level = 0; level <= info.finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect data = info.data_rect(l);
    const TexelRect tiles = info.tile_rect(l);
    cost.texels += static_cast<std::uint64_t>(data.width) * static_cast<std::uint64_t>(data.height);
    cost.tiles += static_cast<std::uint64_t>(tiles.width) * static_cast<std::uint64_t>(tiles.height);
  }
  cost.raw_bytes = cost.tiles * info.tile_payload_bytes();
  return cost;
}

}  // namespace vt::pipeline
