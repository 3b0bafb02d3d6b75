#include "store/store_reader.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <utility>

#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/format/tile_text.h"
#include "store/index/index_cursor.h"
#include "store/index/page_directory.h"
#include "store/io/file.h"
#include "store/io/hex.h"
#include "store/io/mapping.h"

namespace vt::store {
namespace {

constexpr std::uint16_t kNoLayer = 0xFFFF;

TileLookup lookup_of(const Reference& found) {
  TileLookup lookup{.codec = found.codec, .offset = found.offset, .stored_bytes = found.stored_bytes};
  if (found.present()) lookup.kind = found.kind == ReferenceKind::kConstant ? TileKind::kConstant : TileKind::kStored;
  return lookup;
}

}  // namespace

// By what a reader knows its file again: magic and UUID in the superblock that it has chosen. No writer ever
// changes them; a file that is cut off or overwritten loses them.
struct HeadMark {
  std::uint64_t at = 0;  // of the superblock in the file
  std::array<std::uint64_t, 3> words = {};

  [[nodiscard]] static HeadMark of(const Superblock& superblock) {
    return {.at = superblock_offset(superblock.generation), .words = words_in(encode_superblock(superblock))};
  }
  [[nodiscard]] static std::array<std::uint64_t, 3> words_in(std::span<const std::byte> superblock) {
    return {get<std::uint64_t>(superblock, 0), get<std::uint64_t>(superblock, 16), get<std::uint64_t>(superblock, 24)};
  }
};

struct StoreReader::Impl {
  Snapshot snapshot;
  Mapping mapping;
  HeadMark head;
  std::array<std::uint16_t, kMaxLayers> index_of_id;
  PageDirectory directory;

  [[nodiscard]] const LayerInfo* find(LayerId id) const {
    if (id.value >= kMaxLayers || index_of_id[id.value] == kNoLayer) return nullptr;
    return &snapshot.layers[index_of_id[id.value]];
  }

  [[nodiscard]] tl::unexpected<Error> refuse(ErrorCode code, const std::string& sentence) const {
    return fail(code, snapshot.file.path().string() + ": " + sentence);
  }
  // The layer when its tiles can be read, else null; unreadable() says why.
  [[nodiscard]] const LayerInfo* find_readable(LayerId id) const {
    const LayerInfo* layer = find(id);
    return layer != nullptr && layer->has_known_format() ? layer : nullptr;
  }
  [[nodiscard]] tl::unexpected<Error> unreadable(LayerId id) const {
    if (const LayerInfo* layer = find(id); layer != nullptr) return refuse(ErrorCode::kUnsupported, unknown_format_text(*layer));
    return refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
  }

  // Whether what was read from the mapping until now was the store: a mapping that was lost is all zeros, one
  // that was overwritten is another file's. Asked after the reading, since it is the reading that finds it
  // lost.
  [[nodiscard]] bool is_mapping_intact() const {
    std::atomic_signal_fence(std::memory_order_seq_cst);  // a fault changes what comes after it
    return HeadMark::words_in(mapping.bytes().subspan(head.at)) == head.words;
  }
  // The same of the file itself.
  [[nodiscard]] Result<void> check_file() const {
    std::array<std::byte, 32> begin = {};
    VT_ASSIGN(const std::uint64_t bytes, snapshot.file.size());
    if (bytes >= snapshot.superblock.file_end && snapshot.file.read_at(head.at, begin) && HeadMark::words_in(begin) == head.words)
      return {};
    return refuse(ErrorCode::kIo, "was cut off or overwritten by another program while it was open; open it again when it is whole");
  }
  // Damage that was met may be another program's doing.
  [[nodiscard]] tl::unexpected<Error> explain(Error error) const {
    if (const auto is_ours = check_file(); !is_ours) return tl::unexpected(is_ours.error());
    return tl::unexpected(std::move(error));
  }
  // Copies bytes of the file. Of a mapping that was lost because the disk failed to give some of it, the rest
  // is read from the disk.
  [[nodiscard]] Result<void> fetch(std::uint64_t offset, std::span<std::byte> out) const {
    std::ranges::copy(mapping.bytes().subspan(offset, out.size()), out.begin());
    if (is_mapping_intact()) return {};
    VT_CHECK(check_file());
    return snapshot.file.read_at(offset, out);
  }

