// A channel from outside the builder, see tests/support/aspect_channel.cpp, in vtbuild and vtinspect that
// were linked with it; and what the programs that do not know it make of its store.
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "builder/source/tiff/geotiff_writer.h"
#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kWidth = 16;
constexpr std::int64_t kHeight = 8;

// Pairs of columns look to 350 and 10 degrees, whose mean is north; the plain mean of the numbers would be
// south.
float aspect_at(std::int64_t x) { return x % 2 == 0 ? 350.0F : 10.0F; }

class ExtraChannel : public VtinspectTest {
 protected:
  void SetUp() override {
    write_raster("aspect.tif", 10.0F);
    const Outcome built = build("s.vts");
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }
  // Pairs of columns look to 350 and 10 degrees; the last texel to `last`.
  void write_raster(const std::string& name, float last) const {
    std::vector<float> values;
    for (std::int64_t i = 0; i < kWidth * kHeight; ++i) values.push_back(aspect_at(i % kWidth));
    values.back() = last;
    auto writer =
        source::GeoTiffWriter::create(directory_ / name, {.width = kWidth,
                                                          .height = kHeight,
                                                          .sample_type = SampleType::kFloat32,
                                                          .transform = geo::GeoTransform{500000.0, 10.0, 0.0, 4000000.0, 0.0, -10.0},
                                                          .crs = geo::Crs::from_text("EPSG:32633").value()});
    ASSERT_TRUE(writer) << writer.error().message;
    ASSERT_TRUE(writer->write_rows(std::as_bytes(std::span(values)), kHeight));
    ASSERT_TRUE(writer->finish());
  }
  [[nodiscard]] Outcome build(const std::string& store) const {
    return run_program(VT_VTBUILD_WITH_ASPECT,
                       {"layer", "aspect.tif", "-o", store, "--channel", "aspect", "--tile", "8", "--threads", "1", "--progress", "none"},
                       directory_.path());
  }
  [[nodiscard]] Outcome inspect(const std::vector<std::string>& arguments) const {
    return run_program(VT_VTINSPECT_WITH_ASPECT, arguments, directory_.path());
  }
  [[nodiscard]] nlohmann::json inspect_json(std::vector<std::string> arguments) const {
    arguments.emplace_back("--json");
    const Outcome outcome = inspect(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out, nullptr, /*allow_exceptions=*/false);
  }
};

TEST_F(ExtraChannel, IsAmongTheChannelsOfTheProgram) {
  const Outcome help = run_program(VT_VTBUILD_WITH_ASPECT, {"layer", "--help"}, directory_.path());
  EXPECT_THAT(help.out, HasSubstr("illumination, mask, aspect"));
  const Outcome wrong = run_program(
      VT_VTBUILD_WITH_ASPECT, {"layer", "aspect.tif", "-o", "t.vts", "--channel", "aspect", "--kernel", "kaiser3"}, directory_.path());
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("kernel kaiser3 does not suit aspect layers: the mean of directions has a length"));
}

TEST_F(ExtraChannel, IsTakenInScenesOfTheProgramAlone) {
  write_file("SCENE.json", R"({"format": "vt-scene", "version": 1, "name": "slopes", "layers": [
    {"name": "aspect", "channel": "aspect", "tile": 8, "sources": ["aspect.tif"]}]})");
  const std::vector<std::string> arguments{"dataset", "SCENE.json", "-o", "scene.vts", "--threads", "1", "--progress", "none"};
  const Outcome built = run_program(VT_VTBUILD_WITH_ASPECT, arguments, directory_.path());
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(inspect({"compare", "s.vts", "scene.vts", "--progress", "none"}).exit_code, 0);
  const Outcome refused = run_program(VT_VTBUILD, arguments, directory_.path());
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("/layers/0/channel"));
}

TEST_F(ExtraChannel, AveragesByItsOwnRule) {
  // Level 0 is one texel of a pair's kind: the mean of 350 and 10 degrees is north, of the length of their
  // cosine.
  const auto sample = inspect_json({"sample", "s.vts", "--level", "0", "--uv", "0.5,0.75"});
  ASSERT_EQ(sample["value"].size(), 2U);
  EXPECT_NEAR(sample["value"][0].get<double>(), std::cos(10.0 * std::numbers::pi / 180.0), 2.0 / 65535.0);
  EXPECT_NEAR(sample["value"][1].get<double>(), 0.0, 2.0 / 65535.0);
}

TEST_F(ExtraChannel, IsShownCheckedAndCompared) {
  const Outcome info = inspect({"info", "s.vts"});
  EXPECT_THAT(info.out, HasSubstr("\"aspect\": aspect, rg16"));
  EXPECT_THAT(info.out, HasSubstr("direction"));
  EXPECT_EQ(inspect({"validate", "s.vts"}).exit_code, 0);
  EXPECT_EQ(inspect({"extract", "s.vts", "-o", "aspect.exr"}).exit_code, 0);
  const Outcome equal = inspect({"compare", "s.vts", "aspect.tif", "--progress", "none"});
  EXPECT_EQ(equal.exit_code, 0) << equal.out << equal.err;
  write_raster("other.tif", 13.0F);
  const Outcome other = inspect({"compare", "s.vts", "other.tif", "--layer", "aspect", "--progress", "none"});
  EXPECT_EQ(other.exit_code, 3) << other.err;
  EXPECT_THAT(other.out, HasSubstr("direction"));
  ASSERT_EQ(build("t.vts").exit_code, 0);
  EXPECT_EQ(inspect({"compare", "s.vts", "t.vts", "--progress", "none"}).exit_code, 0);
}

TEST_F(ExtraChannel, OfProgramsThatDoNotKnowItTexelsAreStillTexels) {
  const Outcome info = run({"info", "s.vts"});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, HasSubstr("channel 32769, rg16"));
  EXPECT_EQ(run({"validate", "s.vts"}).exit_code, 0);
  EXPECT_EQ(run({"extract", "s.vts", "-o", "texels.exr"}).exit_code, 0);
  const auto sample = run_json("vtinspect-sample", {"sample", "s.vts", "--level", "0", "--uv", "0.5,0.75"});
  EXPECT_NEAR(sample["value"][0].get<double>(), std::cos(10.0 * std::numbers::pi / 180.0), 2.0 / 65535.0);
}

}  // namespace
}  // namespace vt::test
