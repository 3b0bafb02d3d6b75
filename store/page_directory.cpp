#include "store/page_directory.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>

namespace vt::store {
namespace {

constexpr std::uint64_t kFull = 1;

[[nodiscard]] std::uint64_t leaf_word(std::uint64_t offset, bool is_full) {
  return (offset / kRecordAlignment) << 1 | (is_full ? kFull : 0);
}
[[nodiscard]] std::uint64_t leaf_offset(std::uint64_t word) { return (word >> 1) * kRecordAlignment; }

void fetch(const void* address) { __builtin_prefetch(address); }

}  // namespace

// An inner page. The children's words follow it, one for each present slot.
struct alignas(64) PageDirectory::Node {
  std::array<std::uint64_t, kPageWords> presence = {};
  std::array<std::uint16_t, kPageWords> ranks = {};

  [[nodiscard]] static std::size_t bytes_for(std::size_t children) { return sizeof(Node) + sizeof(Word) * children; }
  [[nodiscard]] static Node* of(std::uint64_t word) { return reinterpret_cast<Node*>(word & ~kFull); }
  [[nodiscard]] Word* children() { return reinterpret_cast<Word*>(this + 1); }
  [[nodiscard]] std::size_t count() const { return ranks.back() + static_cast<std::size_t>(std::popcount(presence.back())); }

  // Null: the slot is absent.
  [[nodiscard]] static Word* child(std::uint64_t word, int slot) {
    Node* node = of(word);
    if ((word & kFull) != 0) return node->children() + slot;
    const std::size_t index = static_cast<std::size_t>(slot) / 64;
    const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
    if ((node->presence[index] & bit) == 0) return nullptr;
    return node->children() + node->ranks[index] + std::popcount(node->presence[index] & (bit - 1));
  }

