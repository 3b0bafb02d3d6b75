#include "tools/vtinspect/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/text/json_text.h"
#include "store/texel/texel_decoder.h"
#include "store/vt_mapping.h"
#include "tools/cli/cli_support.h"
#include "tools/cli/open_store.h"
#include "tools/vtinspect/class_names.h"
#include "tools/vtinspect/quality_text.h"

namespace vt::inspect {

namespace {

// The place that was asked for, in every space that has a name for it.
struct Place {
  Point2 position;  // continuous, in texels of the level's padded square
  Point2 uv;
  Point2 crs;
  std::optional<Point2> lonlat;
};

struct Value {
  std::vector<double> channels;        // codes of byte formats, values of float formats; NaN is no data
  std::vector<double> linear;          // linear light 0..1, for sRGB layers
  std::optional<TileId> present_tile;  // the tile itself, or the nearest ancestor that the store holds
};

std::string pair_text(Point2 point) { return cli::format_exact(point.x) + ", " + cli::format_exact(point.y); }
nlohmann::ordered_json pair_json(Point2 point) { return {point.x, point.y}; }

Result<Point2> crs_from_argument(const SampleOptions& options, const geo::Crs& crs) {
  std::array<double, 2> numbers{};
  VT_CHECK(cli::parse_numbers(options.lonlat, "--lonlat", "LON,LAT, two numbers in degrees", numbers));
  if (crs.kind() == geo::CrsKind::kPixel) {
    return fail(ErrorCode::kUsage, fmt::format("{}: has no place on the Earth; use --texel or --uv", options.store.string()));
  }
  auto position = crs.crs_from_lonlat({numbers[0], numbers[1]});
  if (!position) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: longitude {}, latitude {} has no place in {}: {}", options.store.string(), cli::format_exact(numbers[0]),
                            cli::format_exact(numbers[1]), crs.text(), position.error().message));
  }
  return *position;
}

// The same place so many turns round the Earth further that it lies in the layer, if it lies there at all;
// else as near to it as can be.
Point2 turned_into(const LayerInfo& layer, const geo::Crs& crs, Point2 position) {
  const std::optional<double> turn = crs.turn();
  if (!turn) return position;
  const double west = layer.grid.origin_x;
  const double east = west + static_cast<double>(layer.data.width) * layer.grid.step_x;
  if (position.x >= west && position.x <= east) return position;
  const Point2 first{position.x + *turn * std::ceil((west - position.x) / *turn), position.y};
  // Just east of the layer may be nearer to its west edge than to its east edge, one turn on.
  const bool is_before = first.x > east && west - (first.x - *turn) < first.x - east;
  return is_before ? Point2{first.x - *turn, position.y} : first;
}

Result<Point2> position_from_arguments(const SampleOptions& options, const VtMapping& mapping, const LayerInfo& layer, Level level,
                                       const geo::Crs& crs) {
  const TexelRect data = layer.data_rect(level);
  if (!options.texel.empty()) {
    std::array<std::int64_t, 2> numbers{};
    VT_CHECK(cli::parse_integers(options.texel, "--texel", "X,Y, two whole numbers", numbers));
    const auto [x, y] = numbers;
    if (x < 0 || y < 0 || x >= data.width || y >= data.height) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("{}: texel {},{} is outside level {} of layer {}; valid: 0..{}, 0..{}", options.store.string(), x, y,
                              int{level.value}, layer.name, data.width - 1, data.height - 1));
    }
    const double offset = layer.value_offset(level);
    return Point2{static_cast<double>(data.x + x) + offset, static_cast<double>(data.y + y) + offset};
  }
  if (!options.uv.empty()) {
    std::array<double, 2> numbers{};
    VT_CHECK(cli::parse_numbers(options.uv, "--uv", "U,V, two numbers from 0 to 1", numbers));
    return mapping.texel_from_uv(level, {numbers[0], numbers[1]});
  }
  VT_ASSIGN(const Point2 position, crs_from_argument(options, crs));
  return mapping.texel_from_crs(level, turned_into(layer, crs, position));
}

// What is valid, in the terms in which the place was given.
std::string valid_range(const SampleOptions& options, const VtMapping& mapping, const LayerInfo& layer, const geo::Crs& crs) {
  // At the finest level: coarser texels may reach beyond the data.
  const TexelRect& data = layer.data;
  const Point2 north_west{static_cast<double>(data.x), static_cast<double>(data.y)};
  const Point2 south_east{static_cast<double>(data.right()), static_cast<double>(data.bottom())};
  if (!options.uv.empty()) {
    const Point2 a = mapping.uv_from_texel(layer.finest, north_west);
    const Point2 b = mapping.uv_from_texel(layer.finest, south_east);
    return fmt::format("u {:.10g} .. {:.10g}, v {:.10g} .. {:.10g}", a.x, b.x, b.y, a.y);
  }
  // Straight edges of the grid are curves on the Earth, so their corners and middles give the range only
  // roughly.
  double west = 0.0;
  double east = 0.0;
  double south = 0.0;
  double north = 0.0;
  bool is_first = true;
  for (int row = 0; row <= 2; ++row) {
    for (int column = 0; column <= 2; ++column) {
      const Point2 texel{north_west.x + (south_east.x - north_west.x) * column / 2.0,
                         north_west.y + (south_east.y - north_west.y) * row / 2.0};
      const auto lonlat = crs.lonlat_from_crs(mapping.crs_from_texel(layer.finest, texel));
      if (!lonlat) continue;
      west = is_first ? lonlat->x : std::min(west, lonlat->x);
      east = is_first ? lonlat->x : std::max(east, lonlat->x);
      south = is_first ? lonlat->y : std::min(south, lonlat->y);
      north = is_first ? lonlat->y : std::max(north, lonlat->y);
      is_first = false;
    }
  }
  return fmt::format("longitude about {:.8g} .. {:.8g}, latitude about {:.8g} .. {:.8g}", west, east, south, north);
}

