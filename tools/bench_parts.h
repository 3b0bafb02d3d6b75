// The parts of a colour build that no builder can do without, each alone, on one thread, with everything in memory or in the page cache:
// reading the input's bytes, filtering, block encoding, compressing, writing the output's bytes. What a build takes beyond their sum
// (divided by the threads) is what the pipeline costs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "store/result.h"

namespace vt::bench {

// What one job consists of, as on vtbuild's command line.
struct JobKind {
  std::string kernel;
  std::string format;
  std::string compression;
};

// Seconds for the whole input on one thread; 0 for what the job does not do.
struct PartSeconds {
  double read = 0.0;
  double filter = 0.0;  // codes to linear light, all overviews, back to codes
  double encode = 0.0;  // texels of all levels to BC1
  double compress = 0.0;
  double write = 0.0;  // and sync, as a build does
  [[nodiscard]] double sum() const { return read + filter + encode + compress + write; }
};

// Reading and writing move all bytes. The rest is measured on a window of at most 4096 x 4096 texels from the middle of the input, whose
// samples are loaded beforehand, and scaled by the number of texels. Each part is the median of `runs`.
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
