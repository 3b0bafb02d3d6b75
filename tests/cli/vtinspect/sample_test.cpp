#include "tests/cli/vtinspect/run.h"
#include "tools/cli/cli_support.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class VtinspectSample : public VtinspectTest {
 protected:
  void SetUp() override { write_sample_store(directory_ / "s.vts"); }
};

TEST_F(VtinspectSample, ThreeWaysOfAddressingAgree) {
  for (const int level : {0, 1, 2}) {
    const std::string level_text = std::to_string(level);
    const auto by_texel = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--level", level_text, "--texel", "3,2"});
    const auto exact = [](const nlohmann::json& pair) {
      return cli::format_exact(pair[0].get<double>()) + "," + cli::format_exact(pair[1].get<double>());
    };
    const auto by_uv =
        run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--level", level_text, "--uv", exact(by_texel["uv"])});
    const auto by_lonlat =
        run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--level", level_text, "--lonlat", exact(by_texel["lonlat"])});
    for (const auto* other : {&by_uv, &by_lonlat}) {
      for (const char* const key : {"texel", "texel_in_square", "tile", "texel_in_tile", "value", "linear"}) {
        EXPECT_EQ((*other)[key], by_texel[key]) << key << " at level " << level;
      }
      // A 32-bit quantum of a UTM coordinate of 5e6 m is 1e-9 m; a texel is 10 m and more.
      EXPECT_NEAR((*other)["position"][0].get<double>(), by_texel["position"][0].get<double>(), 1e-7);
      EXPECT_NEAR((*other)["position"][1].get<double>(), by_texel["position"][1].get<double>(), 1e-7);
    }
  }
}

TEST_F(VtinspectSample, ValueAndPlaceAreTheOnesWritten) {
  const auto json = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--texel", "0,0"});
  // Texel 0,0 of the data is 4,8 of the square: tile 0,0, texel 4,8 in it.
  EXPECT_EQ(json["texel_in_square"], (nlohmann::json{4, 8}));
  EXPECT_EQ(json["tile"], (nlohmann::json{{"level", 2}, {"x", 0}, {"y", 0}}));
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_EQ(json["value"][static_cast<std::size_t>(channel)], color_code(Level{2}, 4, 8, channel));
  }
  EXPECT_EQ(json["crs"], (nlohmann::json{kWest + 5.0, kNorth - 5.0}));
  EXPECT_EQ(json["uv"], (nlohmann::json{0.0125, 1.0 - 5.0 / 240.0}));
  // 5 m east of a central meridian at this latitude is 5 / (N cos(lat) k0) radians; 45.15 degrees north.
  EXPECT_NEAR(json["lonlat"][0].get<double>(), 15.0 + 5.0 / 0.9996 / (6388838.0 * 0.70525) * 57.29577951, 1e-7);
  EXPECT_NEAR(json["lonlat"][1].get<double>(), 45.153, 0.01);
}

TEST_F(VtinspectSample, HolesAreNoValue) {
  const auto json = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "elevation", "--texel", "3,2"});
  EXPECT_EQ(json["value"], nlohmann::json::array({nullptr}));
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "elevation", "--texel", "3,2"}).out, HasSubstr("value     no data"));
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "elevation", "--texel", "4,2"}).out, HasSubstr("value     142.25 m\n"));
}

TEST_F(VtinspectSample, AnAbsentTileNamesItsAncestor) {
  SampleStore options;
  options.absent_color_tile = TileId{Level{2}, 2, 1};
  write_sample_store(directory_ / "holes.vts", options);
  // Column 30 of the data is 34 of the square, in tile column 2.
  const auto json = run_json("vtinspect-sample", {"sample", "holes.vts", "--layer", "color", "--texel", "30,20"});
  EXPECT_EQ(json["tile_present"], false);
  EXPECT_TRUE(json["value"].is_null());
  EXPECT_EQ(json["nearest_present"], (nlohmann::json{{"level", 1}, {"x", 1}, {"y", 0}}));
}

TEST_F(VtinspectSample, TheWholeAreaIsInside) {
  // Corners included: u = 1 and v = 0 belong to the last texels.
  const auto south_east = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--uv", "1,0"});
  EXPECT_EQ(south_east["texel"], (nlohmann::json{39, 23}));
  const auto north_west = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "color", "--uv", "0,1"});
  EXPECT_EQ(north_west["texel"], (nlohmann::json{0, 0}));
}

TEST_F(VtinspectSample, OutsideSaysWhatIsInside) {
  const auto outside = [&](const std::string& option, const std::string& place) {
    const Outcome outcome = run({"sample", "s.vts", "--layer", "color", option, place});
    EXPECT_EQ(outcome.exit_code, 2) << option << ' ' << place;
    EXPECT_EQ(outcome.out, "");
    return outcome.err;
  };
  EXPECT_THAT(outside("--texel", "40,0"), AllOf(HasSubstr("40,0"), HasSubstr("valid: 0..39, 0..23")));
  EXPECT_THAT(outside("--texel", "0,-1"), HasSubstr("valid: 0..39, 0..23"));
  EXPECT_THAT(outside("--texel", "9223372036854775807,0"), HasSubstr("valid: 0..39, 0..23"));
  EXPECT_THAT(outside("--uv", "1.001,0.5"), HasSubstr("valid: u 0 .. 1, v 0 .. 1"));
  EXPECT_THAT(outside("--uv", "1e300,0.5"), HasSubstr("valid: u 0 .. 1"));
  EXPECT_THAT(outside("--lonlat", "16,45.15"), HasSubstr("valid: longitude about 15 .. 15.005"));
}

TEST_F(VtinspectSample, TellsWhichLayersAndLevelsThereAre) {
  EXPECT_THAT(run({"sample", "s.vts", "--layer", "colour", "--uv", "0,0"}).err, HasSubstr("layers: color, elevation"));
  EXPECT_EQ(run({"sample", "s.vts", "--layer", "colour", "--uv", "0,0"}).exit_code, 2);
  const Outcome level = run({"sample", "s.vts", "--layer", "color", "--level", "3", "--uv", "0,0"});
  EXPECT_EQ(level.exit_code, 2);
  EXPECT_THAT(level.err, HasSubstr("levels: 0 (coarsest) to 2 (finest)"));
}

}  // namespace
}  // namespace vt::test
