#include "tests/support/naive_store_reader.h"

#include <zstd.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

#include "tests/support/naive_prediction.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace vt::test {
namespace {

using Bytes = std::span<const std::byte>;

void require(bool condition, const char* claim) {
  if (!condition) throw std::runtime_error(std::string("tile store: not so: ") + claim);
}

// ---- Section 2: conventions

Bytes part(Bytes bytes, std::uint64_t offset, std::uint64_t size) {
  require(offset <= bytes.size() && size <= bytes.size() - offset, "the structure lies inside the bytes there are");
  return bytes.subspan(offset, size);
}

std::uint64_t get_unsigned(Bytes bytes, std::uint64_t offset, unsigned size) {
  std::uint64_t value = 0;
  unsigned shift = 0;
  for (const std::byte byte : part(bytes, offset, size)) {
    value |= std::to_integer<std::uint64_t>(byte) << shift;
    shift += 8;
  }
  return value;
}

unsigned get_u8(Bytes bytes, std::uint64_t offset) { return static_cast<unsigned>(get_unsigned(bytes, offset, 1)); }
unsigned get_u16(Bytes bytes, std::uint64_t offset) { return static_cast<unsigned>(get_unsigned(bytes, offset, 2)); }
std::uint32_t get_u32(Bytes bytes, std::uint64_t offset) { return static_cast<std::uint32_t>(get_unsigned(bytes, offset, 4)); }
std::uint64_t get_u48(Bytes bytes, std::uint64_t offset) { return get_unsigned(bytes, offset, 6); }
std::uint64_t get_u64(Bytes bytes, std::uint64_t offset) { return get_unsigned(bytes, offset, 8); }
std::int64_t get_i64(Bytes bytes, std::uint64_t offset) { return static_cast<std::int64_t>(get_u64(bytes, offset)); }
double get_f64(Bytes bytes, std::uint64_t offset) { return std::bit_cast<double>(get_u64(bytes, offset)); }

std::string get_text(Bytes bytes, std::uint64_t offset, std::uint64_t size) {
  std::string text;
  for (const std::byte byte : part(bytes, offset, size)) text.push_back(static_cast<char>(byte));
  return text;
}

std::uint64_t hash_of(Bytes bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

void require_zero(Bytes bytes, std::uint64_t offset, std::uint64_t size, const char* claim) {
  for (const std::byte byte : part(bytes, offset, size)) require(byte == std::byte{0}, claim);
}

std::uint64_t align64(std::uint64_t n) { return (n + 63) / 64 * 64; }

// ---- Section 4: reference

constexpr std::uint64_t kLogBegin = 8192;

constexpr unsigned kAbsent = 0;
constexpr unsigned kTile = 1;
constexpr unsigned kConstant = 2;
constexpr unsigned kPage = 3;
constexpr unsigned kCatalog = 4;
constexpr unsigned kSharedTile = 5;

constexpr unsigned kRaw = 0;
constexpr unsigned kZstd = 1;
constexpr unsigned kPredicted = 2;

NaiveReference read_reference(Bytes bytes, std::uint64_t at, std::uint64_t file_end) {
  NaiveReference reference;
  reference.offset = get_u48(bytes, at + 0);
  reference.kind = get_u8(bytes, at + 6);
  reference.codec = get_u8(bytes, at + 7);
  reference.stored_bytes = get_u32(bytes, at + 8);
  reference.check = get_u32(bytes, at + 12);

  if (reference.kind == kAbsent) {
    require_zero(bytes, at, 16, "an absent reference is 16 zero bytes");
    return reference;
  }
  require(reference.kind <= kSharedTile, "the reference's kind is known");
  require(reference.codec == kRaw ||
              ((reference.codec == kZstd || reference.codec == kPredicted) && (reference.kind == kTile || reference.kind == kSharedTile)),
          "the reference's codec is raw, or zstd or predicted for a tile");
  if (reference.kind == kTile || reference.kind == kConstant || reference.kind == kSharedTile)
    require(reference.stored_bytes <= 1U << 28, "a tile is stored in 2^28 bytes at most");
  require(reference.offset % 64 == 0 && reference.offset >= kLogBegin, "the reference's offset is a multiple of 64 in the log");
  require(reference.offset + align64(32 + std::uint64_t{reference.stored_bytes}) <= file_end, "the referenced record ends before file_end");
  return reference;
}

// ---- Section 3: superblock

constexpr std::uint64_t kSuperblockBytes = 4096;
constexpr std::uint32_t kCatalogLimit = 64U << 20;

// Nothing when it is damaged. `slot` is 0 for A and 1 for B.
std::optional<NaiveSuperblock> read_superblock(Bytes file, unsigned slot) {
  if (file.size() < (slot + 1) * kSuperblockBytes) return std::nullopt;
  const Bytes block = part(file, slot * kSuperblockBytes, kSuperblockBytes);
  if (get_text(block, 0, 8) != "VTSTORE1") return std::nullopt;
  if (get_u64(block, 4088) != hash_of(part(block, 0, 4088))) return std::nullopt;

  require(get_u32(block, 8) >= 1 && get_u32(block, 8) <= 4, "the superblock's version is 1 to 4");
  require_zero(block, 12, 4, "the superblock's reserved bytes 12 to 15 are zero");
  const Bytes uuid = part(block, 16, 16);
  const std::uint64_t generation = get_u64(block, 32);
  require(generation % 2 == slot, "the generation is in its slot");
  const std::uint64_t file_end = get_u64(block, 40);
  require(file_end % 64 == 0 && file_end >= kLogBegin && file_end <= std::uint64_t{1} << 48, "file_end is possible");
  const NaiveReference catalog = read_reference(block, 48, file_end);
  require(catalog.kind == kCatalog, "the superblock's reference is to a catalog");
  require(catalog.stored_bytes <= kCatalogLimit, "the catalog has 64 MiB at most");
  // Bytes 64 to 127 are ignorable.
  require_zero(block, 128, 3960, "the superblock's reserved bytes 128 to 4087 are zero");
  return NaiveSuperblock{.uuid = NaiveBytes(uuid.begin(), uuid.end()),
                         .generation = generation,
                         .file_end = file_end,
                         .catalog = catalog,
                         .version = get_u32(block, 8)};
}

NaiveSuperblock choose_superblock(Bytes file) {
  const std::optional<NaiveSuperblock> a = read_superblock(file, 0);
  const std::optional<NaiveSuperblock> b = read_superblock(file, 1);
  require(a || b, "one superblock at least is whole");
  if (!b) return *a;
  if (!a) return *b;
  require(a->uuid == b->uuid, "both superblocks have one UUID");
  return a->generation > b->generation ? *a : *b;
}

// ---- Section 5: record

// The payload as stored, after every check that needs the whole record.
Bytes read_record(Bytes file, const NaiveReference& reference, std::uint64_t key, std::uint64_t raw_bytes) {
  const Bytes record = part(file, reference.offset, 32 + std::uint64_t{reference.stored_bytes});
  require(get_u32(record, 8) == 0x43525456, "the record's magic is VTRC");
  require(get_u8(record, 12) == reference.kind, "the record's type is the reference's kind");
  require(get_u8(record, 13) == reference.codec, "the record's codec is the reference's");
  require_zero(record, 14, 2, "the record's reserved bytes are zero");
  require(get_u32(record, 16) == raw_bytes, "the record's raw_bytes are what was looked for");
  require(get_u32(record, 20) == reference.stored_bytes, "the record's stored_bytes are the reference's");
  if (reference.codec == kRaw) require(reference.stored_bytes == raw_bytes, "a raw record's stored_bytes are its raw_bytes");
  require(get_u64(record, 24) == key, "the record's key is what was looked for");
  const std::uint64_t hash = get_u64(record, 0);
  require((hash & 0xFFFFFFFF) == reference.check, "the low half of the record's hash is the reference's check");
  require(hash == hash_of(record.subspan(8)), "the record's hash is right");
  return record.subspan(32);
}

std::uint64_t key_of(unsigned layer_id, unsigned level, std::uint64_t morton) {
  return std::uint64_t{layer_id} << 52 | std::uint64_t{level} << 46 | morton;
}

std::uint64_t morton_of(std::uint64_t x, std::uint64_t y) {
  std::uint64_t morton = 0;
  for (unsigned i = 0; i < 23; ++i) {
    morton |= (x >> i & 1) << (2 * i);
    morton |= (y >> i & 1) << (2 * i + 1);
  }
  return morton;
}

// ---- Section 8: the table of formats

enum class Numbers { kNone, kCodes, kHalves, kFloats };  // kNone: those that codec 2 and zero_is_nodata do not take

struct Format {
  unsigned number;
  const char* name;
  std::uint64_t edge;
  std::uint64_t block_bytes;
  Numbers numbers = Numbers::kNone;
  std::uint64_t channels = 0;  // of numbers
};

constexpr unsigned kBlob = 22;  // has neither edge nor bytes

constexpr Format kFormats[] = {
    {1, "rgb8", 1, 3, Numbers::kCodes, 3},
    {2, "rgba8", 1, 4, Numbers::kCodes, 4},
    {3, "bc1", 4, 8},
    {4, "r32f", 1, 4, Numbers::kFloats, 1},
    {5, "rg32f", 1, 8, Numbers::kFloats, 2},
    {6, "rgba32f", 1, 16, Numbers::kFloats, 4},
    {7, "hash128", 1, 16},
    {8, "r8", 1, 1, Numbers::kCodes, 1},
    {9, "rg8", 1, 2, Numbers::kCodes, 2},
    {10, "r16", 1, 2, Numbers::kCodes, 1},
    {11, "rg16", 1, 4, Numbers::kCodes, 2},
    {12, "rgba16", 1, 8, Numbers::kCodes, 4},
    {13, "r16f", 1, 2, Numbers::kHalves, 1},
    {14, "rg16f", 1, 4, Numbers::kHalves, 2},
    {15, "rgba16f", 1, 8, Numbers::kHalves, 4},
    {16, "rgb9e5", 1, 4},
    {17, "bc3", 4, 16},
    {18, "bc4", 4, 8},
    {19, "bc5", 4, 16},
    {20, "bc6h", 4, 16},
    {21, "bc7", 4, 16},
    {kBlob, "blob", 0, 0},
};

// Null for numbers of newer programs.
const Format* find_format(unsigned number) {
  for (const Format& format : kFormats)
    if (format.number == number) return &format;
  return nullptr;
}

const Format& format_of(unsigned number) {
  const Format* const format = find_format(number);
  require(format != nullptr, "the texel format is known");
  return *format;
}

constexpr std::uint64_t kBlobLimit = 256U << 20;

std::uint64_t tile_bytes_of(const NaiveLayer& layer) {
  const Format& format = format_of(layer.format);
  require(format.number != kBlob, "tiles of blobs have no size in common");
  const std::uint64_t blocks = (std::uint64_t{1} << layer.tile_exponent) / format.edge;
  return blocks * blocks * format.block_bytes;
}

// ---- Section 6: catalog

constexpr std::uint32_t kJsonLimit = 16U << 20;

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t at) { return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U; };
    const unsigned lead = byte(i);
    const unsigned tail = lead < 0x80 ? 0 : lead < 0xC2 ? 9 : lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : lead < 0xF5 ? 3 : 9;
    if (tail == 9) return false;
    for (unsigned k = 1; k <= tail; ++k) {
      if ((byte(i + k) & 0xC0) != 0x80) return false;
    }
    if (lead == 0xE0 && byte(i + 1) < 0xA0) return false;
    if (lead == 0xED && byte(i + 1) > 0x9F) return false;
    if (lead == 0xF0 && byte(i + 1) < 0x90) return false;
    if (lead == 0xF4 && byte(i + 1) > 0x8F) return false;
    i += 1 + tail;
  }
  return true;
}

