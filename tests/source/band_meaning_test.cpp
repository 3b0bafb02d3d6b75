// What the readers say of bands: roles, full scales, coverage, no-data values, scales and units, and what
// they leave unused.

#include "builder/source/band_meaning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "tests/source/raster_files.h"
#include "tests/support/raw_tiff.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::pixels_of;
using test::RawTiff;

constexpr std::uint16_t kExtraSamples = 338;
constexpr std::uint16_t kMetadata = 42112;
constexpr std::uint16_t kNodata = 42113;

class BandMeaningTest : public testing::Test {
 protected:
  std::unique_ptr<RasterSource> open(const RawTiff& tiff, const OpenOptions& options = {}) {
    const auto path = folder_ / ("r" + std::to_string(count_++) + ".tif");
    tiff.write(path);
    return open_path(path, options);
  }
  std::unique_ptr<RasterSource> open_path(const std::filesystem::path& path, const OpenOptions& options = {}) {
    auto source = open_raster(path, options);
    EXPECT_TRUE(source.has_value()) << (source ? "" : source.error().message);
    return source ? std::move(*source) : nullptr;
  }
  static std::vector<int> codes(const RasterSource& source) {
    std::vector<int> codes;
    for (const std::byte code : read_all(source)) codes.push_back(std::to_integer<int>(code));
    return codes;
  }
  static bool mentions(const RasterInfo& info, const std::string& words) {
    return std::ranges::any_of(info.unused, [&](const UnusedFact& fact) { return fact.what.find(words) != std::string::npos; });
  }

  test::TempFolder folder_;
  int count_ = 0;
};

std::vector<BandRole> roles_of(const RasterInfo& info) {
  std::vector<BandRole> roles;
  for (const BandMeaning& band : info.meaning) roles.push_back(band.role);
  return roles;
}

TEST_F(BandMeaningTest, FullScaleIsThatOfTheBits) {
  // One row of two samples each; rows are padded to whole bytes, most significant bit first.
  struct Row {
    std::uint16_t bits;
    std::uint16_t format;
    std::string pixels;
    double full;
    SampleType type;
  };
  const std::vector<Row> rows = {
      {1, 1, std::string("\x40", 1), 1.0, SampleType::kUint8},
      {4, 1, std::string("\xF3", 1), 15.0, SampleType::kUint8},
      {8, 1, std::string("\x01\xFF", 2), 255.0, SampleType::kUint8},
      {8, 2, std::string("\x01\x7F", 2), 127.0, SampleType::kInt8},
      {11, 1, std::string("\xFF\xE0\x00", 3), 2047.0, SampleType::kUint16},
      {12, 1, std::string("\xFF\xF0\x00", 3), 4095.0, SampleType::kUint16},
      {16, 1, std::string(4, '\1'), 65535.0, SampleType::kUint16},
      {16, 2, std::string(4, '\1'), 32767.0, SampleType::kInt16},
      {32, 1, std::string(8, '\1'), 4294967295.0, SampleType::kUint32},
      {32, 3, std::string(8, '\1'), 1.0, SampleType::kFloat32},
      {64, 3, std::string(16, '\1'), 1.0, SampleType::kFloat64},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(std::to_string(row.bits) + " bits, format " + std::to_string(row.format));
    const auto source =
        open(RawTiff().page({.width = 2, .height = 1, .bits = row.bits, .sample_format = row.format, .pixels = row.pixels}));
    ASSERT_TRUE(source);
    EXPECT_EQ(source->info().sample_type, row.type);
    ASSERT_EQ(source->info().meaning.size(), 1U);
    EXPECT_EQ(source->info().meaning[0].full_scale, row.full);
    EXPECT_EQ(source->info().meaning[0].role, BandRole::kGrey);
  }
}

