#include "tools/vtinspect/extract.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "builder/channels/all_channels.h"
#include "store/store_reader.h"
#include "store/vt_mapping.h"
#include "tools/cli/open_store.h"
#include "tools/pictures/picture_writer.h"
#include "tools/vtinspect/display.h"
#include "tools/vtinspect/mosaic.h"

namespace vt::inspect {

namespace {

// A band is as many rows as fit, at most a row of tiles; narrower bands unpack a tile more than once.
constexpr std::size_t kBandBytes = std::size_t{64} << 20;

struct Band {
  TexelRect rect;
  std::vector<std::byte> texels;
  std::vector<std::uint8_t> is_present;
};

// Calls `visit(band)` for every band of `rect` from north to south. Bands end at tile edges, so that no tile
// is unpacked twice where one row of tiles fits into kBandBytes.
template <class Visit>
Result<void> for_each_band(LevelReader& level, const LayerInfo& layer, const TexelRect& rect, const Visit& visit) {
  const std::size_t texel_bytes = layout_of(layer).texel_bytes();
  const std::size_t row_bytes = static_cast<std::size_t>(rect.width) * (texel_bytes + 1);
  const auto most_rows = static_cast<std::int64_t>(std::max<std::size_t>(1, kBandBytes / row_bytes));
  const std::int64_t tile = layer.tile_texels();
  Band band;
  for (std::int64_t y = rect.y; y < rect.bottom(); y = band.rect.bottom()) {
    const std::int64_t to_tile_edge = tile - y % tile;
    band.rect = {rect.x, y, rect.width, std::min({to_tile_edge, most_rows, rect.bottom() - y})};
    const auto count = static_cast<std::size_t>(band.rect.width * band.rect.height);
    band.texels.resize(count * texel_bytes);
    band.is_present.resize(count);
    if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "extract: stopped; the output was not written");
    VT_CHECK(level.read(band.rect, band.texels, band.is_present));
    VT_CHECK(visit(band));
  }
  return {};
}

// The values of one texel of a band, whether it holds bytes or floats.
void read_texel(const Band& band, bool is_float, std::size_t texel, std::span<float> values) {
  if (is_float) {
    std::memcpy(values.data(), &band.texels[texel * values.size_bytes()], values.size_bytes());
    return;
  }
  for (std::size_t c = 0; c < values.size(); ++c)
    values[c] = band.is_present[texel] != 0 ? static_cast<float>(std::to_integer<std::uint8_t>(band.texels[texel * values.size() + c]))
                                            : std::numeric_limits<float>::quiet_NaN();
}

// Values to bytes, with alpha 0 where a shown channel is no number.
void stretch(const Band& band, const TexelLayout& layout, const Display& display, bool with_alpha, const ValueRange& range,
             std::vector<std::byte>& out) {
  const auto shown = static_cast<std::size_t>(display.channels());
  const std::size_t out_stride = shown + (with_alpha ? 1 : 0);
  std::vector<float> values(static_cast<std::size_t>(layout.channels));
  out.assign(band.is_present.size() * out_stride, std::byte{0});
  for (std::size_t texel = 0; texel < band.is_present.size(); ++texel) {
    read_texel(band, layout.is_float, texel, values);
    const std::array<float, 3> seen = display.shown(values);
    bool is_known = true;
    for (std::size_t c = 0; c < shown; ++c) {
      is_known = is_known && std::isfinite(seen[c]);
      if (std::isfinite(seen[c])) out[texel * out_stride + c] = static_cast<std::byte>(std::lround(display.tone(seen[c], range)));
    }
    if (with_alpha && is_known) out[texel * out_stride + shown] = std::byte{255};
  }
}

// Bytes with one more channel: 255 where a tile is present.
void append_alpha(const Band& band, int channels, std::vector<std::byte>& out) {
  const auto stride = static_cast<std::size_t>(channels);
  out.resize(band.is_present.size() * (stride + 1));
  for (std::size_t texel = 0; texel < band.is_present.size(); ++texel) {
    std::memcpy(&out[texel * (stride + 1)], &band.texels[texel * stride], stride);
    out[texel * (stride + 1) + stride] = band.is_present[texel] != 0 ? std::byte{255} : std::byte{0};
  }
}

// Turns "no data" into its number. False when a value that is data is that number already.
bool replace_nan(std::span<std::byte> floats, float nodata) {
  bool is_free = true;
  for (std::size_t at = 0; at < floats.size(); at += sizeof nodata) {
    float value = 0.0F;
    std::memcpy(&value, &floats[at], sizeof value);
    is_free = is_free && value != nodata;
    if (std::isnan(value)) std::memcpy(&floats[at], &nodata, sizeof nodata);
  }
  return is_free;
}

// The rectangle that --window names, in the padded square.
Result<TexelRect> window_rect(const ExtractOptions& options, const LayerInfo& layer, Level level) {
  const TexelRect data = layer.data_rect(level);
  if (options.window.empty()) return data;
  std::array<std::int64_t, 4> numbers{};
  VT_CHECK(cli::parse_integers(options.window, "--window", "X,Y,W,H, four whole numbers", numbers));
  const auto [x, y, width, height] = numbers;
  // Written so that no sum can overflow.
  const bool fits = x >= 0 && y >= 0 && width > 0 && height > 0 && x < data.width && y < data.height && width <= data.width - x &&
                    height <= data.height - y;
  if (!fits) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: --window {} is not inside level {} of layer {}, which is {} x {} texels", options.store.string(),
                            options.window, int{level.value}, layer.name, data.width, data.height));
  }
  return TexelRect{data.x + x, data.y + y, width, height};
}

