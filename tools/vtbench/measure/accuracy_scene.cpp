#include "tools/vtbench/measure/accuracy_scene.h"

#include <fmt/format.h>

#include <array>

#include "builder/sample/bands.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "store/region.h"
#include "store/texel/bc1.h"
#include "tools/vtbench/measure/whole_builds.h"

namespace vt::bench {
namespace {

constexpr std::int64_t kMargin = 8;  // texels; more than the longest kernel of the builder reaches

Result<Codes> level_codes(const store::StoreReader& reader, const LayerInfo& layer, Level level) {
  const TexelRect rect = layer.data_rect(level);
  const auto width = static_cast<std::size_t>(rect.width);
  const auto height = static_cast<std::size_t>(rect.height);
  std::vector<std::byte> payload(payload_bytes(format_info(layer.format), width, height));
  VT_ASSIGN(const store::RegionReport report, store::read_region(reader, layer.id, level, rect, payload));
  if (report.texels_own_level != width * height) return fail(ErrorCode::kInternal, "the store that was just built lacks tiles");
  Codes rgb(width * height * 3);
  if (layer.format == TexelFormat::kRgb8) {
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = std::to_integer<std::uint8_t>(payload[i]);
    return rgb;
  }
  if (layer.format != TexelFormat::kBc1) return fail(ErrorCode::kUnsupported, "errors are known of RGB8 and BC1 only");
  std::vector<std::byte> rgba(width * height * 4);
  store::decode_bc1_image(payload, width, height, rgba);
  for (std::size_t i = 0; i < width * height; ++i)
    for (std::size_t p = 0; p < 3; ++p) rgb[i * 3 + p] = std::to_integer<std::uint8_t>(rgba[i * 4 + p]);
  return rgb;
}

Result<Codes> tiff_codes(const std::filesystem::path& path) {
  VT_ASSIGN(const auto raster, source::open_raster(path));
  const source::RasterInfo& info = raster->info();
  if (info.bands < 3 || info.sample_type != SampleType::kUint8)
    return fail(ErrorCode::kInvalidData, path.string() + ": not three bands of 8 bits");
  const auto pitch = static_cast<std::size_t>(info.width) * 3;
  std::vector<std::byte> bytes(pitch * static_cast<std::size_t>(info.height));
  VT_CHECK(raster->read({0, 0, info.width, info.height}, std::array{0, 1, 2}, bytes, pitch));
  Codes rgb(bytes.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = std::to_integer<std::uint8_t>(bytes[i]);
  return rgb;
}

}  // namespace

Codes paint_scene(std::int64_t size) {
  const sample::World world(1);
  Codes rgb;
  sample::Band band;
  for (std::int64_t index = 0; index < sample::band_count(size); ++index) {
    sample::paint_band(world, size, index, band);
    rgb.insert(rgb.end(), band.rgb.begin(), band.rgb.end());
  }
  return rgb;
}

Result<void> write_scene(const std::filesystem::path& path, const Codes& rgb, std::int64_t size) {
  source::GeoTiffSpec spec;
  spec.width = size;
  spec.height = size;
  spec.bands = 3;
  spec.transform = geo::GeoTransform{500000.0, sample::kTexelMetres, 0.0, 5400000.0, 0.0, -sample::kTexelMetres};
  VT_ASSIGN(spec.crs, geo::Crs::from_epsg(32633));
  VT_ASSIGN(source::GeoTiffWriter writer, source::GeoTiffWriter::create(path, spec));
  VT_CHECK(writer.write_rows(std::as_bytes(std::span(rgb)), size));
  return writer.finish();
}

Truth make_truth(Codes base, std::int64_t size, const std::vector<std::string>& kernels) {
  Truth truth;
  truth.base = std::move(base);
  const LightImage light = light_from_codes(truth.base, size, size);
  const auto pyramid = [&](const auto& halve) {
    std::vector<LightImage> levels;
    for (std::int64_t edge = size / 2; edge >= kSmallestLevel; edge /= 2) levels.push_back(halve(levels.empty() ? light : levels.back()));
    return levels;
  };
  truth.ideal = pyramid([](const LightImage& fine) { return halve_ideally(fine); });
  for (const std::string& kernel : kernels)
    if (const auto taps = kernel_taps(kernel))
      truth.by_kernel[kernel] = pyramid([&](const LightImage& fine) { return halve_exactly(fine, *taps); });
  for (std::int64_t edge = size; edge > kSmallestLevel; edge /= 2)
    truth.codes_averaged.push_back(halve_codes(truth.codes_averaged.empty() ? truth.base : truth.codes_averaged.back(), edge, edge));
  return truth;
}

Result<std::vector<Codes>> levels_of_store(const std::filesystem::path& path, std::size_t overviews) {
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
  const LayerInfo* layer = reader.find_layer("color");
  if (layer == nullptr || layer->finest.value < overviews) return fail(ErrorCode::kInternal, "the store that was just built lacks levels");
  std::vector<Codes> levels;
  for (std::size_t k = 0; k <= overviews; ++k) {
    VT_ASSIGN(Codes codes, level_codes(reader, *layer, Level{static_cast<std::uint8_t>(layer->finest.value - k)}));
    levels.push_back(std::move(codes));
  }
  return levels;
}

Result<std::vector<Codes>> levels_of_tiff(const std::filesystem::path& path, std::size_t overviews, const std::filesystem::path& gdal,
                                          const std::filesystem::path& scratch) {
  std::vector<Codes> levels;
  VT_ASSIGN(Codes base, tiff_codes(path));
  levels.push_back(std::move(base));
  const auto level_file = scratch / "level.tif";
  const auto messages = scratch / "messages.txt";
  for (std::size_t k = 0; k < overviews; ++k) {
    const std::vector<std::string> arguments = {gdal.string(), "-q", "-ovr", std::to_string(k), path.string(), level_file.string()};
    VT_CHECK(run_checked({arguments, {}, messages, messages}));
    VT_ASSIGN(Codes codes, tiff_codes(level_file));
    levels.push_back(std::move(codes));
    std::filesystem::remove(level_file);
  }
  return levels;
}

Errors errors_of(const std::vector<Codes>& levels, const Truth& truth, const std::string& kernel, std::size_t first_overview) {
  Errors errors;
  if (first_overview > 0) errors.base_psnr_code_db = psnr_of_codes_db(levels.front(), truth.base);
  const auto own = truth.by_kernel.find(kernel);
  if (own != truth.by_kernel.end()) errors.from_kernel.emplace();
  for (std::size_t k = 0; k < truth.ideal.size(); ++k) {
    const Codes& codes = levels[k + first_overview];
    errors.from_ideal.add_level(codes, truth.ideal[k], kMargin);
    if (errors.from_kernel) errors.from_kernel->add_level(codes, own->second[k], kMargin);
  }
  return errors;
}

}  // namespace vt::bench
