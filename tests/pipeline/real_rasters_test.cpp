// Real files, built and compared with what GDAL says is in them and where it lies.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

const std::filesystem::path kData = VT_TEST_DATA;

struct RealCase {
  std::string file;
  ChannelType channel = ChannelType::kColor;
  std::vector<int> bands;      // of the layer's channels, counted from 1
  std::optional<Area> extent;  // for the picture that carries none
  double tolerance = 0.0;      // lossy decoders may differ by a few counts
};

std::vector<RealCase> real_cases() {
  return {
      {"imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif", ChannelType::kColor, {1, 2, 3, 4}, {}, 0.0},
      {"imagery/swellendam_3320D_2010_315_RGB_LATLNG.tif", ChannelType::kColor, {1, 2, 3, 4}, {}, 0.0},
      {"imagery/olinda_L7_ETMs.tif", ChannelType::kColor, {3, 2, 1}, {}, 0.0},
      {"imagery/hro_colorado_0x15m.tif", ChannelType::kColor, {1, 2, 3}, {}, 0.0},
      {"imagery/hro_colorado_0x15m_alpha.tif", ChannelType::kColor, {1, 2, 3, 4}, {}, 0.0},
      {"imagery/hro_colorado_0x15m_mask.tif", ChannelType::kColor, {1, 2, 3}, {}, 0.0},
      {"imagery/rio_color_rgb8.tif", ChannelType::kColor, {1, 2, 3}, {}, 0.0},
      {"elevation/everest_srtm_90m.tif", ChannelType::kElevation, {1}, {}, 0.0},
      {"elevation/dom1_32_356_5699_1_nw_2020.tif", ChannelType::kElevation, {1}, {}, 0.0},
      {"elevation/N49W123.tif", ChannelType::kElevation, {1}, {}, 0.0},
      {"elevation/hypsometry_3857.tif", ChannelType::kElevation, {1}, {}, 0.0},
      // JPEG decoders may round differently in the inverse transform and the colour conversion.
      {"global/bmng_5400x2700.jpg", ChannelType::kColor, {1, 2, 3}, Area{-180, -90, 180, 90}, 4.0},
  };
}

class RealRasters : public testing::TestWithParam<RealCase> {
 protected:
  static const nlohmann::json& truth() {
    static const nlohmann::json document = [] {
      std::ifstream file(kData / "truth.json");
      nlohmann::json files = nlohmann::json::parse(file).at("files");
      nlohmann::json by_path;
      for (auto& one : files) by_path[one.at("path").get<std::string>()] = one;
      return by_path;
    }();
    return document;
  }
};

TEST_P(RealRasters, FinestLevelHoldsTheFilesOwnSamplesInTheirPlace) {
  const RealCase& c = GetParam();
  if (!std::filesystem::exists(kData / "truth.json"))
    GTEST_SKIP() << "no real rasters in " << kData << "; set VT_TEST_DATA to compare with them";
  const nlohmann::json& facts = truth().at(c.file);
  const test::TempFolder folder;
  LayerRequest request = request_for({kData / c.file}, c.channel);
  request.tile_texels = 256;
  if (c.bands.size() == 3) request.sources[0].bands = c.bands;
  if (c.extent) {
    request.sources[0].extent = c.extent;
    request.sources[0].fallback_crs = geo::Crs::from_epsg(4326).value();
  }
  build(folder / "a.vts", request);
  const auto validation = store::validate(folder / "a.vts");
  ASSERT_TRUE(validation.has_value() && validation->ok());

  auto reader = store::StoreReader::open(folder / "a.vts");
  const LayerInfo& layer = *reader->find_layer(request.name);
  ASSERT_EQ(layer.data.width, facts.at("width").get<std::int64_t>());
  ASSERT_EQ(layer.data.height, facts.at("height").get<std::int64_t>());

  // Values.
  const Tiles tiles = tiles_of(folder / "a.vts", request.name);
  const int texel_channels = format_info(layer.format).channels;
  for (std::size_t k = 0; k < c.bands.size(); ++k) {
    const nlohmann::json& band = facts.at("band_info").at(static_cast<std::size_t>(c.bands[k] - 1));
    for (const nlohmann::json& sample : band.at("samples")) {
      const auto x = sample[0].get<std::int64_t>();
      const auto y = sample[1].get<std::int64_t>();
      const std::string where = c.file + " band " + std::to_string(c.bands[k]) + " sample " + std::to_string(x) + "," + std::to_string(y);
      if (c.channel == ChannelType::kElevation) {
        const auto wanted = sample[2].get<double>();
        const bool is_void = !band.at("nodata").is_null() && wanted == band.at("nodata").get<double>();
        const bool has_tile = tiles.contains({layer.finest, static_cast<std::uint32_t>(x >> 8), static_cast<std::uint32_t>(y >> 8)});
        if (is_void && !has_tile) continue;
        const float found = texel_at<float, 1>(tiles, 8, layer.finest, x, y)[0];
        if (is_void) {
          EXPECT_TRUE(std::isnan(found)) << where;
        } else {
          EXPECT_EQ(found, static_cast<float>(wanted)) << where;
        }
      } else {
        const double found = texel_channels == 4 ? (texel_at<std::uint8_t, 4>(tiles, 8, layer.finest, x, y))[k]
                                                 : (texel_at<std::uint8_t, 3>(tiles, 8, layer.finest, x, y))[k];
        EXPECT_NEAR(found, sample[2].get<double>(), c.tolerance) << where;
      }
    }
  }

  // Places: corners and centre of the data rectangle, on the file's own datum.
  if (!facts.contains("lonlat_own_datum")) return;
  const auto metadata = nlohmann::json::parse(reader->description().metadata_json);
  const geo::Crs crs = geo::Crs::from_json(metadata.at("crs")).value();
  const VtMapping mapping(reader->description().area, layer);
  const auto w = static_cast<double>(layer.data.width);
  const auto h = static_cast<double>(layer.data.height);
  const std::map<std::string, Point2> corners = {
      {"upper_left", {0, 0}}, {"upper_right", {w, 0}}, {"lower_right", {w, h}}, {"lower_left", {0, h}}, {"centre", {w / 2, h / 2}}};
  for (const auto& [name, texel] : corners) {
    const nlohmann::json& wanted = facts.at("lonlat_own_datum").at(name);
    const Point2 found = crs.lonlat_from_crs(mapping.crs_from_texel(layer.finest, texel)).value();
    // 1e-9 degree, and half the last of the ten decimals that the truth is written with.
    EXPECT_NEAR(found.x, wanted[0].get<double>(), 1e-9 + 5e-11) << c.file << " " << name;
    EXPECT_NEAR(found.y, wanted[1].get<double>(), 1e-9 + 5e-11) << c.file << " " << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, RealRasters, testing::ValuesIn(real_cases()), [](const auto& one) {
  std::string name = std::filesystem::path(one.param.file).stem().string();
  for (char& ch : name)
    if (!isalnum(static_cast<unsigned char>(ch))) ch = '_';
  return name;
});

}  // namespace
}  // namespace vt::pipeline
