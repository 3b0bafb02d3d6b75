// Every TIFF of the real-raster collection against what GDAL recorded about it in truth.json: size, type,
// nodata, place, every pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "tests/source/sha256.h"

namespace vt::source {
namespace {

using Json = nlohmann::json;

// Valid files, or what GDAL takes for such, that we refuse, with a piece of the message. Anything else must
// read.
const std::map<std::string, std::string> kRefused = {
    {"geotiff-variants/encodings/flower-separated-planar-16.tif", "PhotometricInterpretation 5"},
    {"geotiff-variants/encodings/seq-4c-16b-cmyk-c6e52592.tiff", "PhotometricInterpretation 5"},
    {"geotiff-variants/encodings/libtiffpic_off_luv32.tif", "PhotometricInterpretation 32845"},
    {"geotiff-variants/encodings/minisblack-2c-8b-alpha.tiff", "associated alpha"},
    {"geotiff-variants/encodings/gradient-1c-64b.tiff", "64 bits"},
    {"geotiff-variants/gdal/gtiff_int64_full_range.tif", "64 bits"},
    {"geotiff-variants/gdal/gtiff_uint64_full_range.tif", "64 bits"},
    {"geotiff-variants/gdal/gtiff_uint64_LZW_predictor_2.tif", "64 bits"},
    {"geotiff-variants/gdal/gtiff_rgbsmall_uint64_LZW_predictor_2.tif", "64 bits"},
    {"geotiff-variants/gdal/gtiff_stefan_full_greyalpha_uint64_LZW_predictor_2.tif", "64 bits"},
    {"geotiff-variants/gdal/int64.tif", "64 bits"},
    {"geotiff-variants/gdal/uint64.tif", "64 bits"},
    {"geotiff-variants/gdal/int24.tif", "24 bits"},
    {"geotiff-variants/gdal/cfloat32.tif", "complex"},
    {"geotiff-variants/gdal/cfloat64.tif", "complex"},
    {"geotiff-variants/gdal/cint16.tif", "complex"},
    {"geotiff-variants/gdal/cint32.tif", "complex"},
    {"geotiff-variants/gdal/cint_sar.tif", "complex"},
    {"geotiff-variants/gdal/complex_float32.tif", "complex"},
    {"geotiff-variants/gdal/complex_int32.tif", "complex"},
    {"geotiff-variants/gdal/gtiff_cint32_big_endian.tif", "complex"},
    {"geotiff-variants/gdal/gtiff_complex_non_zero_real_zero_imag.tif", "complex"},
};

// Files that do not tell where all their blocks are (tables too short, or a block at byte 0, which is the
// header): GDAL guesses, we give an error when the missing blocks are read.
const std::set<std::string> kDamagedTables = {
    "geotiff-variants/gdal/minimum_tiff_tags_no_warning.tif",
    "geotiff-variants/gdal/minimum_tiff_tags_with_warning.tif",
    "geotiff-variants/corrupt/size_of_stripbytecount_at_1_and_lower_than_stripcount.tif",
    "geotiff-variants/corrupt/stripbytecounts_count_not_same_as_stripoffsets_count.tif",
};

const Json& truth() {
  static const Json value = [] {
    std::ifstream file(std::string(VT_TEST_DATA) + "/truth.json");
    return file ? Json::parse(file) : Json();
  }();
  return value;
}

double number(const Json& value) {
  if (value.is_number()) return value.get<double>();
  const auto& text = value.get_ref<const std::string&>();
  if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
  return text == "-Infinity" ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

double sample_at(const std::byte* place, SampleType type) {
  return visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
    T value;
    std::memcpy(&value, place, sizeof value);
    return static_cast<double>(value);
  });
}

const std::map<std::string, SampleType> kGdalTypes = {
    {"Byte", SampleType::kUint8},    {"Int8", SampleType::kInt8},   {"UInt16", SampleType::kUint16},   {"Int16", SampleType::kInt16},
    {"UInt32", SampleType::kUint32}, {"Int32", SampleType::kInt32}, {"Float32", SampleType::kFloat32}, {"Float64", SampleType::kFloat64}};

class Truth : public testing::Test {
 protected:
  void SetUp() override {
    if (truth().is_null()) GTEST_SKIP() << "no real rasters at " << VT_TEST_DATA;
  }
};

std::filesystem::path data_path(const Json& file) { return std::filesystem::path(VT_TEST_DATA) / file.at("path").get<std::string>(); }

bool is_tiff(const Json& file) { return file.contains("tiff") && file.at("tiff").is_object(); }

// What GDAL says of every band: its colour and scale, and whether a mask or an alpha band covers it.
void compare_meaning(const Json& file, const RasterInfo& info) {
  const std::map<std::string, BandRole> roles = {{"Gray", BandRole::kGrey}, {"Red", BandRole::kRed},        {"Green", BandRole::kGreen},
                                                 {"Blue", BandRole::kBlue}, {"Alpha", BandRole::kCoverage}, {"Palette", BandRole::kIndex}};
  const Json& bands = file.at("band_info");
  const std::string photometric = file.at("tiff").at("photometric").get<std::string>();
  // To GDAL bits and MinIsWhite codes are a palette of greys, and any colour map is a palette; only one alpha
  // band counts.
  const bool is_grey = photometric == "min-is-white" || photometric == "min-is-black";
  const bool is_converted = !is_grey && photometric != "rgb" && photometric != "palette" && photometric != "ycbcr";
  bool has_alpha = false;
  for (const Json& band : bands) has_alpha = has_alpha || band.at("color_interp") == "Alpha";
  for (std::size_t b = 0; b < bands.size() && b < info.meaning.size() && !is_converted; ++b) {
    SCOPED_TRACE("band " + std::to_string(b));
    const Json& band = bands[b];
    const BandMeaning& ours = info.meaning[b];
    const auto role = roles.find(band.at("color_interp").get<std::string>());
    const bool is_known = role != roles.end();
    if (is_known && role->second == BandRole::kCoverage) {
      EXPECT_TRUE(ours.role == BandRole::kCoverage || static_cast<int>(b) != info.alpha_band);
    } else if (is_known && !(is_grey && role->second == BandRole::kIndex)) {
      EXPECT_EQ(ours.role, role->second) << band.at("color_interp");
    } else if (!is_known && photometric != "min-is-white") {
      EXPECT_TRUE(ours.role == BandRole::kUnknown || ours.role == BandRole::kOther);
    }
    EXPECT_EQ(ours.scale.value_or(1.0), band.contains("scale") ? number(band.at("scale")) : 1.0);
    // GDAL 3.6.2 does not yet look at the third number of the pixel scale, which beside a vertical system
    // scales the heights.
    const bool has_height_scale = file.at("path") == "geotiff-variants/gdal/tiff_vertcs_scale_offset.tif";
    EXPECT_EQ(info.heights.scale.value_or(1.0), has_height_scale ? 2.0 : 1.0);
    const auto mask = band.value("mask", std::vector<std::string>{});
    const auto has_flag = [&](const char* flag) { return std::ranges::find(mask, flag) != mask.end(); };
    if (has_flag("per_dataset") && !has_flag("nodata")) {
      EXPECT_GE(info.alpha_band, 0) << band.at("mask");
      EXPECT_EQ(info.alpha_is_mask, !has_flag("alpha")) << band.at("mask");
    } else if (!has_alpha) {
      EXPECT_LT(info.alpha_band, 0) << band.value("mask", Json());
    }
  }
}

void compare_info(const Json& file, const RasterInfo& info) {
  EXPECT_EQ(info.width, file.at("width").get<std::int64_t>());
  EXPECT_EQ(info.height, file.at("height").get<std::int64_t>());
  EXPECT_EQ(sample_name(info.sample_type), std::string(sample_name(kGdalTypes.at(file.at("dtype").get<std::string>()))));

  const Json& nodata = file.at("band_info").at(0).at("nodata");
  const auto& ours_nodata = info.meaning.at(0).nodata;
  EXPECT_EQ(ours_nodata.has_value(), !nodata.is_null());
  if (ours_nodata && !nodata.is_null()) {
    EXPECT_TRUE(same(*ours_nodata, number(nodata))) << *ours_nodata << " for " << nodata;
  }

  const bool has_transform = file.contains("geotransform") && !file.at("geotransform").is_null();
  if (info.has_transform && !has_transform && file.contains("gcps")) {
    // GDAL leaves tie points as they are; on a grid they place the raster. Its columns and rows count from
    // the outer corner, too.
    for (const Json& tie : file.at("gcps").at("first")) {
      const Point2 place = info.transform.crs_from_raster({tie[0].get<double>(), tie[1].get<double>()});
      EXPECT_NEAR(place.x, tie[2].get<double>(), 1e-3 * std::abs(info.transform.x_column));
      EXPECT_NEAR(place.y, tie[3].get<double>(), 1e-3 * std::abs(info.transform.y_row));
    }
    return;
  }
  EXPECT_EQ(info.has_transform, has_transform);
  if (info.has_transform && has_transform) {
    const auto t = file.at("geotransform").get<std::vector<double>>();
    const geo::GeoTransform& g = info.transform;
    const std::array<double, 6> ours = {g.x0, g.x_column, g.x_row, g.y0, g.y_column, g.y_row};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(ours[i], t[i], 1e-12 * std::max(1e-3, std::abs(t[i]))) << "geotransform " << i;
  }
}

// All pixels of all bands, a few rows at a time.
void compare_pixels(const Json& file, const RasterSource& source) {
  const RasterInfo& info = source.info();
  const auto& bands = file.at("band_info");
  const std::size_t bytes = sample_bytes(info.sample_type);
  const bool lossy = file.at("lossy_decoder").get<bool>();
  // GDAL keeps associated alpha multiplied in; we divide it out, so colours follow from GDAL's colour and
  // alpha codes.
  const bool associated = file.at("tiff").at("extra_samples") == Json::array({1});
  for (std::size_t b = 0; b < bands.size() && static_cast<int>(b) < info.bands; ++b) {
    const Json& band = bands[b];
    const std::array<int, 1> wanted = {static_cast<int>(b)};
    test::Sha256 hash;
    constexpr std::int64_t kRows = 64;
    std::vector<std::byte> rows;
    const bool whole = band.contains("sha256_pixels") && !band.at("sha256_pixels").is_null() && !lossy &&
                       !(associated && static_cast<int>(b) != info.alpha_band);
    for (std::int64_t y = 0; whole && y < info.height; y += kRows) {
      const std::int64_t count = std::min(kRows, info.height - y);
      rows.assign(static_cast<std::size_t>(count * info.width) * bytes, std::byte{0});
      const auto read = source.read({0, y, info.width, count}, wanted, rows, static_cast<std::size_t>(info.width) * bytes);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      hash.add(rows);
    }
    if (whole) {
      EXPECT_EQ(hash.hex(), band.at("sha256_pixels").get<std::string>()) << "band " << b;
    }
    const Json samples = band.value("samples", Json::array());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Json& sample = samples[i];
      double wanted_value = number(sample[2]);
      if (associated && static_cast<int>(b) != info.alpha_band) {
        const double alpha = number(bands[static_cast<std::size_t>(info.alpha_band)].at("samples")[i][2]);
        const double top = std::pow(2.0, 8.0 * static_cast<double>(bytes)) - 1.0;
        wanted_value = alpha == 0.0 ? 0.0 : std::min(top, std::floor(wanted_value * top / alpha + 0.5));
      }
      std::vector<std::byte> one(bytes);
      const auto read = source.read({sample[0].get<std::int64_t>(), sample[1].get<std::int64_t>(), 1, 1}, wanted, one, bytes);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      const double ours = sample_at(one.data(), info.sample_type);
      // Another JPEG or WebP decoder may round differently by a few codes.
      const bool equal = lossy ? std::abs(ours - wanted_value) <= 4.0 : same(ours, wanted_value);
      EXPECT_TRUE(equal) << "band " << b << " at " << sample << ": " << ours;
    }
  }
}