// Whether a text that is UTF-8 has characters which a name must not have.
bool has_control_characters(const std::string& text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (byte(i) <= 0x1F || byte(i) == 0x7F) return true;
    if (byte(i) == 0xC2 && byte(i + 1) <= 0x9F) return true;  // U+0080 to U+009F
    if (byte(i) != 0xE2) continue;
    if (byte(i + 1) == 0x80 && byte(i + 2) >= 0xA8 && byte(i + 2) <= 0xAE) return true;  // U+2028 to U+202E
    if (byte(i + 1) == 0x81 && byte(i + 2) >= 0xA6 && byte(i + 2) <= 0xA9) return true;  // U+2066 to U+2069
  }
  return false;
}

struct LayerEntry {
  NaiveLayer layer;  // without roots and texts
  unsigned name_bytes = 0;
  std::uint32_t metadata_bytes = 0;
};

LayerEntry read_layer_entry(Bytes entry, unsigned version) {
  LayerEntry result;
  NaiveLayer& layer = result.layer;
  layer.id = get_u16(entry, 0);
  require(layer.id <= 4095, "a layer's id is 0 to 4095");
  layer.channel = get_u16(entry, 2);
  require(layer.channel >= 1, "a layer's channel is not 0");  // others than 1 to 8 mean nothing to us, and texels are texels
  layer.format = get_u16(entry, 4);
  require(layer.format >= 1, "a layer's format is not 0");  // of numbers without a row the tiles cannot be read
  layer.transfer = get_u8(entry, 6);
  require(layer.transfer <= 1, "a layer's transfer is 0 or 1");
  layer.role = get_u8(entry, 7);
  require(layer.role <= 1, "a layer's role is 0 or 1");
  layer.state = get_u8(entry, 8);
  require(layer.state <= 1, "a layer's state is 0 or 1");
  layer.tile_exponent = get_u8(entry, 9);
  require(layer.tile_exponent >= 2 && layer.tile_exponent <= 12, "a layer's tile_exponent is 2 to 12");
  layer.finest = get_u8(entry, 10);
  require(layer.finest <= 23 && layer.finest + layer.tile_exponent <= 31,
          "a layer's finest level is 0 to 23, with the tile exponent 31 at most");
  result.name_bytes = get_u8(entry, 11);
  require(result.name_bytes >= 1 && result.name_bytes <= 63, "a layer's name has 1 to 63 bytes");
  layer.owner = get_u16(entry, 12);
  const unsigned flags = get_u8(entry, 14);
  require(flags < (version < 3 ? 1U : 4U), "a layer's reserved flags are zero");
  layer.is_part = (flags & 1) != 0;
  layer.zero_is_nodata = (flags & 2) != 0;
  require(!layer.is_part || layer.role == 0, "only a texture layer is a part");
  require(layer.role == 1 || layer.is_part || layer.owner == 0, "only a carry layer or a part has an owner");
  require(layer.format != kBlob || layer.role == 1, "only a carry layer holds blobs");
  const Format* const format = find_format(layer.format);
  require(!layer.zero_is_nodata || format == nullptr || format->numbers == Numbers::kCodes, "only in formats of codes is zero no data");
  layer.is_point_sampled = get_u8(entry, 15) == 1;  // ignorable, so that other values are none
  result.metadata_bytes = get_u32(entry, 16);
  require(result.metadata_bytes <= kJsonLimit, "a layer's JSON has 16 MiB at most");
  require_zero(entry, 20, 4, "a layer's reserved bytes 20 to 23 are zero");

  const std::int64_t side = std::int64_t{1} << (layer.finest + layer.tile_exponent);
  layer.data_x = get_i64(entry, 24);
  layer.data_y = get_i64(entry, 32);
  layer.data_width = get_i64(entry, 40);
  layer.data_height = get_i64(entry, 48);
  require(layer.data_x >= 0 && layer.data_x <= side && layer.data_y >= 0 && layer.data_y <= side, "a layer's data begins in its square");
  require(layer.data_width >= 1 && layer.data_width <= side - layer.data_x, "a layer's data columns lie in its square");
  require(layer.data_height >= 1 && layer.data_height <= side - layer.data_y, "a layer's data rows lie in its square");

  layer.origin_x = get_f64(entry, 56);
  layer.origin_y = get_f64(entry, 64);
  require(std::isfinite(layer.origin_x) && std::isfinite(layer.origin_y), "a layer's origin is finite");
  layer.step_x = get_f64(entry, 72);
  layer.step_y = get_f64(entry, 80);
  require(std::isfinite(layer.step_x) && layer.step_x > 0.0, "a layer's step_x is finite and above 0");
  require(std::isfinite(layer.step_y) && layer.step_y > 0.0, "a layer's step_y is finite and above 0");
  layer.source_nodata = get_f64(entry, 88);
  layer.tiles = get_u64(entry, 96);
  layer.constant_tiles = get_u64(entry, 104);
  require(layer.constant_tiles <= layer.tiles, "a layer's constant tiles are among its tiles");
  layer.stored_bytes = get_u64(entry, 112);
  require_zero(entry, 120, 8, "a layer's reserved bytes 120 to 127 are zero");
  for (unsigned c = 0; version >= 3 && c < 4; ++c) {
    layer.scale[c] = get_f64(entry, 128 + 16 * c);
    layer.offset[c] = get_f64(entry, 136 + 16 * c);
    require(std::isfinite(layer.scale[c]) && layer.scale[c] != 0.0, "a component's scale is finite and not 0");
    require(std::isfinite(layer.offset[c]), "a component's offset is finite");
  }
  return result;
}