Result<Value> read_value(const store::StoreReader& reader, const LayerInfo& layer, TileId tile, std::int64_t column, std::int64_t row) {
  Value value;
  VT_ASSIGN(value.present_tile, reader.nearest_present(layer.id, tile));
  if (!value.present_tile || *value.present_tile != tile) {
    const AbsentTexels absent = absent_texels(layer, tile.level);
    if (absent.is_data) value.channels.assign(static_cast<std::size_t>(layout_of(layer).channels), double{absent.value});
    return value;
  }

  const TexelLayout layout = layout_of(layer);
  const std::size_t edge = layer.tile_texels();
  std::vector<std::byte> payload(layer.tile_payload_bytes());
  VT_CHECK(reader.read(layer.id, tile, payload));
  const std::size_t at = static_cast<std::size_t>(row) * edge + static_cast<std::size_t>(column);
  if (layout.is_float) {  // in double: codes can hold what floats do not
    std::vector<float> samples(edge * edge * static_cast<std::size_t>(layout.channels));
    store::decode_texels(layer.format, payload, edge, edge, samples);
    const std::span<const float> here = std::span(samples).subspan(at * static_cast<std::size_t>(layout.channels));
    for (std::size_t c = 0; c < static_cast<std::size_t>(layout.channels); ++c) value.channels.push_back(value_of(layer, here, c));
    return value;
  }
  std::vector<std::byte> texels(edge * edge * layout.texel_bytes());
  decode_tile(layer, payload, texels);

  const std::byte* const texel = &texels[at * layout.texel_bytes()];
  for (int channel = 0; channel < layout.channels; ++channel) {
    const auto code = std::to_integer<std::uint8_t>(texel[channel]);
    value.channels.push_back(code);
    if (layer.transfer == Transfer::kSrgb) {
      value.linear.push_back(channel < 3 ? linear_from_srgb()[code] : code / 255.0);
    }
  }
  return value;
}

std::string layer_unit(const LayerInfo& layer) { return unit_of(layer, text::json_or_null(layer.metadata_json)); }

std::string numbers_text(const std::vector<double>& numbers, bool is_exact) {
  std::string text;
  for (const double number : numbers) {
    if (!text.empty()) text += ", ";
    // Nine digits give floats back exactly.
    const bool is_float = number == double{static_cast<float>(number)};
    text += std::isnan(number) ? "no data" : is_exact ? fmt::format("{}", number) : fmt::format("{:.{}g}", number, is_float ? 9 : 12);
  }
  return text;
}

}  // namespace

