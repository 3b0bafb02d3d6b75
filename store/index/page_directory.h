// A reader's memory of the index pages it has checked: where each lies and how dense it is, so that finding a
// tile again touches one word of memory and one entry of the file instead of the headers of every page on the
// way. It holds inner pages as tables of their children and leaves as one word; it is filled as pages are
// met, in step with the tree in the file. Nothing gets into it unchecked; checking is its owner's. Threads:
// everything const from any number at once, without locks; a page that two check at the same time is
// remembered once.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "store/format/layout.h"
#include "store/io/mapping.h"
#include "store/layer.h"

namespace vt::store {

class PageDirectory {
 public:
  PageDirectory() = default;
  // `file` outlives the directory; layers are counted as in `layers`. The file may change under it (see
  // mapping.h): what it says is then wrong, and it is up to its owner to find out, but it never reads outside
  // the mapping.
  PageDirectory(const Mapping& file, std::span<const LayerInfo> layers);
  PageDirectory(PageDirectory&& other) noexcept { swap(other); }
  PageDirectory& operator=(PageDirectory&& other) noexcept {
    swap(other);
    return *this;
  }
  ~PageDirectory();

  // find_many() works through so many at a time: as many misses as a processor keeps in flight, and a few
  // more.
  static constexpr std::size_t kBatch = 32;

  struct Query {
    std::size_t layer = 0;
    Level level;
    std::uint64_t morton = 0;
  };
  // Where a tile's entry lies in the file: its kReferenceBytes in a page that was checked. Null when the tile
  // is absent; not known when a page on the way has not been checked yet.
  struct Place {
    const std::byte* entry = nullptr;
    bool is_known = false;

    [[nodiscard]] Reference reference() const {
      return entry == nullptr ? Reference{} : get_reference(std::span(entry, kReferenceBytes), 0);
    }
  };
  [[nodiscard]] Place find(const Query& query) const {
    const Way way = way_to(query, 0);
    if (way.word == nullptr) return {.is_known = way.is_absent};
    return place_in_leaf(way.word->load(std::memory_order_acquire), query.morton);
  }
  // The same for many at once, with all entries on their way to the processor's caches: while the memory
  // answers one query, the others are asked. `places` is as long as `queries`.
  void find_many(std::span<const Query> queries, std::span<Place> places) const;

  // Whether the page of `height` on the way to the tile is known.
  [[nodiscard]] bool knows(const Query& query, int height) const;
  // What such a page has in one of its slots.
  [[nodiscard]] Reference entry_of(const Reference& page, int slot) const;
  // Takes up a page that was checked, if those above it are known and there is space (kMaxBytes). Without
  // space it is checked again each time. `payload` is the very bytes that were checked.
  void remember(const Query& query, int height, const Reference& page, std::span<const std::byte> payload) const;

  // A dense index of 6 * 10^10 tiles; only an index of mostly empty inner pages comes near it.
  static constexpr std::size_t kMaxBytes = std::size_t{512} << 20;

 private:
  // 0: not known. A leaf: its record's place / 64, times 2, plus 1 when all its slots are present. An inner
  // page: the address of its Node, plus 1 in the same case.
  using Word = std::atomic<std::uint64_t>;
  static constexpr std::uint64_t kFull = 1;

  // Presence bits and ranks, as in a page.
  struct Slots {
    std::array<std::uint64_t, kPageWords> presence = {};
    std::array<std::uint16_t, kPageWords> ranks = {};
  };
  // An inner page. The children's words follow it, one for each present slot.
  struct alignas(64) Node {
    Slots slots;

    [[nodiscard]] static Node* of(std::uint64_t word) { return reinterpret_cast<Node*>(word & ~kFull); }
    [[nodiscard]] Word* children() { return reinterpret_cast<Word*>(this + 1); }
    // Null: the slot is absent.
    [[nodiscard]] static Word* child(std::uint64_t word, int slot) {
      Node* node = of(word);
      if ((word & kFull) != 0) return node->children() + slot;
      const std::size_t index = static_cast<std::size_t>(slot) / 64;
      const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
      if ((node->slots.presence[index] & bit) == 0) return nullptr;
      return node->children() + node->slots.ranks[index] + std::popcount(node->slots.presence[index] & (bit - 1));
    }
    [[nodiscard]] std::size_t count() const;
    [[nodiscard]] static std::size_t bytes_for(std::size_t children) { return sizeof(Node) + sizeof(Word) * children; }
    [[nodiscard]] static Node* make(std::span<const std::byte> payload, std::size_t children);
    static void destroy(Node* node);
  };
  // Where the word of a page is. Null: the way to it is not known, or the tile is absent because a page above
  // has nothing there.
  struct Way {
    Word* word = nullptr;
    bool is_absent = false;
  };

  // Acquire, because a word leads to a node that another thread has filled. The pages themselves never
  // change.
  [[nodiscard]] Way way_to(const Query& query, int height) const {
    Word* at = &tops_[first_top_[query.layer] + query.level.value];
    for (int above = top_height(query.level); above > height; --above) {
      const std::uint64_t node = at->load(std::memory_order_acquire);
      if (node == 0) return {};
      at = Node::child(node, page_slot(query.morton, above));
      if (at == nullptr) return {.is_absent = true};
    }
    return {.word = at};
  }
  [[nodiscard]] const std::byte* payload_of_leaf(std::uint64_t leaf) const {
    return file_.data() + (leaf >> 1) * kRecordAlignment + kRecordHeaderBytes;
  }
  [[nodiscard]] Place place_in_leaf(std::uint64_t leaf, std::uint64_t morton) const {
    if (leaf == 0) return {};
    const std::byte* payload = payload_of_leaf(leaf);
    const int slot = page_slot(morton, 0);
    if ((leaf & kFull) != 0)
      return {.entry = payload + kPageEntriesAt + kReferenceBytes * static_cast<std::size_t>(slot), .is_known = true};
    const std::optional<std::size_t> number = page_entry_number(std::span(payload, kPageEntriesAt), slot);
    if (!number) return {.is_known = true};
    return {.entry = entry_at(payload, *number), .is_known = true};
  }
  // The page was checked, but may be another by now: its entries then end in the mapping's slack at the
  // latest.
  [[nodiscard]] static const std::byte* entry_at(const std::byte* payload, std::size_t number) {
    static_assert(kRecordHeaderBytes + kMaxPageBytes <= Mapping::kSlack);
    return payload + kPageEntriesAt + kReferenceBytes * (number % kPageSlots);
  }
  void swap(PageDirectory& other) noexcept;
  static void release(std::uint64_t word, int height);

  std::span<const std::byte> file_;
  std::vector<std::size_t> first_top_;  // by layer, of its level 0 in tops_
  std::vector<Level> levels_;           // as tops_
  mutable std::vector<Word> tops_;
  mutable std::atomic<std::size_t> bytes_ = 0;
};

}  // namespace vt::store
