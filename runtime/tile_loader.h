// The loader thread: first stage of paging, from disk to memory. It reads a tile and its mips, turns them
// into what the graphics card takes, and hands them over in staging buffers from a fixed pool. The GL thread
// only swaps pointers with it under a short lock; it never waits for the disk. Threads: post, take, release
// and the counters belong to one thread (the GL thread); the constructor starts the loader, the destructor
// stops it.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "runtime/residency.h"
#include "runtime/tile_source.h"

namespace vt::runtime {

// What becomes of a layer's texels on their way to GL.
struct TexelConversion {
  TexelFormat source = TexelFormat::kRgb8;
  TexelFormat target = TexelFormat::kRgb8;  // the same as source, or what its blocks are decoded_to
  bool tint_levels = false;                 // mixes 8-bit colours with one colour a level, to show the levels' squares
};

struct TileRequest {
  int slot = -1;
  Ticket ticket = 0;
  LevelLayout level;
  int levels_from_finest = 0;  // for the tint
  TexelOrigin origin;
};

// One tile in memory, mip 0 first, each mip tightly packed.
struct TileImage {
  int slot = -1;
  Ticket ticket = 0;
  int tile_exponent = 0;
  int mips = 0;
  TexelFormat format = TexelFormat::kRgb8;
  bool ok = false;
  std::vector<std::byte> bytes;
};
// Where a mip lies in TileImage::bytes.
[[nodiscard]] std::size_t mip_offset(const FormatInfo& format, int tile_exponent, int mip);
[[nodiscard]] std::size_t tile_bytes(const FormatInfo& format, int tile_exponent, int mips);

// The colour that marks a level, 0 = finest; repeats after eight.
[[nodiscard]] std::array<std::uint8_t, 3> tint_colour(int levels_from_finest);

class TileLoader {
 public:
  // `largest` is the largest tile of the layout; `most_requests` bounds post(). Nothing is allocated after
  // this.
  TileLoader(std::shared_ptr<TileSource> source, TexelConversion conversion, int largest_exponent, int most_mips, int staging_tiles,
             std::size_t most_requests);
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  // Replaces everything that was asked for. What is wanted first stands first. Tiles in work or waiting to be
  // taken are not read again; the tile in work is given up when it is not among the requests.
  void post(std::span<const TileRequest> requests);
  // A finished (or failed) tile, or nullptr. Give it back with release().
  [[nodiscard]] TileImage* take();
  void release(TileImage* image);

  [[nodiscard]] LoaderCounters counters() const;
  [[nodiscard]] std::size_t pending() const;  // queued, in work or waiting to be taken
  [[nodiscard]] std::string last_error() const;

 private:
  void run(std::stop_token stop);
  [[nodiscard]] Result<bool> load(const TileRequest& request, TileImage& image);
  void tint(const TileRequest& request, std::span<std::byte> texels) const;

  std::shared_ptr<TileSource> source_;
  TexelConversion conversion_;
  std::vector<std::byte> scratch_;  // one mip as it is in the store, where it has to be converted
  std::vector<std::unique_ptr<TileImage>> images_;

  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<TileRequest> queue_;
  std::size_t next_ = 0;  // first of queue_ not begun
  TileRequest in_work_;   // slot -1: idle
  bool give_up_ = false;  // nobody wants in_work_ any more
  std::vector<TileImage*> free_;
  std::vector<TileImage*> done_;
  LoaderCounters counters_;
  std::string last_error_;

  std::jthread thread_;  // last: starts when all the above is ready, and is joined before any of it goes
};

}  // namespace vt::runtime