TEST_F(BandMeaningTest, ABandIsCoverageWhenTheTagsOrGdalsNoteSaySo) {
  const auto rgbx = [](std::uint16_t extra, const std::string& note) {
    RawTiff tiff;
    tiff.page({.width = 1, .height = 1, .samples = 4, .photometric = 2, .pixels = std::string("\x0A\x14\x1E\x80", 4)})
        .shorts(kExtraSamples, {extra});
    if (!note.empty())
      tiff.text(kMetadata, "<GDALMetadata><Item name=\"COLORINTERP\" sample=\"3\" role=\"colorinterp\">" + note + "</Item></GDALMetadata>");
    return tiff;
  };
  EXPECT_EQ(open(rgbx(2, ""))->info().alpha_band, 3) << "unassociated alpha";
  EXPECT_EQ(open(rgbx(1, ""))->info().alpha_band, 3) << "associated alpha";
  EXPECT_EQ(open(rgbx(0, ""))->info().alpha_band, -1) << "unspecified";
  EXPECT_EQ(open(rgbx(0, "Alpha"))->info().alpha_band, 3);
  for (const char* note : {"Undefined", "NIR"}) {
    for (const std::uint16_t extra : {1, 2}) {
      const auto infrared = open(rgbx(extra, note));
      EXPECT_EQ(infrared->info().alpha_band, -1) << note;
      EXPECT_EQ(infrared->info().meaning[3].role, BandRole::kOther);
      EXPECT_EQ(codes(*infrared), (std::vector<int>{10, 20, 30, 128})) << "nothing is divided by infrared";
    }
  }
  EXPECT_EQ(codes(*open(rgbx(1, ""))), (std::vector<int>{20, 40, 60, 128})) << "divided by coverage";
}

TEST_F(BandMeaningTest, RolesInAnyOrder) {
  RawTiff tiff;
  tiff.page({.width = 1, .height = 1, .samples = 3, .pixels = std::string("\1\2\3", 3)})
      .shorts(kExtraSamples, {0, 0})
      .text(kMetadata,
            "<GDALMetadata><Item sample=\"0\" role=\"colorinterp\">Blue</Item><Item sample=\"1\" role=\"colorinterp\">Green</Item>"
            "<Item sample=\"2\" role=\"colorinterp\">Red</Item></GDALMetadata>");
  EXPECT_EQ(roles_of(open(tiff)->info()), (std::vector{BandRole::kBlue, BandRole::kGreen, BandRole::kRed}));
}

TEST_F(BandMeaningTest, PalettesExpandWithTheirAlphaBandOrStayIndices) {
  std::vector<std::uint16_t> colors(3 * 256, 0);
  colors[7] = 65535;            // entry 7 is red
  colors[256 + 9] = 128 * 257;  // entry 9 is half green
  RawTiff tiff;
  tiff.page({.width = 3, .height = 1, .samples = 2, .photometric = 3, .pixels = std::string("\x07\xFF\x09\x80\x07\x00", 6)})
      .shorts(320, colors)
      .shorts(kExtraSamples, {2});
  const auto expanded = open(tiff);
  EXPECT_EQ(expanded->info().alpha_band, 3);
  EXPECT_EQ(codes(*expanded), (std::vector<int>{255, 0, 0, 255, 0, 128, 0, 128, 255, 0, 0, 0}));
  const auto indices = open(tiff, {.as_numbers = true});
  EXPECT_EQ(indices->info().alpha_band, 1);
  EXPECT_EQ(indices->info().meaning[0].role, BandRole::kIndex);
  EXPECT_EQ(codes(*indices), (std::vector<int>{7, 255, 9, 128, 7, 0}));
  // The index that is declared "no data" is clear whatever the alpha band says.
  tiff.text(kNodata, "9");
  EXPECT_EQ(codes(*open(tiff)), (std::vector<int>{255, 0, 0, 255, 0, 128, 0, 0, 255, 0, 0, 0}));
  // And so is the one that the user names.
  EXPECT_EQ(codes(*open(tiff, {.nodata = 7.0})), (std::vector<int>{255, 0, 0, 0, 0, 128, 0, 128, 255, 0, 0, 0}));
}

TEST_F(BandMeaningTest, NarrowPalettesWithNarrowAlpha) {
  std::vector<std::uint16_t> colors(3 * 16, 0);
  colors[5] = 65535;
  RawTiff tiff;
  tiff.page({.width = 2, .height = 1, .bits = 4, .samples = 2, .photometric = 3, .pixels = std::string("\x5F\x53", 2)})
      .shorts(320, colors)
      .shorts(kExtraSamples, {2});
  const auto source = open(tiff);
  EXPECT_EQ(codes(*source), (std::vector<int>{255, 0, 0, 15, 255, 0, 0, 3}));
  EXPECT_EQ(source->info().meaning[3].full_scale, 15.0);
  EXPECT_EQ(source->info().meaning[0].full_scale, 255.0);
}

