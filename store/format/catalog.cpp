#include "store/format/catalog.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <string_view>

#include "store/format/text.h"
#include "store/io/bytes.h"

namespace vt::store {
namespace {

constexpr std::size_t kCatalogHeaderBytes = 48;
constexpr std::size_t kComponentsAt = 128;  // in a layer's entry
constexpr std::uint8_t kPartFlag = 1;
constexpr std::uint8_t kZeroIsNodataFlag = 2;
constexpr std::uint8_t kPointSampled = 1;

bool is_name(std::string_view name) { return !name.empty() && name.size() <= kMaxNameBytes && is_plain_text(name); }

}  // namespace

// header   0 u32 layers   4 u32 metadata bytes   8 f64 west   16 south   24 east   32 north   40 u64 reserved
// then one entry a layer, 192 bytes long (128 before version 3), then the roots of all layers, then the
// texts: metadata, and name and metadata of each layer.

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
  if (!is_name(info.name)) return "a name is 1 to 63 bytes of UTF-8 without control characters and without characters that reorder text";
  if (info.channel == ChannelType{}) return "channel type 0 is none";
  if (info.format == TexelFormat{}) return "texel format 0 is none";
  if (info.transfer != Transfer::kLinear && info.transfer != Transfer::kSrgb)
    return "transfer function " + number(static_cast<int>(info.transfer)) + " is not known";
  if (info.role != LayerRole::kTexture && info.role != LayerRole::kCarry)
    return "role " + number(static_cast<int>(info.role)) + " is not known";
  if (info.state != LayerState::kBuilding && info.state != LayerState::kComplete)
    return "state " + number(static_cast<int>(info.state)) + " is not known";
  if (info.is_part && info.role != LayerRole::kTexture) return "only a texture layer is a part of another";
  if (!info.has_owner() && info.owner.value != 0) return "only a carry layer or a part has an owner";
  if (info.holds_blobs() && info.role != LayerRole::kCarry) return "only a carry layer holds blobs";
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
  for (const ComponentRange& range : info.components)
    if (!std::isfinite(range.scale) || !std::isfinite(range.offset) || range.scale == 0.0)
      return "a component's range is not finite, or its scale is 0";
  if (info.zero_is_nodata && info.has_known_format() && nodata_sample(format_info(info.format).samples) != NodataSample::kZero)
    return "a code means \"no data\" in a format that has no codes";
  if (info.metadata_json.size() > kMaxMetadataBytes) return "the layer's metadata is over 16 MiB";
  if (!is_utf8(info.metadata_json)) return "the layer's metadata is not UTF-8";
  if (info.constant_tiles > info.tiles) return "it counts more constant tiles than tiles";
  return {};
}

std::string new_layer_fault(const LayerInfo& info) {
  if (!is_registered(info.channel) && !is_private(info.channel))
    return "channel type " + number(static_cast<int>(info.channel)) + " is not known";
  if (!info.has_known_format()) return "texel format " + number(static_cast<int>(info.format)) + " is not known";
  return layer_fault(info);
}

std::string owner_fault(const LayerInfo& info, std::span<const CatalogLayer> layers) {
  if (!info.has_owner()) return {};
  const char* const bond = info.is_part ? "is part of layer " : "carries for layer ";
  const auto owner = std::find_if(layers.begin(), layers.end(), [&](const CatalogLayer& other) { return other.info.id == info.owner; });
  if (owner == layers.end() || owner->info.role != LayerRole::kTexture)
    return bond + number(info.owner.value) + ", which is no texture layer";
  if (info.is_part && owner->info.is_part) return bond + number(info.owner.value) + ", which is a part itself";
  return {};
}

