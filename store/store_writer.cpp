#include "store/store_writer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <condition_variable>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "store/format/catalog.h"
#include "store/format/file_beside.h"
#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/format/tile_text.h"
#include "store/index/catalog_space.h"
#include "store/index/known_payloads.h"
#include "store/index/page_cache.h"
#include "store/io/file.h"
#include "store/io/uuid.h"

namespace vt::store {
namespace {

// Distinct constant values remembered so that equal ones share a record; forgetting one costs 64 bytes of
// file.
constexpr std::size_t kMaxConstants = 65536;

// The disk is set to work on every so many bytes of the log, while the processors go on; without it a commit
// waits for all of them at once.
constexpr std::uint64_t kWritebackBytes = std::uint64_t{8} << 20;
// Generations are counted in 64 bits; only a forged one comes near the end of them.
constexpr std::uint64_t kMaxGeneration = std::uint64_t{1} << 62;
// What a superblock may say that refers to a catalog of a store of `version` as it is there: layer entries
// grew with version 3.
constexpr std::uint32_t version_beside(std::uint32_t version) {
  return catalog_layer_bytes(version) == catalog_layer_bytes(kFormatVersion) ? kFormatVersion : version;
}
// The newest part of the log is left alone: other threads are still writing to its pages.
constexpr std::uint64_t kWritebackLag = std::uint64_t{4} << 20;

}  // namespace

struct StoreWriter::Impl final : PageCache::Log {
  WriterOptions options;
  File file;
  Uuid uuid = {};
  std::uint64_t generation = 0;
  Extent cold_start;  // handed on from commit to commit
  CatalogSpace catalogs;
  std::vector<std::filesystem::path> removed_leftovers;
  StoreDescription description;

  // Guards everything below. Held while the index is read or changed, never while a tile is hashed, written
  // or read.
  mutable std::mutex mutex;
  std::vector<CatalogLayer> layers;  // ordered by id
  mutable PageCache pages{*this};
  std::uint64_t end = kLogStart;           // where the next record goes
  std::uint64_t written_back = kLogStart;  // up to here the system was asked to write to the disk
  bool changed = false;                    // something was put since the last commit
  std::optional<Error> broken;             // after the first failed write nothing more is promised but what was committed
  std::unordered_map<std::string, Reference> constants;
  KnownPayloads payloads;
  std::condition_variable payload_released;

  [[nodiscard]] CatalogLayer* find(LayerId id) {
    const auto at = std::lower_bound(layers.begin(), layers.end(), id,
                                     [](const CatalogLayer& layer, LayerId wanted) { return layer.info.id < wanted; });
    return at != layers.end() && at->info.id == id ? &*at : nullptr;
  }

  [[nodiscard]] tl::unexpected<Error> refuse(ErrorCode code, const std::string& sentence) const {
    return fail(code, file.path().string() + ": " + sentence);
  }
  // Remembers the first failure: the writer must be closed and the store opened again, which goes back to the
  // last commit.
  [[nodiscard]] tl::unexpected<Error> break_off(Error error) {
    if (!broken) broken = error;
    return tl::unexpected(std::move(error));
  }
  [[nodiscard]] Result<void> check_usable() const {
    if (broken) return tl::unexpected(*broken);
    return {};
  }
  // The layer, when `tile` is a place in its pyramid.
  [[nodiscard]] Result<CatalogLayer*> check_tile(LayerId id, TileId tile) {
    CatalogLayer* layer = find(id);
    if (layer == nullptr) return refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
    if (!is_addressable(tile) || tile.level > layer->info.finest)
      return refuse(ErrorCode::kUsage, tile_place(layer->info, tile) + ": outside the layer's pyramid");
    return layer;
  }
  // The same, when the tile's texels can be written and read as well.
  [[nodiscard]] Result<CatalogLayer*> check_texels(LayerId id, TileId tile) {
    VT_ASSIGN(CatalogLayer * layer, check_tile(id, tile));
    if (!layer->info.has_known_format()) return refuse(ErrorCode::kUnsupported, unknown_format_text(layer->info));
    return layer;
  }

