#include <cmath>
#include <cstring>

#include "store/store_writer.h"
#include "tests/cli/picture_file.h"
#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

class VtinspectExtract : public VtinspectTest {
 protected:
  void SetUp() override { write_sample_store(directory_ / "s.vts"); }
  void expect_success(const std::vector<std::string>& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
};

TEST_F(VtinspectExtract, PngHoldsTheCodesOfEveryLevel) {
  for (int value = 0; value <= 2; ++value) {
    const Level level{static_cast<std::uint8_t>(value)};
    expect_success({"extract", "s.vts", "--layer", "color", "--level", std::to_string(value), "-o", "out.png"});
    const auto picture = read_png(directory_ / "out.png");
    const TexelRect data = coarser(kColorData, 2 - value);
    ASSERT_EQ(picture.width, data.width);
    ASSERT_EQ(picture.height, data.height);
    ASSERT_EQ(picture.channels, 3);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        for (int channel = 0; channel < 3; ++channel) {
          ASSERT_EQ(picture.at(x, y, channel), color_code(level, data.x + x, data.y + y, channel)) << x << ',' << y << " level " << value;
        }
      }
    }
  }
}

TEST_F(VtinspectExtract, AWindowIsThatPartOfTheLevel) {
  expect_success({"extract", "s.vts", "--layer", "color", "--window", "10,5,21,17", "-o", "out.png"});
  const auto picture = read_png(directory_ / "out.png");
  ASSERT_EQ(picture.width, 21);
  ASSERT_EQ(picture.height, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 21; ++x) {
      ASSERT_EQ(picture.at(x, y, 1), color_code(Level{2}, kColorData.x + 10 + x, kColorData.y + 5 + y, 1));
    }
  }
}

TEST_F(VtinspectExtract, WindowsOutsideAreRefused) {
  for (const std::string window :
       {"0,0,41,1", "0,0,1,25", "40,0,1,1", "-1,0,2,2", "0,0,0,1", "9223372036854775807,0,1,1", "1,0,9223372036854775807,1"}) {
    const Outcome outcome = run({"extract", "s.vts", "--layer", "color", "--window", window, "-o", "out.png"});
    EXPECT_EQ(outcome.exit_code, 2) << window;
    EXPECT_THAT(outcome.err, HasSubstr("40 x 24 texels")) << window;
  }
  EXPECT_EQ(files(), std::vector<std::string>{"s.vts"});
}

TEST_F(VtinspectExtract, OfHashesThereIsNoPicture) {
  {
    store::StoreWriter writer = store::StoreWriter::open(directory_ / "s.vts").value();
    LayerInfo hashes = writer.find_layer("color").value();
    hashes.name = "hashes";
    hashes.format = TexelFormat::kHash128;
    hashes.transfer = Transfer::kLinear;
    const LayerId id = writer.add_layer(hashes).value();
    const std::vector<std::byte> hash(16, std::byte{200});
    ASSERT_TRUE(writer.put_constant(id, {}, hash));
    ASSERT_TRUE(writer.finish());
  }
  const Outcome outcome = run({"extract", "s.vts", "--layer", "hashes", "--level", "0", "-o", "out.png"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("s.vts: layer hashes holds hashes, of which there is no picture"));
  EXPECT_EQ(files(), std::vector<std::string>{"s.vts"});
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "hashes", "--level", "0", "--texel", "3,3"}).out,
              HasSubstr("value     200, 200, 200, 200"));
}

TEST_F(VtinspectExtract, StraightAlphaStaysStraight) {
  SampleStore options;
  options.color_format = TexelFormat::kRgba8;
  write_sample_store(directory_ / "rgba.vts", options);
  expect_success({"extract", "rgba.vts", "--layer", "color", "-o", "out.png"});
  const auto picture = read_png(directory_ / "out.png");
  ASSERT_EQ(picture.channels, 4);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      ASSERT_EQ(picture.at(x, y, 0), color_code(Level{2}, kColorData.x + x, kColorData.y + y, 0));
      ASSERT_EQ(picture.at(x, y, 3), (x + y) % 2 == 0 ? 255 : 128);
    }
  }
}