TEST_F(Truth, EveryCleanTiffReadsAsGdalReadsItOrIsRefusedForTheListedReason) {
  OpenOptions options;
  options.as_numbers = true;  // GDAL gives a palette's indices, and MinIsWhite codes as they are
  int read_well = 0;
  int refused = 0;
  for (const Json& file : truth().at("files")) {
    if (!is_tiff(file) || !file.value("gdal_clean", Json()).is_boolean() || !file.at("gdal_clean").get<bool>()) continue;
    const auto path = file.at("path").get<std::string>();
    SCOPED_TRACE(path);
    const auto source = open_raster(data_path(file), options);
    const auto listed = kRefused.find(path);
    if (!source) {
      ++refused;
      EXPECT_EQ(source.error().code, ErrorCode::kUnsupported) << source.error().message;
      EXPECT_NE(listed, kRefused.end()) << source.error().message;
      if (listed != kRefused.end()) {
        EXPECT_NE(source.error().message.find(listed->second), std::string::npos) << source.error().message;
      }
      continue;
    }
    EXPECT_EQ(listed, kRefused.end()) << "reads now; take it off the list";
    if (kDamagedTables.contains(path)) {
      const RasterInfo& info = (*source)->info();
      std::vector<std::byte> pixels(static_cast<std::size_t>(info.width * info.height));
      const std::array<int, 1> first_band = {0};
      const auto read = (*source)->read({0, 0, info.width, info.height}, first_band, pixels, static_cast<std::size_t>(info.width));
      ASSERT_FALSE(read.has_value());
      EXPECT_EQ(read.error().code, ErrorCode::kCorrupt) << read.error().message;
      continue;
    }
    compare_info(file, (*source)->info());
    compare_meaning(file, (*source)->info());
    compare_pixels(file, **source);
    ++read_well;
  }
  RecordProperty("read", read_well);
  RecordProperty("refused", refused);
  EXPECT_EQ(refused, static_cast<int>(kRefused.size()));
}