// Nobody wants a picture of the whole Earth by accident: what takes days, and more than disks hold, is asked
// for piece by piece.
constexpr double kMostBytes = 0x1p44;

Result<void> check_size(const ExtractOptions& options, const LayerInfo& layer, Level level, const TexelRect& rect) {
  const auto bytes_of = [&](const TexelRect& part) {
    return static_cast<double>(part.width) * static_cast<double>(part.height) * static_cast<double>(layout_of(layer).texel_bytes());
  };
  if (bytes_of(rect) <= kMostBytes) return {};
  // What is easy to look at.
  constexpr double kHandyBytes = 0x1p28;
  Level handy = level;
  while (handy.value > 0 && bytes_of(layer.data_rect(handy)) > kHandyBytes) --handy.value;
  const TexelRect coarse = layer.data_rect(handy);
  return fail(
      ErrorCode::kUsage,
      fmt::format("{}: would write {} x {} texels of layer {}, {} uncompressed; choose a part with --window X,Y,W,H, such as 0,0,8192,"
                  "8192, or a coarser level, such as --level {} ({} x {} texels, {})",
                  options.store.string(), rect.width, rect.height, layer.name, cli::format_bytes_of(bytes_of(rect)), int{handy.value},
                  coarse.width, coarse.height, cli::format_bytes_of(bytes_of(coarse))));
}

// The level's own grid: the layer's, with steps 2^k times as long. For the finest level these are exactly the
// source's numbers. Where values do not lie at the centres of their texels, the grid is moved so that the
// centres of its cells are where the values are.
geo::GeoTransform transform_of(const Area& area, const LayerInfo& layer, Level level, const TexelRect& rect) {
  const double scale = std::ldexp(1.0, paper_level(level, layer.finest));
  const double move = layer.value_offset(level) - 0.5;
  const Point2 corner =
      VtMapping(area, layer).crs_from_texel(level, {static_cast<double>(rect.x) + move, static_cast<double>(rect.y) + move});
  geo::GeoTransform transform;
  transform.x0 = corner.x;
  transform.x_column = layer.grid.step_x * scale;
  transform.y0 = corner.y;
  transform.y_row = -layer.grid.step_y * scale;
  return transform;
}

// What GDAL_NODATA and the samples shall say for "no data" in a float layer. Of heights the source's own
// number: there values are the source's own, while in degrees of a direction or kelvins of a code that number
// would be a value like any other.
std::optional<double> nodata_to_write(const LayerInfo& layer, const AbsentTexels& absent) {
  if (absent.code_of_none) return absent.code_of_none;
  if (!std::isnan(absent.value) && !absent.is_data) return std::nullopt;  // it has a value, which is that of texels with data as well
  if (!channels::kind_of(layer.channel).holds_heights || std::abs(layer.source_nodata) > double{std::numeric_limits<float>::max()})
    return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(static_cast<float>(layer.source_nodata));
}

// How the texels without a tile look in the file, for people.
std::string absent_text(const LayerInfo& layer, const AbsentTexels& absent, cli::PictureKind kind) {
  const bool is_float = layout_of(layer).is_float;
  if (absent.is_data) return fmt::format("{:g}, with which voids are filled", absent.value);
  if (absent.code_of_none) return fmt::format("no data, class {:g}", *absent.code_of_none);
  if (has_coverage_channel(layer) || (!is_float && layout_of(layer).channels == 3)) return "transparent";
  if (std::isnan(absent.value)) return kind == cli::PictureKind::kPng ? "transparent" : "no data";
  return fmt::format("{:g}", absent.value);
}

