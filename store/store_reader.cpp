#include "store/store_reader.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <utility>

#include "store/file.h"
#include "store/layout.h"
#include "store/snapshot.h"
#include "store/tile_text.h"

namespace vt::store {
namespace {

// Remembers which index pages have been hashed and checked, so that a lookup pays for it once. A fixed table of page offsets without locks:
// a page that loses its place to another is only checked again.
class VerifiedPages {
 public:
  explicit VerifiedPages(std::uint64_t tiles)
      : slots_(std::bit_ceil(std::clamp<std::uint64_t>(tiles / 64, 1024, std::uint64_t{1} << 22))),
        offsets_(new std::atomic<std::uint64_t>[slots_]()) {}

  // Relaxed is enough: the pages never change, and no data passes through the table.
  [[nodiscard]] bool contains(std::uint64_t offset) const { return slot(offset).load(std::memory_order_relaxed) == offset; }
  void add(std::uint64_t offset) const { slot(offset).store(offset, std::memory_order_relaxed); }

 private:
  [[nodiscard]] std::atomic<std::uint64_t>& slot(std::uint64_t offset) const {
    return offsets_[((offset / kRecordAlignment) * 0x9E3779B97F4A7C15) >> (64 - std::countr_zero(slots_))];
  }
  std::size_t slots_;
  std::unique_ptr<std::atomic<std::uint64_t>[]> offsets_;
};

constexpr std::uint16_t kNoLayer = 0xFFFF;

}  // namespace

struct StoreReader::Impl {
  Snapshot snapshot;
  Mapping mapping;
  std::array<std::uint16_t, kMaxLayers> index_of_id;
  VerifiedPages verified{0};

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

  // The reference to a tile, through the pages of its level from the top.
  [[nodiscard]] Result<Reference> find_tile(const LayerInfo& layer, TileId tile) const {
    if (!is_addressable(tile) || tile.level > layer.finest) return Reference{};
    const std::uint64_t morton = morton_code(tile.x, tile.y);
    Reference at = snapshot.roots[index_of_id[layer.id.value]][tile.level.value];
    for (int height = top_height(tile.level); height >= 0; --height) {
      if (!at.present()) return at;
      const std::uint64_t key = record_key(layer.id, tile.level, page_first_morton(morton, height));
      const bool was_verified = verified.contains(at.offset);
      const auto payload = check_record(record(at), at, key, at.stored_bytes, was_verified ? HashCheck::kSkip : HashCheck::kVerify);
      if (!payload) [[unlikely]]
        return damaged_page(layer, tile, at, payload.error());
      if (!was_verified) {
        if (const auto sound = check_page(*payload, tile.level, height, snapshot.superblock.file_end); !sound)
          return damaged_page(layer, tile, at, sound.error().sentence);
        verified.add(at.offset);
      }
      at = page_entry(*payload, page_slot(morton, height));
    }
    return at;
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
  std::uint64_t tiles = 0;
  for (std::size_t i = 0; i < impl->snapshot.layers.size(); ++i) {
    const LayerInfo& layer = impl->snapshot.layers[i];
    impl->index_of_id[layer.id.value] = static_cast<std::uint16_t>(i);
    // The count only sizes a table, so a wild one does no harm.
    tiles += std::min(layer.tiles, superblock.file_end);
  }
  impl->verified = VerifiedPages(std::min(tiles, superblock.file_end));
  return StoreReader(std::move(impl));
}

const std::filesystem::path& StoreReader::path() const { return impl_->snapshot.file.path(); }
const Snapshot& StoreReader::snapshot() const { return impl_->snapshot; }
const StoreDescription& StoreReader::description() const { return impl_->snapshot.description; }
std::uint64_t StoreReader::generation() const { return impl_->snapshot.superblock.generation; }
std::uint64_t StoreReader::file_bytes() const { return impl_->snapshot.superblock.file_end; }
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
  VT_ASSIGN(const Reference found, impl_->find_tile(*layer, tile));
  TileLookup lookup{.codec = found.codec, .offset = found.offset, .stored_bytes = found.stored_bytes};
  if (found.present()) lookup.kind = found.kind == ReferenceKind::kConstant ? TileKind::kConstant : TileKind::kStored;
  return lookup;
}

Result<void> StoreReader::read(LayerId id, TileId tile, std::span<std::byte> out) const {
  const LayerInfo* layer = impl_->find(id);
  if (layer == nullptr) return impl_->unknown_layer(id);
  assert(out.size() == layer->tile_payload_bytes());
  VT_ASSIGN(const Reference found, impl_->find_tile(*layer, tile));
  if (!found.present()) return impl_->refuse(ErrorCode::kNotFound, tile_place(*layer, tile) + ": absent");

  const bool is_constant = found.kind == ReferenceKind::kConstant;
  const std::size_t raw_bytes = is_constant ? format_info(layer->format).block_bytes : out.size();
  const std::uint64_t key = is_shared(found.kind) ? 0 : record_key(id, tile.level, morton_code(tile.x, tile.y));
  const auto payload = check_record(impl_->record(found), found, key, static_cast<std::uint32_t>(raw_bytes));
  if (!payload) return impl_->refuse(ErrorCode::kCorrupt, tile_place(*layer, tile) + ": " + payload.error());
  if (is_constant) {
    fill_constant(*payload, out);
    return {};
  }
  if (auto decoded = decode_payload(found.codec, *payload, tile_shape(layer->format, layer->tile_texels()), out); !decoded)
    return impl_->refuse(decoded.error().code, tile_place(*layer, tile) + ": " + decoded.error().message);
  return {};
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