// Longitudes that differ by a turn are the same place.
double turn_difference(double a, double b) { return std::abs(std::remainder(a - b, 360.0)); }

TEST_F(Truth, CornersLieWhereProjPutsThemOnTheirOwnDatum) {
  // The requirement is 1e-9 degree; the recorded numbers have 10 decimals, so half of the last one comes on
  // top.
  constexpr double kToleranceDeg = 1e-9 + 0.5e-10;
  constexpr double kInverseToleranceM = 1e-6;
  int checked = 0;
  for (const Json& file : truth().at("files")) {
    if (!is_tiff(file) || !file.contains("lonlat_own_datum") || !file.at("lonlat_own_datum").is_object()) continue;
    const auto source = open_raster(data_path(file));
    if (!source || !(*source)->info().crs || !(*source)->info().has_transform) continue;
    const RasterInfo& info = (*source)->info();
    SCOPED_TRACE(file.at("path").get<std::string>() + " " + info.crs->text());
    // PROJ 9.1.1 finds latitudes of this projection by a series that is off by up to 2e-8 degree;
    // projection_truth_test.cpp holds ours to the closed form.
    const bool is_by_series = std::holds_alternative<geo::CylindricalEqualArea>(info.crs->definition().projection);
    const double latitude_tolerance_deg = is_by_series ? 2e-8 : kToleranceDeg;
    const Json& code = file.at("crs").at("code");
    const int own_code = info.crs->definition().epsg;
    if (code.is_string() && own_code != 0 && own_code != 21892 && code != "EPSG:4979") {
      // 21892 is the older number of 21897; 4979 is 4326 with heights, which another key may declare.
      EXPECT_EQ("EPSG:" + std::to_string(own_code), code.get<std::string>());
    }
    const auto w = static_cast<double>(info.width);
    const auto h = static_cast<double>(info.height);
    const std::map<std::string, Point2> places = {
        {"upper_left", {0, 0}}, {"upper_right", {w, 0}}, {"lower_right", {w, h}}, {"lower_left", {0, h}}, {"centre", {w / 2, h / 2}}};
    for (const auto& [name, raster] : places) {
      const Json& expected = file.at("lonlat_own_datum").at(name);
      if (expected.is_null()) continue;
      const Point2 crs = info.transform.crs_from_raster(raster);
      const auto lonlat = info.crs->lonlat_from_crs(crs);
      ASSERT_TRUE(lonlat.has_value()) << lonlat.error().message;
      EXPECT_LE(turn_difference(lonlat->x, expected[0].get<double>()), kToleranceDeg) << name;
      EXPECT_NEAR(lonlat->y, expected[1].get<double>(), latitude_tolerance_deg) << name;
      const auto back = info.crs->crs_from_lonlat(*lonlat);
      ASSERT_TRUE(back.has_value()) << back.error().message;
      if (info.crs->kind() == geo::CrsKind::kGeographic) continue;
      const double unit = info.crs->definition().metres_per_unit;
      EXPECT_NEAR(back->x * unit, crs.x * unit, kInverseToleranceM) << name;
      EXPECT_NEAR(back->y * unit, crs.y * unit, kInverseToleranceM) << name;
      ++checked;
    }
  }
  EXPECT_GT(checked, 500);  // projected places
}

