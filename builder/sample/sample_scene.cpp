#include "builder/sample/sample_scene.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <system_error>

#include "builder/geo/crs.h"
#include "builder/sample/bands.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "builder/text/json_text.h"
#include "builder/text/text_file.h"
#include "store/io/output_file.h"

namespace vt::sample {
namespace {

// Made-up land at a real place: off the coast of northern Norway.
constexpr int kEpsg = 32633;
constexpr double kCentreEast = 433000.0;
constexpr double kCentreNorth = 7568000.0;

constexpr std::array<const char*, 6> kFiles{"imagery.tif", "elevation.tif", "materials.tif", "materials.json", "lights.json", "SCENE.json"};
constexpr const char* kSceneName = "Sample coast, seed ";

struct MaterialRow {
  Material material;
  const char* name;
  std::array<int, 3> color;  // for maps
};
constexpr std::array<MaterialRow, 9> kMaterials{{{Material::kWater, "water", {38, 84, 124}},
                                                 {Material::kSand, "sand", {226, 205, 150}},
                                                 {Material::kGrass, "grass", {128, 168, 82}},
                                                 {Material::kForest, "forest", {42, 94, 48}},
                                                 {Material::kRock, "rock", {136, 130, 124}},
                                                 {Material::kSnow, "snow", {244, 248, 252}},
                                                 {Material::kField, "field", {214, 184, 92}},
                                                 {Material::kRoad, "road", {70, 70, 76}},
                                                 {Material::kBuilding, "building", {186, 84, 62}}}};

struct Rectangle {
  double west, south, east, north;
};
Rectangle area_of(std::int64_t size) {
  const double half = static_cast<double>(size) * kTexelMetres / 2.0;
  return {kCentreEast - half, kCentreNorth - half, kCentreEast + half, kCentreNorth + half};
}

source::GeoTiffSpec spec_of(std::int64_t size, int step, int bands, source::SampleType type, const geo::Crs& crs) {
  const Rectangle area = area_of(size);
  source::GeoTiffSpec spec;
  spec.width = spec.height = size / step;
  spec.bands = bands;
  spec.sample_type = type;
  spec.transform = geo::GeoTransform{
      .x0 = area.west, .x_column = kTexelMetres * step, .x_row = 0.0, .y0 = area.north, .y_column = 0.0, .y_row = -kTexelMetres * step};
  spec.crs = crs;
  spec.tile = 256;
  return spec;
}

std::string materials_json() {
  nlohmann::ordered_json classes = nlohmann::ordered_json::array();
  for (const MaterialRow& row : kMaterials)
    classes.push_back({{"id", static_cast<int>(row.material)}, {"name", row.name}, {"color", row.color}});
  const nlohmann::ordered_json document = {{"format", "vt-materials"}, {"version", 1}, {"file", "materials.tif"}, {"classes", classes}};
  return document.dump(2) + "\n";
}

std::string lights_json(const std::vector<Light>& lights) {
  // One light a line, so that a large list stays readable and needs no tree in memory.
  std::string text = fmt::format(
      "{{\n  \"format\": \"vt-lights\",\n  \"version\": 1,\n  \"crs\": \"EPSG:{}\",\n"
      "  \"about\": \"position: CRS coordinates; height_m: above ground; color: linear RGB, largest 1; power_w: radiant power, all "
      "directions\",\n"
      "  \"lights\": [",
      kEpsg);
  const char* separator = "\n";
  for (const Light& light : lights) {
    text += fmt::format(
        "{}    {{\"position\": [{:.2f}, {:.2f}], \"height_m\": {:.2f}, \"color\": [{:.2f}, {:.2f}, {:.2f}], \"power_w\": {:.1f}}}",
        separator, kCentreEast + light.position.x, kCentreNorth + light.position.y, light.height_m, light.red, light.green, light.blue,
        light.power_w);
    separator = ",\n";
  }
  return text + "\n  ]\n}\n";
}

std::string scene_json(const SampleOptions& options) {
  const Rectangle area = area_of(options.size);
  const nlohmann::ordered_json document = {
      {"format", "vt-scene"},
      {"version", 1},
      {"name", fmt::format("{}{}", kSceneName, options.seed)},
      {"crs", fmt::format("EPSG:{}", kEpsg)},
      {"area", {{"west", area.west}, {"south", area.south}, {"east", area.east}, {"north", area.north}}},
      {"layers",
       {{{"name", "color"},
         {"channel", "color"},
         {"sources", {"imagery.tif"}},
         {"format", "rgb8"},
         {"kernel", "kaiser3"},
         {"compression", "zstd:3"},
         {"tile", 256},
         {"gsd", kTexelMetres}},
        {{"name", "elevation"},
         {"channel", "elevation"},
         {"sources", {"elevation.tif"}},
         {"format", "r32f"},
         {"kernel", "box"},
         {"compression", "zstd:3"},
         {"tile", 256},
         {"gsd", kTexelMetres * kHeightStep}},
        {{"name", "material"},
         {"channel", "material"},
         {"sources", {"materials.tif"}},
         {"format", "r8"},
         {"options", {{"classes", "materials.json"}, {"mixture", 3}}},
         {"compression", "zstd:3"},
         {"tile", 256},
         {"gsd", kTexelMetres * kMaterialStep}}}},
      {"references",
       {{{"role", "materials"}, {"file", "materials.tif"}},
        {{"role", "material-names"}, {"file", "materials.json"}},
        {{"role", "lights"}, {"file", "lights.json"}}}}};
  return document.dump(2) + "\n";
}

bool is_sample_scene(const std::filesystem::path& scene) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  const auto content = text::read_text_file(scene, kMostBytes);
  const nlohmann::ordered_json json = content ? text::json_or_null(*content) : nlohmann::ordered_json();
  return json.is_object() && json.value("format", nlohmann::ordered_json()) == "vt-scene" && json.contains("name") &&
         json["name"].is_string() && json["name"].get<std::string>().starts_with(kSceneName);
}

Result<void> check_what_is_there(const std::filesystem::path& folder) {
  std::error_code missing;
  const std::filesystem::path scene = folder / "SCENE.json";
  const bool is_ours = is_sample_scene(scene);
  const auto finished = std::filesystem::last_write_time(scene, missing);
  std::string others;
  for (const char* name : kFiles) {
    const bool is_there = std::filesystem::exists(std::filesystem::symlink_status(folder / name, missing));
    if (!is_there) continue;
    const auto written = std::filesystem::last_write_time(folder / name, missing);
    if (!is_ours || missing || written > finished) others += (others.empty() ? "" : ", ") + std::string(name);
  }
  if (others.empty()) return {};
  return fail(ErrorCode::kExists, fmt::format("{}: has files that a sample scene would replace and that were not made as part of one, or "
                                              "were changed since: {}; choose another folder, or replace them with `force`",
                                              folder.string(), others));
}

}  // namespace

