// What ordinary misfortune does: clear errors, and a store that is whole.
#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>

#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

double noisy_code(std::int64_t x, std::int64_t y, int band) { return hash_noise(x, y, band) % 256; }

Error plan_error(const LayerRequest& request) {
  auto plan = plan_layer(request, std::nullopt, 1 << 20);
  EXPECT_FALSE(plan.has_value());
  return plan ? Error{} : plan.error();
}

TEST(Failures, MissingFileIsAnInputError) {
  const Error error = plan_error(request_for({"no/such/file.tif"}, ChannelType::kColor));
  EXPECT_EQ(error.code, ErrorCode::kIo);
  EXPECT_NE(error.message.find("no/such/file.tif"), std::string::npos);
}

TEST(Failures, ATruncatedRasterNamesItselfAndLeavesTheStoreWhole) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 300, .height = 300}, noisy_code);
  const auto size = std::filesystem::file_size(folder / "input.tif");
  for (const double part : {0.0, 0.01, 0.3, 0.7, 0.999}) {
    const auto cut = folder / "cut.tif";
    std::filesystem::copy_file(folder / "input.tif", cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, static_cast<std::uintmax_t>(static_cast<double>(size) * part));
    const LayerRequest request = request_for({cut}, ChannelType::kColor);
    auto plan = plan_layer(request, std::nullopt, 1 << 20);
    Error error;
    if (!plan) {
      error = plan.error();
    } else {
      auto writer = open_or_create(folder / "cut.vts", plan->crs, plan->extent());
      ASSERT_TRUE(writer.has_value());
      const auto report = build_layer(*writer, *plan, {.threads = 2, .block_levels = 1});
      ASSERT_FALSE(report.has_value()) << "a build from " << part * 100 << " % of a file succeeded";
      error = report.error();
    }
    EXPECT_TRUE(error.code == ErrorCode::kInvalidData || error.code == ErrorCode::kCorrupt || error.code == ErrorCode::kIo ||
                error.code == ErrorCode::kUnsupported)
        << error.message;
    EXPECT_NE(error.message.find("cut.tif"), std::string::npos) << error.message;
    if (std::filesystem::exists(folder / "cut.vts")) {
      EXPECT_TRUE(store::validate(folder / "cut.vts")->ok());
      std::filesystem::remove(folder / "cut.vts");
    }
  }
}

TEST(Failures, WithoutACoordinateSystemTheMessageSaysHowToGiveOne) {
  const test::TempFolder folder;
  source::GeoTiffSpec spec;
  spec.width = spec.height = 8;
  spec.bands = 3;
  auto writer = source::GeoTiffWriter::create(folder / "nowhere.tif", spec);
  ASSERT_TRUE(writer.has_value());
  ASSERT_TRUE(writer->write_rows(std::vector<std::byte>(8 * 8 * 3), 8).has_value());
  ASSERT_TRUE(writer->finish().has_value());
  LayerRequest request = request_for({folder / "nowhere.tif"}, ChannelType::kColor);
  const Error error = plan_error(request);
  EXPECT_EQ(error.code, ErrorCode::kInvalidData);
  EXPECT_NE(error.message.find("`crs`"), std::string::npos) << error.message;
  EXPECT_NE(error.message.find("`extent`"), std::string::npos) << error.message;
  // And doing as it says helps.
  request.sources[0].fallback_crs = geo::Crs::from_epsg(4326).value();
  request.sources[0].extent = Area{10, 50, 11, 51};
  EXPECT_TRUE(plan_layer(request, std::nullopt, 1 << 20).has_value());
}

TEST(Failures, BandsAndKernelsThatMakeNoSenseAreRefused) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 8, .height = 8}, noisy_code);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  request.sources[0].bands = {1, 2, 7};
  EXPECT_EQ(plan_error(request).code, ErrorCode::kUsage);
  request = request_for({folder / "input.tif"}, ChannelType::kElevation);
  request.sources[0].bands = {1};
  request.kernel = "kaiser3";
  EXPECT_EQ(plan_error(request).code, ErrorCode::kUsage);
  request = request_for({folder / "input.tif"}, ChannelType::kMaterial);
  request.sources[0].bands = {1};
  request.format = TexelFormat::kBc4;
  EXPECT_EQ(plan_error(request).code, ErrorCode::kUnsupported);
  request = request_for({folder / "input.tif"}, ChannelType::kColor);
  request.tile_texels = 48;
  EXPECT_EQ(plan_error(request).code, ErrorCode::kUsage);
}

