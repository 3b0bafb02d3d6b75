// Checks a whole store: superblocks, catalog, index, every tile record, parents of every tile, counts. Shared by vtinspect and the tests.
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
  [[nodiscard]] bool ok() const;
};

struct ValidateOptions {
  bool decode_tiles = true;  // also decompress every tile
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = nullptr;
};

// kIo when the file cannot be read at all; damage of any kind is a finding, not an error.
[[nodiscard]] Result<ValidationReport> validate(const std::filesystem::path& path, const ValidateOptions& options = {});

}  // namespace vt::store