TEST_F(VtinspectExtract, AbsentTilesAreTransparentAndCounted) {
  SampleStore options;
  options.absent_color_tile = TileId{Level{2}, 1, 1};  // columns 12..27, rows 8..23 of the data
  write_sample_store(directory_ / "holes.vts", options);
  const Outcome outcome = run({"extract", "holes.vts", "--layer", "color", "-o", "out.png"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("holes.vts: 1 tiles of layer color, level 2 are absent; they are written as transparent"));
  const auto picture = read_png(directory_ / "out.png");
  ASSERT_EQ(picture.channels, 4);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const bool is_hole = x >= 12 && x < 28 && y >= 8;
      ASSERT_EQ(picture.at(x, y, 3), is_hole ? 0 : 255) << x << ',' << y;
    }
  }
}

TEST_F(VtinspectExtract, TiffLiesExactlyOnTheLevelsGrid) {
  struct Case {
    std::string level;
    std::string window;
    std::int64_t x, y;  // where the window starts
    double x0, y0, step;
  };
  // Coarse levels start on the square's grid: column 1 of level 0 is finest column 4, row 2 is finest row 8,
  // where the data starts.
  for (const Case& expected :
       {Case{"2", "0,0,40,24", 0, 0, kWest, kNorth, 10.0}, Case{"2", "7,3,5,4", 7, 3, kWest + 70.0, kNorth - 30.0, 10.0},
        Case{"1", "1,2,3,4", 1, 2, kWest + 20.0, kNorth - 40.0, 20.0}, Case{"0", "0,0,10,6", 0, 0, kWest, kNorth, 40.0}}) {
    expect_success({"extract", "s.vts", "--layer", "color", "--level", expected.level, "--window", expected.window, "-o", "out.tif"});
    const TiffFile tiff = read_tiff(directory_ / "out.tif");
    // Raster 0,0 is the outer corner (PixelIsArea) and lies on x0, y0; ProjectedCSType is EPSG's number of
    // UTM 33N.
    EXPECT_EQ(tiff.pixel_scale, (std::vector<double>{expected.step, expected.step, 0.0}));
    EXPECT_EQ(tiff.tie_point, (std::vector<double>{0.0, 0.0, 0.0, expected.x0, expected.y0, 0.0}));
    EXPECT_EQ(tiff.geo_key(1025), 1);
    EXPECT_EQ(tiff.geo_key(3072), 32633);
    EXPECT_EQ(tiff.bands, 3);
    EXPECT_EQ(tiff.extra_samples, 0);
    EXPECT_EQ(tiff.bits_per_sample, 8);
    const auto level = Level{static_cast<std::uint8_t>(std::stoi(expected.level))};
    const TexelRect data = coarser(kColorData, 2 - level.value);
    for (std::int64_t y = 0; y < tiff.height; ++y) {
      for (std::int64_t x = 0; x < tiff.width; ++x) {
        const auto code = tiff.samples[static_cast<std::size_t>((y * tiff.width + x) * 3)];
        ASSERT_EQ(std::to_integer<int>(code), color_code(level, data.x + expected.x + x, data.y + expected.y + y, 0));
      }
    }
  }
}

TEST_F(VtinspectExtract, TiffGivesTheSourcesNodataBack) {
  expect_success({"extract", "s.vts", "--layer", "elevation", "-o", "out.tif"});
  const TiffFile tiff = read_tiff(directory_ / "out.tif");
  ASSERT_EQ(tiff.width, kElevationData.width);
  ASSERT_EQ(tiff.height, kElevationData.height);
  ASSERT_EQ(tiff.bands, 1);
  ASSERT_EQ(tiff.bits_per_sample, 32);
  EXPECT_EQ(tiff.nodata, "-9999");
  for (std::int64_t y = 0; y < tiff.height; ++y) {
    for (std::int64_t x = 0; x < tiff.width; ++x) {
      float value = 0.0F;
      std::memcpy(&value, &tiff.samples[static_cast<std::size_t>(y * tiff.width + x) * sizeof value], sizeof value);
      const float written = elevation_m(Level{1}, x, y);
      EXPECT_EQ(value, std::isnan(written) ? -9999.0F : written);
    }
  }
}