void check_between_layers(const std::vector<NaiveLayer>& layers) {
  std::set<std::string> names;
  std::set<unsigned> texture_ids;
  std::set<unsigned> part_ids;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    require(i == 0 || layers[i - 1].id < layers[i].id, "layer ids ascend strictly");
    require(names.insert(layers[i].name).second, "layer names are unique");
    if (layers[i].role == 0) texture_ids.insert(layers[i].id);
    if (layers[i].is_part) part_ids.insert(layers[i].id);
  }
  for (const NaiveLayer& layer : layers) {
    if (layer.role == 1) require(texture_ids.contains(layer.owner), "a carry layer's owner is there and a texture layer");
    if (layer.is_part)
      require(texture_ids.contains(layer.owner) && !part_ids.contains(layer.owner), "a part's owner is there, a texture layer and no part");
  }
}

NaiveCatalog read_catalog(Bytes payload, std::uint64_t file_end, unsigned version) {
  NaiveCatalog catalog;
  const std::uint32_t layer_count = get_u32(payload, 0);
  require(layer_count <= 4096, "there are 4096 layers at most");
  const std::uint32_t metadata_bytes = get_u32(payload, 4);
  require(metadata_bytes <= kJsonLimit, "the dataset's JSON has 16 MiB at most");
  catalog.west = get_f64(payload, 8);
  catalog.south = get_f64(payload, 16);
  catalog.east = get_f64(payload, 24);
  catalog.north = get_f64(payload, 32);
  require(std::isfinite(catalog.west) && std::isfinite(catalog.south) && std::isfinite(catalog.east) && std::isfinite(catalog.north),
          "the area is finite");
  require(catalog.west < catalog.east && catalog.south < catalog.north, "the area is not empty");
  require_zero(payload, 40, 8, "the catalog's reserved bytes are zero");

  std::uint64_t at = 48;
  std::vector<LayerEntry> entries;
  for (std::uint32_t i = 0; i < layer_count; ++i) {
    const std::uint64_t entry_bytes = version < 3 ? 128 : 192;
    entries.push_back(read_layer_entry(part(payload, at, entry_bytes), version));
    at += entry_bytes;
  }
  for (LayerEntry& entry : entries) {
    for (unsigned level = 0; level <= entry.layer.finest; ++level) {
      const NaiveReference root = read_reference(payload, at, file_end);
      require(root.kind == kAbsent || root.kind == kPage, "a root is absent or a page");
      entry.layer.roots.push_back(root);
      at += 16;
    }
  }
  catalog.metadata_json = get_text(payload, at, metadata_bytes);
  require(is_utf8(catalog.metadata_json), "the dataset's JSON is UTF-8");
  at += metadata_bytes;
  for (LayerEntry& entry : entries) {
    entry.layer.name = get_text(payload, at, entry.name_bytes);
    require(is_utf8(entry.layer.name) && !has_control_characters(entry.layer.name), "a layer's name is UTF-8 without control characters");
    at += entry.name_bytes;
    entry.layer.metadata_json = get_text(payload, at, entry.metadata_bytes);
    require(is_utf8(entry.layer.metadata_json), "a layer's JSON is UTF-8");
    at += entry.metadata_bytes;
    catalog.layers.push_back(entry.layer);
  }
  require(at == payload.size(), "the catalog's parts fill its payload");
  check_between_layers(catalog.layers);
  return catalog;
}

