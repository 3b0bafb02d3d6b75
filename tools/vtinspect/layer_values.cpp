#include "tools/vtinspect/layer_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "builder/channels/all_channels.h"
#include "builder/channels/shared/srgb.h"
#include "builder/text/json_text.h"
#include "store/texel/texel_decoder.h"

namespace vt::inspect {

namespace {

std::string quoted_layer_names(const store::StoreReader& reader) {
  std::string names;
  for (const LayerInfo& layer : reader.layers()) {
    if (!names.empty()) names += ", ";
    names += layer.name;
    if (layer.has_owner()) names += layer.is_part ? " (part)" : " (carry)";
  }
  return names.empty() ? "none" : names;
}

Result<const LayerInfo*> find_wanted_layer(const store::StoreReader& reader, const std::string& layer) {
  const std::string file = reader.path().string();
  if (!layer.empty()) {
    if (const LayerInfo* found = reader.find_layer(layer)) return found;
    std::uint16_t number = 0;
    const auto [stop, error] = std::from_chars(layer.data(), layer.data() + layer.size(), number);
    if (error == std::errc() && stop == layer.data() + layer.size()) {
      if (const LayerInfo* found = reader.find_layer(LayerId{number})) return found;
    }
    return fail(ErrorCode::kNotFound, fmt::format("{}: no layer \"{}\"; layers: {}", file, layer, quoted_layer_names(reader)));
  }
  const LayerInfo* only = nullptr;
  for (const LayerInfo& candidate : reader.layers()) {
    if (candidate.has_owner()) continue;
    if (only != nullptr) {
      return fail(ErrorCode::kUsage, fmt::format("{}: has several layers; choose one with --layer: {}", file, quoted_layer_names(reader)));
    }
    only = &candidate;
  }
  if (only == nullptr) return fail(ErrorCode::kNotFound, fmt::format("{}: has no texture layer yet", file));
  return only;
}

}  // namespace

Result<const LayerInfo*> choose_layer(const store::StoreReader& reader, const std::string& layer) {
  VT_ASSIGN(const LayerInfo* const found, find_wanted_layer(reader, layer));
  VT_CHECK(reader.check_readable(found->id));
  return found;
}

Result<Level> choose_level(const store::StoreReader& reader, const LayerInfo& layer, std::optional<int> level) {
  if (!level) return layer.finest;
  if (*level < 0 || *level > layer.finest.value) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: layer {} has no level {}; levels: 0 (coarsest) to {} (finest)",
                                                  reader.path().string(), layer.name, *level, layer.finest.value));
  }
  return Level{static_cast<std::uint8_t>(*level)};
}

Result<nlohmann::json> dataset_metadata(const store::StoreReader& reader) {
  const std::string& json = reader.description().metadata_json;
  if (json.empty()) return nlohmann::json::object();  // the format takes an empty text for {}
  auto metadata = text::parse_json(json);
  if (!metadata)
    return fail(metadata.error().code, fmt::format("{}: the store's metadata {}", reader.path().string(), metadata.error().message));
  if (!metadata->is_object())
    return fail(ErrorCode::kInvalidData, fmt::format("{}: the store's metadata is not a JSON object", reader.path().string()));
  return metadata;
}

Result<geo::Crs> crs_of(const store::StoreReader& reader) {
  VT_ASSIGN(const nlohmann::json metadata, dataset_metadata(reader));
  const auto crs = metadata.find("crs");
  if (crs == metadata.end()) return geo::Crs();
  auto result = geo::Crs::from_json(*crs);
  if (!result) {
    return fail(ErrorCode::kInvalidData,
                fmt::format("{}: the \"crs\" of the store's metadata: {}", reader.path().string(), result.error().message));
  }
  return result;
}