  [[nodiscard]] PageDirectory::Query query_for(const LayerInfo& layer, TileId tile) const {
    return {.layer = index_of_id[layer.id.value], .level = tile.level, .morton = morton_code(tile.x, tile.y)};
  }
  [[nodiscard]] static bool may_have(const LayerInfo& layer, TileId tile) { return is_addressable(tile) && tile.level <= layer.finest; }

  // The reference to a tile.
  [[nodiscard]] Result<Reference> find_tile(const LayerInfo& layer, TileId tile) const {
    if (!may_have(layer, tile)) return Reference{};
    const auto query = query_for(layer, tile);
    if (const PageDirectory::Place place = directory.find(query); place.is_known) {
      const Reference found = place.reference();
      if (is_mapping_intact()) return found;
    }
    return find_through_pages(layer, tile, query);
  }
  // The same through the pages of the tile's level from the top, each of which is checked when it is met for
  // the first time.
  [[nodiscard]] Result<Reference> find_through_pages(const LayerInfo& layer, TileId tile, const PageDirectory::Query& query) const {
    std::array<std::byte, kRecordHeaderBytes + kMaxPageBytes> record;
    Reference at = snapshot.roots[query.layer][tile.level.value];
    for (int height = top_height(tile.level); height >= 0; --height) {
      if (!at.present()) return at;
      const auto damaged = [&](const std::string& sentence) {
        return explain({ErrorCode::kCorrupt, snapshot.file.path().string() + ": " + tile_place(layer, tile) + ": index page at offset " +
                                                 std::to_string(at.offset) + ": " + sentence});
      };
      if (const char* wrong = reference_fault(at, ReferenceKind::kPage, snapshot.superblock.file_end); wrong != nullptr)
        return damaged(wrong);
      if (at.stored_bytes > kMaxPageBytes) return damaged("too large");
      const int slot = page_slot(query.morton, height);
      if (directory.knows(query, height)) {
        const Reference next = directory.entry_of(at, slot);
        if (is_mapping_intact()) {
          at = next;
          continue;
        }
      }
      const auto whole = std::span(record).first(kRecordHeaderBytes + at.stored_bytes);
      VT_CHECK(fetch(at.offset, whole));
      const auto payload =
          check_record(whole, at, record_key(layer.id, tile.level, page_first_morton(query.morton, height)), at.stored_bytes);
      if (!payload) return damaged(payload.error());
      if (const auto sound = check_page(*payload, tile.level, height, snapshot.superblock.file_end); !sound)
        return damaged(sound.error().sentence);
      directory.remember(query, height, at, *payload);
      at = page_entry(*payload, slot);
    }
    return at;
  }

  [[nodiscard]] Result<Reference> find_present(const LayerInfo& layer, TileId tile) const {
    VT_ASSIGN(const Reference found, find_tile(layer, tile));
    if (!found.present()) return refuse(ErrorCode::kNotFound, tile_place(layer, tile) + ": absent");
    return found;
  }

  // Unpacks a tile where it lies, without a copy. It is used first and checked afterwards, so that a change
  // between the two is seen: the decoders keep to their buffers whatever the bytes are. (zstd says so of
  // bytes that are damaged; of bytes that another program overwrites at that very moment it says nothing.)
  [[nodiscard]] Result<void> read_mapped(const LayerInfo& layer, TileId tile, const Reference& reference, std::span<std::byte> out) const {
    return unpack(layer, tile, reference, mapping.bytes().subspan(reference.offset, kRecordHeaderBytes + reference.stored_bytes), out);
  }
  // A copy of a record: where the file is not mapped any more, and of a blob, whose length is to be checked
  // before it is used.
  [[nodiscard]] Result<std::vector<std::byte>> fetch_record(const Reference& reference) const {
    std::vector<std::byte> record(kRecordHeaderBytes + reference.stored_bytes);
    VT_CHECK(fetch(reference.offset, record));
    return record;
  }
  [[nodiscard]] Result<void> unpack(const LayerInfo& layer, TileId tile, const Reference& reference, std::span<const std::byte> record,
                                    std::span<std::byte> out) const {
    const auto payload = record.subspan(kRecordHeaderBytes);
    Result<void> decoded;
    if (reference.kind != ReferenceKind::kConstant) {
      decoded = decode_payload(reference.codec, payload, tile_shape(layer.format, layer.tile_texels()), out);
    } else if (payload.size() == format_info(layer.format).block_bytes) {
      fill_constant(payload, out);
    }
    VT_CHECK(check(layer, tile, reference, record));
    if (!decoded) return refuse(decoded.error().code, tile_place(layer, tile) + ": " + decoded.error().message);
    return {};
  }
  [[nodiscard]] Result<void> check(const LayerInfo& layer, TileId tile, const Reference& reference,
                                   std::span<const std::byte> record) const {
    const std::uint64_t key = is_shared(reference.kind) ? 0 : record_key(layer.id, tile.level, morton_code(tile.x, tile.y));
    const auto payload = check_record(record, reference, key, wanted_raw_bytes(layer, reference.kind, record));
    return payload ? Result<void>() : damaged_tile(layer, tile, payload.error());
  }

