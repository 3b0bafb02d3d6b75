#include "store/index/index_cursor.h"

#include <bit>
#include <cassert>

#include "store/format/tile_text.h"

namespace vt::store {
namespace {

// The first present slot at or after `slot`; kPageSlots when there is none.
int next_present(std::span<const std::byte> payload, int slot) {
  while (slot < kPageSlots) {
    const auto word = get<std::uint64_t>(payload, kPageBitmapAt + 8 * static_cast<std::size_t>(slot / 64)) >> (slot % 64);
    if (word != 0) return slot + std::countr_zero(word);
    slot = (slot / 64 + 1) * 64;
  }
  return kPageSlots;
}

}  // namespace

IndexCursor::IndexCursor(const Snapshot& snapshot, std::size_t layer, Level level, int height)
    : snapshot_(snapshot), layer_(layer), level_(level), height_(height), top_(top_height(level)) {
  assert(layer < snapshot.layers.size() && level <= snapshot.layers[layer].finest && height >= 0);
  if (height <= top_) pages_.resize(static_cast<std::size_t>(top_ - height + 1));
}

std::span<const std::byte> IndexCursor::payload(const OpenPage& page) const { return std::span(page.record).subspan(kRecordHeaderBytes); }

Result<void> IndexCursor::open(const Reference& reference, std::uint64_t first_morton) {
  OpenPage& page = pages_[depth_];
  const int height = top_ - static_cast<int>(depth_);
  const LayerInfo& layer = snapshot_.layers[layer_];
  const auto damaged = [&](const std::string& sentence) {
    return fail(ErrorCode::kCorrupt, snapshot_.file.path().string() + ": " + tile_place(layer, tile_from_morton(level_, first_morton)) +
                                         " and what follows: index page at offset " + std::to_string(reference.offset) + ": " + sentence);
  };
  if (reference.stored_bytes > kMaxPageBytes) return damaged("too large");
  page.record.resize(kRecordHeaderBytes + reference.stored_bytes);
  VT_CHECK(snapshot_.file.read_at(reference.offset, page.record));
  const auto checked = check_record(page.record, reference, record_key(layer.id, level_, first_morton), reference.stored_bytes);
  if (!checked) return damaged(checked.error());
  if (const auto sound = check_page(*checked, level_, height, snapshot_.superblock.file_end); !sound)
    return damaged(sound.error().sentence);
  page.first_morton = first_morton;
  page.slot = 0;
  page.given = 0;
  ++depth_;
  return {};
}

Result<bool> IndexCursor::next() {
  if (!started_) {
    started_ = true;
    const Reference& root = snapshot_.roots[layer_][level_.value];
    if (root.present() && !pages_.empty()) VT_CHECK(open(root, 0));
  }
  while (depth_ > 0) {
    OpenPage& page = pages_[depth_ - 1];
    const int height = top_ - static_cast<int>(depth_) + 1;
    const int slot = next_present(payload(page), page.slot);
    if (slot == kPageSlots) {
      --depth_;
      continue;
    }
    page.slot = slot + 1;
    const Reference entry = get_reference(payload(page), kPageEntriesAt + kReferenceBytes * page.given++);
    const std::uint64_t morton = page.first_morton | (static_cast<std::uint64_t>(slot) << (kPageBits * height));
    if (height == height_) {
      entry_ = entry;
      morton_ = morton;
      return true;
    }
    VT_CHECK(open(entry, morton));
  }
  return false;
}

}  // namespace vt::store