TEST_F(BandMeaningTest, MinIsWhiteInvertsColoursOnlyAndNeverCoverage) {
  RawTiff grey;
  grey.page({.width = 2, .height = 1, .samples = 2, .photometric = 0, .pixels = std::string("\x01\xF0\xC8\x10", 4)})
      .shorts(kExtraSamples, {2})
      .text(kNodata, "1");
  const auto inverted = open(grey);
  EXPECT_EQ(codes(*inverted), (std::vector<int>{254, 0xF0, 55, 0x10}));
  EXPECT_EQ(inverted->info().meaning[0].nodata, 254.0);
  const auto numbers = open(grey, {.as_numbers = true});
  EXPECT_EQ(codes(*numbers), (std::vector<int>{1, 0xF0, 200, 0x10}));
  EXPECT_EQ(numbers->info().meaning[0].nodata, 1.0);
  EXPECT_EQ(open(grey, {.nodata = 200.0})->info().meaning[0].nodata, 55.0) << "a code as it is stored";
  // In separate planes coverage is a plane of its own.
  RawTiff planes;
  planes.page({.width = 2, .height = 1, .samples = 2, .photometric = 0, .pixels = std::string("\x01\xC8\xF0\x10", 4)})
      .shorts(kExtraSamples, {2})
      .shorts(284, {2})
      .longs(279, {2, 2});
  // Two strips need two places: both follow the header.
  planes.longs(273, {8, 10});
  EXPECT_EQ(codes(*open(planes)), (std::vector<int>{254, 0xF0, 55, 0x10}));
}

TEST_F(BandMeaningTest, MasksInsideAndBesideAreABandMore) {
  const std::vector<std::uint16_t> samples{100, 200, 300, 400};
  RawTiff inside;
  inside.page({.width = 4, .height = 1, .bits = 16, .pixels = pixels_of(samples)})
      .page({.width = 4, .height = 1, .bits = 1, .photometric = 4, .pixels = std::string("\xA0", 1)})
      .longs(254, {4});
  const auto masked = open(inside);
  EXPECT_EQ(masked->info().bands, 2);
  EXPECT_EQ(masked->info().alpha_band, 1);
  EXPECT_TRUE(masked->info().alpha_is_mask);
  EXPECT_EQ(masked->info().meaning[1].full_scale, 255.0);
  const std::vector<std::byte> got = read_all(*masked);
  EXPECT_EQ(pixels_of(got), pixels_of(std::vector<std::uint16_t>{100, 255, 200, 0, 300, 255, 400, 0}));

  RawTiff plain;
  plain.page({.width = 4, .height = 1, .bits = 16, .pixels = pixels_of(samples)});
  plain.write(folder_ / "beside.tif");
  EXPECT_EQ(open_path(folder_ / "beside.tif")->info().bands, 1);
  RawTiff mask;
  mask.page({.width = 4, .height = 1, .pixels = std::string("\xFF\x00\x01\x00", 4)}).write(folder_ / "beside.tif.msk");
  const auto beside = open_path(folder_ / "beside.tif");
  EXPECT_EQ(read_all(*beside), got);
  ASSERT_EQ(beside->info().companions.size(), 1U);
  expect_windows_match(*beside, got, 5, 20);
  // A mask of another raster is refused.
  RawTiff wrong;
  wrong.page({.width = 5, .height = 1, .pixels = std::string(5, '\xFF')}).write(folder_ / "beside.tif.msk");
  const auto refused = open_raster(folder_ / "beside.tif");
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(refused.error().message.find("beside.tif.msk"), std::string::npos) << refused.error().message;
  // One for each band counts as one, of which it is known.
  RawTiff each;
  each.page({.width = 4, .height = 1, .samples = 2, .pixels = std::string("\xFF\xFF\x00\xFF\xFF\x00\x00\x00", 8)})
      .write(folder_ / "beside.tif.msk");
  const auto two = open_path(folder_ / "beside.tif");
  EXPECT_EQ(two->info().mask_bands, 2);
  EXPECT_EQ(pixels_of(read_all(*two)), pixels_of(std::vector<std::uint16_t>{100, 255, 200, 0, 300, 0, 400, 0}));
}