// ---- Section 7: index

unsigned top_of(unsigned level) { return level <= 5 ? 0 : (level + 4) / 5 - 1; }

// Checks the whole page, then gives the entry of one slot, absent when its bit is clear.
NaiveReference read_page(Bytes payload, unsigned level, unsigned height, std::uint64_t slot, std::uint64_t file_end) {
  const unsigned count = get_u16(payload, 0);
  require(count >= 1 && count <= 1024, "a page has 1 to 1024 entries");
  require(payload.size() == 176 + 16 * std::uint64_t{count}, "a page has 176 + 16 * count bytes");
  require(get_u8(payload, 2) == height, "a page's height is that of its place");
  require_zero(payload, 3, 13, "a page's reserved bytes are zero");

  // 4^(level - 5 * height) slots lie inside the level; a top page can cover less than 5 levels, no page
  // covers more.
  const unsigned levels_below = level - 5 * height;
  const std::uint64_t slots = levels_below >= 5 ? 1024 : std::uint64_t{1} << (2 * levels_below);

  NaiveReference wanted;
  unsigned present_before = 0;
  for (std::uint64_t s = 0; s < 1024; ++s) {
    if (s % 64 == 0) require(get_u16(payload, 144 + 2 * (s / 64)) == present_before, "a rank counts the bits of the words before it");
    const bool present = (get_u64(payload, 16 + 8 * (s / 64)) >> (s % 64) & 1) != 0;
    if (!present) continue;
    require(s < slots, "a page's entry lies inside the level");
    const NaiveReference entry = read_reference(payload, 176 + 16 * std::uint64_t{present_before}, file_end);
    if (height == 0) {
      require(entry.kind == kTile || entry.kind == kSharedTile || entry.kind == kConstant,
              "a leaf's entry is a tile, shared or not, or a constant");
    } else {
      require(entry.kind == kPage, "an inner page's entry is a page");
    }
    if (s == slot) wanted = entry;
    ++present_before;
  }
  require(present_before == count, "a page's count is that of its presence bits");
  return wanted;
}

