#include "store/validate.h"

#include <algorithm>
#include <cassert>
#include <random>
#include <set>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/format/tile_text.h"
#include "store/io/file.h"
#include "store/io/mapping.h"

namespace vt::store {
namespace {

// A ruined store has as many findings as tiles; nobody reads more than this.
constexpr std::size_t kMaxFindings = 1000;

// Nobody packs a store to save less.
constexpr std::uint64_t kLittleGarbage = std::uint64_t{1} << 20;

bool is_error(FaultNumber number) {
  switch (number) {
    case FaultNumber::kSuperblockDamaged:
    case FaultNumber::kUncommittedTail:
    case FaultNumber::kGarbage:
    case FaultNumber::kLayerBuilding:
    case FaultNumber::kTileOutsideData:
    case FaultNumber::kUnknownChannel:
    case FaultNumber::kUnknownFormat:
      return false;
    case FaultNumber::kNoSuperblock:
    case FaultNumber::kVersion:
    case FaultNumber::kSuperblockReserved:
    case FaultNumber::kFileTruncated:
    case FaultNumber::kSuperblockField:
    case FaultNumber::kForeignSuperblock:
    case FaultNumber::kMayBeOlder:
    case FaultNumber::kMoreFindings:
    case FaultNumber::kCatalogReference:
    case FaultNumber::kCatalogRecord:
    case FaultNumber::kCatalogStructure:
    case FaultNumber::kLayerField:
    case FaultNumber::kLayerClash:
    case FaultNumber::kPageReference:
    case FaultNumber::kPageRecord:
    case FaultNumber::kPageStructure:
    case FaultNumber::kPageEntry:
    case FaultNumber::kTileRecord:
    case FaultNumber::kTileDecode:
    case FaultNumber::kPadding:
    case FaultNumber::kParentAbsent:
    case FaultNumber::kLayerCounts:
      return true;
  }
  return true;
}

// What one also finds who comes while a writer is at it: a superblock half written, or a new catalog where
// the one was that it led to.
bool may_be_a_writer(const Finding& finding) {
  const auto number = static_cast<FaultNumber>(finding.number);
  return number == FaultNumber::kSuperblockDamaged || number == FaultNumber::kNoSuperblock || number == FaultNumber::kMayBeOlder ||
         number == FaultNumber::kCatalogRecord;
}

enum class Presence { kAbsent, kPresent, kUnknown };

// One pass over everything that the newest generation reaches, level by level from the coarsest, so that a
// tile's parents have been seen before it.
class StoreCheck {
 public:
  // `file` was mapped after `head` was read, so that it holds all that the superblocks promise.
  StoreCheck(const Head& head, const Mapping& file, const ValidateOptions& options, ValidationReport& report)
      : head_(head), bytes_(file.bytes()), options_(options), report_(report) {}

  void run() {
    const auto chosen = choose_superblock(head_.bytes, head_.file_bytes);
    if (!chosen) return add(chosen.error(), "superblocks");
    if (chosen->damage)
      add(chosen->may_be_older ? FaultNumber::kMayBeOlder : FaultNumber::kSuperblockDamaged, "superblocks", chosen->remark());
    const Superblock& superblock = chosen->newest;
    end_ = superblock.file_end;
    if (bytes_.size() > end_ && !chosen->may_be_older)
      add(FaultNumber::kUncommittedTail, "offset " + std::to_string(end_),
          std::to_string(bytes_.size() - end_) + " bytes after the last commit belong to no generation; the next writer removes them");

    if (const auto catalog = check_catalog(superblock.catalog, superblock.version)) {
      for (const CatalogLayer& layer : catalog->layers) total_ += layer.info.tiles;
      report_.tiles_in_store = total_;
      report_.is_sampled = options_.sample_tiles > 0 && options_.sample_tiles < total_;
      if (report_.is_sampled) {
        check_sample(*catalog);
      } else {
        check_all(*catalog);
      }
    }
    report_.bytes_checked = kLogStart + reachable_bytes_;
  }