// A directory behind the first that cannot be read may be that of a mask, without which no data would count
// as data.
TEST_F(BandMeaningTest, ADirectoryThatMayBeAMaskIsNotLost) {
  RawTiff masked;
  masked.page({.width = 4, .height = 1, .bits = 16, .pixels = pixels_of(std::vector<std::uint16_t>{100, 200, 300, 400})})
      .page({.width = 4, .height = 1, .bits = 1, .photometric = 4, .pixels = std::string("\xA0", 1)})
      .longs(254, {4});
  const std::string good = masked.bytes();
  // The place of the second directory is noted behind the entries of the first.
  std::uint32_t first_at = 0;
  std::memcpy(&first_at, &good[4], 4);
  std::uint16_t entries = 0;
  std::memcpy(&entries, &good[first_at], 2);
  const std::size_t link = first_at + 2 + 12U * entries;
  std::uint32_t second_at = 0;
  std::memcpy(&second_at, &good[link], 4);
  ASSERT_LT(second_at, good.size());
  const auto refusal_of = [&](const std::string& content) {
    std::ofstream(folder_ / "damaged.tif", std::ios::binary) << content;
    const auto source = open_raster(folder_ / "damaged.tif");
    EXPECT_FALSE(source.has_value());
    return source ? Error{} : source.error();
  };
  for (const std::uint32_t elsewhere : {static_cast<std::uint32_t>(good.size()), 0x7FFFFFF0U, 1U, first_at}) {
    std::string damaged = good;
    std::memcpy(&damaged[link], &elsewhere, 4);
    const Error error = refusal_of(damaged);
    EXPECT_EQ(error.code, ErrorCode::kInvalidData) << elsewhere;
    EXPECT_NE(error.message.find("directory 1 cannot be read"), std::string::npos) << elsewhere << ": " << error.message;
  }
  EXPECT_EQ(refusal_of(good.substr(0, second_at + 20)).code, ErrorCode::kInvalidData);
}

// However far behind the picture it lies, and when it is of something else.
TEST_F(BandMeaningTest, AMaskIsNotPassedOverInSilence) {
  const auto with_pages_before_mask = [](int pages, std::uint32_t mask_width) {
    RawTiff tiff = RawTiff::grey(4, 1);
    for (int i = 0; i < pages; ++i) tiff.page({.width = 1, .height = 1, .pixels = "x"});
    tiff.page({.width = mask_width, .height = 1, .bits = 1, .photometric = 4, .pixels = std::string("\xA0", 1)}).longs(254, {4});
    return tiff;
  };
  EXPECT_EQ(open(with_pages_before_mask(1000, 4))->info().bands, 2);
  with_pages_before_mask(1030, 4).write(folder_ / "far.tif");
  const auto far = open_raster(folder_ / "far.tif");
  ASSERT_FALSE(far.has_value());
  EXPECT_NE(far.error().message.find("more than 1024 directories"), std::string::npos) << far.error().message;
  const auto other = open(with_pages_before_mask(0, 5));
  EXPECT_EQ(other->info().bands, 1);
  EXPECT_TRUE(mentions(other->info(), "a second picture"));
}

TEST_F(BandMeaningTest, AMaskOfSignedBytesIsTheirLargest) {
  RawTiff tiff;
  tiff.page({.width = 2, .height = 1, .sample_format = 2, .pixels = std::string("\x05\xFB", 2)})
      .page({.width = 2, .height = 1, .bits = 1, .photometric = 4, .pixels = std::string("\x80", 1)})
      .longs(254, {4});
  const auto source = open(tiff);
  EXPECT_EQ(source->info().meaning[1].full_scale, 127.0);
  EXPECT_EQ(codes(*source), (std::vector<int>{5, 127, 0xFB, 0}));
}

