// Reads that the operating system refuses, one at a time: whichever it is, opening and reading a raster ends
// in an error that names a file, or gives what an undisturbed run gives. A tag that could not be read is
// never taken for one that is not there.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <fstream>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "tests/source/raster_files.h"
#include "tests/support/raw_tiff.h"
#include "tests/support/temp_folder.h"

namespace {

std::atomic<int> reads_before_failure{-1};  // -1: none fails
std::atomic<int> reads_seen{0};

bool fails_now() {
  reads_seen.fetch_add(1);
  return reads_before_failure.load() >= 0 && reads_before_failure.fetch_sub(1) == 0;
}

}  // namespace

extern "C" ssize_t pread(int descriptor, void* out, size_t bytes, off_t offset) {
  using Pread = ssize_t (*)(int, void*, size_t, off_t);
  static const auto real = reinterpret_cast<Pread>(dlsym(RTLD_NEXT, "pread"));
  if (fails_now()) {
    errno = EIO;
    return -1;
  }
  return real(descriptor, out, bytes, offset);
}
extern "C" ssize_t pread64(int descriptor, void* out, size_t bytes, off64_t offset) { return pread(descriptor, out, bytes, offset); }

namespace vt::source {
namespace {

using test::RawTiff;

struct Reading {
  std::string facts;
  std::vector<std::byte> samples;
  bool operator==(const Reading&) const = default;
};

Result<Reading> read_whole(const std::filesystem::path& path) {
  VT_ASSIGN(const std::unique_ptr<RasterSource> source, open_raster(path));
  const RasterInfo& info = source->info();
  Reading reading;
  reading.facts = std::to_string(info.bands) + " alpha " + std::to_string(info.alpha_band) + " crs " +
                  (info.crs ? info.crs->text() : "none") + (info.has_transform ? " x0 " + std::to_string(info.transform.x0) : "");
  for (const BandMeaning& band : info.meaning)
    reading.facts += " [nodata " + (band.nodata ? std::to_string(*band.nodata) : "none") + " scale " +
                     std::to_string(band.scale.value_or(1.0)) + " unit " + band.unit + " role " +
                     std::to_string(static_cast<int>(band.role)) + "]";
  for (const UnusedFact& fact : info.unused) reading.facts += " unused " + fact.what;
  const std::size_t pitch = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.bands) * sample_bytes(info.sample_type);
  reading.samples.resize(pitch * static_cast<std::size_t>(info.height));
  VT_CHECK(source->read({0, 0, info.width, info.height}, all_bands(info.bands), reading.samples, pitch));
  return reading;
}

class ReadErrorTest : public testing::Test {
 protected:
  void expect_error_or_the_same(const std::filesystem::path& path) {
    reads_before_failure = -1;
    reads_seen = 0;
    const auto undisturbed = read_whole(path);
    ASSERT_TRUE(undisturbed.has_value()) << undisturbed.error().message;
    const int reads = reads_seen;
    int errors = 0;
    for (int n = 0; n < reads; ++n) {
      reads_before_failure = n;
      const auto disturbed = read_whole(path);
      if (disturbed) {
        EXPECT_EQ(disturbed->facts, undisturbed->facts) << "read " << n << " of " << reads;
        EXPECT_EQ(disturbed->samples, undisturbed->samples) << "read " << n << " of " << reads;
        continue;
      }
      ++errors;
      EXPECT_EQ(disturbed.error().code, ErrorCode::kIo) << disturbed.error().message;
      EXPECT_NE(disturbed.error().message.find(path.stem().string()), std::string::npos) << disturbed.error().message;
    }
    reads_before_failure = -1;
    // Reads are not made for nothing: nearly all of them decide something.
    EXPECT_GT(errors, 5);
    EXPECT_GE(errors, reads - 2);
  }

  test::TempFolder folder_;
};

RawTiff heights() {
  RawTiff tiff;
  tiff.page({.width = 16, .height = 16, .bits = 16, .sample_format = 2, .pixels = std::string(512, '\3')})
      .utm33()
      .text(42112, "<GDALMetadata><Item sample=\"0\" role=\"scale\">0.25</Item></GDALMetadata>")
      .text(42113, "-9999");
  return tiff;
}

TEST_F(ReadErrorTest, OfHeightsWithTags) {
  heights().write(folder_ / "heights.tif");
  expect_error_or_the_same(folder_ / "heights.tif");
}

TEST_F(ReadErrorTest, OfAMaskInsideAndAPageMore) {
  RawTiff tiff = heights();
  tiff.page({.width = 16, .height = 16, .bits = 1, .photometric = 4, .pixels = std::string(32, '\x5A')}).longs(254, {4});
  tiff.page({.width = 2, .height = 2, .pixels = "abcd"});
  tiff.write(folder_ / "masked.tif");
  expect_error_or_the_same(folder_ / "masked.tif");
}

TEST_F(ReadErrorTest, OfFilesBeside) {
  heights().write(folder_ / "pair.tif");
  RawTiff mask;
  mask.page({.width = 16, .height = 16, .pixels = std::string(256, '\xFF')}).write(folder_ / "pair.tif.msk");
  std::ofstream(folder_ / "pair.tif.aux.xml")
      << "<PAMDataset><PAMRasterBand band=\"1\"><NoDataValue>7</NoDataValue></PAMRasterBand></PAMDataset>";
  expect_error_or_the_same(folder_ / "pair.tif");
}

}  // namespace
}  // namespace vt::source