  [[nodiscard]] Result<std::uint64_t> reserve(std::uint64_t record_bytes) {
    if (record_bytes > kMaxFileBytes - end) return refuse(ErrorCode::kIo, "the store would pass 256 TiB, the limit of its format");
    return std::exchange(end, end + record_bytes);
  }
  // The part of the log to send on its way to the disk now; empty most of the time.
  [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> next_writeback() {
    if (!options.sync || end < written_back + kWritebackBytes + kWritebackLag) return {0, 0};
    const std::uint64_t from = std::exchange(written_back, end - kWritebackLag);
    return {from, written_back - from};
  }
  [[nodiscard]] Result<void> write_record(std::uint64_t offset, std::span<const std::byte> header, std::span<const std::byte> payload) {
    return file.write_at(offset, header, payload, kRecordAlignment);
  }
  [[nodiscard]] Result<Reference> append(RecordType type, std::uint64_t key, std::span<const std::byte> payload) {
    const auto bytes = static_cast<std::uint32_t>(payload.size());
    RecordHeader header{.type = type, .codec = Codec::kRaw, .raw_bytes = bytes, .stored_bytes = bytes, .key = key};
    const auto sealed = seal_record(header, payload);
    Reference reference{.stored_bytes = bytes, .check = static_cast<std::uint32_t>(header.hash), .kind = static_cast<ReferenceKind>(type)};
    VT_ASSIGN(reference.offset, reserve(reference.record_bytes()));
    VT_CHECK(write_record(reference.offset, sealed, payload));
    return reference;
  }

  // PageCache::Log
  [[nodiscard]] Reference& root(LayerId id, Level level) override { return find(id)->roots[level.value]; }
  [[nodiscard]] Result<Reference> append_page(std::uint64_t key, std::span<const std::byte> payload) override {
    return append(RecordType::kPage, key, payload);
  }
  [[nodiscard]] Result<std::vector<std::byte>> read_page(const Reference& reference, std::uint64_t key, Level level, int height) override {
    const auto damaged = [&](const std::string& sentence) {
      return refuse(ErrorCode::kCorrupt, "index page at offset " + std::to_string(reference.offset) + ": " + sentence);
    };
    if (reference.stored_bytes > kMaxPageBytes) return damaged("too large");
    std::vector<std::byte> record(kRecordHeaderBytes + reference.stored_bytes);
    VT_CHECK(file.read_at(reference.offset, record));
    const auto payload = check_record(record, reference, key, reference.stored_bytes);
    if (!payload) return damaged(payload.error());
    if (const auto sound = check_page(*payload, level, height, end); !sound) return damaged(sound.error().sentence);
    record.erase(record.begin(), record.begin() + kRecordHeaderBytes);
    return record;
  }

  // What the index says of a tile, and what its record must be.
  struct Entry {
    Reference reference;
    std::uint64_t key = 0;
    std::optional<std::uint32_t> raw_bytes;  // of a blob what its record says
    TileShape shape;
    std::string place;  // for messages
  };
  struct Payload {
    std::span<const std::byte> bytes;  // as stored; valid until the thread's next call
    std::uint32_t raw_bytes = 0;
  };
  [[nodiscard]] Result<Entry> entry(LayerId id, TileId tile);
  [[nodiscard]] Result<Payload> stored_payload(const Entry& entry) const;

  [[nodiscard]] Result<void> decode(const Entry& entry, const Payload& payload, std::span<std::byte> out) const;

  class PayloadClaim;
  // The steps of put(), all but the first and the last without the lock.
  // Says whether other tiles may share its record.
  [[nodiscard]] Result<bool> check_payload(LayerId id, TileId tile, const PayloadView& payload);
  [[nodiscard]] Result<bool> holds_same(const KnownPayload& known, const PayloadView& payload) const;
  [[nodiscard]] Result<Reference> write_payload(RecordType type, std::uint64_t key, const PayloadView& payload);
  [[nodiscard]] Result<Reference> place_payload(LayerId id, TileId tile, const PayloadView& payload,
                                                const std::optional<KnownPayload>& known);
  [[nodiscard]] Result<void> share_first(const KnownPayload& first, const Reference& shared);

  // Points the index at a record (or at nothing) and keeps the layer's counts.
  [[nodiscard]] Result<void> set_entry(CatalogLayer& layer, TileId tile, const Reference& reference) {
    auto old = pages.exchange(layer.info.id, tile, reference);
    if (!old) return break_off(old.error());
    LayerInfo& info = layer.info;
    if (old->present()) {
      // The counts came from a file and may be too small.
      const auto take = [](std::uint64_t& count, std::uint64_t amount) { count -= std::min(count, amount); };
      take(info.tiles, 1);
      take(info.constant_tiles, old->kind == ReferenceKind::kConstant ? 1 : 0);
      take(info.stored_bytes, old->record_bytes());
      info.constant_tiles = std::min(info.constant_tiles, info.tiles);
    }
    if (reference.present()) {
      info.tiles += 1;
      info.constant_tiles += reference.kind == ReferenceKind::kConstant ? 1 : 0;
      info.stored_bytes += reference.record_bytes();
    }
    if (*old != reference) changed = true;
    return {};
  }

  // The state whose records are on the disk becomes the store's, in both superblocks: first in the place of
  // the older one, and when that is safe in the place of the other. So a commit that has returned is never in
  // one superblock alone.
  [[nodiscard]] Result<void> publish(const Reference& catalog, std::uint64_t first, std::uint32_t version = kFormatVersion) {
    Superblock superblock{.version = version,
                          .uuid = uuid,
                          .file_end = end,
                          .catalog = catalog,
                          .cold_start = cold_start,
                          .catalog_space = catalogs.current().bytes,
                          .spare_catalog = catalogs.spare()};
    for (superblock.generation = first; superblock.generation <= first + 1; ++superblock.generation) {
      VT_CHECK(file.write_at(superblock_offset(superblock.generation), encode_superblock(superblock)));
      VT_CHECK(sync());
    }
    generation = first + 1;
    return {};
  }
  [[nodiscard]] Result<void> sync() {
    if (!options.sync) return {};
    return file.sync();
  }
  // Everything up to the superblocks: after this the new generation is whole on disk, and nobody knows of it.
  [[nodiscard]] Result<Reference> append_generation() {
    VT_CHECK(pages.flush());
    VT_ASSIGN(const std::vector<std::byte> payload, encode_catalog({.description = description, .layers = layers}));
    const auto bytes = static_cast<std::uint32_t>(payload.size());
    RecordHeader header{.type = RecordType::kCatalog, .raw_bytes = bytes, .stored_bytes = bytes};
    const auto sealed = seal_record(header, payload);
    VT_ASSIGN(Extent place, catalogs.next(aligned(sealed.size() + payload.size()), file));
    if (place.offset == 0) {
      VT_ASSIGN(place.offset, reserve(place.bytes));
    }
    // A writer never commits what its reader refuses. It would be a store that came to it with fields that
    // contradict each other.
    if (const auto readable = decode_catalog(payload, end, kFormatVersion); !readable)
      return refuse(ErrorCode::kCorrupt, "not committed, since no reader would take it: " + readable.error().sentence);
    // To the end of its space, so that zeros are all that is behind it.
    std::vector<std::byte> record(place.bytes);
    std::ranges::copy(payload, std::ranges::copy(sealed, record.begin()).out);
    VT_CHECK(file.write_at(place.offset, record));
    VT_CHECK(sync());
    catalogs.take(place);
    return Reference{
        .offset = place.offset, .stored_bytes = bytes, .check = static_cast<std::uint32_t>(header.hash), .kind = ReferenceKind::kCatalog};
  }
  [[nodiscard]] Result<void> commit_locked() {
    VT_CHECK(check_usable());
    if (!changed) return {};
    const auto committed = append_generation().and_then([&](const Reference& catalog) { return publish(catalog, generation + 1); });
    if (!committed) return break_off(committed.error());
    changed = false;
    return {};
  }
};

StoreWriter::StoreWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StoreWriter::StoreWriter(StoreWriter&&) noexcept = default;
StoreWriter& StoreWriter::operator=(StoreWriter&&) noexcept = default;
StoreWriter::~StoreWriter() = default;

Result<StoreWriter> StoreWriter::create(const std::filesystem::path& path, const StoreDescription& description, WriterOptions options) {
  if (const std::string wrong = description_fault(description); !wrong.empty())
    return fail(ErrorCode::kInvalidData, path.string() + ": " + wrong);
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored)))
    return fail(ErrorCode::kExists, path.string() + ": is there already; remove it or choose another name");

  auto impl = std::make_unique<Impl>();
  impl->options = std::move(options);
  impl->uuid = random_uuid();
  impl->description = description;

  impl->removed_leftovers = remove_leftovers(path);
  VT_ASSIGN(impl->file, create_beside(path));
  impl->file.set_hook(&impl->options.before_operation);
  const auto filled = impl->append_generation().and_then([&](const Reference& catalog) { return impl->publish(catalog, 0); }).and_then([&] {
    return take_name(impl->file, path, impl->options.sync);
  });
  if (!filled) {
    impl->file.remove_own_name();
    return tl::unexpected(filled.error());
  }
  return StoreWriter(std::move(impl));
}

