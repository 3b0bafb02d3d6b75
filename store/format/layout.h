// The bytes of a store file, structure by structure, as schemas/tile-store.md specifies them: encoding,
// decoding, and every check that one structure can be given by itself. Owns no file and no memory; the
// writer, the reader, the validator and the tests share it. Pure functions, any thread.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "store/codec/codec.h"
#include "store/format/fault.h"
#include "store/io/bytes.h"
#include "store/io/uuid.h"
#include "store/layer.h"

namespace vt::store {

// ---- Constants of the format ----

inline constexpr std::uint32_t kFormatVersion = 4;        // what is written
inline constexpr std::uint32_t kOldestFormatVersion = 1;  // what is read
inline constexpr std::uint32_t kPairedVersion = 4;        // from it on every commit is in both superblocks
inline constexpr std::size_t kSuperblockBytes = 4096;
inline constexpr std::uint64_t kLogStart = 2 * kSuperblockBytes;
inline constexpr std::uint64_t kRecordAlignment = 64;
inline constexpr std::size_t kRecordHeaderBytes = 32;
inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 48;
inline constexpr std::size_t kMaxCatalogBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMaxMetadataBytes = std::size_t{16} << 20;  // of one JSON text
inline constexpr std::size_t kMaxNameBytes = 63;
inline constexpr int kMaxLayers = 4096;  // 12 bits of a key
inline constexpr int kMaxFinest = 23;    // 46 bits of Morton code in a key

inline constexpr int kPageSlots = 1024;  // 10 bits of Morton code a page
inline constexpr int kPageBits = 10;
inline constexpr int kPageSteps = 5;  // levels a page spans
inline constexpr std::size_t kPageHeaderBytes = 16;
inline constexpr std::size_t kPageBitmapBytes = kPageSlots / 8;
inline constexpr std::size_t kPageWords = kPageSlots / 64;
inline constexpr std::size_t kReferenceBytes = 16;
inline constexpr std::size_t kPageBitmapAt = kPageHeaderBytes;
inline constexpr std::size_t kPageRanksAt = kPageBitmapAt + kPageBitmapBytes;
inline constexpr std::size_t kPageEntriesAt = kPageRanksAt + 2 * kPageWords;
inline constexpr std::size_t kMaxPageBytes = kPageEntriesAt + kPageSlots * kReferenceBytes;

[[nodiscard]] constexpr std::uint64_t aligned(std::uint64_t bytes) { return (bytes + kRecordAlignment - 1) & ~(kRecordAlignment - 1); }

// ---- Keys ----

// Interleaves the bits of column (even) and row (odd): tiles near each other on the ground are near each
// other in the index.
[[nodiscard]] constexpr std::uint64_t morton_code(std::uint32_t x, std::uint32_t y) {
  const auto spread = [](std::uint64_t v) {
    v = (v | (v << 16)) & 0x0000FFFF0000FFFF;
    v = (v | (v << 8)) & 0x00FF00FF00FF00FF;
    v = (v | (v << 4)) & 0x0F0F0F0F0F0F0F0F;
    v = (v | (v << 2)) & 0x3333333333333333;
    return (v | (v << 1)) & 0x5555555555555555;
  };
  return spread(x) | (spread(y) << 1);
}
[[nodiscard]] constexpr std::uint32_t morton_column(std::uint64_t code) {
  std::uint64_t v = code & 0x5555555555555555;
  v = (v | (v >> 1)) & 0x3333333333333333;
  v = (v | (v >> 2)) & 0x0F0F0F0F0F0F0F0F;
  v = (v | (v >> 4)) & 0x00FF00FF00FF00FF;
  v = (v | (v >> 8)) & 0x0000FFFF0000FFFF;
  return static_cast<std::uint32_t>(v | (v >> 16));
}
[[nodiscard]] constexpr TileId tile_from_morton(Level level, std::uint64_t code) {
  return {level, morton_column(code), morton_column(code >> 1)};
}
[[nodiscard]] constexpr std::uint64_t record_key(LayerId layer, Level level, std::uint64_t morton) {
  return (std::uint64_t{layer.value} << 52) | (std::uint64_t{level.value} << 46) | morton;
}
// Inside the 2^level x 2^level tiles of its level, and deep enough to have a key.
[[nodiscard]] constexpr bool is_addressable(TileId tile) {
  return tile.level.value <= kMaxFinest && (tile.x >> tile.level.value) == 0 && (tile.y >> tile.level.value) == 0;
}

// A level's index is a radix tree over the Morton code; a page of height 0 is a leaf and holds tiles, one of
// height h holds pages of height h - 1.
[[nodiscard]] constexpr int top_height(Level level) {
  return level.value <= kPageSteps ? 0 : (level.value + kPageSteps - 1) / kPageSteps - 1;
}
[[nodiscard]] constexpr int page_slot(std::uint64_t morton, int height) {
  return static_cast<int>((morton >> (kPageBits * height)) & (kPageSlots - 1));
}
[[nodiscard]] constexpr std::uint64_t page_first_morton(std::uint64_t morton, int height) {
  return (morton >> (kPageBits * (height + 1))) << (kPageBits * (height + 1));
}
// Slots that lie inside the level: the top page of a level that is no multiple of five uses only its first
// few.
[[nodiscard]] constexpr int usable_slots(Level level, int height) {
  const int levels_below = level.value - kPageSteps * height;
  return levels_below >= kPageSteps ? kPageSlots : 1 << (2 * levels_below);
}

// ---- Hash ----

// XXH3-64, seed 0. The one checksum of the format.
[[nodiscard]] std::uint64_t hash_bytes(std::span<const std::byte> bytes);
// The same over two pieces as if they were one.
[[nodiscard]] std::uint64_t hash_bytes(std::span<const std::byte> first, std::span<const std::byte> second);

// ---- References ----

enum class ReferenceKind : std::uint8_t { kAbsent = 0, kTile = 1, kConstant = 2, kPage = 3, kCatalog = 4, kSharedTile = 5 };
// Whether many entries of the index may refer to one record, which then has key 0.
[[nodiscard]] constexpr bool is_shared(ReferenceKind kind) {
  return kind == ReferenceKind::kConstant || kind == ReferenceKind::kSharedTile;
}

struct Reference {
  std::uint64_t offset = 0;        // of the record's first byte
  std::uint32_t stored_bytes = 0;  // of its payload
  std::uint32_t check = 0;         // low half of its hash
  ReferenceKind kind = ReferenceKind::kAbsent;
  Codec codec = Codec::kRaw;
  auto operator<=>(const Reference&) const = default;

