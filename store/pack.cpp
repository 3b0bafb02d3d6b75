#include "store/pack.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "store/format/catalog.h"
#include "store/format/file_beside.h"
#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/format/tile_text.h"
#include "store/index/index_builder.h"
#include "store/index/index_cursor.h"
#include "store/index/new_store.h"
#include "store/io/file.h"
#include "store/io/folder.h"
#include "store/io/uuid.h"

namespace vt::store {
namespace {

// Levels whose tiles lie mixed, those over one place together. Three levels over one tile are 21 tiles, one
// to four megabytes: what a view of one place needs at once and about what a disk reads ahead. With one level
// a group, a flight down through 20 levels reads at 20 places; with all levels in one, neighbours in the
// finest one lie as far apart as whole subtrees are long.
constexpr int kGroupLevels = 3;

// Shared records whose new place is remembered, so that they stay shared; forgetting one costs a copy of it.
constexpr std::size_t kMaxSharedRecords = std::size_t{1} << 20;

constexpr int kHeights = top_height(Level{kMaxFinest}) + 1;

// Room for all pages of one height of one level, filled from the front as the pages are finished.
struct PageRoom {
  std::uint64_t bytes = 0;
  std::uint64_t next = 0;
  std::uint64_t end = 0;
  bool is_reserved = false;
};

// One level of one layer on its way. A page has as many entries in the new store as in the old one, so the
// room it takes is known before the places of its tiles are.
class LevelCopy final : public IndexBuilder::Sink {
 public:
  LevelCopy(const Snapshot& source, NewStore& target, std::size_t layer, Level level)
      : source_(source), target_(target), layer_(layer), level_(level) {}

  // Sums up the pages without reading a leaf.
  [[nodiscard]] Result<void> measure() {
    const Reference& root = source_.roots[layer_][level_.value];
    rooms_[top()].bytes = root.present() ? root.record_bytes() : 0;
    for (int height = top_height(level_); height > 0; --height) {
      IndexCursor pages(source_, layer_, level_, height);
      while (true) {
        VT_ASSIGN(const bool found, pages.next());
        if (!found) break;
        rooms_[static_cast<std::size_t>(height) - 1].bytes += pages.entry().record_bytes();
      }
    }
    return {};
  }

  [[nodiscard]] std::size_t layer() const { return layer_; }
  [[nodiscard]] Level level() const { return level_; }
  [[nodiscard]] std::uint64_t top_page_bytes() const { return rooms_[top()].bytes; }
  [[nodiscard]] std::uint64_t unreserved_page_bytes() const {
    std::uint64_t bytes = 0;
    for (const PageRoom& room : rooms_) bytes += room.is_reserved ? 0 : room.bytes;
    return bytes;
  }

  [[nodiscard]] Result<void> reserve_top() { return reserve(rooms_[top()]); }
  [[nodiscard]] Result<void> reserve_pages() {
    for (std::size_t height = rooms_.size(); height-- > 0;) VT_CHECK(reserve(rooms_[height]));
    return {};
  }