Result<StoreWriter> StoreWriter::open(const std::filesystem::path& path, WriterOptions options) {
  auto impl = std::make_unique<Impl>();
  impl->options = std::move(options);
  VT_ASSIGN(impl->file, open_for_change(path, File::Mode::kReadWrite));
  impl->file.set_hook(&impl->options.before_operation);
  impl->removed_leftovers = remove_leftovers(path);

  VT_ASSIGN(const Head head, read_head(impl->file));
  const auto refused = [&](const Fault& found) { return fail(found.code, path.string() + ": " + found.sentence); };
  const auto chosen = choose_superblock(head.bytes, head.file_bytes);
  if (!chosen) return refused(chosen.error());
  const Superblock& newest = chosen->newest;
  // Going on from the older generation would remove the later one for good.
  if (chosen->may_be_older)
    return fail(ErrorCode::kCorrupt,
                path.string() + ": not opened for writing, since a later generation would be lost: " + chosen->remark());
  if (newest.generation > kMaxGeneration)
    return fail(ErrorCode::kInvalidData,
                path.string() + ": generation " + std::to_string(newest.generation) + " cannot be followed by another");

  std::vector<std::byte> record(kRecordHeaderBytes + newest.catalog.stored_bytes);
  VT_CHECK(impl->file.read_at(newest.catalog.offset, record));
  const auto payload = check_record(record, newest.catalog, 0, newest.catalog.stored_bytes);
  if (!payload) return fail(ErrorCode::kCorrupt, path.string() + ": catalog: " + payload.error());
  auto catalog = decode_catalog(*payload, newest.file_end, newest.version);
  if (!catalog) return refused(catalog.error());

  impl->uuid = newest.uuid;
  impl->generation = newest.generation;
  impl->cold_start = newest.cold_start;
  impl->catalogs = CatalogSpace(newest);
  impl->end = impl->written_back = newest.file_end;
  impl->description = std::move(catalog->description);
  impl->layers = std::move(catalog->layers);

  // Recovery: what was never committed goes away.
  const bool has_tail = head.file_bytes > newest.file_end;
  if (has_tail) VT_CHECK(impl->file.truncate(newest.file_end));
  // A superblock that is damaged, or that an interrupted commit or an older program left behind, gets the
  // newest state: only then is it safe to overwrite the other one.
  if (!chosen->is_pair()) {
    if (has_tail) VT_CHECK(impl->sync());
    VT_CHECK(impl->publish(newest.catalog, newest.generation + 1, version_beside(newest.version)));
  }
  return StoreWriter(std::move(impl));
}