namespace {

// Samples on the scale of 0 to 255 that are whole, decoded out of blocks or not.
bool has_byte_samples(TexelFormat format) { return format_info(format_info(format).encoded_from).samples == SampleKind::kUnorm8; }

// "no_data_class" of a layer of classes, as class_table_of() reads it.
std::optional<double> class_of_none(const nlohmann::ordered_json& metadata) {
  if (!metadata.is_object() || !metadata.contains("no_data_class")) return std::nullopt;
  const auto& code = metadata["no_data_class"];
  if (!code.is_number_integer() || code < 0 || code > channels::kGreatestClass) return std::nullopt;
  return code.get<double>();
}

bool means_its_codes(const LayerInfo& layer) {
  return !layer.zero_is_nodata &&
         std::ranges::all_of(layer.components, [](const ComponentRange& range) { return range == ComponentRange(); });
}

}  // namespace

TexelLayout layout_of(const LayerInfo& layer) {
  const FormatInfo& info = format_info(layer.format);
  if (info.samples == SampleKind::kOpaque) return {info.block_bytes, false};
  return {info.channels, !(has_byte_samples(layer.format) && means_its_codes(layer))};
}

bool has_coverage_channel(const LayerInfo& layer) {
  return channels::kind_of(layer.channel).fourth_is_coverage && format_info(layer.format).channels == 4;
}

AbsentTexels absent_texels(const LayerInfo& layer, Level level) {
  const bool is_float = layout_of(layer).is_float;
  AbsentTexels absent{.value = is_float ? std::numeric_limits<float>::quiet_NaN() : 0.0F};
  const nlohmann::ordered_json metadata = text::json_or_null(layer.metadata_json);
  switch (channels::kind_of(layer.channel).absent) {
    case channels::Absent::kClass:
      absent.code_of_none = class_of_none(metadata);
      if (absent.code_of_none) absent.value = static_cast<float>(*absent.code_of_none);
      // Shares of classes: of none there are none.
      if (!absent.code_of_none && layer.is_part) absent.value = 0.0F;
      break;
    case channels::Absent::kZero:
      absent.value = 0.0F;
      break;
    case channels::Absent::kFill: {
      const bool is_here = metadata.is_object() && metadata.contains("filled_m") && metadata["filled_m"].is_number();
      // Bounds of one height are not stored: they are not void at the finest level, but left out.
      const bool is_left_out = layer.is_part && level == layer.finest;
      if (!is_here || is_left_out || layer.state != LayerState::kComplete) break;
      absent.value = metadata["filled_m"].get<float>();
      absent.is_data = true;
      break;
    }
    case channels::Absent::kUnknown:
      break;
  }
  return absent;
}

double value_of(const LayerInfo& layer, std::span<const float> texel, std::size_t component) {
  if (layer.zero_is_nodata && texel[0] == 0.0F) return std::numeric_limits<double>::quiet_NaN();
  const ComponentRange& range = layer.components[component];
  const double sample = static_cast<double>(texel[component]);
  return range == ComponentRange() ? sample : range.offset + range.scale * sample;
}

void decode_tile(const LayerInfo& layer, std::span<const std::byte> payload, std::span<std::byte> out) {
  const std::size_t edge = layer.tile_texels();
  const FormatInfo& info = format_info(layer.format);
  const TexelLayout layout = layout_of(layer);
  if (!layout.is_float && (info.samples == SampleKind::kUnorm8 || info.samples == SampleKind::kOpaque)) {
    std::copy(payload.begin(), payload.end(), out.begin());
    return;
  }
  std::vector<float> samples(edge * edge * info.channels);
  store::decode_texels(layer.format, payload, edge, edge, samples);
  if (!layout.is_float) {
    for (std::size_t i = 0; i < samples.size(); ++i) out[i] = static_cast<std::byte>(samples[i]);
    return;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t component = i % info.channels;
    const auto value = static_cast<float>(value_of(layer, std::span(samples).subspan(i - component), component));
    std::memcpy(&out[i * sizeof value], &value, sizeof value);
  }
}

LevelReader::LevelReader(const store::StoreReader& reader, const LayerInfo& layer, Level level)
    : reader_(reader),
      layer_(layer),
      level_(level),
      layout_(layout_of(layer)),
      absent_(absent_texels(layer, level)),
      payload_(layer.tile_payload_bytes()),
      texels_(std::size_t{layer.tile_texels()} * layer.tile_texels() * layout_.texel_bytes()) {}