TEST_F(Truth, EveryCrsThatWeDoNotReadIsExplained) {
  std::set<std::string> unread;
  for (const Json& file : truth().at("files")) {
    if (!is_tiff(file) || !file.contains("crs") || !file.at("crs").is_object() || file.at("crs").at("kind") == "local") continue;
    const auto source = open_raster(data_path(file));
    if (!source || (*source)->info().crs) continue;
    SCOPED_TRACE(file.at("path").get<std::string>());
    const std::string& problem = (*source)->info().crs_problem;
    EXPECT_FALSE(problem.empty());
    const std::string& declared = (*source)->info().declared_crs_text;
    EXPECT_FALSE(declared.empty());
    if (problem.find("CRS EPSG:") != std::string::npos) {
      EXPECT_NE(declared.find("EPSG:"), std::string::npos) << declared << ": " << problem;
    }
    const Json& method = file.at("crs").contains("method") ? file.at("crs").at("method") : Json();
    // All that we promise must be read: transverse Mercator, and degrees from Greenwich on a datum of the
    // list.
    EXPECT_NE(method, "Transverse_Mercator") << problem;
    unread.insert(problem);
  }
  for (const std::string& problem : unread) std::printf("  unread CRS: %s\n", problem.c_str());
}

TEST_F(Truth, PicturesReadAsGdalReadsThem) {
  int checked = 0;
  for (const Json& file : truth().at("files")) {
    const auto path = file.at("path").get<std::string>();
    const bool picture = path.ends_with(".jpg") || path.ends_with(".png") || path.ends_with(".jp2");
    const bool clean = file.contains("gdal_clean") && file.at("gdal_clean") == true;
    // GDAL brings CMYK to RGB by a rule of its own, and shows palette indices where OpenImageIO shows
    // colours.
    if (!picture || !clean || path == "formats/jpeg/rgb_ntf_cmyk.jpg" || path == "formats/worldfile/test.png") continue;
    if (path.starts_with("formats/corrupt/")) continue;
    SCOPED_TRACE(path);
    const auto source = open_raster(data_path(file));
    if (path == "formats/png/uint16_interlaced.png") {  // OpenImageIO swaps its bytes, so we refuse
      ASSERT_FALSE(source.has_value());
      EXPECT_EQ(source.error().code, ErrorCode::kUnsupported);
      continue;
    }
    ASSERT_TRUE(source.has_value()) << source.error().message;
    const RasterInfo& info = (*source)->info();
    EXPECT_EQ(info.width, file.at("width").get<std::int64_t>());
    EXPECT_EQ(info.height, file.at("height").get<std::int64_t>());
    const bool transparent_color = path == "formats/png/tbbn2c16.png";  // one colour is declared transparent: an alpha band to OpenImageIO
    EXPECT_EQ(info.bands, file.at("bands").get<int>() + (transparent_color ? 1 : 0));
    EXPECT_EQ(info.sample_type, kGdalTypes.at(file.at("dtype").get<std::string>()));
    if (path.starts_with("formats/worldfile/")) {
      const auto t = file.at("geotransform").get<std::vector<double>>();
      ASSERT_TRUE(info.has_transform);
      EXPECT_NEAR(info.transform.x0, t[0], 1e-9 * std::abs(t[0]));
      EXPECT_NEAR(info.transform.y0, t[3], 1e-9 * std::abs(t[3]));
      EXPECT_EQ(info.transform.x_column, t[1]);
      EXPECT_EQ(info.transform.y_row, t[5]);
    }
    // Decoders of JPEG may differ in rounding; the same libraries usually agree to 1, two colour conversions
    // to 2.
    const double tolerance = file.at("lossy_decoder") == true ? 2.0 : 0.0;
    for (std::size_t b = 0; b < file.at("band_info").size(); ++b) {
      const std::array<int, 1> wanted = {static_cast<int>(b)};
      for (const Json& sample : file.at("band_info")[b].at("samples")) {
        std::vector<std::byte> one(sample_bytes(info.sample_type));
        const auto read = (*source)->read({sample[0].get<std::int64_t>(), sample[1].get<std::int64_t>(), 1, 1}, wanted, one, one.size());
        ASSERT_TRUE(read.has_value()) << read.error().message;
        EXPECT_NEAR(sample_at(one.data(), info.sample_type), number(sample[2]), tolerance) << "band " << b << " at " << sample;
      }
    }
    ++checked;
  }
  EXPECT_GE(checked, 15);
}

