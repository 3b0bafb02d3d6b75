#include "store/snapshot.h"

#include <algorithm>
#include <utility>

#include "store/catalog.h"

namespace vt::store {

Result<Snapshot> load_snapshot(File opened) {
  Snapshot snapshot{.file = std::move(opened)};
  const File& file = snapshot.file;
  const auto refused = [&](ErrorCode code, const std::string& sentence) { return fail(code, file.path().string() + ": " + sentence); };

  // The size is asked for after the superblocks are read: a writer only ever makes the file longer than they say.
  VT_ASSIGN(const std::uint64_t first_bytes, file.size());
  std::vector<std::byte> head(std::min<std::uint64_t>(kLogStart, first_bytes));
  VT_CHECK(file.read_at(0, head));
  VT_ASSIGN(const std::uint64_t file_bytes, file.size());
  const auto superblock = choose_superblock(head, file_bytes);
  if (!superblock) return refused(superblock.error().code, superblock.error().sentence);
  snapshot.superblock = *superblock;

  const Reference& at = superblock->catalog;
  std::vector<std::byte> record(kRecordHeaderBytes + at.stored_bytes);
  VT_CHECK(file.read_at(at.offset, record));
  const auto payload = check_record(record, at, 0, at.stored_bytes);
  if (!payload) return refused(ErrorCode::kCorrupt, std::string("catalog: ") + payload.error());
  auto catalog = decode_catalog(*payload, superblock->file_end, superblock->version);
  if (!catalog) return refused(catalog.error().code, catalog.error().sentence);

  snapshot.description = std::move(catalog->description);
  for (CatalogLayer& layer : catalog->layers) {
    snapshot.layers.push_back(std::move(layer.info));
    snapshot.roots.push_back(std::move(layer.roots));
  }
  return snapshot;
}

}  // namespace vt::store