const StoreDescription& StoreWriter::description() const { return impl_->description; }

const std::vector<std::filesystem::path>& StoreWriter::removed_leftovers() const { return impl_->removed_leftovers; }

std::vector<LayerInfo> StoreWriter::layers() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<LayerInfo> infos;
  for (const CatalogLayer& layer : impl_->layers) infos.push_back(layer.info);
  return infos;
}

std::optional<LayerInfo> StoreWriter::find_layer(std::string_view name) const {
  const std::lock_guard lock(impl_->mutex);
  for (const CatalogLayer& layer : impl_->layers)
    if (layer.info.name == name) return layer.info;
  return std::nullopt;
}

Result<LayerId> StoreWriter::add_layer(const LayerInfo& wanted) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  LayerInfo info = wanted;
  info.state = LayerState::kBuilding;
  info.tiles = info.constant_tiles = info.stored_bytes = 0;
  if (!info.has_owner()) info.owner = {};
  info.id = {};

  // The lowest id that is free keeps ids small and the order of a build reproducible.
  auto before = impl_->layers.begin();
  for (; before != impl_->layers.end() && before->info.id == info.id; ++before) ++info.id.value;
  if (const std::string wrong = new_layer_fault(info); !wrong.empty())
    return impl_->refuse(ErrorCode::kInvalidData, "layer " + info.name + ": " + wrong);
  for (const CatalogLayer& layer : impl_->layers)
    if (layer.info.name == info.name)
      return impl_->refuse(ErrorCode::kExists, "layer " + info.name + ": is there already; remove it or choose another name");
  if (const std::string wrong = owner_fault(info, impl_->layers); !wrong.empty())
    return impl_->refuse(ErrorCode::kInvalidData, "layer " + info.name + ": " + wrong);
  impl_->layers.insert(before, {.info = info, .roots = std::vector<Reference>(std::size_t{info.finest.value} + 1)});
  impl_->changed = true;
  return info.id;
}