  [[nodiscard]] static Node* make(std::span<const std::byte> payload, std::size_t children) {
    auto* node = new (::operator new (bytes_for(children), std::align_val_t{alignof(Node)})) Node;
    for (std::size_t i = 0; i < kPageWords; ++i) {
      node->presence[i] = get<std::uint64_t>(payload, kPageBitmapAt + 8 * i);
      node->ranks[i] = get<std::uint16_t>(payload, kPageRanksAt + 2 * i);
    }
    for (std::size_t i = 0; i < children; ++i) new (node->children() + i) Word(0);
    return node;
  }
  static void destroy(Node* node) { ::operator delete (node, std::align_val_t{alignof(Node)}); }
};

PageDirectory::PageDirectory(std::span<const std::byte> file, std::span<const LayerInfo> layers) : file_(file) {
  for (const LayerInfo& layer : layers) {
    first_top_.push_back(levels_.size());
    for (int level = 0; level <= layer.finest.value; ++level) levels_.push_back(Level{static_cast<std::uint8_t>(level)});
  }
  tops_ = std::vector<Word>(levels_.size());
}

PageDirectory::~PageDirectory() {
  for (std::size_t i = 0; i < tops_.size(); ++i) release(tops_[i], top_height(levels_[i]));
}

void PageDirectory::release(std::uint64_t word, int height) {
  if (height == 0 || word == 0) return;
  Node* node = Node::of(word);
  for (std::size_t i = 0; i < node->count(); ++i) release(node->children()[i], height - 1);
  Node::destroy(node);
}

void PageDirectory::swap(PageDirectory& other) noexcept {
  std::swap(file_, other.file_);
  first_top_.swap(other.first_top_);
  levels_.swap(other.levels_);
  tops_.swap(other.tops_);
  bytes_ = other.bytes_.exchange(bytes_);
}

// Acquire, because a word leads to a node that another thread has filled. The pages themselves never change.
PageDirectory::Way PageDirectory::way_to(const Query& query, int height) const {
  Word* at = &top(query);
  for (int above = top_height(query.level); above > height; --above) {
    const std::uint64_t node = at->load(std::memory_order_acquire);
    if (node == 0) return {};
    at = Node::child(node, page_slot(query.morton, above));
    if (at == nullptr) return {.is_absent = true};
  }
  return {.word = at};
}

bool PageDirectory::find(const Query& query, Reference& entry) const {
  const Way way = way_to(query, 0);
  if (way.word == nullptr) {
    entry = {};
    return way.is_absent;
  }
  const std::uint64_t leaf = way.word->load(std::memory_order_acquire);
  if (leaf == 0) return false;
  entry = entry_of_leaf(leaf, query.morton);
  return true;
}

Reference PageDirectory::entry_of_leaf(std::uint64_t leaf, std::uint64_t morton) const {
  const auto payload = payload_at(leaf_offset(leaf));
  const int slot = page_slot(morton, 0);
  if ((leaf & kFull) == 0) return page_entry(payload, slot);
  return get_reference(payload, kPageEntriesAt + kReferenceBytes * static_cast<std::size_t>(slot));
}

void PageDirectory::find_many(std::span<const Query> queries, std::span<bool> found, std::span<Reference> entries) const {
  assert(found.size() == queries.size() && entries.size() == queries.size());
  std::array<Way, kBatch> ways;
  std::array<std::uint64_t, kBatch> leaves;
  for (std::size_t first = 0; first < queries.size(); first += kBatch) {
    const auto batch = queries.subspan(first, std::min(kBatch, queries.size() - first));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      ways[i] = way_to(batch[i], 0);
      fetch(ways[i].word);
    }
    for (std::size_t i = 0; i < batch.size(); ++i) {
      leaves[i] = ways[i].word == nullptr ? 0 : ways[i].word->load(std::memory_order_acquire);
      if (leaves[i] == 0) continue;
      const std::byte* payload = payload_at(leaf_offset(leaves[i])).data();
      const auto slot = static_cast<std::size_t>(page_slot(batch[i].morton, 0));
      if ((leaves[i] & kFull) != 0) {
        fetch(payload + kPageEntriesAt + kReferenceBytes * slot);
      } else {
        fetch(payload + kPageBitmapAt + 8 * (slot / 64));
        fetch(payload + kPageRanksAt + 2 * (slot / 64));
      }
    }
    for (std::size_t i = 0; i < batch.size(); ++i) {
      found[first + i] = leaves[i] != 0 || ways[i].is_absent;
      entries[first + i] = leaves[i] != 0 ? entry_of_leaf(leaves[i], batch[i].morton) : Reference{};
    }
  }
}

bool PageDirectory::knows(const Query& query, int height) const {
  const Way way = way_to(query, height);
  return way.word != nullptr && way.word->load(std::memory_order_acquire) != 0;
}

void PageDirectory::remember(const Query& query, int height, const Reference& page) const {
  const Way way = way_to(query, height);
  if (way.word == nullptr) return;
  const std::size_t count = get<std::uint16_t>(payload_at(page.offset), 0);
  const bool is_full = count == kPageSlots;
  std::uint64_t unknown = 0;
  if (height == 0) {
    way.word->compare_exchange_strong(unknown, leaf_word(page.offset, is_full), std::memory_order_release, std::memory_order_relaxed);
    return;
  }
  const std::size_t bytes = Node::bytes_for(count);
  if (bytes_.fetch_add(bytes, std::memory_order_relaxed) + bytes <= kMaxBytes) {
    Node* node = Node::make(payload_at(page.offset), count);
    const std::uint64_t word = reinterpret_cast<std::uint64_t>(node) | (is_full ? kFull : 0);
    if (way.word->compare_exchange_strong(unknown, word, std::memory_order_release, std::memory_order_relaxed)) return;
    Node::destroy(node);  // another thread was faster
  }
  bytes_.fetch_sub(bytes, std::memory_order_relaxed);
}

}  // namespace vt::store
