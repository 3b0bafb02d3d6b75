#include "store/index/catalog_space.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace vt::store {

CatalogSpace::CatalogSpace(const Superblock& newest)
    : current_{.offset = newest.catalog.offset, .bytes = std::max(newest.catalog_space, newest.catalog.record_bytes())},
      spare_(newest.spare_catalog) {}

Result<Extent> CatalogSpace::next(std::uint64_t record_bytes, const File& file) {
  if (record_bytes <= spare_.bytes && !is_spare_known_) {
    VT_ASSIGN(is_spare_known_, is_spare_free(file));
    if (!is_spare_known_) spare_ = {};
  }
  if (record_bytes <= spare_.bytes) return spare_;
  // Half as much again, and few places are left behind on the way to a large catalog. The second catalog of a
  // store follows an empty one.
  const bool is_growing = spare_.bytes > 0;
  return Extent{.bytes = is_growing ? aligned(record_bytes + record_bytes / 2) : record_bytes};
}

void CatalogSpace::take(const Extent& place) {
  spare_ = std::exchange(current_, place);
  is_spare_known_ = std::exchange(is_current_known_, true);
}

// Whatever the superblock says, nothing but an old catalog and zeros is overwritten, and never the catalog
// that is in use.
Result<bool> CatalogSpace::is_spare_free(const File& file) const {
  const bool is_apart = spare_.offset + spare_.bytes <= current_.offset || current_.offset + current_.bytes <= spare_.offset;
  if (!is_apart || spare_.offset % kRecordAlignment != 0 || spare_.bytes % kRecordAlignment != 0 || spare_.bytes < kRecordHeaderBytes ||
      spare_.bytes > 2 * kMaxCatalogBytes)
    return false;
  std::vector<std::byte> bytes(spare_.bytes);
  VT_CHECK(file.read_at(spare_.offset, bytes));
  const Reference old{
      .stored_bytes = get<std::uint32_t>(bytes, 20), .check = get<std::uint32_t>(bytes, 0), .kind = ReferenceKind::kCatalog};
  if (old.record_bytes() > bytes.size()) return false;
  const auto record = std::span(bytes).first(kRecordHeaderBytes + old.stored_bytes);
  return check_record(record, old, 0, old.stored_bytes).has_value() && all_zero(std::span(bytes).subspan(record.size()));
}

}  // namespace vt::store