  // Copying: begin, then take entry() and put() its copy until there is none, then finish.
  [[nodiscard]] Result<void> begin() {
    const LayerInfo& layer = source_.layers[layer_];
    cursor_.emplace(source_, layer_, level_);
    builder_.emplace(*this, layer.id, level_);
    // A build goes from the finest level up, and carry layers keep only what a later build needs; everywhere
    // else a tile has its parent.
    if (layer.role == LayerRole::kTexture && layer.state == LayerState::kComplete && level_.value > 0)
      parents_.emplace(source_, layer_, Level{static_cast<std::uint8_t>(level_.value - 1)});
    return advance();
  }
  [[nodiscard]] bool has_entry() const { return has_entry_; }
  [[nodiscard]] const Reference& entry() const { return cursor_->entry(); }
  [[nodiscard]] std::uint64_t morton() const { return cursor_->morton(); }
  // Whether the entry has a parent, where it should. Parents come in the order of their children.
  [[nodiscard]] Result<bool> has_parent() {
    if (!parents_) return true;
    const std::uint64_t wanted = morton() >> 2;
    while (!has_passed_parent_ && (!parent_ || *parent_ < wanted)) {
      VT_ASSIGN(const bool found, parents_->next());
      has_passed_parent_ = !found;
      if (found) parent_ = parents_->morton();
    }
    return !has_passed_parent_ && parent_ == wanted;
  }
  [[nodiscard]] Result<void> put(const Reference& copy) {
    VT_CHECK(builder_->add(cursor_->morton(), copy));
    return advance();
  }
  [[nodiscard]] Result<Reference> finish() {
    VT_ASSIGN(const Reference root, builder_->finish());
    for (const PageRoom& room : rooms_)
      if (room.next != room.end) return fail(ErrorCode::kInternal, "pack: the index is not as long as it was measured");
    cursor_.reset();
    builder_.reset();
    parents_.reset();
    is_done_ = true;
    return root;
  }
  [[nodiscard]] bool is_done() const { return is_done_; }

 private:
  [[nodiscard]] std::size_t top() const { return static_cast<std::size_t>(top_height(level_)); }
  [[nodiscard]] Result<void> reserve(PageRoom& room) {
    if (std::exchange(room.is_reserved, true)) return {};
    VT_ASSIGN(room.next, target_.reserve(room.bytes));
    room.end = room.next + room.bytes;
    return {};
  }
  [[nodiscard]] Result<void> advance() {
    VT_ASSIGN(has_entry_, cursor_->next());
    return {};
  }
  [[nodiscard]] Result<Reference> place_page(std::uint64_t key, int height, std::span<const std::byte> payload) override {
    PageRoom& room = rooms_[static_cast<std::size_t>(height)];
    const std::uint64_t bytes = aligned(kRecordHeaderBytes + payload.size());
    if (!room.is_reserved || bytes > room.end - room.next)
      return fail(ErrorCode::kInternal, "pack: the index is longer than it was measured");
    return target_.write_page(std::exchange(room.next, room.next + bytes), key, payload);
  }

  const Snapshot& source_;
  NewStore& target_;
  std::size_t layer_;  // in the source
  Level level_;
  std::array<PageRoom, kHeights> rooms_ = {};  // by height
  std::optional<IndexCursor> cursor_;
  std::optional<IndexBuilder> builder_;
  std::optional<IndexCursor> parents_;  // goes through the level above in step
  std::optional<std::uint64_t> parent_;
  bool has_passed_parent_ = false;  // the level above has come to its end
  bool has_entry_ = false;
  bool is_done_ = false;
};

// A record that many tiles share, and the size at which they share it: a store with two different ones is
// damaged. Layers of a format that is not known share among themselves only.
struct SharedRecord {
  std::uint64_t offset = 0;
  std::size_t raw_bytes = 0;  // 0 of a format that is not known
  bool operator==(const SharedRecord&) const = default;
};
// Its copy, and the formats in which it is known to decode: tiles of two layers may share it and differ in
// that.
struct SharedCopy {
  Reference reference;
  std::uint64_t formats = 0;  // a bit each

  // Every tile of a format that is not known counts as one that decodes: nobody here can tell.
  [[nodiscard]] static std::uint64_t bit_of(TexelFormat format) {
    return is_known(format) ? std::uint64_t{1} << static_cast<unsigned>(format) : 0;
  }
  [[nodiscard]] bool is_known_to_decode(TexelFormat format) const { return (formats & bit_of(format)) == bit_of(format); }
};
struct HashSharedRecord {
  std::size_t operator()(const SharedRecord& record) const {
    return static_cast<std::size_t>((record.offset ^ (record.raw_bytes << 1)) * 0x9E3779B97F4A7C15);
  }
};

// What is asked of the new file apart from its contents.
struct Identity {
  Uuid uuid = {};
  std::uint64_t generation = 0;
  const File* replaces = nullptr;
};

class Packing {
 public:
  Packing(const Snapshot& source, NewStore& target, const PackOptions& options) : source_(source), target_(target), options_(options) {}