// ---- Section 8: tiles

NaiveBytes decode_zstd(Bytes frame, std::uint64_t tile_bytes) {
  // One frame and nothing after it: ZSTD_decompress alone would go on to a second.
  require(ZSTD_findFrameCompressedSize(frame.data(), frame.size()) == frame.size(), "a zstd payload is one frame");
  NaiveBytes tile(tile_bytes);
  require(ZSTD_decompress(tile.data(), tile.size(), frame.data(), frame.size()) == tile_bytes, "a zstd payload decodes to the tile's size");
  return tile;
}

NaiveBytes decode_predicted(Bytes payload, const NaiveLayer& layer) {
  NaivePrediction prediction;
  const std::uint64_t edge = std::uint64_t{1} << layer.tile_exponent;
  prediction.width = edge;
  prediction.height = edge;
  const Format& format = format_of(layer.format);
  require(format.numbers != Numbers::kNone, "the format can be predicted");
  const std::uint64_t channels = format.channels;
  prediction.is_float = format.numbers != Numbers::kCodes;
  prediction.sample_bytes = format.block_bytes / channels;
  const bool has_green = format.numbers == Numbers::kCodes && format.block_bytes == channels && channels >= 3;
  const unsigned flags = get_u8(payload, 0);
  require(flags <= (has_green ? 1U : 0U), "the prediction's reserved flags are zero");
  prediction.subtracts_green = flags == 1;
  for (std::uint64_t c = 0; c < channels; ++c) {
    prediction.predictors.push_back(get_u8(payload, 1 + c));
    require(prediction.predictors.back() <= 5, "a predictor is 0 to 5");
  }
  return naive_texels(decode_zstd(payload.subspan(1 + channels), tile_bytes_of(layer)), prediction);
}

