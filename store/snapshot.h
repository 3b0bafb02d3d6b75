// One generation of a store file: its superblock and its catalog, read and checked, with the file they came from. What everything that
// reads a store begins with, and what pack.h copies from. Says nothing of pages and tiles. Threads: const use from any number.
#pragma once

#include <vector>

#include "store/file.h"
#include "store/layer.h"
#include "store/layout.h"
#include "store/result.h"

namespace vt::store {

struct Snapshot {
  File file;
  Superblock superblock;
  StoreDescription description;
  std::vector<LayerInfo> layers;              // ordered by id
  std::vector<std::vector<Reference>> roots;  // as `layers`, one a level
};

// The newest whole generation of `file`, which is open for reading. A writer may be appending to it meanwhile.
[[nodiscard]] Result<Snapshot> load_snapshot(File file);

}  // namespace vt::store