Result<void> write_sample_scene(const std::filesystem::path& dir, const SampleOptions& options) {
  if (options.size < kMinSampleSize || options.size > kMaxSampleSize || options.size % 8 != 0)
    return fail(ErrorCode::kUsage, fmt::format("a sample scene of {} texels cannot be made; choose a multiple of 8 from {} to {}",
                                               options.size, kMinSampleSize, kMaxSampleSize));
  if (!options.replace_anything) VT_CHECK(check_what_is_there(dir));
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("{}: cannot make the folder: {}", dir.string(), error.message()));

  VT_ASSIGN(const geo::Crs crs, geo::Crs::from_epsg(kEpsg));
  using source::GeoTiffWriter;
  using source::SampleType;
  VT_ASSIGN(GeoTiffWriter imagery, GeoTiffWriter::create(dir / "imagery.tif", spec_of(options.size, 1, 3, SampleType::kUint8, crs)));
  source::GeoTiffSpec elevation_spec = spec_of(options.size, kHeightStep, 1, SampleType::kFloat32, crs);
  elevation_spec.nodata = static_cast<double>(kVoid);
  VT_ASSIGN(GeoTiffWriter elevation, GeoTiffWriter::create(dir / "elevation.tif", elevation_spec));
  VT_ASSIGN(GeoTiffWriter materials,
            GeoTiffWriter::create(dir / "materials.tif", spec_of(options.size, kMaterialStep, 1, SampleType::kUint8, crs)));

  const World world(options.seed);
  Band band;
  const std::int64_t bands = band_count(options.size);
  for (std::int64_t i = 0; i < bands; ++i) {
    if (options.progress && !options.progress(static_cast<double>(i) / static_cast<double>(bands)))
      return fail(ErrorCode::kCancelled, "the sample scene was not finished");
    paint_band(world, options.size, i, band);
    VT_CHECK(imagery.write_rows(std::as_bytes(std::span(band.rgb)), band.rows));
    VT_CHECK(elevation.write_rows(std::as_bytes(std::span(band.height_m)), band.rows / kHeightStep));
    VT_CHECK(materials.write_rows(std::as_bytes(std::span(band.material)), band.rows / kMaterialStep));
  }
  VT_CHECK(imagery.finish());
  VT_CHECK(elevation.finish());
  VT_CHECK(materials.finish());
  VT_CHECK(store::write_whole_file(dir / "materials.json", materials_json()));
  VT_CHECK(store::write_whole_file(dir / "lights.json", lights_json(lights_of(world, options.size))));
  // Last, so that a folder with a SCENE.json is complete.
  VT_CHECK(store::write_whole_file(dir / "SCENE.json", scene_json(options)));
  if (options.progress) (void)options.progress(1.0);
  return {};
}

}  // namespace vt::sample
