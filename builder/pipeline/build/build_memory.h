// What a build keeps in memory, counted before it begins: `--memory` is honoured by choosing blocks that fit.
// Arithmetic only; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/pipeline/plan/layer_plan.h"
#include "store/result.h"

namespace vt::pipeline {

// The program itself: code, libraries and what they touch, measured with a build of one small tile. Reading
// pictures other than TIFF loads another library with many of its own.
inline constexpr std::size_t kProgramBytes = std::size_t{12} << 20;
inline constexpr std::size_t kPictureLibraryBytes = std::size_t{128} << 20;

// Bytes by what they are for. Upper bounds where the exact figure depends on the data.
struct BuildMemory {
  std::size_t program = 0;
  std::size_t sources = 0;  // descriptions of all files, decoded blocks kept for all, idle decoders
  std::size_t store = 0;    // pages of the index, shared values, lists of blocks
  std::size_t worker = 0;   // one worker: rows of all levels, tiles in the making, samples being read
  std::size_t surface = 0;  // one thread that measures the surface when all workers are done, see surface_pass.h

  [[nodiscard]] std::size_t total(int threads) const {
    return program + sources + store + std::max(static_cast<std::size_t>(threads) * worker, surface);
  }
  // How many of `threads` may measure the surface, so that no more than `memory_bytes` are used; at least
  // one.
  [[nodiscard]] int surface_threads(int threads, std::size_t memory_bytes) const;
};

// With blocks of 2^levels tiles along an edge.
[[nodiscard]] BuildMemory build_memory(const LayerPlan& plan, int levels, int threads);

// The block that takes the least memory, and of several the largest: to show what a build needs that does not
// fit.
[[nodiscard]] int cheapest_block_levels(const LayerPlan& plan, int threads);

// Decoded samples that the sources of a layer may keep, of all the memory that a build may use.
[[nodiscard]] constexpr std::size_t source_cache_bytes(std::size_t memory_bytes) {
  return std::clamp<std::size_t>(memory_bytes / 8, std::size_t{4} << 20, std::size_t{128} << 20);
}

// For each layer the largest block (2^levels tiles) that fits `threads` workers into `memory_bytes`, at most
// 4096 texels wide. kUsage when not even the smallest does for one of them: the message names it and says how
// many threads, or how much memory, would be enough for all.
[[nodiscard]] Result<std::vector<int>> choose_block_levels(std::span<const LayerPlan> plans, int threads, std::size_t memory_bytes);
[[nodiscard]] Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes);

}  // namespace vt::pipeline
