// Every TIFF of the real-raster collection against what GDAL recorded about it in truth.json: size, type, nodata, place, every pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "tests/source/sha256.h"

namespace vt::source {
namespace {

using Json = nlohmann::json;

// Valid files, or what GDAL takes for such, that we refuse, with a piece of the message. Anything else must read.
const std::map<std::string, std::string> kRefused = {
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
  const auto as = [&]<class T>(T value) {
    std::memcpy(&value, place, sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case SampleType::kUint8: return as(std::uint8_t{});
    case SampleType::kInt8: return as(std::int8_t{});
    case SampleType::kUint16: return as(std::uint16_t{});
    case SampleType::kInt16: return as(std::int16_t{});
    case SampleType::kUint32: return as(std::uint32_t{});
    case SampleType::kInt32: return as(std::int32_t{});
    case SampleType::kFloat32: return as(float{});
    case SampleType::kFloat64: return as(double{});
  }
  return 0.0;
}

const std::map<std::string, SampleType> kGdalTypes = {{"Byte", SampleType::kUint8},     {"Int8", SampleType::kInt8},     {"UInt16", SampleType::kUint16},
                                                      {"Int16", SampleType::kInt16},    {"UInt32", SampleType::kUint32}, {"Int32", SampleType::kInt32},
                                                      {"Float32", SampleType::kFloat32}, {"Float64", SampleType::kFloat64}};

class Truth : public testing::Test {
 protected:
  void SetUp() override {
    if (truth().is_null()) GTEST_SKIP() << "no real rasters at " << VT_TEST_DATA;
  }
};

std::filesystem::path data_path(const Json& file) { return std::filesystem::path(VT_TEST_DATA) / file.at("path").get<std::string>(); }

bool is_tiff(const Json& file) { return file.contains("tiff") && file.at("tiff").is_object(); }

// GDAL keeps MinIsWhite codes; we invert unsigned ones.
std::optional<double> inverted_from(const Json& file) {
  const Json& tiff = file.at("tiff");
  if (tiff.value("photometric", "") != "min-is-white" || tiff.at("sample_format").at(0) != "uint") return std::nullopt;
  return std::pow(2.0, tiff.at("bits_per_sample").at(0).get<int>()) - 1.0;
}

void invert(std::vector<std::byte>& row, SampleType type, double max) {
  const std::size_t bytes = sample_bytes(type);
  for (std::size_t at = 0; at < row.size(); at += bytes) {
    const auto code = static_cast<std::uint32_t>(max - sample_at(row.data() + at, type));
    std::memcpy(row.data() + at, &code, bytes);
  }
}

void compare_info(const Json& file, const RasterInfo& info) {
  EXPECT_EQ(info.width, file.at("width").get<std::int64_t>());
  EXPECT_EQ(info.height, file.at("height").get<std::int64_t>());
  EXPECT_EQ(sample_name(info.sample_type), std::string(sample_name(kGdalTypes.at(file.at("dtype").get<std::string>()))));

  const Json& nodata = file.at("band_info").at(0).at("nodata");
  EXPECT_EQ(info.nodata.has_value(), !nodata.is_null());
  if (info.nodata && !nodata.is_null()) {
    const auto max = inverted_from(file);
    EXPECT_TRUE(same(max ? *max - *info.nodata : *info.nodata, number(nodata))) << *info.nodata << " for " << nodata;
  }

  const bool has_transform = file.contains("geotransform") && !file.at("geotransform").is_null();
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
  const auto max = inverted_from(file);
  const bool lossy = file.at("lossy_decoder").get<bool>();
  for (std::size_t b = 0; b < bands.size() && static_cast<int>(b) < info.bands; ++b) {
    const Json& band = bands[b];
    const std::array<int, 1> wanted = {static_cast<int>(b)};
    test::Sha256 hash;
    constexpr std::int64_t kRows = 64;
    std::vector<std::byte> rows;
    const bool whole = band.contains("sha256_pixels") && !band.at("sha256_pixels").is_null() && !lossy;
    for (std::int64_t y = 0; whole && y < info.height; y += kRows) {
      const std::int64_t count = std::min(kRows, info.height - y);
      rows.assign(static_cast<std::size_t>(count * info.width) * bytes, std::byte{0});
      const auto read = source.read({0, y, info.width, count}, wanted, rows, static_cast<std::size_t>(info.width) * bytes);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      if (max) invert(rows, info.sample_type, *max);
      hash.add(rows);
    }
    if (whole) {
      EXPECT_EQ(hash.hex(), band.at("sha256_pixels").get<std::string>()) << "band " << b;
    }
    for (const Json& sample : band.value("samples", Json::array())) {
      std::vector<std::byte> one(bytes);
      const auto read = source.read({sample[0].get<std::int64_t>(), sample[1].get<std::int64_t>(), 1, 1}, wanted, one, bytes);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      if (max) invert(one, info.sample_type, *max);
      const double ours = sample_at(one.data(), info.sample_type);
      // Another JPEG or WebP decoder may round differently by a few codes.
      const bool equal = lossy ? std::abs(ours - number(sample[2])) <= 4.0 : same(ours, number(sample[2]));
      EXPECT_TRUE(equal) << "band " << b << " at " << sample << ": " << ours;
    }
  }
}

TEST_F(Truth, EveryCleanTiffReadsAsGdalReadsItOrIsRefusedForTheListedReason) {
  OpenOptions options;
  options.palette_indices = true;  // GDAL gives the indices
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
    compare_info(file, (*source)->info());
    compare_pixels(file, **source);
    ++read_well;
  }
  RecordProperty("read", read_well);
  RecordProperty("refused", refused);
  EXPECT_EQ(refused, static_cast<int>(kRefused.size()));
}

}  // namespace
}  // namespace vt::source