 private:
  struct LayerCheck {
    const CatalogLayer& layer;
    LayerInfo counted = {};
    bool is_whole = true;  // no index page was lost, so the counts mean something
    std::uint64_t outside_data = 0;
    TileId first_outside = {};
  };

  void check_all(const Catalog& catalog) {
    for (const CatalogLayer& layer : catalog.layers) check_layer(layer);
    const std::uint64_t log_bytes = end_ - kLogStart;
    if (is_index_damaged_ || log_bytes <= reachable_bytes_) return;
    // Every build leaves some. It is worth a word when packing is worth it.
    report_.garbage_bytes = log_bytes - reachable_bytes_;
    if (report_.garbage_bytes > std::max(kLittleGarbage, log_bytes / 8))
      add(FaultNumber::kGarbage, "log",
          std::to_string(report_.garbage_bytes) + " of " + std::to_string(log_bytes) +
              " bytes belong to older generations or removed tiles; packing with `keep-carry` frees them, and packing without it what "
              "updates need as well");
  }

  // Layers by their number of tiles, levels by the area of their data, then any entry of each page on the way
  // down.
  void check_sample(const Catalog& catalog) {
    struct Stratum {
      LayerCheck check;
      std::vector<double> level_weights;
    };
    std::vector<Stratum> strata;
    std::vector<double> layer_weights;
    for (const CatalogLayer& layer : catalog.layers) {
      strata.push_back({.check = {.layer = layer}});
      remark_on(layer.info);
      bool has_tiles = false;
      for (int number = 0; number <= layer.info.finest.value; ++number) {
        const Level level{static_cast<std::uint8_t>(number)};
        const TexelRect tiles = layer.info.tile_rect(level);
        const Reference& root = layer.roots[level.value];
        const bool is_sound = root.present() && known_page(strata.back().check, root, level, top_height(level), 0);
        has_tiles = has_tiles || is_sound;
        strata.back().level_weights.push_back(is_sound ? static_cast<double>(tiles.width) * static_cast<double>(tiles.height) : 0.0);
      }
      layer_weights.push_back(has_tiles ? static_cast<double>(layer.info.tiles) : 0.0);
    }
    if (std::all_of(layer_weights.begin(), layer_weights.end(), [](double weight) { return weight == 0.0; })) return;

    std::mt19937_64 random(options_.seed);
    std::discrete_distribution<std::size_t> any_layer(layer_weights.begin(), layer_weights.end());
    std::unordered_set<std::uint64_t> seen;
    for (std::uint64_t i = 0; i < options_.sample_tiles; ++i) {
      Stratum& stratum = strata[any_layer(random)];
      std::discrete_distribution<int> any_level(stratum.level_weights.begin(), stratum.level_weights.end());
      const Level level{static_cast<std::uint8_t>(any_level(random))};
      check_random_tile(stratum.check, level, random, seen);
    }
    for (const Stratum& stratum : strata) report_outside(stratum.check);
  }

  void check_random_tile(LayerCheck& check, Level level, std::mt19937_64& random, std::unordered_set<std::uint64_t>& seen) {
    Reference at = check.layer.roots[level.value];
    std::uint64_t morton = 0;
    for (int height = top_height(level); height >= 0; --height) {
      const auto payload = known_page(check, at, level, height, morton);
      if (!payload) return;
      // The n-th present slot: as many steps as there are words before it.
      std::size_t nth = random() % get<std::uint16_t>(*payload, 0);
      int slot = 0;
      while (true) {
        at = page_entry(*payload, slot);
        if (at.present() && nth-- == 0) break;
        ++slot;
      }
      morton |= static_cast<std::uint64_t>(slot) << (kPageBits * height);
    }
    if (seen.insert(record_key(check.layer.info.id, level, morton)).second) check_tile(check, at, tile_from_morton(level, morton));
  }

