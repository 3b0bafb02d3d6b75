// Esri ASCII grids: what is written is what is read, in a type that keeps it, in windows of any place; and
// what is damaged is said to be.
#include "builder/source/formats/ascii_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <string>

#include "builder/source/raster_source.h"
#include "store/io/content_hash.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

constexpr const char* kHeader = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\n";

class AsciiGridTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& content, const std::string& name = "grid.asc") {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  std::unique_ptr<RasterSource> open(const std::string& content, const OpenOptions& options = {}) {
    auto source = open_raster(write(content), options);
    EXPECT_TRUE(source.has_value()) << source.error().message;
    return source ? *std::move(source) : nullptr;
  }
  Error error_of(const std::string& content) {
    const auto source = open_raster(write(content));
    EXPECT_FALSE(source.has_value()) << content;
    return source ? Error{} : source.error();
  }
  static std::vector<double> values(const RasterSource& source) {
    const std::vector<std::byte> bytes = read_all(source);
    const SampleType type = source.info().sample_type;
    std::vector<double> result;
    for (std::size_t at = 0; at < bytes.size(); at += sample_bytes(type)) {
      result.push_back(visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
        T value;
        std::memcpy(&value, bytes.data() + at, sizeof value);
        return static_cast<double>(value);
      }));
    }
    return result;
  }
  test::TempFolder folder_;
};

