// A layer that was never finished is in nobody's way, and work that is worth something is never thrown away
// without being asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "builder/pipeline/blocks/block_marks.h"
#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

double one_code(std::int64_t x, std::int64_t y, int band) { return hash_noise(x, y, band) % 256; }
double another_code(std::int64_t x, std::int64_t y, int band) { return hash_noise(x + 7, y, band) % 256; }

struct Attempt {
  std::optional<Error> error;
  BuildReport report;
  std::vector<std::string> remarks;
};

class UnfinishedLayer : public testing::Test {
 protected:
  // 300 texels are 5 x 5 blocks of two tiles of 32.
  LayerRequest request(const std::string& kernel = "box") {
    LayerRequest request = request_for({folder_ / "input.tif"}, ChannelType::kColor);
    request.kernel = kernel;
    request.tile_texels = 32;
    return request;
  }
  void write_input(double (*value)(std::int64_t, std::int64_t, int), const std::string& name = "input.tif") {
    write_raster(folder_ / name, {.width = 300, .height = 300, .tile = 64, .compression = source::GeoTiffSpec::Compression::kDeflate},
                 value);
  }
  // Some tiles in the middle of the file do not decompress any more.
  void spoil_input() {
    const auto size = static_cast<std::streamoff>(std::filesystem::file_size(folder_ / "input.tif"));
    std::fstream file(folder_ / "input.tif", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(size * 6 / 10);
    file << std::string(static_cast<std::size_t>(size / 10), '\xFF');
  }
  Attempt run(const LayerRequest& wanted, BuildOptions options = {}) {
    Attempt attempt;
    options.threads = 1;
    options.block_levels = 1;
    options.remark = [&](const std::string& remark) { attempt.remarks.push_back(remark); };
    const auto frame = existing_frame(store_);
    EXPECT_TRUE(frame);
    auto plan = plan_layer(wanted, *frame, 1 << 20);
    if (!plan) {
      attempt.error = plan.error();
      return attempt;
    }
    auto writer = open_or_create(store_, plan->crs, plan->extent());
    EXPECT_TRUE(writer);
    auto built = build_layer(*writer, *plan, options);
    if (built) {
      attempt.report = *built;
    } else {
      attempt.error = built.error();
    }
    EXPECT_TRUE(store::validate(store_)->ok());
    return attempt;
  }
  // Stops after some blocks.
  void interrupt(const LayerRequest& wanted, std::uint64_t after_texels) {
    std::atomic<bool> cancel = false;
    const Attempt attempt =
        run(wanted, {.progress = [&](std::uint64_t done, std::uint64_t) { cancel = done >= after_texels; }, .cancel = &cancel});
    ASSERT_TRUE(attempt.error);
    ASSERT_EQ(attempt.error->code, ErrorCode::kCancelled);
  }
  // The tiles are those of a build that was never anything else.
  void expect_as_new(const LayerRequest& wanted) {
    const auto fresh = folder_ / "fresh.vts";
    std::filesystem::remove(fresh);
    build(fresh, wanted, {.threads = 1, .block_levels = 1});
    EXPECT_EQ(tiles_of(store_, "color"), tiles_of(fresh, "color"));
  }

  test::TempFolder folder_;
  std::filesystem::path store_ = folder_ / "a.vts";
};

TEST_F(UnfinishedLayer, ThatNeverCameToAnythingGivesWayToACorrectedCommand) {
  write_input(one_code);
  interrupt(request(), 0);
  const Attempt corrected = run(request("kaiser3"));
  ASSERT_FALSE(corrected.error) << corrected.error->message;
  ASSERT_EQ(corrected.remarks.size(), 1U);
  EXPECT_THAT(corrected.remarks[0], AllOf(HasSubstr("layer 'color' was begun with other settings"), HasSubstr("built anew")));
  expect_as_new(request("kaiser3"));
}

// Dim light was begun with, and bright light is built: what is stored suits the light that is there.
TEST_F(UnfinishedLayer, ThatGivesWayLeavesNoScaleOfLightBehind) {
  const auto light_of = [&](double factor) {
    const std::filesystem::path path = folder_ / (factor < 1.0 ? "dim.tif" : "bright.tif");
    write_raster(path, {.width = 300, .height = 300, .type = SampleType::kFloat32},
                 [&](std::int64_t x, std::int64_t y, int band) { return factor * (1.0 + hash_noise(x, y, band) % 100); });
    LayerRequest wanted = request_for({path}, ChannelType::kIllumination);
    wanted.tile_texels = 32;
    wanted.format = TexelFormat::kRgba16Float;
    return wanted;
  };
  interrupt(light_of(1e-6), 0);
  const auto scale_of = [](const std::filesystem::path& store) {
    return store::StoreReader::open(store)->find_layer("illumination")->components[0].scale;
  };
  const double dim = scale_of(store_);
  ASSERT_LT(dim, 1e-3);
  LayerRequest bright = light_of(1000.0);
  const Attempt corrected = run(bright);
  ASSERT_FALSE(corrected.error) << corrected.error->message;
  build(folder_ / "fresh.vts", bright, {.threads = 1, .block_levels = 1});
  EXPECT_EQ(scale_of(store_), scale_of(folder_ / "fresh.vts"));
  EXPECT_TRUE(tiles_of(store_, "illumination") == tiles_of(folder_ / "fresh.vts", "illumination"));
}

// The scale of light was chosen for the sources as they were; the command that began the layer goes on with
// it.
TEST_F(UnfinishedLayer, GoesOnWithItsScaleOfLightWhenItsSourcesHaveChanged) {
  const auto write_light = [&](double factor) {
    write_raster(folder_ / "light.tif", {.width = 300, .height = 300, .type = SampleType::kFloat32},
                 [&](std::int64_t x, std::int64_t y, int band) { return factor * (1.0 + hash_noise(x, y, band) % 100); });
  };
  LayerRequest wanted = request_for({folder_ / "light.tif"}, ChannelType::kIllumination);
  wanted.tile_texels = 32;
  wanted.format = TexelFormat::kRgba16Float;
  write_light(1e-6);
  interrupt(wanted, 20000);
  write_light(3e-6);
  const Attempt again = run(wanted);
  ASSERT_FALSE(again.error) << again.error->message;
  EXPECT_LT(store::StoreReader::open(store_)->find_layer("illumination")->components[0].scale, 1e-3);
}

TEST_F(UnfinishedLayer, ThatFailedForItsDataGivesWayWhateverItCameTo) {
  write_input(one_code);
  spoil_input();
  const Attempt failed = run(request());
  ASSERT_TRUE(failed.error);
  ASSERT_TRUE(is_of_the_data(failed.error->code)) << failed.error->message;
  write_input(another_code);
  const Attempt corrected = run(request("kaiser3"));
  ASSERT_FALSE(corrected.error) << corrected.error->message;
  ASSERT_EQ(corrected.remarks.size(), 1U);
  EXPECT_THAT(corrected.remarks[0], HasSubstr("could not be finished"));
  expect_as_new(request("kaiser3"));
}

// A file was bad, and is mended: what was built of the others stays.
TEST_F(UnfinishedLayer, ThatFailedForItsDataGoesOnWhenTheyAreMended) {
  write_input(one_code);
  spoil_input();
  ASSERT_TRUE(run(request()).error);
  write_input(one_code);
  const Attempt again = run(request());
  ASSERT_FALSE(again.error) << again.error->message;
  EXPECT_GT(again.report.blocks_checked, again.report.blocks_changed);
  expect_as_new(request());
  const Attempt other = run(request("kaiser3"));
  EXPECT_TRUE(other.error) << "complete by now";
}

TEST_F(UnfinishedLayer, ThatHoldsWorkIsKeptForTheCommandThatBeganIt) {
  write_input(one_code);
  interrupt(request(), 30000);
  const Attempt other = run(request("kaiser3"));
  ASSERT_TRUE(other.error);
  EXPECT_EQ(other.error->code, ErrorCode::kExists);
  EXPECT_THAT(other.error->message,
              AllOf(HasSubstr("an unfinished layer 'color'"), HasSubstr("by the command that began it"), HasSubstr("remove the layer")));
  const Attempt same = run(request());
  ASSERT_FALSE(same.error) << same.error->message;
  EXPECT_GT(same.report.blocks_resumed, 0);
  EXPECT_TRUE(same.remarks.empty());
  expect_as_new(request());
}

TEST_F(UnfinishedLayer, GoesOnWithOtherSourcesAsAnUpdateDoes) {
  write_input(one_code);
  interrupt(request(), 30000);
  // The upper rows stay as they were.
  write_raster(folder_ / "input.tif", {.width = 300, .height = 300, .tile = 64},
               [](std::int64_t x, std::int64_t y, int band) { return y < 60 ? one_code(x, y, band) : another_code(x, y, band); });
  const Attempt again = run(request());
  ASSERT_FALSE(again.error) << again.error->message;
  ASSERT_EQ(again.remarks.size(), 1U);
  EXPECT_THAT(again.remarks[0], AllOf(HasSubstr("never finished"), HasSubstr("sources have changed")));
  EXPECT_GT(again.report.blocks_checked, 0);
  expect_as_new(request());
}

// A run that ends inside a block leaves tiles of it in the store. When no source reaches there any more, they
// have to go.
TEST_F(UnfinishedLayer, LeavesNoTilesOfABlockThatWasBegunAndLostItsSource) {
  write_input(one_code, "west.tif");
  RasterSpec east{.width = 300, .height = 300, .tile = 64};
  east.transform.x0 += 300 * east.transform.x_column;
  write_raster(folder_ / "east.tif", east, another_code);
  LayerRequest both = request_for({folder_ / "west.tif", folder_ / "east.tif"}, ChannelType::kColor);
  both.tile_texels = 32;
  both.format = TexelFormat::kRgba8;
  for (auto& source : both.sources) source.nodata = {0.0};
  LayerRequest one = both;
  one.sources.pop_back();
  // Both cover the same area, so that the settings are the same.
  const auto plan = plan_layer(both, std::nullopt, 1 << 20);
  ASSERT_TRUE(plan) << plan.error().message;
  both.area = one.area = plan->extent();
  {
    auto again = plan_layer(both, std::nullopt, 1 << 20);
    ASSERT_TRUE(again);
    auto writer = open_or_create(store_, again->crs, again->extent());
    ASSERT_TRUE(writer);
    // The writer is let go with tiles of a block put and its mark not yet set, as a killed process leaves
    // them at a checkpoint: every second report of progress comes from inside a block.
    std::atomic<bool> cancel = false;
    int reports = 0;
    const auto stopped =
        build_layer(*writer, *again,
                    {.threads = 1,
                     .block_levels = 3,
                     .progress = [&](std::uint64_t done, std::uint64_t total) { cancel = ++reports > 3 && done > total / 3; },
                     .cancel = &cancel});
    ASSERT_FALSE(stopped);
  }
  const Attempt alone = run(one);
  ASSERT_FALSE(alone.error) << alone.error->message;
  const auto fresh = folder_ / "fresh.vts";
  build(fresh, one, {.threads = 1, .block_levels = 1});
  EXPECT_EQ(tiles_of(store_, "color"), tiles_of(fresh, "color"));
}

TEST_F(UnfinishedLayer, ALayerThatWasCompleteIsNeverInThisState) {
  write_input(one_code);
  ASSERT_FALSE(run(request()).error);
  const Attempt other = run(request("kaiser3"));
  ASSERT_TRUE(other.error);
  EXPECT_THAT(other.error->message, HasSubstr("built with other settings"));
  // Also in the middle of an update.
  write_input(another_code);
  std::atomic<bool> cancel = false;
  const Attempt update =
      run(request(), {.update = true, .progress = [&](std::uint64_t, std::uint64_t) { cancel = true; }, .cancel = &cancel});
  ASSERT_TRUE(update.error);
  EXPECT_EQ(update.error->code, ErrorCode::kCancelled);
  const Attempt after = run(request("kaiser3"));
  ASSERT_TRUE(after.error);
  EXPECT_EQ(after.error->code, ErrorCode::kExists);
  ASSERT_FALSE(run(request()).error) << "and the update goes on";
  expect_as_new(request());
}

}  // namespace
}  // namespace vt::pipeline
