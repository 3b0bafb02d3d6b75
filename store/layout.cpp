#include "store/layout.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "store/xxh3.h"

namespace vt::store {
namespace {

constexpr std::string_view kSuperblockMagic = "VTSTORE1";
constexpr std::uint32_t kRecordMagic = 0x43525456;  // "VTRC"

// Offsets in the superblock.
constexpr std::size_t kSuperblockReservedAt = 128;
constexpr std::size_t kSuperblockHashAt = kSuperblockBytes - 8;

// Sizes in the catalog.
constexpr std::size_t kCatalogHeaderBytes = 48;
constexpr std::size_t kCatalogLayerBytes = 128;

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xC2 && lead < 0xE0 ? 2
                               : lead >= 0xE0 && lead < 0xF0 ? 3
                               : lead >= 0xF0 && lead < 0xF5 ? 4
                                                             : 0;
    if (length == 0 || length > text.size() - i) return false;
    for (std::size_t k = 1; k < length; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0) != 0x80) return false;
    const auto second = static_cast<unsigned char>(length > 1 ? text[i + 1] : 0);
    if ((lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) || (lead == 0xF0 && second < 0x90) ||
        (lead == 0xF4 && second > 0x8F))
      return false;
    i += length;
  }
  return true;
}

bool is_name(std::string_view name) {
  if (name.empty() || name.size() > kMaxNameBytes || !is_utf8(name)) return false;
  return std::none_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

std::string number(auto value) { return std::to_string(value); }

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

// ---- Superblocks ----
//
//   0 "VTSTORE1"    8 u32 version    12 u32 reserved    16 uuid    32 u64 generation    40 u64 file end    48 catalog reference
//  64 u64 cold start's offset   72 u64 its bytes   80 ignorable   128 reserved   4088 u64 hash of bytes 0..4087

std::array<std::byte, kSuperblockBytes> encode_superblock(const Superblock& superblock) {
  std::array<std::byte, kSuperblockBytes> block = {};
  put_text(block, 0, kSuperblockMagic);
  put<std::uint32_t>(block, 8, kFormatVersion);
  std::copy(superblock.uuid.begin(), superblock.uuid.end(), block.begin() + 16);
  put<std::uint64_t>(block, 32, superblock.generation);
  put<std::uint64_t>(block, 40, superblock.file_end);
  put_reference(block, 48, superblock.catalog);
  put<std::uint64_t>(block, 64, superblock.cold_start.offset);
  put<std::uint64_t>(block, 72, superblock.cold_start.bytes);
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

  Superblock superblock{
      .generation = get<std::uint64_t>(block, 32), .file_end = get<std::uint64_t>(block, 40), .catalog = get_reference(block, 48)};
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
  const ColdStart hint{.offset = get<std::uint64_t>(block, 64), .bytes = get<std::uint64_t>(block, 72)};
  if (hint.offset >= kLogStart && hint.offset <= superblock.file_end && hint.bytes <= superblock.file_end - hint.offset)
    superblock.cold_start = hint;
  return superblock;
}

Checked<Superblock> choose_superblock(std::span<const std::byte> head, std::uint64_t file_bytes) {
  std::optional<Superblock> newest;
  std::optional<Fault> first_damage;
  for (int slot = 0; slot < 2; ++slot) {
    const std::size_t at = static_cast<std::size_t>(slot) * kSuperblockBytes;
    const auto block = head.subspan(std::min(at, head.size()));
    auto superblock = decode_superblock(block.first(std::min(kSuperblockBytes, block.size())), slot);
    if (!superblock) {
      if (superblock.error().number != FaultNumber::kSuperblockDamaged) return superblock;
      if (!first_damage) first_damage = superblock.error();
      continue;
    }
    if (newest && newest->uuid != superblock->uuid)
      return fault(FaultNumber::kForeignSuperblock, ErrorCode::kInvalidData,
                   "the two superblocks belong to different stores (their UUIDs differ)");
    if (!newest || superblock->generation > newest->generation) newest = *superblock;
  }
  if (!newest) {
    if (head.size() < kLogStart)
      return fault(FaultNumber::kNoSuperblock, ErrorCode::kInvalidData,
                   "not a tile store: " + number(file_bytes) + " bytes, at least 8192 wanted");
    const bool is_foreign = first_damage->code == ErrorCode::kInvalidData;
    return fault(
        FaultNumber::kNoSuperblock, is_foreign ? ErrorCode::kInvalidData : ErrorCode::kCorrupt,
        (is_foreign ? "not a tile store, or both superblocks are lost: " : "both superblocks are damaged: ") + first_damage->sentence);
  }
  if (newest->file_end > file_bytes)
    return fault(FaultNumber::kFileTruncated, ErrorCode::kCorrupt,
                 "the file has " + number(file_bytes) + " bytes, generation " + number(newest->generation) + " needs " +
                     number(newest->file_end) + "; it was truncated, or copied while incomplete");
  return *newest;
}

// ---- Catalog ----
//
// header   0 u32 layers   4 u32 metadata bytes   8 f64 west   16 south   24 east   32 north   40 u64 reserved
// then one 128-byte entry a layer, then the roots of all layers, then the texts: metadata, and name and metadata of each layer.

std::string description_fault(const StoreDescription& description) {
  const Area& area = description.area;
  for (const double edge : {area.west, area.south, area.east, area.north})
    if (!std::isfinite(edge)) return "an edge of the area is not a finite number";
  if (!(area.west < area.east)) return "the area's west edge is not west of its east edge (longitudes are unwrapped: east may be over 180)";
  if (!(area.south < area.north)) return "the area's south edge is not south of its north edge";
  if (description.metadata_json.size() > kMaxMetadataBytes) return "the dataset's metadata is over 16 MiB";
  if (!is_utf8(description.metadata_json)) return "the dataset's metadata is not UTF-8";
  return {};
}

std::string layer_fault(const LayerInfo& info) {
  if (info.id.value >= kMaxLayers) return "id " + number(info.id.value) + " is over 4095";
  if (!is_name(info.name)) return "a name is 1 to 63 bytes of UTF-8 without control characters";
  if (!channel_from_number(static_cast<std::uint16_t>(info.channel)))
    return "channel type " + number(static_cast<int>(info.channel)) + " is not known";
  if (!format_from_number(static_cast<std::uint16_t>(info.format)))
    return "texel format " + number(static_cast<int>(info.format)) + " is not known";
  if (info.transfer != Transfer::kLinear && info.transfer != Transfer::kSrgb)
    return "transfer function " + number(static_cast<int>(info.transfer)) + " is not known";
  if (info.role != LayerRole::kTexture && info.role != LayerRole::kCarry)
    return "role " + number(static_cast<int>(info.role)) + " is not known";
  if (info.state != LayerState::kBuilding && info.state != LayerState::kComplete)
    return "state " + number(static_cast<int>(info.state)) + " is not known";
  if (info.role == LayerRole::kTexture && info.owner.value != 0) return "only a carry layer has an owner";
  if (info.tile_exponent < kMinTileExponent || info.tile_exponent > kMaxTileExponent)
    return "tile exponent " + number(info.tile_exponent) + " is not 2 to 12";
  if (info.finest.value > kMaxFinest || info.vt_exponent() > kMaxVtExponent)
    return "finest level " + number(info.finest.value) + " is over 23, or gives more than 2^31 texels a side";
  const std::int64_t side = std::int64_t{1} << info.vt_exponent();
  const TexelRect& data = info.data;
  if (data.x < 0 || data.y < 0 || data.width < 1 || data.height < 1 || data.x >= side || data.y >= side || data.width > side - data.x ||
      data.height > side - data.y)
    return "the data rectangle is empty or reaches outside the padded square of " + number(side) + " texels";
  const GridPlacement& grid = info.grid;
  for (const double value : {grid.origin_x, grid.origin_y, grid.step_x, grid.step_y})
    if (!std::isfinite(value)) return "the grid placement is not finite";
  if (!(grid.step_x > 0.0) || !(grid.step_y > 0.0)) return "a grid step is not above zero";
  if (info.metadata_json.size() > kMaxMetadataBytes) return "the layer's metadata is over 16 MiB";
  if (!is_utf8(info.metadata_json)) return "the layer's metadata is not UTF-8";
  if (info.constant_tiles > info.tiles) return "it counts more constant tiles than tiles";
  return {};
}

Result<std::vector<std::byte>> encode_catalog(const Catalog& catalog) {
  std::size_t roots_at = kCatalogHeaderBytes + kCatalogLayerBytes * catalog.layers.size();
  std::size_t texts_at = roots_at;
  for (const CatalogLayer& layer : catalog.layers) texts_at += kReferenceBytes * layer.roots.size();
  std::size_t total = texts_at + catalog.description.metadata_json.size();
  for (const CatalogLayer& layer : catalog.layers) total += layer.info.name.size() + layer.info.metadata_json.size();
  if (total > kMaxCatalogBytes)
    return fail(ErrorCode::kInvalidData,
                "layers and metadata take " + number(total) + " bytes, over the limit of 64 MiB; shorten the metadata");

  std::vector<std::byte> out(total);
  const auto put_next_text = [&](std::string_view text) {
    put_text(out, texts_at, text);
    texts_at += text.size();
  };
  put<std::uint32_t>(out, 0, static_cast<std::uint32_t>(catalog.layers.size()));
  put<std::uint32_t>(out, 4, static_cast<std::uint32_t>(catalog.description.metadata_json.size()));
  put_f64(out, 8, catalog.description.area.west);
  put_f64(out, 16, catalog.description.area.south);
  put_f64(out, 24, catalog.description.area.east);
  put_f64(out, 32, catalog.description.area.north);
  put_next_text(catalog.description.metadata_json);

  std::size_t at = kCatalogHeaderBytes;
  for (const CatalogLayer& layer : catalog.layers) {
    const LayerInfo& info = layer.info;
    const std::span<std::byte> entry = std::span(out).subspan(at, kCatalogLayerBytes);
    put<std::uint16_t>(entry, 0, info.id.value);
    put<std::uint16_t>(entry, 2, static_cast<std::uint16_t>(info.channel));
    put<std::uint16_t>(entry, 4, static_cast<std::uint16_t>(info.format));
    put<std::uint8_t>(entry, 6, static_cast<std::uint8_t>(info.transfer));
    put<std::uint8_t>(entry, 7, static_cast<std::uint8_t>(info.role));
    put<std::uint8_t>(entry, 8, static_cast<std::uint8_t>(info.state));
    put<std::uint8_t>(entry, 9, info.tile_exponent);
    put<std::uint8_t>(entry, 10, info.finest.value);
    put<std::uint8_t>(entry, 11, static_cast<std::uint8_t>(info.name.size()));
    put<std::uint16_t>(entry, 12, info.owner.value);
    // 14 u8 reserved, 15 u8 ignorable
    put<std::uint32_t>(entry, 16, static_cast<std::uint32_t>(info.metadata_json.size()));
    // 20 u32 reserved
    put_i64(entry, 24, info.data.x);
    put_i64(entry, 32, info.data.y);
    put_i64(entry, 40, info.data.width);
    put_i64(entry, 48, info.data.height);
    put_f64(entry, 56, info.grid.origin_x);
    put_f64(entry, 64, info.grid.origin_y);
    put_f64(entry, 72, info.grid.step_x);
    put_f64(entry, 80, info.grid.step_y);
    put_f64(entry, 88, info.source_nodata);
    put<std::uint64_t>(entry, 96, info.tiles);
    put<std::uint64_t>(entry, 104, info.constant_tiles);
    put<std::uint64_t>(entry, 112, info.stored_bytes);
    // 120 u64 reserved
    at += kCatalogLayerBytes;

    for (const Reference& root : layer.roots) {
      put_reference(out, roots_at, root);
      roots_at += kReferenceBytes;
    }
    put_next_text(info.name);
    put_next_text(info.metadata_json);
  }
  assert(texts_at == total);
  return out;
}

Checked<Catalog> decode_catalog(std::span<const std::byte> payload, std::uint64_t file_end) {
  const auto broken = [](const std::string& sentence) {
    return fault(FaultNumber::kCatalogStructure, ErrorCode::kInvalidData, "catalog: " + sentence);
  };
  const auto too_short = [&] { return broken("ends before its counts say, at " + number(payload.size()) + " bytes"); };

  if (payload.size() < kCatalogHeaderBytes) return too_short();
  const std::size_t layer_count = get<std::uint32_t>(payload, 0);
  const std::size_t metadata_bytes = get<std::uint32_t>(payload, 4);
  if (layer_count > kMaxLayers) return broken(number(layer_count) + " layers, at most 4096 wanted");
  if (get<std::uint64_t>(payload, 40) != 0) return broken("reserved bytes are set");
  if (payload.size() < kCatalogHeaderBytes + kCatalogLayerBytes * layer_count) return too_short();

  Catalog catalog;
  catalog.description.area = {
      .west = get_f64(payload, 8), .south = get_f64(payload, 16), .east = get_f64(payload, 24), .north = get_f64(payload, 32)};

  // First the fixed entries, so that the places of roots and texts are known.
  std::size_t roots_at = kCatalogHeaderBytes + kCatalogLayerBytes * layer_count;
  std::size_t texts_at = roots_at;
  std::size_t text_bytes = metadata_bytes;
  for (std::size_t i = 0; i < layer_count; ++i) {
    const auto entry = payload.subspan(kCatalogHeaderBytes + kCatalogLayerBytes * i, kCatalogLayerBytes);
    const std::size_t finest = get<std::uint8_t>(entry, 10);
    if (finest > kMaxFinest)
      return fault(FaultNumber::kLayerField, ErrorCode::kInvalidData,
                   "catalog, layer entry " + number(i) + ": finest level " + number(finest) + " is over 23");
    if (get<std::uint8_t>(entry, 14) != 0 || get<std::uint32_t>(entry, 20) != 0 || get<std::uint64_t>(entry, 120) != 0)
      return broken("layer entry " + number(i) + " has reserved bytes set");
    texts_at += kReferenceBytes * (finest + 1);
    text_bytes += std::size_t{get<std::uint8_t>(entry, 11)} + get<std::uint32_t>(entry, 16);
  }
  if (payload.size() < texts_at || payload.size() - texts_at != text_bytes)
    return broken("has " + number(payload.size()) + " bytes, its counts add up to " + number(texts_at + text_bytes));

  const auto next_text = [&](std::size_t bytes) {
    const std::string_view text = get_text(payload, texts_at, bytes);
    texts_at += bytes;
    return std::string(text);
  };
  catalog.description.metadata_json = next_text(metadata_bytes);
  if (const std::string wrong = description_fault(catalog.description); !wrong.empty()) return broken(wrong);

  std::set<std::string> names;
  for (std::size_t i = 0; i < layer_count; ++i) {
    const auto entry = payload.subspan(kCatalogHeaderBytes + kCatalogLayerBytes * i, kCatalogLayerBytes);
    CatalogLayer layer;
    LayerInfo& info = layer.info;
    info.id = {get<std::uint16_t>(entry, 0)};
    info.channel = static_cast<ChannelType>(get<std::uint16_t>(entry, 2));
    info.format = static_cast<TexelFormat>(get<std::uint16_t>(entry, 4));
    info.transfer = static_cast<Transfer>(get<std::uint8_t>(entry, 6));
    info.role = static_cast<LayerRole>(get<std::uint8_t>(entry, 7));
    info.state = static_cast<LayerState>(get<std::uint8_t>(entry, 8));
    info.tile_exponent = get<std::uint8_t>(entry, 9);
    info.finest = {get<std::uint8_t>(entry, 10)};
    info.name = next_text(get<std::uint8_t>(entry, 11));
    info.owner = {get<std::uint16_t>(entry, 12)};
    info.metadata_json = next_text(get<std::uint32_t>(entry, 16));
    info.data = {get_i64(entry, 24), get_i64(entry, 32), get_i64(entry, 40), get_i64(entry, 48)};
    info.grid = {get_f64(entry, 56), get_f64(entry, 64), get_f64(entry, 72), get_f64(entry, 80)};
    info.source_nodata = get_f64(entry, 88);
    info.tiles = get<std::uint64_t>(entry, 96);
    info.constant_tiles = get<std::uint64_t>(entry, 104);
    info.stored_bytes = get<std::uint64_t>(entry, 112);

    const std::string place = "catalog, layer " + number(info.id.value);
    if (const std::string wrong = layer_fault(info); !wrong.empty())
      return fault(FaultNumber::kLayerField, ErrorCode::kInvalidData, place + ": " + wrong);
    if (!catalog.layers.empty() && info.id <= catalog.layers.back().info.id)
      return fault(FaultNumber::kLayerClash, ErrorCode::kInvalidData, place + ": layers are not in the order of their ids");
    if (!names.insert(info.name).second)
      return fault(FaultNumber::kLayerClash, ErrorCode::kInvalidData, place + ": another layer has the same name, " + info.name);

    for (int level = 0; level <= info.finest.value; ++level) {
      const Reference root = get_reference(payload, roots_at);
      roots_at += kReferenceBytes;
      if (root.present() || root != Reference{})
        if (const char* wrong = reference_fault(root, ReferenceKind::kPage, file_end); wrong != nullptr)
          return fault(FaultNumber::kPageReference, ErrorCode::kInvalidData, place + ", level " + number(level) + ", root page: " + wrong);
      layer.roots.push_back(root);
    }
    catalog.layers.push_back(std::move(layer));
  }

  for (const CatalogLayer& layer : catalog.layers) {
    if (layer.info.role != LayerRole::kCarry) continue;
    const auto owns = [&](const CatalogLayer& other) {
      return other.info.id == layer.info.owner && other.info.role == LayerRole::kTexture;
    };
    if (std::none_of(catalog.layers.begin(), catalog.layers.end(), owns))
      return fault(FaultNumber::kLayerClash, ErrorCode::kInvalidData,
                   "catalog, layer " + number(layer.info.id.value) + ": carries for layer " + number(layer.info.owner.value) +
                       ", which is no texture layer");
  }
  return catalog;
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
