// A reader's memory of the index pages it has checked: where each lies and how dense it is, so that finding a tile again touches one word
// of memory and one entry of the file instead of the headers of every page on the way. It holds inner pages as tables of their children
// and leaves as one word; it is filled as pages are met, in step with the tree in the file. Nothing gets into it unchecked; checking is its
// owner's. Threads: everything const from any number at once, without locks; a page that two check at the same time is remembered once.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "store/layer.h"
#include "store/layout.h"

namespace vt::store {

class PageDirectory {
 public:
  PageDirectory() = default;
  // `file` is the mapped file and outlives the directory; layers are counted as in `layers`.
  PageDirectory(std::span<const std::byte> file, std::span<const LayerInfo> layers);
  PageDirectory(PageDirectory&& other) noexcept { swap(other); }
  PageDirectory& operator=(PageDirectory&& other) noexcept {
    swap(other);
    return *this;
  }
  ~PageDirectory();

  // find_many() works through so many at a time: as many misses as a processor keeps in flight, and a few more.
  static constexpr std::size_t kBatch = 32;

  struct Query {
    std::size_t layer = 0;
    Level level;
    std::uint64_t morton = 0;
  };
  // False: a page on the way has not been checked yet. Otherwise `entry` is the tile's, absent when it has none.
  [[nodiscard]] bool find(const Query& query, Reference& entry) const;
  // The same for many at once: while the memory answers one, the others are asked. `found` and `entries` are as long as `queries`.
  void find_many(std::span<const Query> queries, std::span<bool> found, std::span<Reference> entries) const;

  // Whether the page of `height` on the way to the tile is known.
  [[nodiscard]] bool knows(const Query& query, int height) const;
  // Takes up a page that was checked, if those above it are known and there is room (kMaxBytes). Without room it is checked again each
  // time.
  void remember(const Query& query, int height, const Reference& page) const;

  // A dense index of 6 * 10^10 tiles; only an index of mostly empty inner pages comes near it.
  static constexpr std::size_t kMaxBytes = std::size_t{512} << 20;

 private:
  // 0: not known. A leaf: its record's place / 64, times 2, plus 1 when all its slots are present. An inner page: the address of its Node,
  // plus 1 in the same case.
  using Word = std::atomic<std::uint64_t>;
  struct Node;
  // Where the word of a page is. Null: the way to it is not known, or the tile is absent because a page above has nothing there.
  struct Way {
    Word* word = nullptr;
    bool is_absent = false;
  };

  void swap(PageDirectory& other) noexcept;
  [[nodiscard]] Word& top(const Query& query) const { return tops_[first_top_[query.layer] + query.level.value]; }
  [[nodiscard]] Way way_to(const Query& query, int height) const;
  [[nodiscard]] Reference entry_of_leaf(std::uint64_t leaf, std::uint64_t morton) const;
  [[nodiscard]] std::span<const std::byte> payload_at(std::uint64_t offset) const { return file_.subspan(offset + kRecordHeaderBytes); }
  static void release(std::uint64_t word, int height);

  std::span<const std::byte> file_;
  std::vector<std::size_t> first_top_;  // by layer, of its level 0 in tops_
  std::vector<Level> levels_;           // as tops_
  mutable std::vector<Word> tops_;
  mutable std::atomic<std::size_t> bytes_ = 0;
};

}  // namespace vt::store