struct Job {
  const store::StoreReader& reader;
  const LayerInfo& layer;
  Level level;
  TexelRect rect;
  std::uint64_t missing_tiles;
  AbsentTexels absent;
};

Result<void> extract_bytes(const ExtractOptions& options, const Job& job, LevelReader& level, cli::PictureSpec spec,
                           cli::Progress& progress) {
  const TexelLayout layout = layout_of(job.layer);
  spec.channels = layout.channels;
  spec.is_srgb = job.layer.transfer == Transfer::kSrgb;
  spec.last_is_alpha = has_coverage_channel(job.layer);
  if (spec.transform) spec.nodata = job.absent.code_of_none;
  const bool needs_alpha = job.missing_tiles > 0 && layout.channels == 3 && !spec.nodata;
  if (needs_alpha) {
    spec.channels = 4;
    spec.last_is_alpha = true;
  }
  VT_ASSIGN(const auto picture, cli::create_picture(options.output, spec));
  std::vector<std::byte> with_alpha;
  const auto write_band = [&](Band& band) -> Result<void> {
    if (needs_alpha) append_alpha(band, layout.channels, with_alpha);
    VT_CHECK(picture->write_rows(needs_alpha ? with_alpha : band.texels, band.rect.height));
    progress.update(static_cast<std::uint64_t>(band.rect.bottom() - job.rect.y));
    return {};
  };
  VT_CHECK(for_each_band(level, job.layer, job.rect, write_band));
  return picture->finish();
}

// With `nodata` in place of NaN, if it is given. False: the file would say that values are missing which are
// not; it was not finished.
Result<bool> write_floats(const ExtractOptions& options, const Job& job, LevelReader& level, const cli::PictureSpec& spec,
                          cli::Progress& progress) {
  const bool replaces = spec.nodata && !std::isnan(*spec.nodata);
  // A class is what says that there is none.
  const bool may_collide = replaces && !job.absent.code_of_none;
  bool is_free = true;
  VT_ASSIGN(const auto picture, cli::create_picture(options.output, spec));
  const auto write_band = [&](Band& band) -> Result<void> {
    if (!is_free) return {};
    if (replaces && !replace_nan(band.texels, static_cast<float>(*spec.nodata)) && may_collide) {
      is_free = false;
      return {};
    }
    VT_CHECK(picture->write_rows(band.texels, band.rect.height));
    progress.update(static_cast<std::uint64_t>(band.rect.bottom() - job.rect.y));
    return {};
  };
  VT_CHECK(for_each_band(level, job.layer, job.rect, write_band));
  if (is_free) VT_CHECK(picture->finish());
  return is_free;
}

Result<void> extract_floats(const ExtractOptions& options, const Job& job, LevelReader& level, cli::PictureSpec spec,
                            cli::Progress& progress) {
  spec.channels = layout_of(job.layer).channels;
  spec.is_float = true;
  const bool is_tiff = spec.transform.has_value();
  spec.last_is_alpha = is_tiff && has_coverage_channel(job.layer);
  if (is_tiff) spec.nodata = nodata_to_write(job.layer, job.absent);  // in a GeoTIFF "no data" has a place
  VT_ASSIGN(const bool is_written, write_floats(options, job, level, spec, progress));
  if (is_written) return {};
  // Such as a mean of heights around 0 where 0 was the source's "no data".
  cli::print_note("vtinspect", fmt::format("{}: {} was the source's \"no data\" and is a value here; NaN is \"no data\" in this file",
                                           options.output.string(), cli::format_exact(*spec.nodata)));
  spec.nodata = std::numeric_limits<double>::quiet_NaN();
  VT_ASSIGN([[maybe_unused]] const bool is_free, write_floats(options, job, level, spec, progress));
  return {};
}