TEST(Failures, ALayerOutsideTheStoresAreaIsRefused) {
  const test::TempFolder folder;
  write_raster(folder / "here.tif", {.width = 40, .height = 40}, noisy_code);
  RasterSpec elsewhere{.width = 40, .height = 40};
  elsewhere.transform.x0 += 100000.0;
  write_raster(folder / "elsewhere.tif", elsewhere, noisy_code);
  build(folder / "a.vts", request_for({folder / "here.tif"}, ChannelType::kColor));
  LayerRequest request = request_for({folder / "elsewhere.tif"}, ChannelType::kColor);
  request.name = "other";
  const auto frame = existing_frame(folder / "a.vts");
  ASSERT_TRUE(frame.has_value());
  const auto plan = plan_layer(request, *frame, 1 << 20);
  ASSERT_FALSE(plan.has_value());
  EXPECT_EQ(plan.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(plan.error().message.find("outside the store's area"), std::string::npos);
}

// Every single write fails once with "no space left": the store stays at a checkpoint, validates, and the
// next run completes it.
TEST(Failures, AFullDiskLosesNothingThatWasCommitted) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 150, .height = 120}, noisy_code);
  const LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  build(folder / "whole.vts", request, {.threads = 1, .block_levels = 1});
  const Tiles wanted = tiles_of(folder / "whole.vts", "color");
  auto plan = plan_layer(request, std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value());
  bool reached_the_end = false;
  for (int fail_at = 0; !reached_the_end; ++fail_at) {
    ASSERT_LT(fail_at, 1000);
    const auto path = folder / "full.vts";
    std::filesystem::remove(path);
    {
      auto created = open_or_create(path, plan->crs, plan->extent());
      ASSERT_TRUE(created.has_value());
      ASSERT_TRUE(created->finish().has_value());
    }
    {
      std::atomic<int> writes{0};
      store::WriterOptions options;
      options.before_operation = [&](const store::FileOperation& operation) {
        return operation.kind == store::FileOperation::Kind::kWrite && writes++ >= fail_at ? ENOSPC : 0;
      };
      auto writer = store::StoreWriter::open(path, options);
      ASSERT_TRUE(writer.has_value());
      const auto report = build_layer(*writer, *plan, {.threads = 2, .block_levels = 1});
      reached_the_end = report.has_value();
      if (!report) {
        EXPECT_EQ(report.error().code, ErrorCode::kIo) << report.error().message;
      }
    }
    const auto validation = store::validate(path);
    ASSERT_TRUE(validation.has_value() && validation->ok()) << "after write " << fail_at;
    if (fail_at % 7 == 0) {
      build(path, request);
      ASSERT_EQ(tiles_of(path, "color"), wanted) << "after write " << fail_at;
    }
  }
}

TEST(Failures, AnUnfinishedLayerWithoutItsCarryIsNotBuiltIntoAnother) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 150, .height = 120}, noisy_code);
  const LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  const auto path = folder / "store.vts";
  build(path, request, {.threads = 1, .block_levels = 1});
  auto writer = store::StoreWriter::open(path);
  ASSERT_TRUE(writer.has_value());
  const auto carry = writer->find_layer("color/carry");
  ASSERT_TRUE(carry.has_value());
  ASSERT_TRUE(writer->remove_layer(carry->id).has_value());
  ASSERT_TRUE(writer->set_state(writer->find_layer("color")->id, LayerState::kBuilding).has_value());
  const auto plan = plan_layer(request, existing_frame(path).value(), 1 << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  const auto report = build_layer(*writer, *plan, {.threads = 1});
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(report.error().message.find("color/carry"), std::string::npos) << report.error().message;
}

TEST(Failures, AFolderThatCannotBeWrittenIsAnOutputError) {
  const auto frame = existing_frame("/proc/such.vts");
  ASSERT_TRUE(frame.has_value());
  const auto writer = open_or_create("/proc/such.vts", utm33(), {0, 0, 1, 1});
  ASSERT_FALSE(writer.has_value());
  EXPECT_EQ(writer.error().code, ErrorCode::kIo);
  EXPECT_NE(writer.error().message.find("/proc/"), std::string::npos) << writer.error().message;
}

}  // namespace
}  // namespace vt::pipeline
