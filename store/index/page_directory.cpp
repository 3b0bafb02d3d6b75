#include "store/index/page_directory.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>

namespace vt::store {
namespace {

std::uint64_t leaf_word(std::uint64_t offset, bool is_full) { return (offset / kRecordAlignment) << 1 | (is_full ? 1 : 0); }

void fetch(const void* address) { __builtin_prefetch(address); }

}  // namespace

std::size_t PageDirectory::Node::count() const {
  return slots.ranks.back() + static_cast<std::size_t>(std::popcount(slots.presence.back()));
}

PageDirectory::Node* PageDirectory::Node::make(std::span<const std::byte> payload, std::size_t children) {
  auto* node = new (::operator new (bytes_for(children), std::align_val_t{alignof(Node)})) Node;
  for (std::size_t i = 0; i < kPageWords; ++i) {
    node->slots.presence[i] = get<std::uint64_t>(payload, kPageBitmapAt + 8 * i);
    node->slots.ranks[i] = get<std::uint16_t>(payload, kPageRanksAt + 2 * i);
  }
  for (std::size_t i = 0; i < children; ++i) new (node->children() + i) Word(0);
  return node;
}

void PageDirectory::Node::destroy(Node* node) { ::operator delete (node, std::align_val_t{alignof(Node)}); }

PageDirectory::PageDirectory(const Mapping& file, std::span<const LayerInfo> layers) : file_(file.bytes()) {
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

void PageDirectory::find_many(std::span<const Query> queries, std::span<Place> places) const {
  assert(places.size() == queries.size());
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
      if (leaves[i] == 0 || (leaves[i] & kFull) != 0) continue;
      const std::byte* payload = payload_of_leaf(leaves[i]);
      const auto word = static_cast<std::size_t>(page_slot(batch[i].morton, 0)) / 64;
      fetch(payload + kPageBitmapAt + 8 * word);
      fetch(payload + kPageRanksAt + 2 * word);
    }
    for (std::size_t i = 0; i < batch.size(); ++i) {
      Place& place = places[first + i];
      place = ways[i].word == nullptr ? Place{.is_known = ways[i].is_absent} : place_in_leaf(leaves[i], batch[i].morton);
      fetch(place.entry);
    }
  }
}

bool PageDirectory::knows(const Query& query, int height) const {
  const Way way = way_to(query, height);
  return way.word != nullptr && way.word->load(std::memory_order_acquire) != 0;
}

Reference PageDirectory::entry_of(const Reference& page, int slot) const {
  const std::byte* payload = file_.data() + page.offset + kRecordHeaderBytes;
  const std::optional<std::size_t> number = page_entry_number(std::span(payload, kPageEntriesAt), slot);
  return number ? get_reference(std::span(entry_at(payload, *number), kReferenceBytes), 0) : Reference{};
}

void PageDirectory::remember(const Query& query, int height, const Reference& page, std::span<const std::byte> payload) const {
  const Way way = way_to(query, height);
  if (way.word == nullptr) return;
  const std::size_t count = get<std::uint16_t>(payload, 0);
  const bool is_full = count == kPageSlots;
  std::uint64_t unknown = 0;
  if (height == 0) {
    way.word->compare_exchange_strong(unknown, leaf_word(page.offset, is_full), std::memory_order_release, std::memory_order_relaxed);
    return;
  }
  const std::size_t bytes = Node::bytes_for(count);
  if (bytes_.fetch_add(bytes, std::memory_order_relaxed) + bytes <= kMaxBytes) {
    Node* node = Node::make(payload, count);
    const std::uint64_t word = reinterpret_cast<std::uint64_t>(node) | (is_full ? kFull : 0);
    if (way.word->compare_exchange_strong(unknown, word, std::memory_order_release, std::memory_order_relaxed)) return;
    Node::destroy(node);  // another thread was faster
  }
  bytes_.fetch_sub(bytes, std::memory_order_relaxed);
}

}  // namespace vt::store
