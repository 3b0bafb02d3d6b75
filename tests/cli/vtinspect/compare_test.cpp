#include <cmath>

#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

class VtinspectCompare : public VtinspectTest {
 protected:
  void SetUp() override { write_sample_store(directory_ / "a.vts"); }
};

TEST_F(VtinspectCompare, TwoBuildsOfTheSameAreEqual) {
  write_sample_store(directory_ / "b.vts");
  const Outcome outcome = run({"compare", "a.vts", "b.vts", "--progress", "none"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, "layer color: equal\nlayer elevation: equal\nequal\n");
  EXPECT_EQ(outcome.err, "");
  const auto json = run_json("vtinspect-compare", {"compare", "a.vts", "b.vts"});
  EXPECT_EQ(json["equal"], true);
  EXPECT_EQ(json["within_tolerance"], true);
  EXPECT_TRUE(json["layers"][0]["levels"][2]["psnr_codes_db"].is_null());
}

TEST_F(VtinspectCompare, MeasuresOneChangedCode) {
  SampleStore options;
  options.changed_color_tile = TileId{Level{1}, 1, 0};  // its first texel, 16,0 of the level, is outside the data
  write_sample_store(directory_ / "outside.vts", options);
  options.changed_color_tile = TileId{Level{2}, 1, 1};  // its first texel is 16,16 of the square
  write_sample_store(directory_ / "inside.vts", options);

  const auto outside = run_json("vtinspect-compare", {"compare", "a.vts", "outside.vts"}, 0);
  EXPECT_EQ(outside["equal"], false) << "tile bytes differ";
  EXPECT_EQ(outside["within_tolerance"], true) << "but no texel of the data does";
  EXPECT_EQ(outside["layers"][0]["levels"][1]["differing_tiles"], 1);

  const auto json = run_json("vtinspect-compare", {"compare", "a.vts", "inside.vts"}, 3);
  EXPECT_EQ(json["equal"], false);
  EXPECT_EQ(json["within_tolerance"], false);
  const auto& level = json["layers"][0]["levels"][2];
  EXPECT_EQ(level["differing_tiles"], 1);
  EXPECT_EQ(level["max_error"], 2.0);
  // One of 40 * 24 * 3 samples is off by 2.
  constexpr double kSamples = 40 * 24 * 3;
  EXPECT_NEAR(level["mean_error"].get<double>(), 2.0 / kSamples, 1e-15);
  EXPECT_NEAR(level["psnr_codes_db"].get<double>(), 10.0 * std::log10(255.0 * 255.0 * kSamples / 4.0), 1e-9);
  // The same in light, by the definition of sRGB for codes above 10.
  const auto light = [](int code) { return std::pow((code / 255.0 + 0.055) / 1.055, 2.4); };
  const int code = color_code(Level{2}, 16, 16, 0);
  ASSERT_GT(code, 10);
  const double error = light(code + 2) - light(code);
  EXPECT_NEAR(level["psnr_linear_db"].get<double>(), 10.0 * std::log10(kSamples / (error * error)), 1e-9);
  EXPECT_EQ(json["layers"][0]["levels"][0]["differing_tiles"], 0);

  EXPECT_EQ(run({"compare", "a.vts", "inside.vts", "--tolerance", "2"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "a.vts", "inside.vts", "--tolerance", "1.9"}).exit_code, 3);
  EXPECT_EQ(run({"compare", "a.vts", "inside.vts", "--layer", "elevation"}).exit_code, 0);
  EXPECT_THAT(run({"compare", "a.vts", "inside.vts", "--tolerance", "2"}).out, HasSubstr("within the tolerance of 2"));
}

TEST_F(VtinspectCompare, CountsTilesOfOneSideOnly) {
  SampleStore options;
  options.absent_color_tile = TileId{Level{2}, 2, 1};
  write_sample_store(directory_ / "b.vts", options);
  const auto json = run_json("vtinspect-compare", {"compare", "a.vts", "b.vts", "--tolerance", "1000"}, 3);
  EXPECT_EQ(json["layers"][0]["levels"][2]["only_in_first"], 1);
  EXPECT_EQ(json["layers"][0]["levels"][2]["only_in_second"], 0);
  const auto reverse = run_json("vtinspect-compare", {"compare", "b.vts", "a.vts"}, 3);
  EXPECT_EQ(reverse["layers"][0]["levels"][2]["only_in_second"], 1);
}

TEST_F(VtinspectCompare, NamesLayersThatCannotBeCompared) {
  SampleStore options;
  options.color_format = TexelFormat::kRgba8;
  options.with_elevation = false;
  write_sample_store(directory_ / "b.vts", options);
  const auto json = run_json("vtinspect-compare", {"compare", "a.vts", "b.vts"}, 3);
  EXPECT_THAT(json["mismatches"].dump(), testing::AllOf(HasSubstr("format rgb8 and rgba8"), HasSubstr("layer elevation: only in a.vts")));
  const auto reverse = run_json("vtinspect-compare", {"compare", "b.vts", "a.vts"}, 3);
  EXPECT_THAT(reverse["mismatches"].dump(), HasSubstr("layer elevation: only in a.vts"));
}

TEST_F(VtinspectCompare, CarryLayersCountOnlyWhenAskedFor) {
  SampleStore options;
  options.with_carry = true;
  write_sample_store(directory_ / "b.vts", options);
  EXPECT_EQ(run({"compare", "a.vts", "b.vts"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "b.vts", "a.vts"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "a.vts", "b.vts", "--all"}).exit_code, 3);
  EXPECT_EQ(run({"compare", "b.vts", "a.vts", "--all"}).exit_code, 3);
  EXPECT_EQ(run({"compare", "b.vts", "b.vts", "--all"}).exit_code, 0);
}

TEST_F(VtinspectCompare, WhatExtractWritesIsEqualToTheStore) {
  for (const std::string layer : {"color", "elevation"}) {
    ASSERT_EQ(run({"extract", "a.vts", "--layer", layer, "-o", layer + ".tif"}).exit_code, 0);
    const auto whole = run_json("vtinspect-compare", {"compare", "a.vts", layer + ".tif", "--layer", layer});
    EXPECT_EQ(whole["layers"][0]["levels"][0]["max_error"], 0.0);
    EXPECT_EQ(whole["layers"][0]["levels"][0]["hole_mismatches"], 0);
    ASSERT_EQ(run({"extract", "a.vts", "--layer", layer, "--window", "3,1,9,8", "-o", "part.tif"}).exit_code, 0);
    EXPECT_EQ(run({"compare", "a.vts", "part.tif", "--layer", layer}).exit_code, 0) << "a window lies in its place";
  }
  const Outcome coarse = run({"extract", "a.vts", "--layer", "color", "--level", "1", "-o", "coarse.tif"});
  ASSERT_EQ(coarse.exit_code, 0);
  const Outcome outcome = run({"compare", "a.vts", "coarse.tif", "--layer", "color"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.out, HasSubstr("the raster's grid"));
}

TEST_F(VtinspectCompare, FindsTheDifferenceToARaster) {
  SampleStore options;
  options.changed_color_tile = TileId{Level{2}, 1, 1};
  write_sample_store(directory_ / "b.vts", options);
  ASSERT_EQ(run({"extract", "b.vts", "--layer", "color", "-o", "b.tif"}).exit_code, 0);
  const auto json = run_json("vtinspect-compare", {"compare", "a.vts", "b.tif", "--layer", "color"}, 3);
  EXPECT_EQ(json["layers"][0]["levels"][0]["max_error"], 2.0);
  EXPECT_EQ(json["layers"][0]["levels"][0]["differing_tiles"], 1);
  EXPECT_EQ(run({"compare", "a.vts", "missing.tif", "--layer", "color"}).exit_code, 2);
}

}  // namespace
}  // namespace vt::test
