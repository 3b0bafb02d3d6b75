#include "store/store_reader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "store/file.h"
#include "store/layout.h"
#include "store/page_directory.h"
#include "store/snapshot.h"
#include "store/tile_text.h"

namespace vt::store {
namespace {

constexpr std::uint16_t kNoLayer = 0xFFFF;

TileLookup lookup_of(const Reference& found) {
  TileLookup lookup{.codec = found.codec, .offset = found.offset, .stored_bytes = found.stored_bytes};
  if (found.present()) lookup.kind = found.kind == ReferenceKind::kConstant ? TileKind::kConstant : TileKind::kStored;
  return lookup;
}

}  // namespace

struct StoreReader::Impl {
  Snapshot snapshot;
  Mapping mapping;
  std::array<std::uint16_t, kMaxLayers> index_of_id;
  PageDirectory directory;

  [[nodiscard]] const LayerInfo* find(LayerId id) const {
    if (id.value >= kMaxLayers || index_of_id[id.value] == kNoLayer) return nullptr;
    return &snapshot.layers[index_of_id[id.value]];
  }

  [[nodiscard]] tl::unexpected<Error> refuse(ErrorCode code, const std::string& sentence) const {
    return fail(code, snapshot.file.path().string() + ": " + sentence);
  }
  [[nodiscard]] tl::unexpected<Error> unknown_layer(LayerId id) const {
    return refuse(ErrorCode::kUsage, "no layer has id " + std::to_string(id.value));
  }

  // The whole record; its place is checked here, its contents by check_record.
  [[nodiscard]] std::span<const std::byte> record(const Reference& reference) const {
    return mapping.bytes().subspan(reference.offset, kRecordHeaderBytes + reference.stored_bytes);
  }

  [[nodiscard]] PageDirectory::Query query_for(const LayerInfo& layer, TileId tile) const {
    return {.layer = index_of_id[layer.id.value], .level = tile.level, .morton = morton_code(tile.x, tile.y)};
  }
  [[nodiscard]] static bool may_have(const LayerInfo& layer, TileId tile) { return is_addressable(tile) && tile.level <= layer.finest; }

  // The reference to a tile.
  [[nodiscard]] Result<Reference> find_tile(const LayerInfo& layer, TileId tile) const {
    if (!may_have(layer, tile)) return Reference{};
    const auto query = query_for(layer, tile);
    const PageDirectory::Place place = directory.find(query);
    return place.is_known ? place.reference() : find_through_pages(layer, tile, query);
  }
  // The same through the pages of the tile's level from the top, each of which is checked when it is met for the first time.
  [[nodiscard]] Result<Reference> find_through_pages(const LayerInfo& layer, TileId tile, const PageDirectory::Query& query) const {
    Reference at = snapshot.roots[query.layer][tile.level.value];
    for (int height = top_height(tile.level); height >= 0; --height) {
      if (!at.present()) return at;
      if (!directory.knows(query, height)) {
        const std::uint64_t key = record_key(layer.id, tile.level, page_first_morton(query.morton, height));
        const auto payload = check_record(record(at), at, key, at.stored_bytes);
        if (!payload) return damaged_page(layer, tile, at, payload.error());
        if (const auto sound = check_page(*payload, tile.level, height, snapshot.superblock.file_end); !sound)
          return damaged_page(layer, tile, at, sound.error().sentence);
        directory.remember(query, height, at);
      }
      at = page_entry(record(at).subspan(kRecordHeaderBytes), page_slot(query.morton, height));
    }
    return at;
  }