  // A page's payload, checked when it is met for the first time.
  [[nodiscard]] std::optional<std::span<const std::byte>> known_page(LayerCheck& check, const Reference& reference, Level level, int height,
                                                                     std::uint64_t first_morton) {
    if (unsound_pages_.contains(reference.offset)) return std::nullopt;
    if (!known_pages_.insert(reference.offset).second) return bytes_.subspan(reference.offset + kRecordHeaderBytes, reference.stored_bytes);
    return checked_page(check, reference, level, height, first_morton);
  }

  void add(FaultNumber number, std::string place, std::string sentence) {
    if (report_.findings.size() < kMaxFindings) {
      report_.findings.push_back({static_cast<int>(number), is_error(number), std::move(place), std::move(sentence)});
    } else if (report_.findings.size() == kMaxFindings) {
      report_.findings.push_back({static_cast<int>(FaultNumber::kMoreFindings), true, "report", "there are more findings than are listed"});
    }
  }
  void add(const Fault& fault, std::string place) { add(fault.number, std::move(place), fault.sentence); }

  // Hash, header and padding of one record; counts its bytes.
  [[nodiscard]] std::optional<std::span<const std::byte>> check_record_at(const Reference& reference, std::uint64_t key,
                                                                          std::uint32_t raw_bytes, FaultNumber number,
                                                                          const std::string& place) {
    return check_record_in(bytes_.subspan(reference.offset, reference.record_bytes()), reference, key, raw_bytes, number, place);
  }
  [[nodiscard]] std::optional<std::span<const std::byte>> check_record_in(std::span<const std::byte> whole, const Reference& reference,
                                                                          std::uint64_t key, std::uint32_t raw_bytes, FaultNumber number,
                                                                          const std::string& place) {
    reachable_bytes_ += reference.record_bytes();
    const std::size_t used = kRecordHeaderBytes + reference.stored_bytes;
    if (!all_zero(whole.subspan(used)))
      add(FaultNumber::kPadding, place, "bytes that pad its record at offset " + std::to_string(reference.offset) + " are not zero");
    const auto payload = check_record(whole.first(used), reference, key, raw_bytes);
    if (payload) return *payload;
    add(number, place, "record at offset " + std::to_string(reference.offset) + ": " + payload.error());
    return std::nullopt;
  }

  [[nodiscard]] std::optional<Catalog> check_catalog(const Reference& reference, std::uint32_t version) {
    // A copy: a writer's next catalogs may go where this one is.
    const auto mapped = bytes_.subspan(reference.offset, reference.record_bytes());
    const std::vector<std::byte> record(mapped.begin(), mapped.end());
    const auto payload = check_record_in(record, reference, 0, reference.stored_bytes, FaultNumber::kCatalogRecord, "catalog");
    if (!payload) return std::nullopt;
    auto catalog = decode_catalog(*payload, end_, version);
    if (catalog) return std::move(*catalog);
    add(catalog.error(), "catalog");
    return std::nullopt;
  }

  // What the catalog says of a layer that is no fault and worth knowing.
  void remark_on(const LayerInfo& info) {
    const std::string place = "layer " + info.name;
    if (info.state == LayerState::kBuilding)
      add(FaultNumber::kLayerBuilding, place, "its build has not come to its end; run the same build again to go on");
    if (!is_registered(info.channel))
      add(FaultNumber::kUnknownChannel, place,
          "its channel has number " + std::to_string(static_cast<unsigned>(info.channel)) +
              (is_private(info.channel) ? ", one of those that users give a meaning of their own"
                                        : ", which this program does not know; a newer program wrote it") +
              ". Its texels are read as plain numbers");
    if (!info.has_known_format())
      add(FaultNumber::kUnknownFormat, place,
          "its texel format has number " + std::to_string(static_cast<unsigned>(info.format)) +
              ", which this program does not know; a newer program wrote it. Its records were checked, but not what they decode to");
  }
  void report_outside(const LayerCheck& check) {
    if (check.outside_data > 0)
      add(FaultNumber::kTileOutsideData, tile_place(check.layer.info, check.first_outside),
          std::to_string(check.outside_data) + " tiles, this one first, have no part in the layer's data rectangle");
  }