  [[nodiscard]] bool present() const { return kind != ReferenceKind::kAbsent; }
  // The whole record with its padding.
  [[nodiscard]] std::uint64_t record_bytes() const { return aligned(kRecordHeaderBytes + std::uint64_t{stored_bytes}); }
};

void put_reference(std::span<std::byte> bytes, std::size_t at, const Reference& reference);
[[nodiscard]] inline Reference get_reference(std::span<const std::byte> bytes, std::size_t at) {
  const std::uint64_t word = get<std::uint64_t>(bytes, at);
  return {.offset = word & (kMaxFileBytes - 1),
          .stored_bytes = get<std::uint32_t>(bytes, at + 8),
          .check = get<std::uint32_t>(bytes, at + 12),
          .kind = static_cast<ReferenceKind>((word >> 48) & 0xFF),
          .codec = static_cast<Codec>(word >> 56)};
}
// A present reference of the wanted kind: a known codec, on a record boundary, whole inside [kLogStart,
// file_end). nullptr when sound, else what is wrong.
[[nodiscard]] const char* reference_fault(const Reference& reference, ReferenceKind wanted, std::uint64_t file_end);

// ---- Records ----

enum class RecordType : std::uint8_t { kTile = 1, kConstant = 2, kPage = 3, kCatalog = 4, kSharedTile = 5 };
[[nodiscard]] constexpr RecordType record_type_of(ReferenceKind kind) { return static_cast<RecordType>(kind); }

struct RecordHeader {
  std::uint64_t hash = 0;
  RecordType type = RecordType::kTile;
  Codec codec = Codec::kRaw;
  std::uint32_t raw_bytes = 0;
  std::uint32_t stored_bytes = 0;
  std::uint64_t key = 0;
};

// Fills in the hash, which covers the rest of the header and the payload.
[[nodiscard]] std::array<std::byte, kRecordHeaderBytes> seal_record(RecordHeader& header, std::span<const std::byte> payload);

// `record` is header and payload, exactly reference.stored_bytes + 32 long. Gives the payload; the sentence
// says what differs from the reference.
[[nodiscard]] tl::expected<std::span<const std::byte>, const char*> check_record(std::span<const std::byte> record,
                                                                                 const Reference& reference, std::uint64_t key,
                                                                                 std::uint32_t raw_bytes);
// The raw_bytes that a record gives for itself, as long as a tile can have so many; never 0. `record` is as
// for check_record.
[[nodiscard]] std::uint32_t stated_raw_bytes(std::span<const std::byte> record);
// The raw_bytes that the record of a tile of `layer` must have: those of a block or of a tile. A blob's
// record, and any record of a layer whose format is not known, may have what it gives for itself.
[[nodiscard]] std::uint32_t wanted_raw_bytes(const LayerInfo& layer, ReferenceKind kind, std::span<const std::byte> record);

// ---- Superblocks ----

// A stretch of the log.
struct Extent {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  auto operator<=>(const Extent&) const = default;
};

struct Superblock {
  std::uint32_t version = kFormatVersion;  // a new catalog is always of kFormatVersion
  Uuid uuid = {};
  std::uint64_t generation = 0;
  std::uint64_t file_end = 0;
  Reference catalog;
  // What a reader that begins with a store may read ahead in one go: the catalog, the upper index and the
  // coarsest tiles, as `pack` lays them out. A hint and no more: nothing is wrong when there is none (both
  // 0), or when later commits have moved some of it.
  Extent cold_start;
  // Space for catalogs: what lies behind the catalog's record for it to grow into, and where a later catalog
  // may go, which is where an earlier one lay. Hints: a writer looks at what is there before it writes.
  std::uint64_t catalog_space = 0;  // bytes from the catalog's offset on; 0: no more than its record
  Extent spare_catalog;

