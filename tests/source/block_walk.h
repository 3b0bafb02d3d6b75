// Reads a raster as the builder does: in blocks, row by row of blocks, each with an apron and from its top to
// its bottom in chunks of rows, by several threads at once.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "builder/source/raster_source.h"

namespace vt::source {

struct Walk {
  std::int64_t block = 512;
  std::int64_t apron = 20;
  std::int64_t chunk = 32;
  int threads = 2;
  bool releases = false;  // gives the hint as blocks are done
};

// All bands of every block with its apron must be what `whole` (interleaved, tightly packed) has there.
inline void expect_walk_matches(const RasterSource& source, const std::vector<std::byte>& whole, const Walk& walk) {
  const RasterInfo& info = source.info();
  const auto stride = static_cast<std::int64_t>(static_cast<std::size_t>(info.bands) * sample_bytes(info.sample_type));
  std::vector<int> bands;
  for (int band = 0; band < info.bands; ++band) bands.push_back(band);
  const std::int64_t across = (info.width + walk.block - 1) / walk.block;
  const std::int64_t down = (info.height + walk.block - 1) / walk.block;
  const auto top_of = [&](std::int64_t i) { return std::max<std::int64_t>(0, i / across * walk.block - walk.apron); };
  std::mutex mutex;
  std::int64_t next = 0;
  std::set<std::int64_t> in_hand;
  // The next block; what lies above all blocks in hand is released, as a build does it.
  const auto take = [&](std::optional<std::int64_t> done) -> std::optional<std::int64_t> {
    const std::lock_guard lock(mutex);
    if (done) in_hand.erase(*done);
    if (next == across * down) return std::nullopt;
    in_hand.insert(next);
    if (walk.releases) source.release_rows_before(top_of(*in_hand.begin()));
    return next++;
  };
  const auto work = [&] {
    for (auto taken = take(std::nullopt); taken; taken = take(*taken)) {
      const std::int64_t i = *taken;
      const std::int64_t left = std::max<std::int64_t>(0, i % across * walk.block - walk.apron);
      const std::int64_t top = top_of(i);
      const std::int64_t right = std::min(info.width, (i % across + 1) * walk.block + walk.apron);
      const std::int64_t bottom = std::min(info.height, (i / across + 1) * walk.block + walk.apron);
      std::vector<std::byte> out(static_cast<std::size_t>((right - left) * walk.chunk * stride));
      for (std::int64_t y = top; y < bottom; y += walk.chunk) {
        const Window w{.x = left, .y = y, .width = right - left, .height = std::min(walk.chunk, bottom - y)};
        const auto read = source.read(w, bands, out, static_cast<std::size_t>(w.width * stride));
        ASSERT_TRUE(read.has_value()) << read.error().message;
        for (std::int64_t row = 0; row < w.height; ++row) {
          ASSERT_EQ(std::memcmp(out.data() + row * w.width * stride, whole.data() + ((w.y + row) * info.width + w.x) * stride,
                                static_cast<std::size_t>(w.width * stride)),
                    0)
              << "row " << w.y + row << " from column " << w.x;
        }
      }
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 0; i < walk.threads; ++i) threads.emplace_back(work);
}

}  // namespace vt::source