  // A tile's record, found and checked, and its payload as it lies in the file. kNotFound: absent.
  struct StoredTile {
    Reference reference;
    std::uint32_t raw_bytes = 0;
    std::span<const std::byte> payload;
  };
  [[nodiscard]] Result<StoredTile> stored_tile(const LayerInfo& layer, TileId tile) const {
    StoredTile stored;
    VT_ASSIGN(stored.reference, find_tile(layer, tile));
    if (!stored.reference.present()) return refuse(ErrorCode::kNotFound, tile_place(layer, tile) + ": absent");
    const auto whole = record(stored.reference);
    stored.raw_bytes = wanted_raw_bytes(layer, stored.reference.kind, whole);
    const std::uint64_t key = is_shared(stored.reference.kind) ? 0 : record_key(layer.id, tile.level, morton_code(tile.x, tile.y));
    const auto payload = check_record(whole, stored.reference, key, stored.raw_bytes);
    if (!payload) return refuse(ErrorCode::kCorrupt, tile_place(layer, tile) + ": " + payload.error());
    stored.payload = *payload;
    return stored;
  }
  [[nodiscard]] Result<void> decode(const LayerInfo& layer, TileId tile, const StoredTile& stored, std::span<std::byte> out) const {
    if (auto decoded = decode_payload(stored.reference.codec, stored.payload, tile_shape(layer.format, layer.tile_texels()), out); !decoded)
      return refuse(decoded.error().code, tile_place(layer, tile) + ": " + decoded.error().message);
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> damaged_page(const LayerInfo& layer, TileId tile, const Reference& page,
                                                   const std::string& sentence) const {
    return refuse(ErrorCode::kCorrupt, tile_place(layer, tile) + ": index page at offset " + std::to_string(page.offset) + ": " + sentence);
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

  impl->index_of_id.fill(kNoLayer);
  for (std::size_t i = 0; i < impl->snapshot.layers.size(); ++i)
    impl->index_of_id[impl->snapshot.layers[i].id.value] = static_cast<std::uint16_t>(i);
  impl->directory = PageDirectory(impl->mapping.bytes(), impl->snapshot.layers);
  return StoreReader(std::move(impl));
}

const std::filesystem::path& StoreReader::path() const { return impl_->snapshot.file.path(); }
const Snapshot& StoreReader::snapshot() const { return impl_->snapshot; }
const StoreDescription& StoreReader::description() const { return impl_->snapshot.description; }
std::uint64_t StoreReader::generation() const { return impl_->snapshot.superblock.generation; }
std::uint64_t StoreReader::file_bytes() const { return impl_->snapshot.superblock.file_end; }
StoreHealth StoreReader::health() const { return impl_->snapshot.health; }
const std::string& StoreReader::health_remark() const { return impl_->snapshot.health_remark; }
std::span<const LayerInfo> StoreReader::layers() const { return impl_->snapshot.layers; }
const LayerInfo* StoreReader::find_layer(LayerId layer) const { return impl_->find(layer); }

const LayerInfo* StoreReader::find_layer(std::string_view name) const {
  for (const LayerInfo& layer : impl_->snapshot.layers)
    if (layer.name == name) return &layer;
  return nullptr;
}

std::string StoreReader::uuid() const {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < impl_->snapshot.superblock.uuid.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    const auto value = std::to_integer<unsigned>(impl_->snapshot.superblock.uuid[i]);
    text += kDigits[value / 16];
    text += kDigits[value % 16];
  }
  return text;
}

Result<TileLookup> StoreReader::lookup(LayerId id, TileId tile) const {
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) [[unlikely]]
    return impl_->unknown_layer(id);
  if (!Impl::may_have(*layer, tile)) return TileLookup{};
  const auto query = impl_->query_for(*layer, tile);
  if (const PageDirectory::Place place = impl_->directory.find(query); place.is_known) [[likely]]
    return lookup_of(place.reference());
  VT_ASSIGN(const Reference found, impl_->find_through_pages(*layer, tile, query));
  return lookup_of(found);
}

Result<void> StoreReader::lookup_many(LayerId id, std::span<const TileId> tiles, std::span<TileLookup> out) const {
  assert(out.size() == tiles.size());
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) return impl_->unknown_layer(id);
  std::array<PageDirectory::Query, PageDirectory::kBatch> queries;
  std::array<PageDirectory::Place, PageDirectory::kBatch> places;
  for (std::size_t first = 0; first < tiles.size(); first += queries.size()) {
    const auto batch = tiles.subspan(first, std::min(queries.size(), tiles.size() - first));
    // A tile outside the pyramid asks for the root instead, and its answer is not looked at.
    for (std::size_t i = 0; i < batch.size(); ++i)
      queries[i] = impl_->query_for(*layer, Impl::may_have(*layer, batch[i]) ? batch[i] : TileId{});
    impl_->directory.find_many(std::span(queries).first(batch.size()), std::span(places).first(batch.size()));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (!Impl::may_have(*layer, batch[i])) {
        out[first + i] = {};
      } else if (places[i].is_known) {
        out[first + i] = lookup_of(places[i].reference());
      } else {
        VT_ASSIGN(const Reference found, impl_->find_through_pages(*layer, batch[i], queries[i]));
        out[first + i] = lookup_of(found);
      }
    }
  }
  return {};
}

Result<void> StoreReader::read(LayerId id, TileId tile, std::span<std::byte> out) const {
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) return impl_->unknown_layer(id);
  if (layer->holds_blobs()) return impl_->refuse(ErrorCode::kUsage, "layer " + layer->name + " holds blobs, which have no texels");
  assert(out.size() == layer->tile_payload_bytes());
  VT_ASSIGN(const Impl::StoredTile stored, impl_->stored_tile(*layer, tile));
  if (stored.reference.kind == ReferenceKind::kConstant) {
    fill_constant(stored.payload, out);
    return {};
  }
  return impl_->decode(*layer, tile, stored, out);
}

Result<void> StoreReader::read_blob(LayerId id, TileId tile, std::vector<std::byte>& out) const {
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) return impl_->unknown_layer(id);
  if (!layer->holds_blobs()) return impl_->refuse(ErrorCode::kUsage, "layer " + layer->name + " holds no blobs");
  VT_ASSIGN(const Impl::StoredTile stored, impl_->stored_tile(*layer, tile));
  if (stored.reference.kind != ReferenceKind::kTile)
    return impl_->refuse(ErrorCode::kCorrupt, tile_place(*layer, tile) + ": a blob's record is shared");
  out.resize(stored.raw_bytes);
  return impl_->decode(*layer, tile, stored, out);
}

Result<std::optional<TileId>> StoreReader::nearest_present(LayerId id, TileId tile) const {
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) return impl_->unknown_layer(id);
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