  void check_layer(const CatalogLayer& layer) {
    LayerCheck check{.layer = layer};
    const LayerInfo& info = layer.info;
    const std::string place = "layer " + info.name;
    remark_on(info);
    for (int level = 0; level <= info.finest.value; ++level) {
      const Reference& root = layer.roots[static_cast<std::size_t>(level)];
      const Level l{static_cast<std::uint8_t>(level)};
      if (root.present()) check_page_at(check, root, l, top_height(l), 0);
    }
    report_outside(check);
    if (!check.is_whole) return;
    const auto compare = [&](const char* what, std::uint64_t said, std::uint64_t found) {
      if (said != found)
        add(FaultNumber::kLayerCounts, place,
            "the catalog counts " + std::to_string(said) + " " + what + ", the index " + std::to_string(found));
    };
    compare("tiles", info.tiles, check.counted.tiles);
    compare("constant tiles", info.constant_tiles, check.counted.constant_tiles);
    compare("stored bytes", info.stored_bytes, check.counted.stored_bytes);
  }

  // The payload of one page, or nothing and a finding when it is damaged.
  [[nodiscard]] std::optional<std::span<const std::byte>> checked_page(LayerCheck& check, const Reference& reference, Level level,
                                                                       int height, std::uint64_t first_morton) {
    const LayerInfo& info = check.layer.info;
    const std::string place = tile_place(info, tile_from_morton(level, first_morton)) + " and what follows";
    auto payload =
        check_record_at(reference, record_key(info.id, level, first_morton), reference.stored_bytes, FaultNumber::kPageRecord, place);
    if (payload) {
      if (const auto sound = check_page(*payload, level, height, end_); !sound) {
        add(sound.error(), place);
        payload.reset();
      }
    }
    if (!payload) {
      unsound_pages_.insert(reference.offset);
      check.is_whole = false;
      is_index_damaged_ = true;
    }
    return payload;
  }

  void check_page_at(LayerCheck& check, const Reference& reference, Level level, int height, std::uint64_t first_morton) {
    const auto payload = checked_page(check, reference, level, height, first_morton);
    if (!payload) return;
    for (int slot = 0; slot < kPageSlots; ++slot) {
      const Reference entry = page_entry(*payload, slot);
      if (!entry.present()) continue;
      const std::uint64_t morton = first_morton | (static_cast<std::uint64_t>(slot) << (kPageBits * height));
      if (height > 0) {
        check_page_at(check, entry, level, height - 1, morton);
      } else {
        check_tile(check, entry, tile_from_morton(level, morton));
      }
    }
  }

