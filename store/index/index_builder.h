// Builds the index of one layer's level from entries that come in the order of their Morton codes: every page
// is finished once and never read back, so a level of any size takes a few pages of memory and leaves no
// garbage. What PageCache is for changes here and there, this is for whole levels. Leaves placing and writing
// pages to its owner. Threads: one at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "store/format/layout.h"
#include "store/result.h"

namespace vt::store {

class IndexBuilder {
 public:
  // Where finished pages go. Pages of one height come in the order of their keys; a page comes after all
  // pages below it.
  class Sink {
   public:
    // Gives the reference by which the page will be found. `payload` is valid during the call.
    [[nodiscard]] virtual Result<Reference> place_page(std::uint64_t key, int height, std::span<const std::byte> payload) = 0;

   protected:
    ~Sink() = default;
  };

  // `sink` outlives the builder.
  IndexBuilder(Sink& sink, LayerId layer, Level level);

  // `morton` is greater than the one before and inside the level; `entry` is a tile or a constant.
  [[nodiscard]] Result<void> add(std::uint64_t morton, const Reference& entry);
  // Places what is open and gives the root; absent when nothing was added. Nothing can be added afterwards.
  [[nodiscard]] Result<Reference> finish();

 private:
  struct OpenPage {
    std::array<Reference, kPageSlots> entries = {};
    std::uint64_t first_morton = 0;
    bool in_use = false;
  };

  [[nodiscard]] Result<void> close(int height);
  [[nodiscard]] Result<void> put_entry(int height, std::uint64_t morton, const Reference& entry);

  Sink& sink_;
  LayerId layer_;
  Level level_;
  std::vector<std::unique_ptr<OpenPage>> open_;  // one a height, the leaf first
  std::optional<std::uint64_t> last_;
  Reference root_;
};

}  // namespace vt::store
