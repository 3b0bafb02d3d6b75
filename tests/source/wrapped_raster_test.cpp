#include "builder/source/wrapped_raster.h"

#include <gtest/gtest.h>

#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

// Any window, across any number of seams, against the columns taken one by one.
TEST(WrappedRaster, EveryWindowHasTheColumnsOfTheRasterAgainAndAgain) {
  const test::TempFolder folder;
  GeoTiffSpec spec{.width = 40, .height = 9, .bands = 2, .tile = 16};
  spec.transform = geo::GeoTransform{-180.0, 9.0, 0.0, 40.5, 0.0, -9.0};
  const auto samples = noise(40 * 9 * 2, 3);
  write(folder / "a.tif", spec, samples, 9);
  std::shared_ptr<const RasterSource> raster = open_raster(folder / "a.tif").value();
  std::mt19937 random(11);
  for (const std::int64_t period : {40, 37, 1}) {
    for (const std::int64_t first : {0, -1, 39, -200, 1000}) {
      const WrappedRaster wrapped(raster, period, first, 130);
      EXPECT_EQ(wrapped.info().width, 130);
      EXPECT_EQ(wrapped.info().transform.x0, -180.0 + 9.0 * static_cast<double>(first));
      for (int round = 0; round < 20; ++round) {
        Window window{
            .x = static_cast<std::int64_t>(random() % 130), .y = static_cast<std::int64_t>(random() % 9), .width = 0, .height = 0};
        window.width = 1 + static_cast<std::int64_t>(random() % static_cast<unsigned>(130 - window.x));
        window.height = 1 + static_cast<std::int64_t>(random() % static_cast<unsigned>(9 - window.y));
        const std::vector<int> bands = {1, 0};
        const std::size_t pitch = static_cast<std::size_t>(window.width) * 2 + 3;
        std::vector<std::byte> out(pitch * static_cast<std::size_t>(window.height));
        store::ContentHasher while_reading;
        ASSERT_TRUE(wrapped.read(window, bands, out, pitch, &while_reading).has_value());
        for (std::int64_t y = 0; y < window.height; ++y)
          for (std::int64_t x = 0; x < window.width; ++x)
            for (std::size_t b = 0; b < 2; ++b) {
              const std::int64_t column = ((first + window.x + x) % period + period) % period;
              const auto at = static_cast<std::size_t>(((window.y + y) * 40 + column) * 2 + bands[b]);
              ASSERT_EQ(out[static_cast<std::size_t>(y) * pitch + static_cast<std::size_t>(x) * 2 + b], samples[at]);
            }
        store::ContentHasher alone;
        ASSERT_TRUE(wrapped.hash(window, bands, alone).has_value());
        EXPECT_EQ(alone.digest(), while_reading.digest());
      }
      std::vector<std::byte> out(131);
      EXPECT_EQ(wrapped.read({0, 0, 131, 1}, std::vector<int>{0}, out, 131).error().code, ErrorCode::kUsage);
    }
  }
}

}  // namespace
}  // namespace vt::source