  // A page that was checked may be another by now.
  [[nodiscard]] Result<void> check_place(const LayerInfo& layer, TileId tile, const Reference& reference) const {
    if (const char* wrong = reference_fault(reference, reference.kind, snapshot.superblock.file_end); wrong != nullptr)
      return damaged_tile(layer, tile, wrong);
    return {};
  }
  [[nodiscard]] tl::unexpected<Error> damaged_tile(const LayerInfo& layer, TileId tile, const char* sentence) const {
    return explain({ErrorCode::kCorrupt, snapshot.file.path().string() + ": " + tile_place(layer, tile) + ": " + sentence});
  }
};

StoreReader::StoreReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StoreReader::StoreReader(StoreReader&&) noexcept = default;
StoreReader& StoreReader::operator=(StoreReader&&) noexcept = default;
StoreReader::~StoreReader() = default;

Result<StoreReader> StoreReader::open(const std::filesystem::path& path) {
  auto impl = std::make_unique<Impl>();
  VT_ASSIGN(File file, File::open(path, File::Mode::kRead));
  VT_ASSIGN(impl->snapshot, load_snapshot(std::move(file)));
  const Superblock& superblock = impl->snapshot.superblock;
  VT_ASSIGN(impl->mapping, Mapping::map(impl->snapshot.file, superblock.file_end));
  impl->mapping.read_ahead(superblock.cold_start.offset, superblock.cold_start.bytes);
  impl->head = HeadMark::of(superblock);

  impl->index_of_id.fill(kNoLayer);
  for (std::size_t i = 0; i < impl->snapshot.layers.size(); ++i)
    impl->index_of_id[impl->snapshot.layers[i].id.value] = static_cast<std::uint16_t>(i);
  impl->directory = PageDirectory(impl->mapping, impl->snapshot.layers);
  return StoreReader(std::move(impl));
}

Result<void> StoreReader::check_intact() const { return impl_->check_file(); }

const std::filesystem::path& StoreReader::path() const { return impl_->snapshot.file.path(); }
const Snapshot& StoreReader::snapshot() const { return impl_->snapshot; }
const StoreDescription& StoreReader::description() const { return impl_->snapshot.description; }
std::uint64_t StoreReader::generation() const { return impl_->snapshot.superblock.generation; }
std::uint64_t StoreReader::file_bytes() const { return impl_->snapshot.superblock.file_end; }
StoreHealth StoreReader::health() const { return impl_->snapshot.health; }
const std::string& StoreReader::health_remark() const { return impl_->snapshot.health_remark; }
std::span<const LayerInfo> StoreReader::layers() const { return impl_->snapshot.layers; }
const LayerInfo* StoreReader::find_layer(LayerId layer) const { return impl_->find(layer); }

Result<void> StoreReader::check_readable(LayerId id) const {
  if (impl_->find_readable(id) == nullptr) return impl_->unreadable(id);
  return {};
}

const LayerInfo* StoreReader::find_layer(std::string_view name) const {
  for (const LayerInfo& layer : impl_->snapshot.layers)
    if (layer.name == name) return &layer;
  return nullptr;
}

std::string StoreReader::uuid() const {
  std::string text;
  for (std::size_t i = 0; i < impl_->snapshot.superblock.uuid.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += hex(std::to_integer<unsigned>(impl_->snapshot.superblock.uuid[i]), 2);
  }
  return text;
}

Result<TileLookup> StoreReader::lookup(LayerId id, TileId tile) const {
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) [[unlikely]]
    return impl_->unreadable(id);
  if (!Impl::may_have(*layer, tile)) return TileLookup{};
  const auto query = impl_->query_for(*layer, tile);
  if (const PageDirectory::Place place = impl_->directory.find(query); place.is_known) [[likely]] {
    const TileLookup found = lookup_of(place.reference());
    if (impl_->is_mapping_intact()) [[likely]]
      return found;
  }
  VT_ASSIGN(const Reference found, impl_->find_through_pages(*layer, tile, query));
  return lookup_of(found);
}

