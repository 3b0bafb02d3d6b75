// The writer's view of the index: the few pages it is working on, read from the log when first touched and
// appended to it again when changed (copy-on-write). Memory is bounded; a page that must make room is written
// out early, which costs garbage and nothing else. Leaves locking and file access to its owner. Threads: one
// at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "store/format/layout.h"
#include "store/result.h"

namespace vt::store {

class PageCache {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  static constexpr std::size_t kPageBytes = std::size_t{20} << 10;  // of one page in memory, with all around it

  // Where pages come from and go to.
  class Log {
   public:
    [[nodiscard]] virtual Result<Reference> append_page(std::uint64_t key, std::span<const std::byte> payload) = 0;
    // The payload, verified and checked.
    [[nodiscard]] virtual Result<std::vector<std::byte>> read_page(const Reference& reference, std::uint64_t key, Level level,
                                                                   int height) = 0;

    // Where the reference to a level's top page is kept.
    [[nodiscard]] virtual Reference& root(LayerId layer, Level level) = 0;

   protected:
    ~Log() = default;
  };

  explicit PageCache(Log& log) : log_(log) {}

  // The entry of a tile; absent when there is none.
  [[nodiscard]] Result<Reference> find(LayerId layer, TileId tile);
  // The Morton code of the first tile of the level at `morton` or after it; nullopt when there is none.
  [[nodiscard]] Result<std::optional<std::uint64_t>> first_from(LayerId layer, Level level, std::uint64_t morton);
  // Sets it and gives the one it replaces.
  [[nodiscard]] Result<Reference> exchange(LayerId layer, TileId tile, const Reference& reference);
  // Appends every changed page, children first, and sets the roots.
  [[nodiscard]] Result<void> flush();
  // Drops a layer's pages, changed or not.
  void forget(LayerId layer);

 private:
  struct Name {
    std::uint64_t key = 0;  // layer, level and Morton code of the first tile
    int height = 0;
    bool operator==(const Name&) const = default;
  };
  struct HashName {
    std::size_t operator()(const Name& name) const {
      return static_cast<std::size_t>((name.key + static_cast<unsigned>(name.height)) * 0x9E3779B97F4A7C15);
    }
  };
  struct Page {
    Name name;
    LayerId layer;
    Level level;
    Page* parent = nullptr;  // null: the top page of its level
    int slot_in_parent = 0;
    int cached_children = 0;  // a parent stays while a child is here
    bool dirty = false;
    std::array<Reference, kPageSlots> entries = {};
    std::list<Page*>::iterator age;
  };
  enum class IfAbsent { kGiveNull, kMake };

  [[nodiscard]] Result<Page*> page(LayerId layer, TileId tile, int height, IfAbsent if_absent);
  [[nodiscard]] bool has_child(const Page& page, std::uint64_t morton) const;
  [[nodiscard]] Result<void> write(Page& page);
  [[nodiscard]] Result<void> make_room();

  Log& log_;
  std::unordered_map<Name, std::unique_ptr<Page>, HashName> pages_;
  std::list<Page*> by_age_;  // least recently used first
};

}  // namespace vt::store
