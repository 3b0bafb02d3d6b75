#include "tools/vtinspect/info.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/geo/crs.h"
#include "builder/text/json_text.h"
#include "store/format/text.h"
#include "store/store_reader.h"
#include "store/vt_mapping.h"
#include "tools/cli/cli_support.h"
#include "tools/cli/open_store.h"
#include "tools/vtinspect/class_names.h"
#include "tools/vtinspect/layer_values.h"
#include "tools/vtinspect/quality_text.h"

namespace vt::inspect {

namespace {

// Asking the index for one tile takes about a tenth of a microsecond; above this a table would take longer
// than people wait.
constexpr std::uint64_t kMaxCountedTiles = std::uint64_t{1} << 26;

struct LevelSummary {
  Level level;
  TexelRect data;
  Point2 gsd_crs;               // CRS units per texel
  std::optional<Point2> gsd_m;  // at the area's centre
  std::uint64_t tiles_in_data = 0;
  bool is_counted = false;
  std::uint64_t stored = 0;
  std::uint64_t constant = 0;
  std::uint64_t absent = 0;
  std::uint64_t stored_bytes = 0;
  std::optional<double> ratio;  // unpacked bytes of the tiles present over their bytes in the file
};

std::optional<double> compression_ratio(std::uint64_t tiles, std::size_t tile_bytes, std::uint64_t stored_bytes) {
  if (stored_bytes == 0 || tile_bytes == 0) return std::nullopt;  // blobs have no size in common
  return static_cast<double>(tiles) * static_cast<double>(tile_bytes) / static_cast<double>(stored_bytes);
}

std::optional<Point2> metres_per_unit(const geo::Crs& crs, const Area& area) {
  if (crs.kind() == geo::CrsKind::kPixel) return std::nullopt;
  const auto metres = crs.metres_per_unit_at({(area.west + area.east) / 2.0, (area.south + area.north) / 2.0});
  if (!metres) return std::nullopt;
  return *metres;
}

Result<LevelSummary> summarise(const store::StoreReader& reader, const LayerInfo& layer, Level level, const std::optional<Point2>& metres) {
  LevelSummary summary;
  summary.level = level;
  summary.data = layer.data_rect(level);
  const double scale = std::ldexp(1.0, paper_level(level, layer.finest));
  summary.gsd_crs = {layer.grid.step_x * scale, layer.grid.step_y * scale};
  if (metres) summary.gsd_m = Point2{summary.gsd_crs.x * metres->x, summary.gsd_crs.y * metres->y};

  const TexelRect tiles = layer.tile_rect(level);
  summary.tiles_in_data = static_cast<std::uint64_t>(tiles.width) * static_cast<std::uint64_t>(tiles.height);
  if (summary.tiles_in_data > kMaxCountedTiles || !layer.has_known_format()) return summary;
  summary.is_counted = true;
  for (std::int64_t y = tiles.y; y < tiles.bottom(); ++y) {
    for (std::int64_t x = tiles.x; x < tiles.right(); ++x) {
      VT_ASSIGN(const store::TileLookup found,
                reader.lookup(layer.id, {level, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)}));
      switch (found.kind) {
        case store::TileKind::kAbsent:
          ++summary.absent;
          break;
        case store::TileKind::kStored:
          ++summary.stored;
          summary.stored_bytes += found.stored_bytes;
          break;
        case store::TileKind::kConstant:
          ++summary.constant;
          break;
      }
    }
  }
  summary.ratio = compression_ratio(summary.stored + summary.constant, layer.tile_payload_bytes(), summary.stored_bytes);
  return summary;
}

// Metadata is for people and tools; when it is not JSON it is shown as the text it is.
nlohmann::ordered_json parsed_metadata(const std::string& metadata) {
  auto json = text::parse_ordered_json(metadata);
  return json ? std::move(*json) : nlohmann::ordered_json(metadata);
}

nlohmann::ordered_json rect_json(const TexelRect& rect) {
  return {{"x", rect.x}, {"y", rect.y}, {"width", rect.width}, {"height", rect.height}};
}

nlohmann::ordered_json point_json(const std::optional<Point2>& point) {
  if (!point) return nullptr;
  return {{"x", point->x}, {"y", point->y}};
}

nlohmann::ordered_json level_json(const LayerInfo& layer, const LevelSummary& level) {
  nlohmann::ordered_json json = {
      {"level", level.level.value},
      {"paper_level", paper_level(level.level, layer.finest)},
      {"data", rect_json(level.data)},
      {"gsd_crs_units", point_json(level.gsd_crs)},
      {"gsd_m", point_json(level.gsd_m)},
      {"tiles_in_data", level.tiles_in_data},
      {"tiles", nullptr},
      {"stored_bytes", nullptr},
      {"compression_ratio", nullptr},
  };
  if (level.is_counted) {
    json["tiles"] = {{"stored", level.stored}, {"constant", level.constant}, {"absent", level.absent}};
    json["stored_bytes"] = level.stored_bytes;
    if (level.ratio) json["compression_ratio"] = *level.ratio;
  }
  return json;
}

// Those that the layer's format has; none where it holds no numbers.
std::span<const ComponentRange> components_of(const LayerInfo& layer) {
  const FormatInfo& format = format_info(layer.format);
  return std::span(layer.components).first(format.samples == SampleKind::kOpaque ? 0 : format.channels);
}

nlohmann::ordered_json layer_json(const LayerInfo& layer, const std::vector<LevelSummary>& levels) {
  nlohmann::ordered_json json = {
      {"id", layer.id.value},
      {"name", layer.name},
      {"role", role_name(layer.role)},
      {"state", state_name(layer.state)},
      {"channel", channels::channel_name(layer.channel)},
      {"format", format_name(layer.format)},
      {"transfer", transfer_name(layer.transfer)},
      {"tile_texels", layer.tile_texels()},
      {"finest_level", layer.finest.value},
      {"vt_exponent", layer.vt_exponent()},
      {"data", rect_json(layer.data)},
      {"grid",
       {{"origin_x", layer.grid.origin_x},
        {"origin_y", layer.grid.origin_y},
        {"step_x", layer.grid.step_x},
        {"step_y", layer.grid.step_y}}},
      {"source_nodata", layer.source_nodata},  // NaN becomes null
      {"tiles", layer.tiles},
      {"constant_tiles", layer.constant_tiles},
      {"stored_bytes", layer.stored_bytes},
      {"compression_ratio", nullptr},
      {"metadata", parsed_metadata(layer.metadata_json)},
      {"levels", nlohmann::ordered_json::array()},
  };
  if (layer.has_owner()) json["owner"] = layer.owner.value;
  json["part"] = layer.is_part;
  json["zero_is_nodata"] = layer.zero_is_nodata;
  json["point_sampled"] = layer.is_point_sampled;
  json["components"] = nlohmann::ordered_json::array();
  for (const ComponentRange& range : components_of(layer)) json["components"].push_back({{"scale", range.scale}, {"offset", range.offset}});
  if (const auto ratio = compression_ratio(layer.tiles, layer.tile_payload_bytes(), layer.stored_bytes)) {
    json["compression_ratio"] = *ratio;
  }
  for (const LevelSummary& level : levels) json["levels"].push_back(level_json(layer, level));
  return json;
}

std::string step_text(Point2 value) {
  // Square texels are the rule; two numbers only where they differ.
  if (std::abs(value.x - value.y) <= 1e-9 * std::abs(value.x)) return fmt::format("{:.6g}", value.x);
  return fmt::format("{:.6g} x {:.6g}", value.x, value.y);
}

std::string layer_table(const LayerInfo& layer, const std::vector<LevelSummary>& levels) {
  std::string text = fmt::format("\nlayer {} \"{}\": {}, {}{}{}, {}\n", layer.id.value, layer.name, channels::channel_name(layer.channel),
                                 format_name(layer.format), layer.transfer == Transfer::kSrgb ? " sRGB" : "",
                                 layer.is_part ? fmt::format(", part of layer {}", layer.owner.value) : "", state_name(layer.state));
  text += fmt::format("  {} x {} texels, tiles of {}, finest level {}, vt {}, {} tiles in {}", layer.data.width, layer.data.height,
                      layer.tile_texels(), layer.finest.value, layer.vt_exponent(), layer.tiles, cli::format_bytes(layer.stored_bytes));
  if (const auto ratio = compression_ratio(layer.tiles, layer.tile_payload_bytes(), layer.stored_bytes)) {
    text += fmt::format(" ({:.2f} : 1)", *ratio);
  }
  if (!std::isnan(layer.source_nodata)) text += fmt::format(", source's nodata {:g}", layer.source_nodata);
  if (layer.zero_is_nodata && channels::kind_of(layer.channel).shown != channels::Shown::kClasses) text += ", code 0 is no data";
  text += '\n';
  if (!layer.has_known_format()) text += "  a newer program wrote this format, which this one cannot read\n";
  const auto metadata = parsed_metadata(layer.metadata_json);
  const std::vector<std::string> names = component_names(metadata);
  const std::string unit = unit_of(layer, metadata);
  for (std::size_t c = 0; c < components_of(layer).size(); ++c) {
    const ComponentRange& range = layer.components[c];
    if (range == ComponentRange()) continue;
    text += fmt::format("  {} = {} + {} * sample{}\n", c < names.size() ? names[c] : fmt::format("component {}", c),
                        cli::format_exact(range.offset), cli::format_exact(range.scale), unit.empty() ? "" : " " + unit);
  }
  if (layer.is_point_sampled)
    text +=
        "  point-sampled: a coarser texel is the north-western of the finest texels under it, and its value lies at that one's centre\n";
  const ClassTable classes = class_table_of(layer);
  if (classes.no_data) text += fmt::format("  code {} is no data\n", *classes.no_data);
  if (!classes.classes.empty()) text += fmt::format("  classes {}\n", classes.summary());
  const GridPlacement& grid = layer.grid;
  text += fmt::format("  extent west {:.10g}, south {:.10g}, east {:.10g}, north {:.10g}\n", grid.origin_x,
                      grid.origin_y - static_cast<double>(layer.data.height) * grid.step_y,
                      grid.origin_x + static_cast<double>(layer.data.width) * grid.step_x, grid.origin_y);

  constexpr std::string_view kRow = "  {:>5} {:>5}  {:>19}  {:>21}  {:>21}  {:>9} {:>9} {:>9}  {:>10}  {:>7}\n";
  text += fmt::format(fmt::runtime(kRow), "level", "paper", "texels", "CRS units/texel", "metres/texel", "stored", "constant", "absent",
                      "bytes", "ratio");
  for (const LevelSummary& level : levels) {
    const auto count = [&](std::uint64_t number) { return level.is_counted ? std::to_string(number) : std::string("-"); };
    text += fmt::format(fmt::runtime(kRow), int{level.level.value}, paper_level(level.level, layer.finest),
                        fmt::format("{} x {}", level.data.width, level.data.height), step_text(level.gsd_crs),
                        level.gsd_m ? step_text(*level.gsd_m) : "-", count(level.stored), count(level.constant), count(level.absent),
                        level.is_counted ? cli::format_bytes(level.stored_bytes) : "-",
                        level.ratio ? fmt::format("{:.2f}", *level.ratio) : "-");
  }
  return text + quality_table(metadata);
}

}  // namespace

