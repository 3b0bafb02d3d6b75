#include "store/format/layout.h"

#include <algorithm>
#include <string_view>

#include "store/format/text.h"
#include "store/io/xxh3.h"

namespace vt::store {
namespace {

constexpr std::string_view kSuperblockMagic = "VTSTORE1";
constexpr std::uint32_t kRecordMagic = 0x43525456;  // "VTRC"

// Offsets in the superblock.
constexpr std::size_t kSuperblockReservedAt = 128;
constexpr std::size_t kSuperblockHashAt = kSuperblockBytes - 8;

}  // namespace

// ---- Hash ----

std::uint64_t hash_bytes(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::uint64_t hash_bytes(std::span<const std::byte> first, std::span<const std::byte> second) {
  XXH3_state_t state;
  XXH3_64bits_reset(&state);
  XXH3_64bits_update(&state, first.data(), first.size());
  XXH3_64bits_update(&state, second.data(), second.size());
  return XXH3_64bits_digest(&state);
}

// ---- References ----

void put_reference(std::span<std::byte> bytes, std::size_t at, const Reference& reference) {
  put<std::uint64_t>(bytes, at,
                     reference.offset | (std::uint64_t{static_cast<std::uint8_t>(reference.kind)} << 48) |
                         (std::uint64_t{static_cast<std::uint8_t>(reference.codec)} << 56));
  put<std::uint32_t>(bytes, at + 8, reference.stored_bytes);
  put<std::uint32_t>(bytes, at + 12, reference.check);
}

const char* reference_fault(const Reference& reference, ReferenceKind wanted, std::uint64_t file_end) {
  if (reference.kind != wanted) return "reference is of the wrong kind";
  const bool is_compressed = reference.codec == Codec::kZstd || reference.codec == Codec::kPredictedZstd;
  if (reference.codec != Codec::kRaw && !(is_compressed && (wanted == ReferenceKind::kTile || wanted == ReferenceKind::kSharedTile)))
    return "reference names a codec that is not allowed there";
  if (wanted != ReferenceKind::kPage && wanted != ReferenceKind::kCatalog && reference.stored_bytes > kMaxRawBytes)
    return "reference to a tile of over 256 MiB";
  if (reference.offset % kRecordAlignment != 0) return "reference points between records";
  if (reference.offset < kLogStart || reference.offset > file_end || reference.record_bytes() > file_end - reference.offset)
    return "reference points outside the file";
  return nullptr;
}

// ---- Records ----
//
//   0 u64 hash of everything after it    8 u32 magic    12 u8 type    13 u8 codec    14 u16 reserved
//  16 u32 raw bytes                     20 u32 stored bytes          24 u64 key     32 payload

std::array<std::byte, kRecordHeaderBytes> seal_record(RecordHeader& header, std::span<const std::byte> payload) {
  std::array<std::byte, kRecordHeaderBytes> bytes = {};
  put<std::uint32_t>(bytes, 8, kRecordMagic);
  put<std::uint8_t>(bytes, 12, static_cast<std::uint8_t>(header.type));
  put<std::uint8_t>(bytes, 13, static_cast<std::uint8_t>(header.codec));
  put<std::uint32_t>(bytes, 16, header.raw_bytes);
  put<std::uint32_t>(bytes, 20, header.stored_bytes);
  put<std::uint64_t>(bytes, 24, header.key);
  header.hash = hash_bytes(std::span(bytes).subspan(8), payload);
  put<std::uint64_t>(bytes, 0, header.hash);
  return bytes;
}

tl::expected<std::span<const std::byte>, const char*> check_record(std::span<const std::byte> record, const Reference& reference,
                                                                   std::uint64_t key, std::uint32_t raw_bytes) {
  const auto wrong = [](const char* sentence) { return tl::unexpected<const char*>(sentence); };
  assert(record.size() == kRecordHeaderBytes + reference.stored_bytes);
  const std::uint64_t hash = get<std::uint64_t>(record, 0);
  // The checksum comes first: a flipped bit is damage, whatever field it hits.
  if (static_cast<std::uint32_t>(hash) != reference.check) return wrong("its checksum differs from the one its reference gives");
  if (hash_bytes(record.subspan(8)) != hash) return wrong("its checksum differs");
  if (get<std::uint32_t>(record, 8) != kRecordMagic) return wrong("its header has no record magic");
  if (get<std::uint8_t>(record, 12) != static_cast<std::uint8_t>(record_type_of(reference.kind)))
    return wrong("it is a record of another type");
  if (get<std::uint8_t>(record, 13) != static_cast<std::uint8_t>(reference.codec)) return wrong("its codec differs from its reference");
  if (get<std::uint16_t>(record, 14) != 0) return wrong("its header has reserved bits set");
  if (get<std::uint32_t>(record, 16) != raw_bytes) return wrong("its raw size is not what the layer's format asks for");
  if (get<std::uint32_t>(record, 20) != reference.stored_bytes) return wrong("its stored size differs from its reference");
  if (get<std::uint64_t>(record, 24) != key) return wrong("it carries the key of something else");
  if (reference.codec == Codec::kRaw && reference.stored_bytes != raw_bytes)
    return wrong("it is stored raw, with another size than its raw size");
  return record.subspan(kRecordHeaderBytes);
}

std::uint32_t stated_raw_bytes(std::span<const std::byte> record) {
  return std::clamp<std::uint32_t>(get<std::uint32_t>(record, 16), 1, kMaxRawBytes);
}

std::uint32_t wanted_raw_bytes(const LayerInfo& layer, ReferenceKind kind, std::span<const std::byte> record) {
  if (layer.holds_blobs() || !layer.has_known_format()) return stated_raw_bytes(record);
  return kind == ReferenceKind::kConstant ? format_info(layer.format).block_bytes : static_cast<std::uint32_t>(layer.tile_payload_bytes());
}

// ---- Superblocks ----
//
//   0 "VTSTORE1"    8 u32 version    12 u32 reserved    16 uuid    32 u64 generation    40 u64 file end    48 catalog reference
// 64 u64 cold start's offset   72 u64 its bytes   80 ignorable   88 u64 catalog space   96 u64 spare
// catalog's offset   104 u64 its bytes 112 ignorable   128 reserved   4088 u64 hash of bytes 0..4087

std::array<std::byte, kSuperblockBytes> encode_superblock(const Superblock& superblock) {
  std::array<std::byte, kSuperblockBytes> block = {};
  put_text(block, 0, kSuperblockMagic);
  put<std::uint32_t>(block, 8, superblock.version);
  std::copy(superblock.uuid.begin(), superblock.uuid.end(), block.begin() + 16);
  put<std::uint64_t>(block, 32, superblock.generation);
  put<std::uint64_t>(block, 40, superblock.file_end);
  put_reference(block, 48, superblock.catalog);
  put<std::uint64_t>(block, 64, superblock.cold_start.offset);
  put<std::uint64_t>(block, 72, superblock.cold_start.bytes);
  put<std::uint64_t>(block, 88, superblock.catalog_space);
  put<std::uint64_t>(block, 96, superblock.spare_catalog.offset);
  put<std::uint64_t>(block, 104, superblock.spare_catalog.bytes);
  put<std::uint64_t>(block, kSuperblockHashAt, hash_bytes(std::span(block).first(kSuperblockHashAt)));
  return block;
}

Checked<Superblock> decode_superblock(std::span<const std::byte> block, int slot) {
  const std::string name = slot == 0 ? "superblock A" : "superblock B";
  if (block.size() != kSuperblockBytes)
    return fault(FaultNumber::kSuperblockDamaged, ErrorCode::kCorrupt, name + " is cut off by the end of the file");
  if (get_text(block, 0, 8) != kSuperblockMagic)
    return fault(FaultNumber::kSuperblockDamaged, ErrorCode::kInvalidData, name + " does not begin with \"VTSTORE1\"");
  if (get<std::uint64_t>(block, kSuperblockHashAt) != hash_bytes(block.first(kSuperblockHashAt)))
    return fault(FaultNumber::kSuperblockDamaged, ErrorCode::kCorrupt, name + ": its checksum differs");
  if (const auto version = get<std::uint32_t>(block, 8); version < kOldestFormatVersion || version > kFormatVersion)
    return fault(FaultNumber::kVersion, ErrorCode::kUnsupported,
                 name + " says format version " + number(version) + ", this program reads versions " + number(kOldestFormatVersion) +
                     " to " + number(kFormatVersion) + "; use a newer program");
  if (get<std::uint32_t>(block, 12) != 0 || !all_zero(block.subspan(kSuperblockReservedAt, kSuperblockHashAt - kSuperblockReservedAt)))
    return fault(FaultNumber::kSuperblockReserved, ErrorCode::kUnsupported,
                 name + " has reserved bytes set: a feature this program does not know");

  Superblock superblock{.version = get<std::uint32_t>(block, 8),
                        .generation = get<std::uint64_t>(block, 32),
                        .file_end = get<std::uint64_t>(block, 40),
                        .catalog = get_reference(block, 48)};
  std::copy_n(block.begin() + 16, superblock.uuid.size(), superblock.uuid.begin());
  if (static_cast<int>(superblock.generation & 1) != slot)
    return fault(FaultNumber::kSuperblockField, ErrorCode::kInvalidData,
                 name + " holds generation " + number(superblock.generation) + ", which belongs in the other one");
  if (superblock.file_end < kLogStart || superblock.file_end > kMaxFileBytes || superblock.file_end % kRecordAlignment != 0)
    return fault(FaultNumber::kSuperblockField, ErrorCode::kInvalidData,
                 name + " gives the file's end as " + number(superblock.file_end) + ", which cannot be");
  if (const char* wrong = reference_fault(superblock.catalog, ReferenceKind::kCatalog, superblock.file_end); wrong != nullptr)
    return fault(FaultNumber::kCatalogReference, ErrorCode::kInvalidData, name + ", catalog: " + wrong);
  if (superblock.catalog.stored_bytes > kMaxCatalogBytes)
    return fault(FaultNumber::kCatalogReference, ErrorCode::kInvalidData, name + ", catalog: over 64 MiB");
  // Ignorable bytes: an extent that makes no sense is none.
  const auto hint_at = [&](std::size_t at) {
    const Extent hint{.offset = get<std::uint64_t>(block, at), .bytes = get<std::uint64_t>(block, at + 8)};
    const bool is_inside =
        hint.offset >= kLogStart && hint.offset <= superblock.file_end && hint.bytes <= superblock.file_end - hint.offset;
    return is_inside ? hint : Extent{};
  };
  superblock.cold_start = hint_at(64);
  superblock.spare_catalog = hint_at(96);
  if (const auto space = get<std::uint64_t>(block, 88); space <= superblock.file_end - superblock.catalog.offset)
    superblock.catalog_space = space;
  return superblock;
}

Checked<ChosenSuperblock> choose_superblock(std::span<const std::byte> head, std::uint64_t file_bytes) {
  std::vector<Superblock> whole;  // the newest first
  std::optional<Fault> damage;
  for (int slot = 0; slot < 2; ++slot) {
    const std::size_t at = static_cast<std::size_t>(slot) * kSuperblockBytes;
    const auto block = head.subspan(std::min(at, head.size()));
    auto superblock = decode_superblock(block.first(std::min(kSuperblockBytes, block.size())), slot);
    if (superblock) {
      whole.push_back(*superblock);
    } else if (superblock.error().number != FaultNumber::kSuperblockDamaged) {
      return tl::unexpected(superblock.error());
    } else if (!damage) {
      damage = superblock.error();
    }
  }
  if (whole.empty()) {
    if (head.size() < kLogStart)
      return fault(FaultNumber::kNoSuperblock, ErrorCode::kInvalidData,
                   "not a tile store: " + number(file_bytes) + " bytes, at least 8192 wanted");
    const bool is_foreign = damage->code == ErrorCode::kInvalidData;
    return fault(FaultNumber::kNoSuperblock, is_foreign ? ErrorCode::kInvalidData : ErrorCode::kCorrupt,
                 (is_foreign ? "not a tile store, or both superblocks are lost: " : "both superblocks are damaged: ") + damage->sentence);
  }
  if (whole.size() == 2 && whole[0].uuid != whole[1].uuid)
    return fault(FaultNumber::kForeignSuperblock, ErrorCode::kInvalidData,
                 "the two superblocks belong to different stores (their UUIDs differ)");
  if (whole.size() == 2 && whole[1].generation > whole[0].generation) std::swap(whole[0], whole[1]);

  ChosenSuperblock chosen{.newest = whole[0], .damage = std::move(damage)};
  if (whole.size() == 2) chosen.other = whole[1];
  if (chosen.newest.file_end > file_bytes)
    return fault(FaultNumber::kFileTruncated, ErrorCode::kCorrupt,
                 "the file has " + number(file_bytes) + " bytes, generation " + number(chosen.newest.generation) + " needs " +
                     number(chosen.newest.file_end) + "; it was truncated, or copied while incomplete");
  // One of a pair holds the last commit, whatever became of the other. If it is not one of a pair, the other
  // may have held a later commit, whose records would lie behind this one's.
  chosen.may_be_older = chosen.damage && !chosen.newest.is_paired() && file_bytes > chosen.newest.file_end;
  return chosen;
}

bool ChosenSuperblock::is_pair() const {
  return other && newest.is_paired() && other->is_paired() && newest.generation == other->generation + 1 &&
         newest.catalog == other->catalog && newest.file_end == other->file_end;
}

std::string ChosenSuperblock::remark() const {
  if (!damage) return {};
  if (!may_be_older) return damage->sentence + "; the other one holds the last commit, so nothing is lost, and the next writer mends it";
  return damage->sentence + "; it may have held a generation after " + number(newest.generation) +
         ", so what is read may be older than the last update. Restore the file from a copy; packing it into a new store keeps what "
         "generation " +
         number(newest.generation) + " holds";
}

// ---- Index pages ----
//
//   0 u16 entries   2 u8 height   3 13 reserved   16 presence, 1024 bits   144 16 x u16 ranks   176 entries

std::vector<std::byte> encode_page(std::span<const Reference> entries, int height) {
  assert(entries.size() == kPageSlots);
  std::array<std::uint64_t, kPageWords> present = {};
  std::uint16_t count = 0;
  std::vector<std::byte> out(kMaxPageBytes);
  for (std::size_t slot = 0; slot < kPageSlots; ++slot) {
    if (slot % 64 == 0) put<std::uint16_t>(out, kPageRanksAt + 2 * (slot / 64), count);
    if (!entries[slot].present()) continue;
    present[slot / 64] |= std::uint64_t{1} << (slot % 64);
    put_reference(out, kPageEntriesAt + kReferenceBytes * count, entries[slot]);
    ++count;
  }
  assert(count > 0);
  put<std::uint16_t>(out, 0, count);
  put<std::uint8_t>(out, 2, static_cast<std::uint8_t>(height));
  for (std::size_t word = 0; word < kPageWords; ++word) put<std::uint64_t>(out, kPageBitmapAt + 8 * word, present[word]);
  out.resize(kPageEntriesAt + kReferenceBytes * count);
  return out;
}

Checked<void> check_page(std::span<const std::byte> payload, Level level, int height, std::uint64_t file_end) {
  const auto broken = [](std::string sentence) {
    return fault(FaultNumber::kPageStructure, ErrorCode::kInvalidData, "index page: " + std::move(sentence));
  };
  if (payload.size() < kPageEntriesAt + kReferenceBytes || payload.size() > kMaxPageBytes)
    return broken("its size cannot be " + number(payload.size()) + " bytes");
  const std::size_t count = get<std::uint16_t>(payload, 0);
  if (payload.size() != kPageEntriesAt + kReferenceBytes * count) return broken("its size does not fit its " + number(count) + " entries");
  if (get<std::uint8_t>(payload, 2) != height) return broken("its height is not " + number(height));
  if (!all_zero(payload.subspan(3, kPageHeaderBytes - 3))) return broken("reserved bytes are set");

  const auto usable = static_cast<std::size_t>(usable_slots(level, height));
  std::size_t rank = 0;
  for (std::size_t word_index = 0; word_index < kPageWords; ++word_index) {
    const auto word = get<std::uint64_t>(payload, kPageBitmapAt + 8 * word_index);
    if (get<std::uint16_t>(payload, kPageRanksAt + 2 * word_index) != rank)
      return broken("a rank differs from the presence bits before it");
    const std::size_t usable_here = usable > 64 * word_index ? std::min<std::size_t>(64, usable - 64 * word_index) : 0;
    if (usable_here < 64 && (word >> usable_here) != 0) return broken("an entry lies outside the level");
    rank += static_cast<std::size_t>(std::popcount(word));
  }
  if (rank != count) return broken("it says " + number(count) + " entries and marks " + number(rank));

  for (std::size_t i = 0; i < count; ++i) {
    const Reference entry = get_reference(payload, kPageEntriesAt + kReferenceBytes * i);
    const ReferenceKind wanted = height > 0 ? ReferenceKind::kPage : is_shared(entry.kind) ? entry.kind : ReferenceKind::kTile;
    if (const char* wrong = reference_fault(entry, wanted, file_end); wrong != nullptr)
      return fault(FaultNumber::kPageEntry, ErrorCode::kInvalidData, "index page, entry " + number(i) + ": " + wrong);
  }
  return {};
}

}  // namespace vt::store
