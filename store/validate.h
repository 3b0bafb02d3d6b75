// Checks a whole store: superblocks, catalog, index, every tile record, parents of every tile, counts. Shared
// by vtinspect and the tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "store/result.h"

namespace vt::store {

// Numbers are stable: scripts may look for them. See schemas/tile-store.md for the list.
struct Finding {
  int number = 0;        // 1xx superblock, 2xx catalog, 3xx index, 4xx tile, 5xx layer
  bool is_error = true;  // false: worth knowing, the store is still valid
  std::string place;     // "layer colour, level 4, tile 3,7" or "offset 8192"
  std::string sentence;
};

struct ValidationReport {
  std::vector<Finding> findings;
  std::uint64_t tiles_checked = 0;
  std::uint64_t bytes_checked = 0;
  std::uint64_t tiles_in_store = 0;  // as the catalog counts them
  std::uint64_t garbage_bytes = 0;   // of the log, which nothing reaches; 0 in a sample
  bool is_sampled = false;           // only some tiles were looked at; counts and garbage were not
  [[nodiscard]] bool ok() const;
};

struct ValidateOptions {
  bool decode_tiles = true;  // also decompress every tile
  // Not 0: so many tiles, found by random ways down the index, with every page on the way, their parents, and
  // the top page of every level. For stores that are too large to read whole. A store with no more tiles than
  // that is checked whole.
  std::uint64_t sample_tiles = 0;
  std::uint64_t seed = 1;  // of the sample; the same seed looks at the same tiles
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = nullptr;
};

// kIo when the file cannot be read at all, or is cut off meanwhile (see guard_mappings()); damage of any kind
// is a finding, not an error.
[[nodiscard]] Result<ValidationReport> validate(const std::filesystem::path& path, const ValidateOptions& options = {});

}  // namespace vt::store