// Two of the files GDAL does not read: it takes "nan" for no sample.
TEST_F(Truth, AsciiGridsReadAsGdalReadsThem) {
  int checked = 0;
  for (const Json& file : truth().at("files")) {
    const auto path = file.at("path").get<std::string>();
    if (!path.starts_with("formats/aaigrid/") || path.ends_with(".prj") || path.ends_with(".PRJ")) continue;
    SCOPED_TRACE(path);
    const auto source = open_raster(data_path(file));
    ASSERT_TRUE(source.has_value()) << source.error().message;
    ++checked;
    if (file.at("gdal_reads") != true) continue;
    const RasterInfo& info = (*source)->info();
    EXPECT_EQ(info.width, file.at("width").get<std::int64_t>());
    EXPECT_EQ(info.height, file.at("height").get<std::int64_t>());
    const auto t = file.at("geotransform").get<std::vector<double>>();
    EXPECT_NEAR(info.transform.x0, t[0], 1e-9 * std::abs(t[0]));
    EXPECT_NEAR(info.transform.y0, t[3], 1e-9 * std::abs(t[3]));
    EXPECT_EQ(info.transform.x_column, t[1]);
    EXPECT_EQ(info.transform.y_row, t[5]);
    const Json& band = file.at("band_info")[0];
    const double nodata = number(band.at("nodata"));
    EXPECT_NEAR(info.meaning.at(0).nodata.value(), nodata, 1e-7 * std::abs(nodata));
    for (const Json& sample : band.at("samples")) {
      std::vector<std::byte> one(sample_bytes(info.sample_type));
      const std::array<int, 1> first = {0};
      const auto read = (*source)->read({sample[0].get<std::int64_t>(), sample[1].get<std::int64_t>(), 1, 1}, first, one, one.size());
      ASSERT_TRUE(read.has_value()) << read.error().message;
      // GDAL gives floats, of which this is the rounding.
      EXPECT_NEAR(sample_at(one.data(), info.sample_type), number(sample[2]), 1e-7 * std::abs(number(sample[2]))) << sample;
    }
  }
  EXPECT_EQ(checked, 10);
}

