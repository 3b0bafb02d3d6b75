// The parts of a build that no builder can do without, each alone, on one thread, with everything in memory
// or in the page cache: reading the samples, filtering, block encoding, compressing, writing the output's
// bytes; and what this builder does besides, hashing. Every part runs the very code that a build runs. What a
// build takes beyond their sum (divided by the threads) is what the pipeline costs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "store/result.h"

namespace vt::bench {

// What one job consists of, as on vtbuild's command line.
struct JobKind {
  std::string channel;
  std::string kernel;
  std::string format;
  std::string compression;
};

// Seconds for the whole input on one thread; 0 for what the job does not do.
struct PartSeconds {
  double read = 0.0;      // by the source's reader, decompression included
  double filter = 0.0;    // samples to filter space, all overviews, back to texels
  double encode = 0.0;    // texels of all levels to BC1
  double compress = 0.0;  // prediction included
  double write = 0.0;     // into the page cache
  double sync = 0.0;  // of those bytes to the disk, afterwards; threads do not share it, and a build can begin it early; not counted below
  double hash = 0.0;  // of what was read and of what is written, to find changes and damage; not counted below
  [[nodiscard]] double least_seconds(int threads) const { return (read + filter + encode + compress + write) / threads; }
};

// Reading, hashing, writing and syncing go over all bytes. The rest is measured on a window of at most 4096 x
// 4096 texels from the middle of the input and scaled by the number of texels. Each part is the median of
// `runs`.
class PartsBench {
 public:
  [[nodiscard]] static Result<PartsBench> prepare(const std::filesystem::path& input, const std::filesystem::path& scratch, int runs);
  PartsBench(PartsBench&&) noexcept;
  PartsBench& operator=(PartsBench&&) noexcept;
  ~PartsBench();

  // `output_bytes`: of the store that the job makes.
  [[nodiscard]] Result<PartSeconds> measure(const JobKind& job, std::uint64_t output_bytes);

 private:
  struct Impl;
  explicit PartsBench(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace vt::bench