Result<void> StoreWriter::remove_layer(LayerId id) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  if (impl_->find(id) == nullptr) return impl_->refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
  // Owners before what they own: a layer owns its parts, which own their carry layers.
  std::vector<LayerId> going = {id};
  for (std::size_t i = 0; i < going.size(); ++i)
    for (const CatalogLayer& layer : impl_->layers)
      if (layer.info.has_owner() && layer.info.owner == going[i]) going.push_back(layer.info.id);
  std::erase_if(impl_->layers, [&](const CatalogLayer& layer) {
    const bool goes = std::ranges::find(going, layer.info.id) != going.end();
    if (goes) impl_->pages.forget(layer.info.id);
    return goes;
  });
  impl_->changed = true;
  return {};
}

Result<void> StoreWriter::set_state(LayerId id, LayerState state) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  CatalogLayer* layer = impl_->find(id);
  if (layer == nullptr) return impl_->refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
  if (layer->info.state != state) impl_->changed = true;
  layer->info.state = state;
  return {};
}

Result<void> StoreWriter::set_metadata(LayerId id, std::string metadata_json) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  CatalogLayer* layer = impl_->find(id);
  if (layer == nullptr) return impl_->refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
  LayerInfo info = layer->info;
  info.metadata_json = std::move(metadata_json);
  if (const std::string wrong = layer_fault(info); !wrong.empty())
    return impl_->refuse(ErrorCode::kInvalidData, "layer " + info.name + ": " + wrong);
  if (layer->info.metadata_json != info.metadata_json) impl_->changed = true;
  layer->info = std::move(info);
  return {};
}

Result<bool> StoreWriter::Impl::check_payload(LayerId id, TileId tile, const PayloadView& payload) {
  VT_ASSIGN(const CatalogLayer* layer, check_texels(id, tile));
  if (layer->info.holds_blobs()) {
    if (payload.raw_bytes < 1 || payload.raw_bytes > kMaxRawBytes || payload.bytes.size() > kMaxRawBytes ||
        (payload.codec == Codec::kRaw && payload.bytes.size() != payload.raw_bytes) || payload.codec == Codec::kPredictedZstd)
      return refuse(ErrorCode::kUsage, tile_place(layer->info, tile) + ": a blob has 1 byte to 256 MiB, and is raw or zstd");
    return false;
  }
  const std::size_t wanted = layer->info.tile_payload_bytes();
  const bool is_decodable =
      payload.codec != Codec::kPredictedZstd || tile_shape(layer->info.format, layer->info.tile_texels()).is_predictable();
  if (payload.raw_bytes != wanted || (payload.codec == Codec::kRaw && payload.bytes.size() != wanted) ||
      payload.bytes.size() > kMaxRawBytes || !is_decodable)
    return refuse(ErrorCode::kUsage, tile_place(layer->info, tile) + ": payload of " + std::to_string(payload.raw_bytes) + " bytes, " +
                                         std::to_string(wanted) + " wanted");
  return true;
}

// By comparing the bytes: that the hashes are equal proves nothing.
Result<bool> StoreWriter::Impl::holds_same(const KnownPayload& known, const PayloadView& payload) const {
  if (known.reference.codec != payload.codec || known.raw_bytes != payload.raw_bytes ||
      known.reference.stored_bytes != payload.bytes.size())
    return false;
  Entry entry{.reference = known.reference, .key = 0, .raw_bytes = known.raw_bytes, .shape = {}, .place = "a tile that was put before"};
  if (!is_shared(known.reference.kind)) entry.key = record_key(known.layer, known.tile.level, morton_code(known.tile.x, known.tile.y));
  VT_ASSIGN(const Payload stored, stored_payload(entry));
  return std::ranges::equal(stored.bytes, payload.bytes);
}

