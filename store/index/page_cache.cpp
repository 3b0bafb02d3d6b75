#include "store/index/page_cache.h"

#include <algorithm>
#include <utility>

namespace vt::store {

Result<Reference> PageCache::find(LayerId layer, TileId tile) {
  VT_ASSIGN(const Page* leaf, page(layer, tile, 0, IfAbsent::kGiveNull));
  const Reference found =
      leaf == nullptr ? Reference{} : leaf->entries[static_cast<std::size_t>(page_slot(morton_code(tile.x, tile.y), 0))];
  VT_CHECK(make_room());
  return found;
}

// Whether anything lies below the page's slot for `morton`: on the disk, or in a page that was never written.
bool PageCache::has_child(const Page& page, std::uint64_t morton) const {
  if (page.entries[static_cast<std::size_t>(page_slot(morton, page.name.height))].present()) return true;
  if (page.name.height == 0) return false;
  const int below = page.name.height - 1;
  return pages_.contains({record_key(page.layer, page.level, page_first_morton(morton, below)), below});
}

Result<std::optional<std::uint64_t>> PageCache::first_from(LayerId layer, Level level, std::uint64_t morton) {
  const std::uint64_t end = std::uint64_t{1} << (2 * level.value);
  int height = top_height(level);
  while (morton < end) {
    VT_ASSIGN(const Page* at, page(layer, tile_from_morton(level, morton), height, IfAbsent::kGiveNull));
    const bool is_page = at != nullptr;
    const bool leads_on = is_page && has_child(*at, morton);
    VT_CHECK(make_room());
    if (leads_on && height == 0) return morton;
    if (leads_on) {
      --height;
    } else {  // on to the next slot, or past all that a page would hold; from the top again, since that may be in another page
      const std::uint64_t step = std::uint64_t{1} << (kPageBits * (is_page ? height : height + 1));
      morton = (morton / step + 1) * step;
      height = top_height(level);
    }
  }
  return std::optional<std::uint64_t>();
}

Result<Reference> PageCache::exchange(LayerId layer, TileId tile, const Reference& reference) {
  VT_ASSIGN(Page * leaf, page(layer, tile, 0, IfAbsent::kMake));
  Reference& entry = leaf->entries[static_cast<std::size_t>(page_slot(morton_code(tile.x, tile.y), 0))];
  const Reference old = std::exchange(entry, reference);
  if (old != reference) leaf->dirty = true;
  VT_CHECK(make_room());
  return old;
}

Result<void> PageCache::flush() {
  // Writing a page changes its parent, so heights go upward; within one height the key decides, so that the
  // same tiles give the same log.
  for (int height = 0; height <= top_height(Level{kMaxFinest}); ++height) {
    std::vector<Page*> changed;
    for (Page* page : by_age_)
      if (page->dirty && page->name.height == height) changed.push_back(page);
    std::sort(changed.begin(), changed.end(), [](const Page* a, const Page* b) { return a->name.key < b->name.key; });
    for (Page* page : changed) VT_CHECK(write(*page));
  }
  return {};
}

void PageCache::forget(LayerId layer) {
  std::erase_if(by_age_, [&](const Page* page) { return page->layer == layer; });
  std::erase_if(pages_, [&](const auto& named) { return named.second->layer == layer; });
}

Result<PageCache::Page*> PageCache::page(LayerId layer, TileId tile, int height, IfAbsent if_absent) {
  const std::uint64_t morton = morton_code(tile.x, tile.y);
  const Name name{record_key(layer, tile.level, page_first_morton(morton, height)), height};
  if (const auto known = pages_.find(name); known != pages_.end()) {
    by_age_.splice(by_age_.end(), by_age_, known->second->age);
    return known->second.get();
  }

  Page* parent = nullptr;
  const int slot_in_parent = page_slot(morton, height + 1);
  if (height < top_height(tile.level)) {
    VT_ASSIGN(parent, page(layer, tile, height + 1, if_absent));
    if (parent == nullptr) return nullptr;
  }
  const Reference here = parent == nullptr ? log_.root(layer, tile.level) : parent->entries[static_cast<std::size_t>(slot_in_parent)];
  if (!here.present() && if_absent == IfAbsent::kGiveNull) return nullptr;

  auto made = std::make_unique<Page>();
  made->name = name;
  made->layer = layer;
  made->level = tile.level;
  made->parent = parent;
  made->slot_in_parent = slot_in_parent;
  if (here.present()) {
    VT_ASSIGN(const std::vector<std::byte> payload, log_.read_page(here, name.key, tile.level, height));
    for (int slot = 0; slot < kPageSlots; ++slot) made->entries[static_cast<std::size_t>(slot)] = page_entry(payload, slot);
  }
  if (parent != nullptr) ++parent->cached_children;
  Page* added = made.get();
  added->age = by_age_.insert(by_age_.end(), added);
  pages_.emplace(name, std::move(made));
  return added;
}

Result<void> PageCache::write(Page& page) {
  Reference written;  // a page that lost its last entry is not written: its parent forgets it
  if (std::any_of(page.entries.begin(), page.entries.end(), [](const Reference& entry) { return entry.present(); })) {
    VT_ASSIGN(written, log_.append_page(page.name.key, encode_page(page.entries, page.name.height)));
  }
  if (page.parent == nullptr) {
    log_.root(page.layer, page.level) = written;
  } else {
    page.parent->entries[static_cast<std::size_t>(page.slot_in_parent)] = written;
    page.parent->dirty = true;
  }
  page.dirty = false;
  return {};
}

Result<void> PageCache::make_room() {
  auto oldest = by_age_.begin();
  while (pages_.size() * sizeof(Page) > kMostBytes && oldest != by_age_.end()) {
    Page* victim = *oldest;
    if (victim->cached_children > 0) {
      ++oldest;
      continue;
    }
    if (victim->dirty) VT_CHECK(write(*victim));
    if (victim->parent != nullptr) --victim->parent->cached_children;
    by_age_.erase(victim->age);
    pages_.erase(Name(victim->name));
    oldest = by_age_.begin();
  }
  return {};
}

}  // namespace vt::store