TEST_F(Truth, DamagedFilesEndInAnErrorOrInGdalsPixels) {
  for (const Json& file : truth().at("files")) {
    const auto path = file.at("path").get<std::string>();
    const bool clean = file.contains("gdal_clean") && file.at("gdal_clean") == true;
    if (path.find("/corrupt/") == std::string::npos || clean) continue;
#ifdef __SANITIZE_ADDRESS__
    if (path == "formats/corrupt/idat_broken.png") continue;  // libpng jumps over a destructor in OpenImageIO: 31 bytes leak there
#endif
    SCOPED_TRACE(path);
    const auto source = open_raster(data_path(file));
    if (!source) {
      EXPECT_NE(source.error().message.find(data_path(file).filename().string()), std::string::npos) << source.error().message;
      EXPECT_NE(source.error().code, ErrorCode::kInternal);
      continue;
    }
    const RasterInfo& info = (*source)->info();
    const std::int64_t width = std::min<std::int64_t>(info.width, 4096);
    const std::int64_t rows = std::min<std::int64_t>(info.height, 256);
    std::vector<int> bands(static_cast<std::size_t>(info.bands));
    for (int i = 0; i < info.bands; ++i) bands[static_cast<std::size_t>(i)] = i;
    const std::size_t pitch = static_cast<std::size_t>(width) * bands.size() * sample_bytes(info.sample_type);
    std::vector<std::byte> pixels(pitch * static_cast<std::size_t>(rows));
    bool failed = false;
    const std::int64_t last =
        std::min<std::int64_t>(info.height, (std::int64_t{1} << 26) / width);  // all of most, the head of the huge ones
    for (std::int64_t y = 0; y < last && !failed; y += rows) {
      const auto read = (*source)->read({0, y, width, std::min(rows, info.height - y)}, bands, pixels, pitch);
      failed = !read;
      EXPECT_TRUE(!failed || read.error().message.find("row") != std::string::npos) << read.error().message;
    }
    // Valid but for its size, which GDAL cannot count; its one block is sparse.
    if (path == "geotiff-variants/corrupt/image_width_above_32bit.tif") continue;
    // GDAL minds a broken link to a second directory; the pixels of the first are there.
    if (path == "geotiff-variants/corrupt/gtiff_ossfuzz_470691578.tif") continue;
    const bool unreadable = file.contains("gdal_reads") && file.at("gdal_reads") == false;
    EXPECT_TRUE(failed || !unreadable) << "GDAL cannot read this, we made something up";
  }
}

}  // namespace
}  // namespace vt::source