  // The layers that come along. Everything else is called after it.
  [[nodiscard]] Result<void> choose_layers() {
    for (std::size_t i = 0; i < source_.layers.size(); ++i) {
      const LayerInfo& layer = source_.layers[i];
      if (layer.role == LayerRole::kCarry && !options_.keep_carry) {
        report_.dropped_layers.push_back(layer.name);
        continue;
      }
      if (layer.role == LayerRole::kTexture && layer.state == LayerState::kBuilding)
        return fail(ErrorCode::kInvalidData, source_.file.path().string() + ": layer " + layer.name +
                                                 " is unfinished; finish its build by running the same command again, or remove the layer");
      tiles_ += layer.tiles;
      layers_.push_back(i);
      catalog_.layers.push_back({.info = layer, .roots = std::vector<Reference>(source_.roots[i].size())});
      CatalogLayer& copy = catalog_.layers.back();
      // Counted again on the way.
      copy.info.tiles = copy.info.constant_tiles = copy.info.stored_bytes = 0;
      report_.layers.push_back({.name = layer.name});
    }
    catalog_.description = source_.description;
    return {};
  }

  // Refuses at once what would fill the disk after an hour.
  [[nodiscard]] Result<void> check_room_on_disk(const std::filesystem::path& folder) {
    std::uint64_t wanted = kLogStart;
    for (const std::size_t layer : layers_) {
      const LayerInfo& info = source_.layers[layer];
      // A constant is shared, so it hardly counts.
      const std::uint64_t constants = aligned(kRecordHeaderBytes + format_info(info.format).block_bytes) * info.constant_tiles;
      wanted += info.stored_bytes - std::min(info.stored_bytes, constants);
      wanted += kReferenceBytes * info.tiles;
    }
    // Sharing, and catalogs that count wrong: it never gets longer than the old one.
    wanted = std::min(wanted, source_.superblock.file_end);
    std::error_code problem;
    const auto space = std::filesystem::space(folder, problem);
    if (!problem && space.available < wanted)
      return fail(ErrorCode::kIo, folder.string() + ": has room for " + std::to_string(space.available >> 20) +
                                      " MiB, the packed store takes about " + std::to_string(wanted >> 20) +
                                      " MiB; free some space or pack into another folder");
    return {};
  }

  [[nodiscard]] Result<PackReport> run(const Identity& identity) {
    VT_ASSIGN(const std::uint64_t catalog_room, NewStore::catalog_room(catalog_));
    VT_ASSIGN(const std::uint64_t catalog_at, target_.reserve(catalog_room));
    for (const std::size_t layer : layers_) {
      levels_.emplace_back();
      for (int level = 0; level <= source_.layers[layer].finest.value; ++level) {
        levels_.back().push_back(std::make_unique<LevelCopy>(source_, target_, layer, Level{static_cast<std::uint8_t>(level)}));
        VT_CHECK(levels_.back().back()->measure());
      }
    }
    if (options_.progress) options_.progress(0, tiles_);
    VT_CHECK(copy_cold_start());
    report_.cold_start_bytes = target_.end() - kLogStart;
    for (const LayerRole role : {LayerRole::kTexture, LayerRole::kCarry})
      for (int first = 0; first <= kMaxFinest; first += kGroupLevels)
        for (std::size_t layer = 0; layer < layers_.size(); ++layer)
          if (role_of(layer) == role) VT_CHECK(copy_group(layer, first));

    report_.source_bytes = source_.superblock.file_end;
    report_.packed_bytes = target_.end();
    VT_CHECK(target_.publish(catalog_, {.uuid = identity.uuid,
                                        .generation = identity.generation,
                                        .catalog_at = catalog_at,
                                        .cold_start = {.offset = kLogStart, .bytes = report_.cold_start_bytes}}));
    return report_;
  }

