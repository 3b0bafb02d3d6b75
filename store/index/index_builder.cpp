#include "store/index/index_builder.h"

#include <cassert>

namespace vt::store {

IndexBuilder::IndexBuilder(Sink& sink, LayerId layer, Level level) : sink_(sink), layer_(layer), level_(level) {
  for (int height = 0; height <= top_height(level); ++height) open_.push_back(std::make_unique<OpenPage>());
}

Result<void> IndexBuilder::add(std::uint64_t morton, const Reference& entry) {
  assert(!last_ || morton > *last_);
  assert((morton >> (2 * level_.value)) == 0 && entry.present());
  last_ = morton;
  return put_entry(0, morton, entry);
}

Result<Reference> IndexBuilder::finish() {
  for (int height = 0; height <= top_height(level_); ++height)
    if (open_[static_cast<std::size_t>(height)]->in_use) VT_CHECK(close(height));
  return root_;
}

Result<void> IndexBuilder::put_entry(int height, std::uint64_t morton, const Reference& entry) {
  OpenPage& page = *open_[static_cast<std::size_t>(height)];
  const std::uint64_t first_morton = page_first_morton(morton, height);
  if (page.in_use && page.first_morton != first_morton) VT_CHECK(close(height));
  page.in_use = true;
  page.first_morton = first_morton;
  page.entries[static_cast<std::size_t>(page_slot(morton, height))] = entry;
  return {};
}

// Nothing that is still to come lies in this page, so it is final, and its parent may have its reference.
Result<void> IndexBuilder::close(int height) {
  OpenPage& page = *open_[static_cast<std::size_t>(height)];
  const std::uint64_t key = record_key(layer_, level_, page.first_morton);
  VT_ASSIGN(const Reference placed, sink_.place_page(key, height, encode_page(page.entries, height)));
  page.entries.fill({});
  page.in_use = false;
  if (height < top_height(level_)) return put_entry(height + 1, page.first_morton, placed);
  root_ = placed;
  return {};
}

}  // namespace vt::store