// Twice over the window: once for the range, once to write.
Result<void> extract_stretched(const ExtractOptions& options, const Job& job, const Display& display, LevelReader& level,
                               cli::PictureSpec spec, cli::Progress& progress) {
  const TexelLayout layout = layout_of(job.layer);
  RangeFinder finder(job.layer);
  const auto include_band = [&](Band& band) -> Result<void> {
    std::vector<float> values(static_cast<std::size_t>(layout.channels));
    for (std::size_t texel = 0; texel < band.is_present.size(); ++texel) {
      read_texel(band, layout.is_float, texel, values);
      finder.add(std::span<const float>(display.shown(values)).first(display.channels_with_values()));
    }
    return {};
  };
  VT_CHECK(for_each_band(level, job.layer, job.rect, include_band));
  const ValueRange range = display.fixed_range().value_or(finder.range());
  if (layout.is_float)
    cli::print_note("vtinspect", fmt::format("{}: stretched {:g} .. {:g} to 0 .. 255; write .tif or .exr to keep the values",
                                             options.output.string(), range.min, range.max));

  spec.channels = display.channels() + (finder.has_holes() ? 1 : 0);
  spec.last_is_alpha = finder.has_holes();
  VT_ASSIGN(const auto picture, cli::create_picture(options.output, spec));
  std::vector<std::byte> bytes;
  const auto write_band = [&](Band& band) -> Result<void> {
    stretch(band, layout, display, finder.has_holes(), range, bytes);
    VT_CHECK(picture->write_rows(bytes, band.rect.height));
    progress.update(static_cast<std::uint64_t>(band.rect.bottom() - job.rect.y));
    return {};
  };
  VT_CHECK(for_each_band(level, job.layer, job.rect, write_band));
  return picture->finish();
}

Result<void> extract(const ExtractOptions& options, const Job& job) {
  VT_ASSIGN(const cli::PictureKind kind, cli::picture_kind(options.output));
  const bool is_float = layout_of(job.layer).is_float;
  if (kind == cli::PictureKind::kExr && !is_float) {
    return fail(ErrorCode::kUsage, fmt::format("{}: layer {} holds 8-bit codes ({}) and EXR holds floats; write .png or .tif",
                                               options.output.string(), job.layer.name, format_info(job.layer.format).name));
  }

  cli::PictureSpec spec;
  spec.width = job.rect.width;
  spec.height = job.rect.height;
  if (kind == cli::PictureKind::kTiff) {
    VT_ASSIGN(spec.crs, crs_of(job.reader));
    spec.transform = transform_of(job.reader.description().area, job.layer, job.level, job.rect);
  }

  LevelReader level(job.reader, job.layer, job.level);
  cli::Progress progress(
      {.mode = options.progress, .title = "extracting", .unit = "rows", .total = static_cast<std::uint64_t>(job.rect.height)});
  progress.update(0);
  const Display display(job.layer);
  if (kind == cli::PictureKind::kPng && !display.shows_bytes()) {
    VT_CHECK(extract_stretched(options, job, display, level, spec, progress));
  } else if (!is_float) {
    VT_CHECK(extract_bytes(options, job, level, spec, progress));
  } else {
    VT_CHECK(extract_floats(options, job, level, spec, progress));
  }
  progress.finish();
  return {};
}

}  // namespace

Result<int> run_extract(const ExtractOptions& options) {
  VT_ASSIGN(const cli::PictureKind kind, cli::picture_kind(options.output));
  VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtinspect", options.store));
  VT_ASSIGN(const LayerInfo* const layer, choose_layer(reader, options.choice.layer));
  if (format_info(layer->format).samples == SampleKind::kOpaque)
    return fail(ErrorCode::kUsage, fmt::format("{}: layer {} holds {}", options.store.string(), layer->name,
                                               layer->holds_blobs() ? "blobs, of which there is no picture"
                                                                    : "hashes, of which there is no picture; vtinspect sample shows them"));
  if (options.mosaic) {
    if (kind != cli::PictureKind::kPng)
      return fail(ErrorCode::kUsage, fmt::format("{}: --mosaic writes .png only", options.output.string()));
    VT_ASSIGN(const std::string description, write_mosaic(reader, *layer, options.output));
    cli::print(fmt::format("{}: {}\n", options.output.string(), description));
    return 0;
  }

  VT_ASSIGN(const Level level, choose_level(reader, *layer, options.choice.level));
  VT_ASSIGN(const TexelRect rect, window_rect(options, *layer, level));
  VT_CHECK(check_size(options, *layer, level, rect));
  VT_ASSIGN(const std::uint64_t missing, LevelReader(reader, *layer, level).count_missing(rect));
  const AbsentTexels absent = absent_texels(*layer, level);
  if (missing > 0) {
    cli::print_note("vtinspect",
                    fmt::format("{}: {} tiles of layer {}, level {} are absent; they are written as {}", options.store.string(), missing,
                                layer->name, int{level.value}, absent_text(*layer, absent, kind)));
  }
  VT_CHECK(extract(options, {reader, *layer, level, rect, missing, absent}));
  cli::print(fmt::format("{}: {} x {} texels of layer {}, level {}\n", options.output.string(), rect.width, rect.height, layer->name,
                         int{level.value}));
  return 0;
}

}  // namespace vt::inspect
