// Goes through the index of one layer's level from the first entry to the last, in Morton order. Every page
// is read with pread and checked, a page a height is in memory at a time, and nothing is mapped: the resident
// set stays small whatever the index's size. Threads: a cursor belongs to one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/result.h"

namespace vt::store {

class IndexCursor {
 public:
  // Entries of the pages of `height`: 0 for tiles and constants, more for the pages of `height` - 1. `layer`
  // counts in snapshot.layers. `snapshot` outlives the cursor.
  IndexCursor(const Snapshot& snapshot, std::size_t layer, Level level, int height = 0);

  // Goes to the next entry, the first one at the first call. False: there is none. kCorrupt: a page on the
  // way is damaged.
  [[nodiscard]] Result<bool> next();
  // The entry where the cursor is, and the Morton code of the first tile it can reach.
  [[nodiscard]] const Reference& entry() const { return entry_; }
  [[nodiscard]] std::uint64_t morton() const { return morton_; }

 private:
  struct OpenPage {
    std::vector<std::byte> record;
    std::uint64_t first_morton = 0;
    int slot = 0;           // the next one to look at
    std::size_t given = 0;  // entries given so far
  };
  [[nodiscard]] std::span<const std::byte> payload(const OpenPage& page) const;
  [[nodiscard]] Result<void> open(const Reference& reference, std::uint64_t first_morton);

  const Snapshot& snapshot_;
  std::size_t layer_;
  Level level_;
  int height_;
  int top_;
  std::vector<OpenPage> pages_;  // of the heights from the top down to height_
  std::size_t depth_ = 0;        // of them, how many are open now
  bool started_ = false;
  Reference entry_;
  std::uint64_t morton_ = 0;
};

}  // namespace vt::store