 private:
  [[nodiscard]] LayerRole role_of(std::size_t layer) const { return source_.layers[layers_[layer]].role; }
  // A level of the chosen layer number `layer`; null below its finest.
  [[nodiscard]] LevelCopy* level_of(std::size_t layer, int level) const {
    const auto& levels = levels_[layer];
    return static_cast<std::size_t>(level) < levels.size() ? levels[static_cast<std::size_t>(level)].get() : nullptr;
  }

  // The catalog lies at the front already. After it the top pages of all levels, so that every look-up begins
  // in what is read; then whole levels, the coarsest first, as long as they fit. A layer whose level does not
  // fit is out for the deeper ones.
  [[nodiscard]] Result<void> copy_cold_start() {
    const auto room = [&] { return options_.cold_start_bytes - std::min(options_.cold_start_bytes, target_.end() - kLogStart); };
    for (int level = 0; level <= kMaxFinest; ++level)
      for (std::size_t layer = 0; layer < layers_.size(); ++layer)
        if (LevelCopy* copy = level_of(layer, level); copy != nullptr && role_of(layer) == LayerRole::kTexture)
          if (copy->top_page_bytes() <= room()) VT_CHECK(copy->reserve_top());

    std::vector<bool> is_in(layers_.size(), true);
    for (int level = 0; level <= kMaxFinest; ++level)
      for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
        LevelCopy* copy = level_of(layer, level);
        if (copy == nullptr || role_of(layer) != LayerRole::kTexture || !is_in[layer]) continue;
        VT_ASSIGN(is_in[layer], fits(*copy, room()));
        if (!is_in[layer]) continue;
        VT_CHECK(copy_levels(layer, {copy}));
        report_.layers[layer].cold_levels = level + 1;
      }
    return {};
  }

  [[nodiscard]] Result<bool> fits(const LevelCopy& copy, std::uint64_t room) const {
    std::uint64_t bytes = copy.unreserved_page_bytes();
    if (bytes > room) return false;
    std::unordered_set<SharedRecord, HashSharedRecord> shared_here;
    const LayerInfo& info = source_.layers[copy.layer()];
    IndexCursor tiles(source_, copy.layer(), copy.level());
    while (true) {
      VT_ASSIGN(const bool found, tiles.next());
      if (!found) return true;
      const Reference& entry = tiles.entry();
      const SharedRecord record{entry.offset, raw_bytes_of(info, entry)};
      const bool is_there = is_shared(entry) && (shared_.contains(record) || !shared_here.insert(record).second);
      bytes += is_there ? 0 : entry.record_bytes();
      if (bytes > room) return false;
    }
  }

  // The levels of one layer from `first` on that a group spans, and that are not copied yet.
  [[nodiscard]] Result<void> copy_group(std::size_t layer, int first) {
    std::vector<LevelCopy*> levels;
    for (int level = first; level < first + kGroupLevels; ++level)
      if (LevelCopy* copy = level_of(layer, level); copy != nullptr && !copy->is_done()) levels.push_back(copy);
    return levels.empty() ? Result<void>{} : copy_levels(layer, levels);
  }

  // Pages first, then the tiles: below each tile of the coarsest level those of the finer ones, level by
  // level, so that neighbours stay together in every level. All cursors only ever go forward.
  [[nodiscard]] Result<void> copy_levels(std::size_t layer, const std::vector<LevelCopy*>& levels) {
    for (LevelCopy* level : levels) VT_CHECK(level->reserve_pages());
    for (LevelCopy* level : levels) VT_CHECK(level->begin());
    const Level coarsest = levels.front()->level();
    const auto place_of = [&](const LevelCopy& level) { return level.morton() >> (2 * (level.level().value - coarsest.value)); };
    while (true) {
      std::optional<std::uint64_t> place;
      for (const LevelCopy* level : levels)
        if (level->has_entry() && (!place || place_of(*level) < *place)) place = place_of(*level);
      if (!place) break;
      for (LevelCopy* level : levels)
        while (level->has_entry() && place_of(*level) == *place) VT_CHECK(copy_tile(layer, *level));
    }
    for (LevelCopy* level : levels) {
      VT_ASSIGN(catalog_.layers[layer].roots[level->level().value], level->finish());
    }
    return {};
  }