Result<int> run_info(const InfoOptions& options) {
  VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtinspect", options.store));
  if (options.names_only) {
    for (const LayerInfo& layer : reader.layers()) {
      if (layer.role == LayerRole::kTexture) cli::print(layer.name + "\n");
    }
    return 0;
  }

  const auto metadata = parsed_metadata(reader.description().metadata_json);
  const Area& area = reader.description().area;
  const auto crs = crs_of(reader);
  // A store whose CRS we cannot read still has everything else to show.
  if (!crs) cli::print_note("vtinspect", crs.error().message);
  const auto metres = crs ? metres_per_unit(*crs, area) : std::nullopt;

  nlohmann::ordered_json json = {
      {"path", options.store.string()},
      {"uuid", reader.uuid()},
      {"generation", reader.generation()},
      {"file_bytes", reader.file_bytes()},
      {"health", cli::health_name(reader.health())},
      {"area", {{"west", area.west}, {"south", area.south}, {"east", area.east}, {"north", area.north}}},
      {"crs", crs ? nlohmann::ordered_json(crs->text()) : nlohmann::ordered_json(nullptr)},
      {"metadata", metadata},
      {"layers", nlohmann::ordered_json::array()},
  };
  std::string text = fmt::format("{}\n", options.store.string());
  text += fmt::format("  uuid        {}\n", reader.uuid());
  text += fmt::format("  generation  {}\n", reader.generation());
  text += fmt::format("  size        {} ({} bytes)\n", cli::format_bytes(reader.file_bytes()), reader.file_bytes());
  if (reader.health() != store::StoreHealth::kWhole) text += fmt::format("  damaged     {}\n", reader.health_remark());
  text +=
      fmt::format("  area        west {:.10g}, south {:.10g}, east {:.10g}, north {:.10g}\n", area.west, area.south, area.east, area.north);
  text += fmt::format("  CRS         {}\n", crs ? store::printable(crs->text()) : "unreadable");
  if (metadata.is_object() && metadata.contains("created_by") && metadata["created_by"].is_string()) {
    text += fmt::format("  created by  {}\n", store::printable(metadata["created_by"].get<std::string>()));
  }
  if (reader.layers().empty()) text += "  no layers yet\n";

  for (const LayerInfo& layer : reader.layers()) {
    std::vector<LevelSummary> levels;
    for (int value = 0; value <= layer.finest.value; ++value) {
      VT_ASSIGN(LevelSummary summary, summarise(reader, layer, Level{static_cast<std::uint8_t>(value)}, metres));
      levels.push_back(std::move(summary));
    }
    json["layers"].push_back(layer_json(layer, levels));
    if (layer.role == LayerRole::kCarry) {
      text += fmt::format("\nlayer {} \"{}\": the builder's intermediate state of layer {}, {}\n", layer.id.value, layer.name,
                          layer.owner.value, cli::format_bytes(layer.stored_bytes));
    } else {
      text += layer_table(layer, levels);
    }
  }

  if (options.json) {
    cli::print_json(json);
  } else {
    cli::print(text);
  }
  return 0;
}

}  // namespace vt::inspect
