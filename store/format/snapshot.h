// One generation of a store file: its superblock and its catalog, read and checked, with the file they came
// from. What everything that reads a store begins with, and what pack.h copies from. Says nothing of pages
// and tiles. Threads: const use from any number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "store/description.h"
#include "store/format/layout.h"
#include "store/io/file.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::store {

// The superblocks as they lie in the file, 8 KiB or fewer in a truncated file, and the file's size a moment
// later: a writer only ever makes the file longer than they say.
struct Head {
  std::vector<std::byte> bytes;
  std::uint64_t file_bytes = 0;
};
[[nodiscard]] Result<Head> read_head(const File& file);
// What looks damaged while a writer is at work is read again as long as its superblocks change, so many times
// at most.
inline constexpr int kMostReadings = 100;

struct Snapshot {
  File file;
  Superblock superblock;
  // See description.h.
  StoreHealth health = StoreHealth::kWhole;
  std::string health_remark;
  StoreDescription description;
  std::vector<LayerInfo> layers;              // ordered by id
  std::vector<std::vector<Reference>> roots;  // as `layers`, one a level
};

// Opens a store for somebody who goes on with it, and keeps other writers out until the file is closed.
// kExists: a writer has it, or another store took its name just now.
[[nodiscard]] Result<File> open_for_change(const std::filesystem::path& path, File::Mode mode);

// The newest whole generation of `file`, which is open for reading. A writer may be appending to it
// meanwhile.
[[nodiscard]] Result<Snapshot> load_snapshot(File file);

}  // namespace vt::store