Result<Reference> StoreWriter::Impl::write_payload(RecordType type, std::uint64_t key, const PayloadView& payload) {
  RecordHeader header{.type = type,
                      .codec = payload.codec,
                      .raw_bytes = payload.raw_bytes,
                      .stored_bytes = static_cast<std::uint32_t>(payload.bytes.size()),
                      .key = key};
  const auto sealed = seal_record(header, payload.bytes);
  Reference reference{.stored_bytes = header.stored_bytes,
                      .check = static_cast<std::uint32_t>(header.hash),
                      .kind = static_cast<ReferenceKind>(type),
                      .codec = payload.codec};
  std::pair<std::uint64_t, std::uint64_t> writeback;  // offset, bytes
  {
    const std::lock_guard lock(mutex);
    VT_CHECK(check_usable());
    VT_ASSIGN(reference.offset, reserve(reference.record_bytes()));
    writeback = next_writeback();
  }
  const auto written = write_record(reference.offset, sealed, payload.bytes);
  if (writeback.second != 0) file.start_writeback(writeback.first, writeback.second);
  if (!written) {
    const std::lock_guard lock(mutex);
    return break_off(written.error());
  }
  return reference;
}

// The first tile of a payload gets a record of its own, since most have no equal. The second writes one to
// share, with the third and all others, and what the first had becomes garbage.
Result<Reference> StoreWriter::Impl::place_payload(LayerId id, TileId tile, const PayloadView& payload,
                                                   const std::optional<KnownPayload>& known) {
  if (known) {
    VT_ASSIGN(const bool is_same, holds_same(*known, payload));
    if (is_same && (is_shared(known->reference.kind) || (known->layer == id && known->tile == tile))) return known->reference;
    if (is_same) return write_payload(RecordType::kSharedTile, 0, payload);
  }
  return write_payload(RecordType::kTile, record_key(id, tile.level, morton_code(tile.x, tile.y)), payload);
}

// Unless the first tile is something else by now.
Result<void> StoreWriter::Impl::share_first(const KnownPayload& first, const Reference& shared) {
  CatalogLayer* layer = find(first.layer);
  if (layer == nullptr || first.tile.level > layer->info.finest) return {};
  VT_ASSIGN(const Reference present, pages.find(first.layer, first.tile));
  return present == first.reference ? set_entry(*layer, first.tile, shared) : Result<void>();
}

// A claim on a fingerprint, given back whatever happens: others are waiting for it.
class StoreWriter::Impl::PayloadClaim {
 public:
  PayloadClaim(Impl& impl, std::uint64_t fingerprint) : impl_(impl), fingerprint_(fingerprint) {}
  PayloadClaim(const PayloadClaim&) = delete;
  PayloadClaim& operator=(const PayloadClaim&) = delete;
  ~PayloadClaim() {
    if (!is_held_) return;
    const std::lock_guard lock(impl_.mutex);
    release({});
  }
  // These two are called with the lock.
  [[nodiscard]] std::optional<KnownPayload> take() {
    auto known = impl_.payloads.claim(fingerprint_);
    is_held_ = true;
    return known;
  }
  void release(const std::optional<KnownPayload>& payload) {
    is_held_ = false;
    impl_.payloads.release(fingerprint_, payload);
    impl_.payload_released.notify_all();
  }

 private:
  Impl& impl_;
  std::uint64_t fingerprint_;
  bool is_held_ = false;
};

Result<void> StoreWriter::put(LayerId id, TileId tile, const PayloadView& payload) {
  const std::uint64_t fingerprint =
      impl_->options.payload_fingerprint ? impl_->options.payload_fingerprint(payload) : payload_fingerprint(payload);
  Impl::PayloadClaim claim(*impl_, fingerprint);
  std::optional<KnownPayload> known;
  bool may_share = false;
  {
    std::unique_lock lock(impl_->mutex);
    // Another thread may be at the same payload right now. It does not wait for anybody, so this comes to an
    // end.
    impl_->payload_released.wait(lock, [&] { return !impl_->payloads.is_claimed(fingerprint); });
    VT_CHECK(impl_->check_usable());
    VT_ASSIGN(may_share, impl_->check_payload(id, tile, payload));
    known = claim.take();
  }
  VT_ASSIGN(const Reference placed, impl_->place_payload(id, tile, payload, may_share ? known : std::nullopt));

  const std::lock_guard lock(impl_->mutex);
  // A record of a blob is no other tile's to share, and what was known before stays so.
  claim.release(may_share ? KnownPayload{.reference = placed, .raw_bytes = payload.raw_bytes, .layer = id, .tile = tile} : known);
  VT_CHECK(impl_->check_usable());
  VT_CHECK(impl_->set_entry(*impl_->find(id), tile, placed));
  const bool is_second = placed.kind == ReferenceKind::kSharedTile && known && known->reference.kind == ReferenceKind::kTile;
  return is_second ? impl_->share_first(*known, placed) : Result<void>();
}