TEST_F(BandMeaningTest, ScalesUnitsAndHeights) {
  RawTiff tiff;
  tiff.page({.width = 1, .height = 1, .bits = 16, .pixels = std::string(2, '\1')})
      .text(kMetadata,
            "<GDALMetadata><Item sample=\"0\" role=\"scale\">0.1</Item><Item sample=\"0\" role=\"offset\">7</Item>"
            "<Item sample=\"0\" role=\"unittype\">ft</Item></GDALMetadata>");
  const BandMeaning noted = open(tiff)->info().meaning[0];
  EXPECT_EQ(noted.scale, 0.1);
  EXPECT_EQ(noted.offset, 7.0);
  EXPECT_EQ(noted.unit, "ft");

  const auto with_vertical = [](std::vector<std::uint16_t> keys) {
    RawTiff heights;
    heights.page({.width = 1, .height = 1, .bits = 16, .pixels = std::string(2, '\1')}).utm33();
    std::vector<std::uint16_t> directory{1, 1, 0,    static_cast<std::uint16_t>(3 + keys.size() / 4), 1024, 0, 1, 1, 1025, 0, 1, 1, 3072,
                                         0, 1, 32633};
    directory.insert(directory.end(), keys.begin(), keys.end());
    return heights.shorts(34735, directory);
  };
  EXPECT_EQ(open(with_vertical({4099, 0, 1, 9002}))->info().heights.unit, "0.3048 m");
  const auto us_feet = open(with_vertical({4096, 0, 1, 6360}));
  EXPECT_EQ(us_feet->info().heights.unit.substr(0, 10), "0.30480060");
  EXPECT_TRUE(mentions(us_feet->info(), "EPSG:6360")) << "the datum itself is not used";
  EXPECT_FALSE(us_feet->info().heights.counts_down);
  EXPECT_TRUE(open(with_vertical({4096, 0, 1, 5715}))->info().heights.counts_down) << "mean sea level depth";
  EXPECT_EQ(open(with_vertical({4096, 0, 1, 5773}))->info().heights.unit, "1 m");
  EXPECT_EQ(open(with_vertical({4096, 0, 1, 5773}))->info().meaning[0].unit, "") << "the band itself says nothing";
  EXPECT_EQ(open(with_vertical({4096, 0, 1, 5103}))->info().heights.unit, "") << "a GeoTIFF 1.0 number, which names no unit";
  EXPECT_EQ(open(with_vertical({4099, 0, 1, 9095}))->info().heights.unit, "unit 9095 (GeoKey 4099)")
      << "a British foot, which is not known";
  EXPECT_EQ(open(with_vertical({4096, 0, 1, 6360, 4099, 0, 1, 9003}))->info().heights.unit.substr(0, 10), "0.30480060");
  EXPECT_EQ(open(with_vertical({4096, 0, 1, 8228, 4099, 0, 1, 9001}))->info().heights.unit, "1 m (GeoKey 4099) or 0.3048 m (EPSG:8228)");
}

TEST_F(BandMeaningTest, WhatIsNotUsedIsListedByName) {
  RawTiff tiff;
  tiff.page({.width = 1, .height = 1, .pixels = "x"})
      .text(kMetadata, "no xml")
      .text(kNodata, "none")
      .text(34675, "a profile")
      .page({.width = 3, .height = 1, .pixels = "abc"});
  const auto source = open(tiff);
  const RasterInfo& info = source->info();
  EXPECT_TRUE(mentions(info, "GDAL_METADATA"));
  EXPECT_TRUE(mentions(info, "GDAL_NODATA"));
  EXPECT_TRUE(mentions(info, "ICC profile"));
  EXPECT_TRUE(mentions(info, "a second picture"));
  EXPECT_EQ(info.unused.size(), 4U);
  EXPECT_TRUE(open(RawTiff().page({.width = 1, .height = 1, .pixels = "x"}))->info().unused.empty());
}

// A tag that is there but cannot be had is never an absent tag.
TEST_F(BandMeaningTest, TagsThatPointOutOfTheFileAreErrors) {
  RawTiff tiff;
  tiff.page({.width = 1, .height = 1, .bits = 16, .pixels = std::string(2, '\1')}).utm33().text(kNodata, "-9999.5");
  const std::string good = tiff.bytes();
  // The place of the text is the only mention of its offset in the directory.
  const auto text_at = static_cast<std::uint32_t>(good.find("-9999.5"));
  std::string damaged = good;
  const std::string needle(reinterpret_cast<const char*>(&text_at), 4);
  const std::size_t link = damaged.rfind(needle);
  ASSERT_NE(link, std::string::npos);
  for (const std::uint32_t elsewhere :
       {static_cast<std::uint32_t>(good.size()), static_cast<std::uint32_t>(good.size() - 3), 0x7FFFFFF0U}) {
    damaged.replace(link, 4, std::string(reinterpret_cast<const char*>(&elsewhere), 4));
    std::ofstream(folder_ / "damaged.tif", std::ios::binary) << damaged;
    const auto source = open_raster(folder_ / "damaged.tif");
    ASSERT_FALSE(source.has_value()) << elsewhere;
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(source.error().message.find("42113"), std::string::npos) << source.error().message;
  }
}

}  // namespace
}  // namespace vt::source
