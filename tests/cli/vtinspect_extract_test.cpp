#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstring>

#include "builder/source/raster_source.h"
#include "tests/cli/vtinspect_run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

// A picture as OpenImageIO reads it, in its own sample type, alpha as it stands in the file.
template <class Sample>
struct Picture {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<Sample> samples;
  [[nodiscard]] Sample at(int x, int y, int channel) const {
    return samples[static_cast<std::size_t>((y * width + x) * channels + channel)];
  }
};
template <class Sample>
Picture<Sample> read_picture(const std::filesystem::path& path) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  Picture<Sample> picture{spec.width, spec.height, spec.nchannels, {}};
  picture.samples.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
  const auto type = std::is_same_v<Sample, float> ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
  EXPECT_EQ(spec.format, type);
  EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, type, picture.samples.data()));
  return picture;
}

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
    const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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
  const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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

TEST_F(VtinspectExtract, StraightAlphaStaysStraight) {
  SampleStore options;
  options.color_format = TexelFormat::kRgba8;
  write_sample_store(directory_ / "rgba.vts", options);
  expect_success({"extract", "rgba.vts", "--layer", "color", "-o", "out.png"});
  const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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
  const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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
    double x0, y0, step;
  };
  // Coarse levels start on the square's grid: column 1 of level 0 is finest column 4, row 2 is finest row 8, where the data starts.
  for (const Case& expected : {Case{"2", "0,0,40,24", kWest, kNorth, 10.0}, Case{"2", "7,3,5,4", kWest + 70.0, kNorth - 30.0, 10.0},
                               Case{"1", "1,2,3,4", kWest + 20.0, kNorth - 40.0, 20.0}, Case{"0", "0,0,10,6", kWest, kNorth, 40.0}}) {
    expect_success({"extract", "s.vts", "--layer", "color", "--level", expected.level, "--window", expected.window, "-o", "out.tif"});
    const auto raster = source::open_raster(directory_ / "out.tif");
    ASSERT_TRUE(raster) << raster.error().message;
    const source::RasterInfo& info = (*raster)->info();
    ASSERT_TRUE(info.has_transform);
    EXPECT_EQ(info.transform.x0, expected.x0);
    EXPECT_EQ(info.transform.y0, expected.y0);
    EXPECT_EQ(info.transform.x_column, expected.step);
    EXPECT_EQ(info.transform.y_row, -expected.step);
    EXPECT_TRUE(info.transform.is_north_up());
    ASSERT_TRUE(info.crs) << info.crs_problem;
    EXPECT_TRUE(info.crs->same_coordinates(*geo::Crs::from_epsg(32633)));
    EXPECT_EQ(info.bands, 3);
    EXPECT_EQ(info.alpha_band, -1);
    EXPECT_EQ(info.sample_type, source::SampleType::kUint8);
  }
}

TEST_F(VtinspectExtract, TiffGivesTheSourcesNodataBack) {
  expect_success({"extract", "s.vts", "--layer", "elevation", "-o", "out.tif"});
  const auto raster = source::open_raster(directory_ / "out.tif");
  ASSERT_TRUE(raster) << raster.error().message;
  const source::RasterInfo& info = (*raster)->info();
  ASSERT_EQ(info.width, kElevationData.width);
  ASSERT_EQ(info.height, kElevationData.height);
  ASSERT_EQ(info.sample_type, source::SampleType::kFloat32);
  EXPECT_EQ(info.nodata, -9999.0);
  std::vector<float> values(static_cast<std::size_t>(info.width * info.height));
  const int band = 0;
  const auto read = (*raster)->read({0, 0, info.width, info.height}, {&band, 1}, std::as_writable_bytes(std::span(values)),
                                    static_cast<std::size_t>(info.width) * sizeof(float));
  ASSERT_TRUE(read) << read.error().message;
  for (std::int64_t y = 0; y < info.height; ++y) {
    for (std::int64_t x = 0; x < info.width; ++x) {
      const float written = elevation_m(Level{1}, x, y);
      EXPECT_EQ(values[static_cast<std::size_t>(y * info.width + x)], std::isnan(written) ? -9999.0F : written);
    }
  }
}

TEST_F(VtinspectExtract, ExrHoldsTheFloats) {
  expect_success({"extract", "s.vts", "--layer", "elevation", "-o", "out.exr"});
  const auto picture = read_picture<float>(directory_ / "out.exr");
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
  const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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
  const auto picture = read_picture<std::uint8_t>(directory_ / "out.png");
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
  EXPECT_EQ(read_picture<std::uint8_t>(directory_ / "out.png").width, 40);
  EXPECT_THAT(files(), testing::UnorderedElementsAre("s.vts", "out.png"));
}

}  // namespace
}  // namespace vt::test