TEST_F(AsciiGridTest, LiesWhereItsHeaderSays) {
  const auto corner = open(std::string(kHeader) + "NODATA_value -9999\n1 2 3\n4 5 6\n");
  const RasterInfo& info = corner->info();
  EXPECT_EQ(info.width, 3);
  EXPECT_EQ(info.height, 2);
  EXPECT_EQ(info.bands, 1);
  EXPECT_EQ(info.meaning.at(0).nodata, -9999.0);
  EXPECT_FALSE(info.crs.has_value());
  const Point2 first = info.transform.crs_from_raster({0, 0});
  EXPECT_EQ(first.x, 100.0);
  EXPECT_EQ(first.y, 220.0);
  EXPECT_EQ(info.transform.x_column, 10.0);
  EXPECT_EQ(info.transform.y_row, -10.0);
  EXPECT_EQ(values(*corner), (std::vector<double>{1, 2, 3, 4, 5, 6}));

  // Centres, two steps, another order, capitals, a byte order mark, and no line ends to speak of.
  const auto centre = open("\xef\xbb\xbf NROWS 2 NCOLS 3 DX 10 DY 20 YLLCENTER 210 XLLCENTER 105 1 2 3 4 5\r\n6");
  const Point2 same = centre->info().transform.crs_from_raster({0, 0});
  EXPECT_EQ(same.x, 100.0);
  EXPECT_EQ(same.y, 240.0);
  EXPECT_EQ(centre->info().transform.y_row, -20.0);
  EXPECT_FALSE(centre->info().meaning.at(0).nodata.has_value());
  EXPECT_EQ(values(*centre), (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST_F(AsciiGridTest, TheTypeIsTheSmallestThatKeepsEveryNumber) {
  struct Case {
    const char* nodata;
    const char* samples;
    SampleType type;
    std::vector<double> values;
  };
  const Case cases[] = {
      {"-9999", "1 -32768 32767 0 +5 -9999", SampleType::kInt16, {1, -32768, 32767, 0, 5, -9999}},
      {"-99999", "1 2 3 4 5 6", SampleType::kInt32, {1, 2, 3, 4, 5, 6}},
      {"-9999", "1 2 3 4 5 32768", SampleType::kInt32, {1, 2, 3, 4, 5, 32768}},
      {"-9999", "1 2 3 4 5 2147483648", SampleType::kFloat64, {1, 2, 3, 4, 5, 2147483648.0}},
      {"-9999", "1.5 2 3 4 5 6", SampleType::kFloat32, {1.5, 2, 3, 4, 5, 6}},
      {"-9999", ".5 0,25 1e3 -1.5E-1 5. 6", SampleType::kFloat32, {0.5, 0.25, 1000, -0.15F, 5, 6}},
      {"-9999", "1234.567 2 3 4 5 6", SampleType::kFloat64, {1234.567, 2, 3, 4, 5, 6}},
      {"-9999", "1e39 2 3 4 5 6", SampleType::kFloat64, {1e39, 2, 3, 4, 5, 6}},
      // The number that means no data is only compared: how many digits it has is no matter.
      {"-3.4028234663852886e+38", "-3.4028234663852886e+38 2.5 3 4 5 6", SampleType::kFloat32, {-3.4028234663852886e+38, 2.5, 3, 4, 5, 6}},
      {"nan", "1 2 3 4 5 6", SampleType::kFloat32, {1, 2, 3, 4, 5, 6}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.samples);
    const auto source = open(std::string(kHeader) + "nodata_value " + c.nodata + "\n" + c.samples);
    EXPECT_EQ(source->info().sample_type, c.type);
    EXPECT_EQ(values(*source), c.values);
  }
  const auto holes = open(std::string(kHeader) + "nodata_value nan\nnan 2 3\n4 NaN 6\n");
  EXPECT_EQ(holes->info().sample_type, SampleType::kFloat32);
  EXPECT_TRUE(std::isnan(values(*holes).at(0)) && std::isnan(values(*holes).at(4)));
  EXPECT_EQ(values(*holes).at(5), 6.0);
}

TEST_F(AsciiGridTest, WindowsAreThoseOfTheWholeHoweverLinesAreBroken) {
  constexpr int kWidth = 700;
  constexpr int kHeight = 400;  // three cells, and words across the reader's buffers
  std::mt19937 random(3);
  std::string text = "ncols 700\nnrows 400\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  std::vector<double> wanted;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto value = static_cast<int>(random() % 65536) - 32768;
    wanted.push_back(value);
    text += std::to_string(value) + (random() % 9 == 0 ? "\r\n" : random() % 50 == 0 ? " \t  " : " ");
  }
  const auto source = open(text);
  EXPECT_LT(source->info().block_height, kHeight);
  EXPECT_EQ(values(*source), wanted);
  expect_windows_match(*source, read_all(*source), 5, 60);
}

TEST_F(AsciiGridTest, ContentIsThatOfTheRowsThatAreRead) {
  std::string text = "ncols 700\nnrows 400\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  for (int i = 0; i < 700 * 400; ++i) text += std::to_string(i % 100) + " ";
  const auto hash = [&](const std::string& content, const Window& window) {
    store::ContentHasher hasher;
    const auto source = open(content);
    EXPECT_TRUE(source->hash(window, std::array{0}, hasher).has_value());
    return hasher.digest().bytes;
  };
  const Window top{.x = 0, .y = 0, .width = 10, .height = 10};
  const Window bottom{.x = 0, .y = 390, .width = 10, .height = 10};
  std::string changed = text;
  changed[text.size() - 2] = changed[text.size() - 2] == '1' ? '2' : '1';
  EXPECT_EQ(hash(text, top), hash(changed, top));
  EXPECT_NE(hash(text, bottom), hash(changed, bottom));
  EXPECT_NE(hash(text, top), hash(text, bottom));
}

TEST_F(AsciiGridTest, TheSystemBesideItIsNamedAsNotUsed) {
  write("PROJCS[]", "grid.prj");
  const auto source = open(std::string(kHeader) + "1 2 3 4 5 6");
  ASSERT_EQ(source->info().unused.size(), 1U);
  EXPECT_NE(source->info().unused.front().what.find("grid.prj"), std::string::npos);
}

TEST_F(AsciiGridTest, WhatIsDamagedIsSaid) {
  const std::string header = kHeader;
  const std::pair<std::string, const char*> cases[] = {
      {header + "10 20 30 40 50", "ends after 5 samples of 3 x 2"},
      {header + "1 2 3 4 5 6 7", "goes on after 3 x 2 samples"},
      {header + "1 2 3 4 five 6", "\"five\" at byte"},
      {header + "1 2 3 4 5,5,5 6", "\"5,5,5\" at byte"},
      {header + "1 2 3 4 1e999 6", "\"1e999\" at byte"},
      {header + "1 2 3 4 \x01\xff 6", R"("\u0001\xff" at byte)"},
      {header + "1 2 3 4 " + std::string(200, '5') + " 6", "longer than any number"},
      {header, "for which its"},
      {header + "wrong 5\n1 2 3 4 5 6", "\"wrong\" at byte"},
      {header + "cellsize 5\n1 2 3 4 5 6", "cellsize twice"},
      {header + "dx 5\n1 2 3 4 5 6", "wants cellsize, or dx and dy"},
      {header + "xllcenter 5\n1 2 3 4 5 6", "one of xllcorner and xllcenter"},
      {"ncols 3\nnrows 2\nxllcorner 0\ncellsize 1\n1 2 3 4 5 6", "one of yllcorner and yllcenter"},
      {"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\n1 2 3 4 5 6", "wants cellsize"},
      {"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize -1\n1 2 3 4 5 6", "apart"},
      {"ncols 3\nnrows 2\nxllcorner nan\nyllcorner 0\ncellsize 1\n1 2 3 4 5 6", "nowhere in x"},
      {"ncols 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4 5 6", "ncols, nrows"},
      {"ncols 0\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1", "ncols, nrows"},
      {"ncols 2.5\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4 5", "ncols, nrows"},
      {"ncols 1e30\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2", "ncols, nrows"},
      {"ncols 2147483647\nnrows 2147483647\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2", "claims 2147483647 x 2147483647"},
      {"ncols", "is no number"},
      {"ncols 3 nrows", "is no number"},
  };
  for (const auto& [content, message] : cases) {
    const Error error = error_of(content);
    EXPECT_EQ(error.code, ErrorCode::kInvalidData) << error.message;
    EXPECT_NE(error.message.find(message), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("grid.asc"), std::string::npos) << error.message;
  }
}

// Every prefix and many a flipped byte: an error or samples, never a crash, and a prefix that misses a sample
// is never a grid.
TEST_F(AsciiGridTest, DamagedTextsNeitherCrashNorLie) {
  const std::string good = std::string(kHeader) + "NODATA_value -9999\n10 20 30\n40 50 60";
  for (std::size_t length = 1; length + 2 < good.size(); ++length)
    EXPECT_FALSE(open_raster(write(good.substr(0, length))).has_value()) << length;
  std::mt19937 random(11);
  for (int round = 0; round < 2000; ++round) {
    std::string flipped = good;
    for (int flips = 0; flips < 3; ++flips) flipped[random() % flipped.size()] = static_cast<char>(random());
    if (const auto source = open_raster(write(flipped))) read_all(**source);
  }
}

}  // namespace
}  // namespace vt::source