NaiveBytes repeat_block(Bytes block, std::uint64_t tile_bytes) {
  NaiveBytes tile;
  while (tile.size() < tile_bytes) tile.insert(tile.end(), block.begin(), block.end());
  return tile;
}

}  // namespace

// ---- Section 9: how to read a tile; the numbers are its steps

NaiveStoreReader::NaiveStoreReader(NaiveBytes file) : file_(std::move(file)) {
  // 1.
  superblock_ = choose_superblock(file_);
  require(superblock_.file_end <= file_.size(), "file_end is not beyond the file");
  // 2.
  const NaiveReference& reference = superblock_.catalog;
  catalog_ = read_catalog(read_record(file_, reference, 0, reference.stored_bytes), superblock_.file_end, superblock_.version);
}

NaiveStoreReader NaiveStoreReader::open(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  require(stream.good(), "the file opens");
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const Bytes bytes = std::as_bytes(std::span(text));
  return NaiveStoreReader(NaiveBytes(bytes.begin(), bytes.end()));
}

std::optional<NaiveBytes> NaiveStoreReader::tile(unsigned layer_id, unsigned level, std::uint64_t x, std::uint64_t y) const {
  const NaiveLayer* layer = nullptr;
  for (const NaiveLayer& candidate : catalog_.layers) {
    if (candidate.id == layer_id) layer = &candidate;
  }
  require(layer != nullptr, "the store has the layer");

  // 3.
  require(find_format(layer->format) != nullptr, "the layer's texel format is known");
  if (level > layer->finest || x >= std::uint64_t{1} << level || y >= std::uint64_t{1} << level) return std::nullopt;
  const std::uint64_t morton = morton_of(x, y);

  // 4.
  NaiveReference reference = layer->roots[level];
  for (unsigned height = top_of(level) + 1; height-- > 0;) {
    if (reference.kind == kAbsent) return std::nullopt;
    const unsigned low_bits = 10 * (height + 1);
    const std::uint64_t first_tile = morton >> low_bits << low_bits;
    const Bytes page = read_record(file_, reference, key_of(layer->id, level, first_tile), reference.stored_bytes);
    reference = read_page(page, level, height, (morton >> (10 * height)) % 1024, superblock_.file_end);
  }

  // 5 and 6.
  if (reference.kind == kAbsent) return std::nullopt;
  if (layer->format == kBlob) {
    require(reference.kind == kTile && reference.codec != kPredicted, "a blob is a tile of its own, raw or zstd");
    const std::uint64_t blob_bytes = get_u32(file_, reference.offset + 16);
    require(blob_bytes >= 1 && blob_bytes <= kBlobLimit, "a blob has 1 byte to 256 MiB");
    const Bytes blob = read_record(file_, reference, key_of(layer->id, level, morton), blob_bytes);
    return reference.codec == kZstd ? decode_zstd(blob, blob_bytes) : NaiveBytes(blob.begin(), blob.end());
  }
  const std::uint64_t tile_bytes = tile_bytes_of(*layer);
  if (reference.kind == kConstant) {
    return repeat_block(read_record(file_, reference, 0, format_of(layer->format).block_bytes), tile_bytes);
  }
  const std::uint64_t key = reference.kind == kSharedTile ? 0 : key_of(layer->id, level, morton);
  const Bytes payload = read_record(file_, reference, key, tile_bytes);
  if (reference.codec == kZstd) return decode_zstd(payload, tile_bytes);
  if (reference.codec == kPredicted) return decode_predicted(payload, *layer);
  return NaiveBytes(payload.begin(), payload.end());
}

}  // namespace vt::test