Result<void> LevelReader::read(const TexelRect& rect, std::span<std::byte> out, std::span<std::uint8_t> is_present) {
  const std::size_t texel_bytes = layout_.texel_bytes();
  assert(out.size() == static_cast<std::size_t>(rect.width * rect.height) * texel_bytes);

  // Start from "nothing is there"; tiles then write over it.
  if (layout_.is_float) {
    for (std::size_t at = 0; at < out.size(); at += sizeof absent_.value) std::memcpy(&out[at], &absent_.value, sizeof absent_.value);
  } else {
    std::fill(out.begin(), out.end(), static_cast<std::byte>(absent_.value));
  }
  std::fill(is_present.begin(), is_present.end(), static_cast<std::uint8_t>(absent_.is_data ? 1 : 0));

  const TexelRect tiles = coarser(rect, layer_.tile_exponent);
  for (std::int64_t tile_y = tiles.y; tile_y < tiles.bottom(); ++tile_y) {
    for (std::int64_t tile_x = tiles.x; tile_x < tiles.right(); ++tile_x) {
      const TileId tile{level_, static_cast<std::uint32_t>(tile_x), static_cast<std::uint32_t>(tile_y)};
      if (auto result = reader_.read(layer_.id, tile, payload_); !result) {
        if (result.error().code == ErrorCode::kNotFound) continue;
        return tl::unexpected(result.error());
      }
      decode_tile(layer_, payload_, texels_);
      const TexelRect place = rect_of(tile, layer_.tile_exponent);
      const TexelRect part = intersect(place, rect);
      for (std::int64_t y = part.y; y < part.bottom(); ++y) {
        const auto from = static_cast<std::size_t>((y - place.y) * place.width + (part.x - place.x));
        const auto to = static_cast<std::size_t>((y - rect.y) * rect.width + (part.x - rect.x));
        const auto count = static_cast<std::size_t>(part.width);
        std::memcpy(&out[to * texel_bytes], &texels_[from * texel_bytes], count * texel_bytes);
        if (!is_present.empty()) std::memset(&is_present[to], 1, count);
      }
    }
  }
  return {};
}

Result<std::uint64_t> LevelReader::count_missing(const TexelRect& rect) const {
  const TexelRect tiles = coarser(rect, layer_.tile_exponent);
  const auto in_rect = static_cast<std::uint64_t>(tiles.width) * static_cast<std::uint64_t>(tiles.height);
  if (in_rect > layer_.tiles) {  // the tiles that there are can be counted faster than those that there might be
    std::uint64_t present = 0;
    VT_CHECK(reader_.for_each_tile(layer_.id, level_, [&](TileId tile) -> Result<void> {
      if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "stopped");
      const std::int64_t x = tile.x;
      const std::int64_t y = tile.y;
      present += x >= tiles.x && y >= tiles.y && x < tiles.right() && y < tiles.bottom() ? 1 : 0;
      return {};
    }));
    return in_rect - present;
  }
  std::uint64_t missing = 0;
  for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y) {
    if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "stopped");
    for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
      VT_ASSIGN(const store::TileLookup found,
                reader_.lookup(layer_.id, {level_, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)}));
      if (found.kind == store::TileKind::kAbsent) ++missing;
    }
  }
  return missing;
}

const std::array<double, 256>& linear_from_srgb() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (std::size_t code = 0; code < values.size(); ++code) values[code] = channels::linear_from_srgb(static_cast<double>(code) / 255.0);
    return values;
  }();
  return table;
}

std::string_view role_name(LayerRole role) { return role == LayerRole::kCarry ? "carry" : "texture"; }
std::string_view state_name(LayerState state) { return state == LayerState::kComplete ? "complete" : "building"; }
std::string_view transfer_name(Transfer transfer) { return transfer == Transfer::kSrgb ? "srgb" : "linear"; }

}  // namespace vt::inspect