Result<void> StoreWriter::put_constant(LayerId id, TileId tile, std::span<const std::byte> block) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  VT_ASSIGN(CatalogLayer * layer, impl_->check_texels(id, tile));
  if (layer->info.holds_blobs()) return impl_->refuse(ErrorCode::kUsage, tile_place(layer->info, tile) + ": a blob is no constant");
  const std::size_t wanted = format_info(layer->info.format).block_bytes;
  if (block.size() != wanted)
    return impl_->refuse(ErrorCode::kUsage, tile_place(layer->info, tile) + ": a constant of " + std::to_string(block.size()) + " bytes, " +
                                                std::to_string(wanted) + " wanted");

  const std::string value(reinterpret_cast<const char*>(block.data()), block.size());
  auto known = impl_->constants.find(value);
  if (known == impl_->constants.end()) {
    auto reference = impl_->append(RecordType::kConstant, 0, block);
    if (!reference) return impl_->break_off(reference.error());
    if (impl_->constants.size() >= kMaxConstants) impl_->constants.clear();
    known = impl_->constants.emplace(value, *reference).first;
  }
  return impl_->set_entry(*layer, tile, known->second);
}

Result<void> StoreWriter::remove(LayerId id, TileId tile) {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_usable());
  VT_ASSIGN(CatalogLayer * layer, impl_->check_tile(id, tile));
  VT_ASSIGN(const Reference present, impl_->pages.find(id, tile));
  if (!present.present()) return {};
  return impl_->set_entry(*layer, tile, {});
}

bool StoreWriter::contains(LayerId id, TileId tile) const {
  const std::lock_guard lock(impl_->mutex);
  const auto layer = impl_->check_tile(id, tile);
  if (!layer) return false;
  const auto reference = impl_->pages.find(id, tile);
  return reference && reference->present();
}

Result<std::optional<TileId>> StoreWriter::next_tile(LayerId id, Level level, std::optional<TileId> after) const {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->check_tile(id, after.value_or(TileId{level, 0, 0})));
  VT_ASSIGN(const auto found, impl_->pages.first_from(id, level, after ? morton_code(after->x, after->y) + 1 : 0));
  return found ? std::optional(tile_from_morton(level, *found)) : std::nullopt;
}

Result<StoreWriter::Impl::Entry> StoreWriter::Impl::entry(LayerId id, TileId tile) {
  const std::lock_guard lock(mutex);
  VT_ASSIGN(const CatalogLayer* layer, check_texels(id, tile));
  Entry entry;
  VT_ASSIGN(entry.reference, pages.find(id, tile));
  entry.place = tile_place(layer->info, tile);
  entry.shape = tile_shape(layer->info.format, layer->info.tile_texels());
  const bool is_constant = entry.reference.kind == ReferenceKind::kConstant;
  if (!layer->info.holds_blobs())
    entry.raw_bytes =
        static_cast<std::uint32_t>(is_constant ? format_info(layer->info.format).block_bytes : layer->info.tile_payload_bytes());
  else if (is_shared(entry.reference.kind))
    return refuse(ErrorCode::kCorrupt, entry.place + ": " + kBlobIsShared);
  entry.key = is_shared(entry.reference.kind) ? 0 : record_key(id, tile.level, morton_code(tile.x, tile.y));
  return entry;
}

// Records never change once written, so the file is read without the lock.
Result<StoreWriter::Impl::Payload> StoreWriter::Impl::stored_payload(const Entry& entry) const {
  if (entry.reference.stored_bytes > kMaxRawBytes) return refuse(ErrorCode::kCorrupt, entry.place + ": stored size over 256 MiB");
  thread_local std::vector<std::byte> record;
  record.resize(kRecordHeaderBytes + entry.reference.stored_bytes);
  VT_CHECK(file.read_at(entry.reference.offset, record));
  const std::uint32_t raw_bytes = entry.raw_bytes ? *entry.raw_bytes : stated_raw_bytes(record);
  const auto payload = check_record(record, entry.reference, entry.key, raw_bytes);
  if (!payload) return refuse(ErrorCode::kCorrupt, entry.place + ": " + payload.error());
  return Payload{.bytes = *payload, .raw_bytes = raw_bytes};
}