Result<std::vector<std::byte>> encode_catalog(const Catalog& catalog) {
  std::size_t roots_at = kCatalogHeaderBytes + catalog_layer_bytes(kFormatVersion) * catalog.layers.size();
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
    const std::span<std::byte> entry = std::span(out).subspan(at, catalog_layer_bytes(kFormatVersion));
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
    put<std::uint8_t>(entry, 14, static_cast<std::uint8_t>((info.is_part ? kPartFlag : 0) | (info.zero_is_nodata ? kZeroIsNodataFlag : 0)));
    put<std::uint8_t>(entry, 15, info.is_point_sampled ? kPointSampled : 0);
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
    for (std::size_t c = 0; c < info.components.size(); ++c) {
      put_f64(entry, kComponentsAt + 16 * c, info.components[c].scale);
      put_f64(entry, kComponentsAt + 16 * c + 8, info.components[c].offset);
    }
    at += catalog_layer_bytes(kFormatVersion);

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

Checked<Catalog> decode_catalog(std::span<const std::byte> payload, std::uint64_t file_end, std::uint32_t version) {
  const std::size_t layer_bytes = catalog_layer_bytes(version);
  const std::uint8_t known_flags = version < 3 ? 0 : kPartFlag | kZeroIsNodataFlag;
  const auto broken = [](const std::string& sentence) {
    return fault(FaultNumber::kCatalogStructure, ErrorCode::kInvalidData, "catalog: " + sentence);
  };
  const auto too_short = [&] { return broken("ends before its counts say, at " + number(payload.size()) + " bytes"); };

  if (payload.size() < kCatalogHeaderBytes) return too_short();
  const std::size_t layer_count = get<std::uint32_t>(payload, 0);
  const std::size_t metadata_bytes = get<std::uint32_t>(payload, 4);
  if (layer_count > kMaxLayers) return broken(number(layer_count) + " layers, at most 4096 wanted");
  if (get<std::uint64_t>(payload, 40) != 0) return broken("reserved bytes are set");
  if (payload.size() < kCatalogHeaderBytes + layer_bytes * layer_count) return too_short();

  Catalog catalog;
  catalog.description.area = {
      .west = get_f64(payload, 8), .south = get_f64(payload, 16), .east = get_f64(payload, 24), .north = get_f64(payload, 32)};

  // First the fixed entries, so that the places of roots and texts are known.
  std::size_t roots_at = kCatalogHeaderBytes + layer_bytes * layer_count;
  std::size_t texts_at = roots_at;
  std::size_t text_bytes = metadata_bytes;
  for (std::size_t i = 0; i < layer_count; ++i) {
    const auto entry = payload.subspan(kCatalogHeaderBytes + layer_bytes * i, layer_bytes);
    const std::size_t finest = get<std::uint8_t>(entry, 10);
    if (finest > kMaxFinest)
      return fault(FaultNumber::kLayerField, ErrorCode::kInvalidData,
                   "catalog, layer entry " + number(i) + ": finest level " + number(finest) + " is over 23");
    if ((get<std::uint8_t>(entry, 14) & ~known_flags) != 0 || get<std::uint32_t>(entry, 20) != 0 || get<std::uint64_t>(entry, 120) != 0)
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
    const auto entry = payload.subspan(kCatalogHeaderBytes + layer_bytes * i, layer_bytes);
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
    info.is_part = (get<std::uint8_t>(entry, 14) & kPartFlag) != 0;
    info.zero_is_nodata = (get<std::uint8_t>(entry, 14) & kZeroIsNodataFlag) != 0;
    info.is_point_sampled = get<std::uint8_t>(entry, 15) == kPointSampled;
    for (std::size_t c = 0; version >= 3 && c < info.components.size(); ++c)
      info.components[c] = {get_f64(entry, kComponentsAt + 16 * c), get_f64(entry, kComponentsAt + 16 * c + 8)};

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

  for (const CatalogLayer& layer : catalog.layers)
    if (const std::string wrong = owner_fault(layer.info, catalog.layers); !wrong.empty())
      return fault(FaultNumber::kLayerClash, ErrorCode::kInvalidData, "catalog, layer " + number(layer.info.id.value) + ": " + wrong);
  return catalog;
}

}  // namespace vt::store