  // Its writer keeps every commit in both superblocks, so that this one is enough when the other is damaged.
  // Programs that know no later version than 3, which do not, refuse such a store.
  [[nodiscard]] bool is_paired() const { return version >= kPairedVersion; }
};

// Even generations lie in slot 0 (offset 0), odd ones in slot 1 (offset 4096).
[[nodiscard]] constexpr std::uint64_t superblock_offset(std::uint64_t generation) { return (generation & 1) * kSuperblockBytes; }
[[nodiscard]] std::array<std::byte, kSuperblockBytes> encode_superblock(const Superblock& superblock);
[[nodiscard]] Checked<Superblock> decode_superblock(std::span<const std::byte> block, int slot);

struct ChosenSuperblock {
  Superblock newest;
  std::optional<Superblock> other;  // nothing when its hash is wrong...
  std::optional<Fault> damage;      // ...and then this
  bool may_be_older = false;        // the damaged one may have held a later generation that had been committed

  // Both are whole and hold one state.
  [[nodiscard]] bool is_pair() const;
  // A sentence for people; empty when both are whole.
  [[nodiscard]] std::string remark() const;
};
// The newest whole generation out of the file's first 8 KiB (fewer in a truncated file). Only a superblock
// whose hash is wrong is passed over, as a crash leaves it; one that is whole but promises what the file does
// not hold is an error, never silently replaced by an older generation.
[[nodiscard]] Checked<ChosenSuperblock> choose_superblock(std::span<const std::byte> head, std::uint64_t file_bytes);

// ---- Index pages ----

// `entries` has one reference for every slot, absent ones included; at least one is present.
[[nodiscard]] std::vector<std::byte> encode_page(std::span<const Reference> entries, int height);
// Everything that can be said of a page by itself: sizes, ranks, kinds and extents of its entries.
[[nodiscard]] Checked<void> check_page(std::span<const std::byte> payload, Level level, int height, std::uint64_t file_end);

// Which of the present slots of a page this one is; check_page has passed the page. `payload` may end with
// the ranks.
[[nodiscard]] inline std::optional<std::size_t> page_entry_number(std::span<const std::byte> payload, int slot) {
  const std::size_t word_index = static_cast<std::size_t>(slot) / 64;
  const std::uint64_t word = get<std::uint64_t>(payload, kPageBitmapAt + 8 * word_index);
  const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
  if ((word & bit) == 0) return std::nullopt;
  return get<std::uint16_t>(payload, kPageRanksAt + 2 * word_index) + static_cast<std::size_t>(std::popcount(word & (bit - 1)));
}
// Lookup in such a page.
[[nodiscard]] inline Reference page_entry(std::span<const std::byte> payload, int slot) {
  const auto number = page_entry_number(payload, slot);
  return number ? get_reference(payload, kPageEntriesAt + kReferenceBytes * *number) : Reference{};
}

}  // namespace vt::store
