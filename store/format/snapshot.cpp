#include "store/format/snapshot.h"

#include <algorithm>
#include <utility>

#include "store/format/catalog.h"

namespace vt::store {
namespace {

Result<void> load(const Head& head, Snapshot& snapshot) {
  const File& file = snapshot.file;
  const auto refused = [&](ErrorCode code, const std::string& sentence) { return fail(code, file.path().string() + ": " + sentence); };
  const auto chosen = choose_superblock(head.bytes, head.file_bytes);
  if (!chosen) return refused(chosen.error().code, chosen.error().sentence);
  snapshot.superblock = chosen->newest;
  snapshot.health = chosen->may_be_older ? StoreHealth::kMayBeOlder : chosen->damage ? StoreHealth::kOneSuperblock : StoreHealth::kWhole;
  snapshot.health_remark = chosen->remark();

  const Reference& at = snapshot.superblock.catalog;
  std::vector<std::byte> record(kRecordHeaderBytes + at.stored_bytes);
  VT_CHECK(file.read_at(at.offset, record));
  const auto payload = check_record(record, at, 0, at.stored_bytes);
  if (!payload) return refused(ErrorCode::kCorrupt, std::string("catalog: ") + payload.error());
  auto catalog = decode_catalog(*payload, snapshot.superblock.file_end, snapshot.superblock.version);
  if (!catalog) return refused(catalog.error().code, catalog.error().sentence);

  snapshot.description = std::move(catalog->description);
  for (CatalogLayer& layer : catalog->layers) {
    snapshot.layers.push_back(std::move(layer.info));
    snapshot.roots.push_back(std::move(layer.roots));
  }
  return {};
}

}  // namespace

Result<Head> read_head(const File& file) {
  Head head;
  VT_ASSIGN(const std::uint64_t first_bytes, file.size());
  head.bytes.resize(std::min<std::uint64_t>(kLogStart, first_bytes));
  VT_CHECK(file.read_at(0, head.bytes));
  VT_ASSIGN(head.file_bytes, file.size());
  return head;
}

Result<File> open_for_change(const std::filesystem::path& path, File::Mode mode) {
  VT_ASSIGN(File file, File::open(path, mode));
  VT_ASSIGN(const bool locked, file.try_lock());
  if (!locked)
    return fail(ErrorCode::kExists, path.string() + ": another program is writing to this store; wait until it is done, or stop it");
  // Packing puts another file in the place of this one; what is appended to a file without a name is lost.
  VT_ASSIGN(const bool is_current, file.still_named());
  if (!is_current) return fail(ErrorCode::kExists, path.string() + ": was replaced by another store at this moment; run again");
  return file;
}

Result<Snapshot> load_snapshot(File opened) {
  Snapshot snapshot{.file = std::move(opened)};
  VT_ASSIGN(Head head, read_head(snapshot.file));
  for (int attempt = 1;; ++attempt) {
    auto loaded = load(head, snapshot);
    if (loaded && snapshot.health == StoreHealth::kWhole) return snapshot;
    // Something is damaged, or a writer was at it just now; then there is another state by now.
    VT_ASSIGN(Head again, read_head(snapshot.file));
    if (again.bytes == head.bytes || attempt == kMostReadings) return loaded.map([&] { return std::move(snapshot); });
    head = std::move(again);
    snapshot.layers.clear();
    snapshot.roots.clear();
  }
}

}  // namespace vt::store