  void check_tile(LayerCheck& check, const Reference& reference, TileId tile) {
    const LayerInfo& info = check.layer.info;
    check.counted.tiles += 1;
    check.counted.stored_bytes += reference.record_bytes();
    report_.tiles_checked += 1;
    if (options_.progress && report_.tiles_checked % 256 == 0)
      options_.progress(report_.tiles_checked, std::max(report_.is_sampled ? options_.sample_tiles : total_, report_.tiles_checked));

    const std::string place = tile_place(info, tile);
    if (!info.tile_rect(tile.level).contains(tile.x, tile.y) && check.outside_data++ == 0) check.first_outside = tile;
    // A build goes from the finest level up, and carry layers keep only what a later build needs; everywhere
    // else a tile has its parent.
    if (info.role == LayerRole::kTexture && info.state == LayerState::kComplete && tile.level.value > 0 &&
        find(check, parent_of(tile)) == Presence::kAbsent)
      add(FaultNumber::kParentAbsent, place, kParentIsAbsent);

    const bool is_constant = reference.kind == ReferenceKind::kConstant;
    check.counted.constant_tiles += is_constant ? 1 : 0;
    // A shared record is checked once for each way in which it is referred to, and counted once in all.
    if (is_shared(reference.kind)) {
      if (!checked_shared_.insert({reference, info.tile_payload_bytes(), info.format}).second) return;
      if (!counted_shared_.insert(reference.offset).second) reachable_bytes_ -= reference.record_bytes();
    }
    if (info.holds_blobs() && reference.kind != ReferenceKind::kTile) return add(FaultNumber::kTileRecord, place, kBlobIsShared);
    const auto record = bytes_.subspan(reference.offset, kRecordHeaderBytes + reference.stored_bytes);
    const std::uint32_t raw_bytes = wanted_raw_bytes(info, reference.kind, record);
    const std::uint64_t key = is_shared(reference.kind) ? 0 : record_key(info.id, tile.level, morton_code(tile.x, tile.y));
    const auto payload = check_record_at(reference, key, raw_bytes, FaultNumber::kTileRecord, place);
    if (!payload || is_constant || !options_.decode_tiles || reference.codec == Codec::kRaw || !info.has_known_format()) return;
    decoded_.resize(raw_bytes);
    const TileShape shape = tile_shape(info.format, info.tile_texels());
    if (const auto decoded = decode_payload(reference.codec, *payload, shape, decoded_); !decoded)
      add(FaultNumber::kTileDecode, place, "record at offset " + std::to_string(reference.offset) + ": " + decoded.error().message);
  }

  // Coarser levels come first, so their pages have been checked before; in a sample they are checked now.
  [[nodiscard]] Presence find(LayerCheck& check, TileId tile) {
    const std::uint64_t morton = morton_code(tile.x, tile.y);
    Reference at = check.layer.roots[tile.level.value];
    for (int height = top_height(tile.level); height >= 0; --height) {
      if (!at.present()) return Presence::kAbsent;
      if (report_.is_sampled) {
        static_cast<void>(known_page(check, at, tile.level, height, page_first_morton(morton, height)));
      }
      if (unsound_pages_.contains(at.offset)) return Presence::kUnknown;
      at = page_entry(bytes_.subspan(at.offset + kRecordHeaderBytes, at.stored_bytes), page_slot(morton, height));
    }
    return at.present() ? Presence::kPresent : Presence::kAbsent;
  }

  const Head& head_;
  std::span<const std::byte> bytes_;
  const ValidateOptions& options_;
  ValidationReport& report_;
  std::uint64_t end_ = 0;
  std::uint64_t total_ = 0;
  std::uint64_t reachable_bytes_ = 0;
  bool is_index_damaged_ = false;
  std::unordered_set<std::uint64_t> unsound_pages_;
  std::unordered_set<std::uint64_t> known_pages_;                             // of a sample: those that were checked
  std::set<std::tuple<Reference, std::size_t, TexelFormat>> checked_shared_;  // and the tile that each was to be
  std::unordered_set<std::uint64_t> counted_shared_;                          // offsets
  std::vector<std::byte> decoded_;
};

}  // namespace

bool ValidationReport::ok() const {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& finding) { return finding.is_error; });
}

Result<ValidationReport> validate(const std::filesystem::path& path, const ValidateOptions& options) {
  VT_ASSIGN(const File file, File::open(path, File::Mode::kRead));
  VT_ASSIGN(Head head, read_head(file));
  for (int attempt = 1;; ++attempt) {
    VT_ASSIGN(const Mapping mapping, Mapping::map(file, head.file_bytes));
    ValidationReport report;
    StoreCheck(head, mapping, options, report).run();
    if (mapping.is_lost())
      return fail(ErrorCode::kIo,
                  path.string() + ": was cut off by another program, or cannot be read from the disk; nothing can be said of it");
    if (std::ranges::none_of(report.findings, may_be_a_writer)) return report;
    // One was, unless the superblocks are still the same.
    VT_ASSIGN(Head again, read_head(file));
    if (again.bytes == head.bytes || attempt == kMostReadings) return report;
    head = std::move(again);
  }
}

}  // namespace vt::store