  [[nodiscard]] Result<void> copy_tile(std::size_t layer, LevelCopy& level) {
    LayerInfo& info = catalog_.layers[layer].info;
    const TileId tile = tile_from_morton(level.level(), level.morton());
    VT_ASSIGN(const bool has_parent, level.has_parent());
    if (!has_parent) return damaged(info, tile, kParentIsAbsent);
    VT_ASSIGN(const Reference copy, copy_record(info, level.entry(), tile));
    VT_CHECK(level.put(copy));
    info.tiles += 1;
    info.constant_tiles += copy.kind == ReferenceKind::kConstant ? 1 : 0;
    info.stored_bytes += copy.record_bytes();
    if (++report_.tiles % 256 == 0) {
      if (options_.progress) options_.progress(report_.tiles, std::max(tiles_, report_.tiles));
      if (options_.cancel != nullptr && *options_.cancel) return fail(ErrorCode::kCancelled, "stopped; nothing was changed");
    }
    return {};
  }

  [[nodiscard]] static bool is_shared(const Reference& entry) { return store::is_shared(entry.kind); }
  [[nodiscard]] static std::size_t raw_bytes_of(const LayerInfo& info, const Reference& entry) {
    return entry.kind == ReferenceKind::kConstant ? format_info(info.format).block_bytes : info.tile_payload_bytes();
  }

  // The record's copy, or the copy that was made of it before when it belongs to many tiles.
  [[nodiscard]] Result<Reference> copy_record(const LayerInfo& info, const Reference& from, TileId tile) {
    const SharedRecord record{from.offset, raw_bytes_of(info, from)};
    if (!is_shared(from)) return copy_bytes(info, from, tile, record_key(info.id, tile.level, morton_code(tile.x, tile.y)));
    // A run of one constant is the usual case, and finding it again the usual work.
    if (record != last_shared_from_) {
      if (const auto known = shared_.find(record); known != shared_.end()) {
        last_shared_ = known->second;
      } else {
        VT_ASSIGN(last_shared_.reference, copy_bytes(info, from, tile, 0));
        last_shared_.formats = SharedCopy::bit_of(info.format);
        if (shared_.size() >= kMaxSharedRecords) shared_.clear();
        shared_.emplace(record, last_shared_);
      }
      last_shared_from_ = record;
    }
    // Every reference says for itself what it expects to find...
    Reference expected = from;
    expected.offset = last_shared_.reference.offset;
    if (expected != last_shared_.reference) return damaged(info, tile, "its checksum differs from the one its reference gives");
    // ...and every format how it is to be decoded.
    if (!last_shared_.is_known_to_decode(info.format)) {
      VT_CHECK(check_decodes(info, from, tile));
      last_shared_.formats |= SharedCopy::bit_of(info.format);
      shared_[record] = last_shared_;
    }
    return last_shared_.reference;
  }
  [[nodiscard]] Result<Reference> copy_bytes(const LayerInfo& info, const Reference& from, TileId tile, std::uint64_t key) {
    if (info.holds_blobs() && from.kind != ReferenceKind::kTile) return damaged(info, tile, kBlobIsShared);
    VT_ASSIGN(const std::span<std::byte> record, target_.next_record(kRecordHeaderBytes + std::uint64_t{from.stored_bytes}));
    VT_CHECK(source_.file.read_at(from.offset, record));
    const std::uint32_t raw_bytes = wanted_raw_bytes(info, from.kind, record);
    const auto payload = check_record(record, from, key, raw_bytes);
    if (!payload) return damaged(info, tile, payload.error());
    VT_CHECK(check_decodes(info, from, tile, *payload, raw_bytes));
    Reference copy = from;
    copy.offset = target_.keep_record(record.size());
    return copy;
  }
  [[nodiscard]] Result<void> check_decodes(const LayerInfo& info, const Reference& from, TileId tile, std::span<const std::byte> payload,
                                           std::uint32_t raw_bytes) {
    if (from.codec == Codec::kRaw) return {};  // as long as it should be, and any texels are texels
    if (!info.has_known_format()) return {};   // copied as it is
    decoded_.resize(std::max<std::size_t>(decoded_.size(), raw_bytes));
    const auto decoded =
        decode_payload(from.codec, payload, tile_shape(info.format, info.tile_texels()), std::span(decoded_).first(raw_bytes));
    return decoded ? Result<void>() : damaged(info, tile, decoded.error().message);
  }
  // The same of a shared record that was copied for a layer of another format.
  [[nodiscard]] Result<void> check_decodes(const LayerInfo& info, const Reference& from, TileId tile) {
    std::vector<std::byte> record(kRecordHeaderBytes + std::size_t{from.stored_bytes});
    VT_CHECK(source_.file.read_at(from.offset, record));
    const std::uint32_t raw_bytes = wanted_raw_bytes(info, from.kind, record);
    const auto payload = check_record(record, from, 0, raw_bytes);
    if (!payload) return damaged(info, tile, payload.error());
    return check_decodes(info, from, tile, *payload, raw_bytes);
  }
  [[nodiscard]] tl::unexpected<Error> damaged(const LayerInfo& info, TileId tile, const std::string& sentence) const {
    return fail(ErrorCode::kCorrupt, source_.file.path().string() + ": " + tile_place(info, tile) + ": " + sentence);
  }