Result<void> StoreReader::lookup_many(LayerId id, std::span<const TileId> tiles, std::span<TileLookup> out) const {
  assert(out.size() == tiles.size());
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) return impl_->unreadable(id);
  std::array<PageDirectory::Query, PageDirectory::kBatch> queries;
  std::array<PageDirectory::Place, PageDirectory::kBatch> places;
  for (std::size_t first = 0; first < tiles.size(); first += queries.size()) {
    const auto batch = tiles.subspan(first, std::min(queries.size(), tiles.size() - first));
    // A tile outside the pyramid asks for the root instead, and its answer is not looked at.
    for (std::size_t i = 0; i < batch.size(); ++i)
      queries[i] = impl_->query_for(*layer, Impl::may_have(*layer, batch[i]) ? batch[i] : TileId{});
    impl_->directory.find_many(std::span(queries).first(batch.size()), std::span(places).first(batch.size()));
    for (std::size_t i = 0; i < batch.size(); ++i)
      out[first + i] = Impl::may_have(*layer, batch[i]) && places[i].is_known ? lookup_of(places[i].reference()) : TileLookup{};
    const bool is_mapping_intact = impl_->is_mapping_intact();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (!Impl::may_have(*layer, batch[i]) || (places[i].is_known && is_mapping_intact)) continue;
      VT_ASSIGN(const Reference found, impl_->find_through_pages(*layer, batch[i], queries[i]));
      out[first + i] = lookup_of(found);
    }
  }
  return {};
}

Result<void> StoreReader::read(LayerId id, TileId tile, std::span<std::byte> out) const {
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) return impl_->unreadable(id);
  if (layer->holds_blobs()) return impl_->refuse(ErrorCode::kUsage, "layer " + layer->name + " holds blobs, which have no texels");
  assert(out.size() == layer->tile_payload_bytes());
  VT_ASSIGN(const Reference reference, impl_->find_present(*layer, tile));
  VT_CHECK(impl_->check_place(*layer, tile, reference));
  auto read = impl_->read_mapped(*layer, tile, reference, out);
  if (impl_->is_mapping_intact()) [[likely]]
    return read;
  VT_ASSIGN(const std::vector<std::byte> record, impl_->fetch_record(reference));
  return impl_->unpack(*layer, tile, reference, record, out);
}

Result<void> StoreReader::read_blob(LayerId id, TileId tile, std::vector<std::byte>& out) const {
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) return impl_->unreadable(id);
  if (!layer->holds_blobs()) return impl_->refuse(ErrorCode::kUsage, "layer " + layer->name + " holds no blobs");
  VT_ASSIGN(const Reference reference, impl_->find_present(*layer, tile));
  if (reference.kind != ReferenceKind::kTile) return impl_->damaged_tile(*layer, tile, kBlobIsShared);
  VT_CHECK(impl_->check_place(*layer, tile, reference));
  VT_ASSIGN(const std::vector<std::byte> record, impl_->fetch_record(reference));
  VT_CHECK(impl_->check(*layer, tile, reference, record));
  out.resize(stated_raw_bytes(record));
  return impl_->unpack(*layer, tile, reference, record, out);
}

Result<void> StoreReader::for_each_tile(LayerId id, Level level, const std::function<Result<void>(TileId)>& visit) const {
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) return impl_->unreadable(id);
  if (level > layer->finest) return {};
  IndexCursor cursor(snapshot(), static_cast<std::size_t>(layer - layers().data()), level);
  while (true) {
    VT_ASSIGN(const bool is_there, cursor.next());
    if (!is_there) return {};
    VT_CHECK(visit(tile_from_morton(level, cursor.morton())));
  }
}

Result<std::optional<TileId>> StoreReader::nearest_present(LayerId id, TileId tile) const {
  const LayerInfo* layer = impl_->find_readable(id);
  if (layer == nullptr) return impl_->unreadable(id);
  // Nothing lies deeper than the finest level.
  while (tile.level > layer->finest) tile = parent_of(tile);
  while (true) {
    VT_ASSIGN(const Reference found, impl_->find_tile(*layer, tile));
    if (found.present()) return std::optional(tile);
    if (tile.level.value == 0) return std::optional<TileId>();
    tile = parent_of(tile);
  }
}

}  // namespace vt::store