TEST_F(VtinspectExtract, ExrHoldsTheFloats) {
  expect_success({"extract", "s.vts", "--layer", "elevation", "-o", "out.exr"});
  const auto picture = read_exr(directory_ / "out.exr");
  ASSERT_EQ(picture.channels, 1);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float written = elevation_m(Level{1}, x, y);
      if (std::isnan(written)) {
        EXPECT_TRUE(std::isnan(picture.at(x, y, 0)));
      } else {
        EXPECT_EQ(picture.at(x, y, 0), written);
      }
    }
  }
}

TEST_F(VtinspectExtract, PngOfFloatsIsStretchedAndSaysSo) {
  const Outcome outcome = run({"extract", "s.vts", "--layer", "elevation", "-o", "out.png"});
  EXPECT_EQ(outcome.exit_code, 0);
  // From 0,0 to 19,11: 100.25 + 10 x + y.
  EXPECT_THAT(outcome.err, HasSubstr("stretched 100.25 .. 301.25 to 0 .. 255"));
  const auto picture = read_png(directory_ / "out.png");
  ASSERT_EQ(picture.channels, 2) << "grey, and alpha for the hole";
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const bool is_hole = x == 3 && y == 2;
      EXPECT_EQ(picture.at(x, y, 1), is_hole ? 0 : 255);
      // One rounding to whole codes.
      if (!is_hole) {
        EXPECT_NEAR(picture.at(x, y, 0), (10 * x + y) / 201.0 * 255.0, 0.5 + 1e-4);
      }
    }
  }
}

TEST_F(VtinspectExtract, MosaicShowsEveryLevelEnlarged) {
  const Outcome outcome = run({"extract", "s.vts", "--layer", "color", "--mosaic", "-o", "out.png"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("levels 0 to 2 of layer color"));
  const auto picture = read_png(directory_ / "out.png");
  // Cells of 512 x 307 (40 : 24): three levels at two columns wide by sqrt(2 * 3 * 307 / 512) = 1.9.
  ASSERT_EQ(picture.width, 1 + 2 * 513);
  ASSERT_EQ(picture.height, 1 + 2 * 308);
  // Level 0 is 10 x 6, enlarged 51 times and centred; the middle of its first texel.
  const int left = 1 + (512 - 510) / 2;
  const int top = 1 + (307 - 306) / 2;
  EXPECT_EQ(picture.at(left + 25, top + 25, 0), color_code(Level{0}, 1, 2, 0));
  EXPECT_EQ(picture.at(left + 51 + 25, top + 25, 0), color_code(Level{0}, 2, 2, 0));
  EXPECT_EQ(picture.at(0, 0, 0), 70) << "a gap";
  EXPECT_EQ(picture.at(picture.width - 20, picture.height - 20, 0), 119) << "an empty cell";
}

TEST_F(VtinspectExtract, UnwritableOutputIsAnInputOutputError) {
  std::filesystem::create_directory(directory_ / "a_directory.png");
  for (const std::string output : {"missing/out.png", "missing/out.tif", "a_directory.png"}) {
    const Outcome outcome = run({"extract", "s.vts", "--layer", "color", "-o", output});
    EXPECT_EQ(outcome.exit_code, 2) << output << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(output));
  }
  EXPECT_THAT(files(), testing::UnorderedElementsAre("s.vts", "a_directory.png"));
}

TEST_F(VtinspectExtract, ReplacesAnOlderPictureAsAWhole) {
  write_file("out.png", "something older");
  expect_success({"extract", "s.vts", "--layer", "color", "-o", "out.png"});
  EXPECT_EQ(read_png(directory_ / "out.png").width, 40);
  EXPECT_THAT(files(), testing::UnorderedElementsAre("s.vts", "out.png"));
}

}  // namespace
}  // namespace vt::test