Result<int> run_sample(const SampleOptions& options) {
  const int ways = int{!options.lonlat.empty()} + int{!options.texel.empty()} + int{!options.uv.empty()};
  if (ways != 1) return fail(ErrorCode::kUsage, "sample: give exactly one of --lonlat, --texel and --uv");
  VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtinspect", options.store));
  VT_ASSIGN(const LayerInfo* const layer, choose_layer(reader, options.choice.layer));
  VT_ASSIGN(const Level level, choose_level(reader, *layer, options.choice.level));
  VT_ASSIGN(const geo::Crs crs, crs_of(reader));

  const VtMapping mapping(reader.description().area, *layer);
  VT_ASSIGN(const Point2 position, position_from_arguments(options, mapping, *layer, level, crs));
  // Held against the finest grid, because a coarse texel at the rim covers more than the data. Written so
  // that NaN is outside.
  const double scale = std::ldexp(1.0, paper_level(level, layer->finest));
  const Point2 finest{position.x * scale, position.y * scale};
  const TexelRect data = layer->data_rect(level);
  const bool is_inside =
      !options.texel.empty() || (finest.x >= static_cast<double>(layer->data.x) && finest.x <= static_cast<double>(layer->data.right()) &&
                                 finest.y >= static_cast<double>(layer->data.y) && finest.y <= static_cast<double>(layer->data.bottom()));
  if (!is_inside) {
    return fail(
        ErrorCode::kNotFound,
        fmt::format("{}: {} {} is outside layer {}; valid: {}", options.store.string(), options.uv.empty() ? "longitude, latitude" : "u, v",
                    options.uv.empty() ? options.lonlat : options.uv, layer->name, valid_range(options, mapping, *layer, crs)));
  }

  // The texel whose value lies nearest. The east and south edges belong to the last texel, as u = 1 and v = 0
  // belong to the area.
  const double offset = layer->value_offset(level);
  const auto nearest = [&](double at) { return static_cast<std::int64_t>(std::floor(at + 0.5 - offset)); };
  const std::int64_t x = std::clamp(nearest(position.x), data.x, data.right() - 1);
  const std::int64_t y = std::clamp(nearest(position.y), data.y, data.bottom() - 1);
  const int exponent = layer->tile_exponent;
  const TileId tile{level, static_cast<std::uint32_t>(x >> exponent), static_cast<std::uint32_t>(y >> exponent)};
  const TexelRect tile_place = rect_of(tile, exponent);

  Place place{position, mapping.uv_from_texel(level, position), mapping.crs_from_texel(level, position), std::nullopt};
  if (crs.kind() != geo::CrsKind::kPixel) {
    if (const auto lonlat = crs.lonlat_from_crs(place.crs)) place.lonlat = *lonlat;
  }
  const Point2 value_place = mapping.crs_from_texel(level, {static_cast<double>(x) + offset, static_cast<double>(y) + offset});
  VT_ASSIGN(const Value value, read_value(reader, *layer, tile, x - tile_place.x, y - tile_place.y));
  const bool is_present = value.present_tile == tile;

  if (options.json) {
    nlohmann::ordered_json json = {
        {"path", options.store.string()},
        {"layer", layer->name},
        {"channel", channels::channel_name(layer->channel)},
        {"unit", layer_unit(*layer)},
        {"format", format_info(layer->format).name},
        {"level", level.value},
        {"texel", {x - data.x, y - data.y}},
        {"texel_in_square", {x, y}},
        {"tile", {{"level", tile.level.value}, {"x", tile.x}, {"y", tile.y}}},
        {"texel_in_tile", {x - tile_place.x, y - tile_place.y}},
        {"tile_present", is_present},
        {"nearest_present", nullptr},
        {"position", {place.position.x - static_cast<double>(data.x), place.position.y - static_cast<double>(data.y)}},
        {"uv", pair_json(place.uv)},
        {"crs", pair_json(place.crs)},
        {"lonlat", nullptr},
        {"value_crs", pair_json(value_place)},
        {"value", nullptr},
        {"linear", nullptr},
    };
    if (value.present_tile) {
      json["nearest_present"] = {{"level", value.present_tile->level.value}, {"x", value.present_tile->x}, {"y", value.present_tile->y}};
    }
    if (place.lonlat) json["lonlat"] = pair_json(*place.lonlat);
    if (!value.channels.empty()) json["value"] = value.channels;  // NaN becomes null
    if (!value.linear.empty()) json["linear"] = value.linear;
    cli::print_json(json);
    return 0;
  }

  std::string text =
      fmt::format("layer     {} ({}, {})\n", layer->name, channels::channel_name(layer->channel), format_info(layer->format).name);
  text += fmt::format("level     {} (finest {}, paper level {})\n", int{level.value}, int{layer->finest.value},
                      paper_level(level, layer->finest));
  text += fmt::format("texel     {}, {}\n", x - data.x, y - data.y);
  text += fmt::format("tile      level {}, {},{}; texel {}, {} in it\n", int{tile.level.value}, tile.x, tile.y, x - tile_place.x,
                      y - tile_place.y);
  text += fmt::format("uv        {}\n", pair_text(place.uv));
  text += fmt::format("crs       {}\n", pair_text(place.crs));
  if (place.lonlat) text += fmt::format("lon, lat  {}\n", pair_text(*place.lonlat));
  if (layer->is_point_sampled) text += fmt::format("sampled   at crs {}\n", pair_text(value_place));
  if (!is_present && value.channels.empty()) {
    text += value.present_tile ? fmt::format("value     none: the tile is absent; nearest above: level {}, {},{}\n",
                                             int{value.present_tile->level.value}, value.present_tile->x, value.present_tile->y)
                               : std::string("value     none: the tile and all above it are absent\n");
  } else {
    const std::string unit = layer_unit(*layer);
    text += fmt::format("value     {}{}{}{}\n", numbers_text(value.channels, !layout_of(*layer).is_float), unit.empty() ? "" : " ", unit,
                        is_present ? "" : " (its tile is absent: voids are filled)");
    if (channels::kind_of(layer->channel).shown == channels::Shown::kClasses && !layer->is_part && std::isfinite(value.channels[0])) {
      const std::string name = class_table_of(*layer).name_of(static_cast<int>(value.channels[0]));
      if (!name.empty()) text += fmt::format("class     {}\n", name);
    }
    if (!value.linear.empty()) text += fmt::format("linear    {}\n", numbers_text(value.linear, false));
  }
  cli::print(text);
  return 0;
}

}  // namespace vt::inspect