Result<void> StoreWriter::Impl::decode(const Entry& entry, const Payload& payload, std::span<std::byte> out) const {
  if (auto decoded = decode_payload(entry.reference.codec, payload.bytes, entry.shape, out); !decoded)
    return refuse(decoded.error().code, entry.place + ": " + decoded.error().message);
  return {};
}

Result<bool> StoreWriter::holds(LayerId id, TileId tile, const PayloadView& wanted) const {
  VT_ASSIGN(const Impl::Entry entry, impl_->entry(id, tile));
  const bool has_texels = entry.reference.kind == ReferenceKind::kTile || entry.reference.kind == ReferenceKind::kSharedTile;
  if (!has_texels || entry.reference.codec != wanted.codec || entry.reference.stored_bytes != wanted.bytes.size()) return false;
  VT_ASSIGN(const Impl::Payload stored, impl_->stored_payload(entry));
  return std::ranges::equal(stored.bytes, wanted.bytes);
}

Result<bool> StoreWriter::holds_constant(LayerId id, TileId tile, std::span<const std::byte> block) const {
  VT_ASSIGN(const Impl::Entry entry, impl_->entry(id, tile));
  if (entry.reference.kind != ReferenceKind::kConstant) return false;
  VT_ASSIGN(const Impl::Payload stored, impl_->stored_payload(entry));
  return std::ranges::equal(stored.bytes, block);
}

Result<void> StoreWriter::read(LayerId id, TileId tile, std::span<std::byte> out) const {
  VT_ASSIGN(const Impl::Entry entry, impl_->entry(id, tile));
  if (!entry.raw_bytes) return impl_->refuse(ErrorCode::kUsage, entry.place + ": a blob, which has no texels");
  if (!entry.reference.present()) return impl_->refuse(ErrorCode::kNotFound, entry.place + ": absent");
  VT_ASSIGN(const Impl::Payload payload, impl_->stored_payload(entry));
  if (entry.reference.kind == ReferenceKind::kConstant) {
    fill_constant(payload.bytes, out);
    return {};
  }
  assert(out.size() == *entry.raw_bytes);
  return impl_->decode(entry, payload, out);
}

Result<void> StoreWriter::read_blob(LayerId id, TileId tile, std::vector<std::byte>& out) const {
  VT_ASSIGN(const Impl::Entry entry, impl_->entry(id, tile));
  if (entry.raw_bytes) return impl_->refuse(ErrorCode::kUsage, entry.place + ": no blob");
  if (!entry.reference.present()) return impl_->refuse(ErrorCode::kNotFound, entry.place + ": absent");
  VT_ASSIGN(const Impl::Payload payload, impl_->stored_payload(entry));
  out.resize(payload.raw_bytes);
  return impl_->decode(entry, payload, out);
}

Result<void> StoreWriter::commit() {
  {
    const std::lock_guard lock(impl_->mutex);
    VT_CHECK(impl_->check_usable());
    if (!impl_->changed) return {};
  }
  // The bulk goes to the disk while other threads go on putting; what is left to sync under the lock is
  // small.
  const auto synced = impl_->sync();
  const std::lock_guard lock(impl_->mutex);
  if (!synced) return impl_->break_off(synced.error());
  // A record that is being written right now lies below the new end of the file, and no index points to it
  // yet: garbage if the process dies.
  return impl_->commit_locked();
}

Result<void> StoreWriter::finish() {
  const std::lock_guard lock(impl_->mutex);
  VT_CHECK(impl_->commit_locked());
  const std::string name = impl_->file.path().string();
  impl_->broken = Error{ErrorCode::kUsage, name + ": this writer is finished; open the store again"};
  const auto is_named = impl_->file.still_named();
  VT_CHECK(impl_->file.close());
  VT_CHECK(is_named);
  if (!*is_named)
    return fail(ErrorCode::kIo,
                name +
                    ": was moved, removed or replaced by another program while it was written; what was written is in the file "
                    "that had the name before");
  return {};
}

std::uint64_t StoreWriter::generation() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->generation;
}

std::uint64_t StoreWriter::file_bytes() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->end;
}

}  // namespace vt::store
