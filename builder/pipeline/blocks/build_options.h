// How a plan is carried out, which decides none of the bytes that come of it. Plain values.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace vt::pipeline {

struct BuildOptions {
  int threads = 0;  // 0: as many as the machine has
  std::size_t memory_bytes = std::size_t{512} << 20;
  int block_levels = 0;              // 0: chosen from the memory; a block spans 2^block_levels tiles along an edge
  double checkpoint_seconds = 10.0;  // what is lost when the process is killed: this much work, and the blocks in hand
  // A layer that is there already is compared with its sources, all of them are read, and what differs is
  // built again. The sources' list may have changed too, all other settings may not.
  bool update = false;
  bool with_stats = false;
  // Texels of work done and in all; from any thread. The first call says what an earlier run had done.
  std::function<void(std::uint64_t done_texels, std::uint64_t total_texels)> progress;
  std::function<void(std::uint64_t done_blocks, std::uint64_t total_blocks)> check_progress;  // while sources are compared
  std::function<void(const std::string& remark)> remark;                                      // a sentence for the user, before the work
  const std::atomic<bool>* cancel = nullptr;  // becomes true: commit what is done and return kCancelled
};

}  // namespace vt::pipeline