  const Snapshot& source_;
  NewStore& target_;
  const PackOptions& options_;
  std::vector<std::size_t> layers_;                              // in the source, of those that come along
  std::vector<std::vector<std::unique_ptr<LevelCopy>>> levels_;  // as `layers_`, by level
  Catalog catalog_;
  std::uint64_t tiles_ = 0;                                                // by the source's catalog
  std::unordered_map<SharedRecord, SharedCopy, HashSharedRecord> shared_;  // from the place in the source
  SharedRecord last_shared_from_;
  SharedCopy last_shared_;
  std::vector<std::byte> decoded_;
  PackReport report_;
};

Result<PackReport> pack_snapshot(const Snapshot& source, const std::filesystem::path& path, const Identity& identity,
                                 const PackOptions& options) {
  std::vector<std::filesystem::path> leftovers = remove_leftovers(path);
  VT_ASSIGN(const std::unique_ptr<NewStore> target, NewStore::begin(path, options.writer, identity.replaces));
  Packing packing(source, *target, options);
  VT_CHECK(packing.choose_layers());
  VT_CHECK(packing.check_room_on_disk(folder_of(path)));
  VT_ASSIGN(PackReport report, packing.run(identity));
  report.removed_leftovers = std::move(leftovers);
  return report;
}

}  // namespace

Result<PackReport> pack(const StoreReader& reader, const std::filesystem::path& path, const PackOptions& options) {
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored)))
    return fail(ErrorCode::kExists, path.string() + ": is there already; remove it or choose another name");
  return pack_snapshot(reader.snapshot(), path, {.uuid = random_uuid()}, options);
}

Result<PackReport> pack_in_place(const std::filesystem::path& path, const PackOptions& options) {
  // The lock is held to the end, so that no writer begins on a file that is about to lose its name.
  VT_ASSIGN(File file, open_for_change(path, File::Mode::kRead));
  VT_ASSIGN(const Snapshot source, load_snapshot(std::move(file)));
  if (source.health == StoreHealth::kMayBeOlder)
    return fail(ErrorCode::kCorrupt,
                path.string() + ": not packed in place, since a later generation would be lost: " + source.health_remark);

  // A link stays a link; the file it leads to is what is packed.
  std::error_code problem;
  const std::filesystem::path real = std::filesystem::canonical(path, problem);
  if (problem) return fail(ErrorCode::kIo, path.string() + ": cannot be found again: " + problem.message());
  return pack_snapshot(source, real,
                       {.uuid = source.superblock.uuid, .generation = source.superblock.generation + 1, .replaces = &source.file}, options);
}

}  // namespace vt::store
