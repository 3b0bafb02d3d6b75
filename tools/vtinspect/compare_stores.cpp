// vtinspect compare of two stores: layer by layer and tile by tile.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "builder/channels/all_channels.h"
#include "store/store_reader.h"
#include "tools/cli/open_store.h"
#include "tools/vtinspect/comparison.h"

namespace vt::inspect {

namespace {

// Why tiles of the two layers cannot be held side by side; "" when they can.
std::string grid_mismatch(const LayerInfo& a, const LayerInfo& b) {
  if (a.channel != b.channel) {
    return fmt::format("layer {}: channel {} and {}", a.name, channels::channel_name(a.channel), channels::channel_name(b.channel));
  }
  if (a.format != b.format) {
    return fmt::format("layer {}: format {} and {}", a.name, format_name(a.format), format_name(b.format));
  }
  if (!a.has_known_format()) return unknown_format_text(a);
  if (a.transfer != b.transfer) {
    return fmt::format("layer {}: transfer {} and {}", a.name, transfer_name(a.transfer), transfer_name(b.transfer));
  }
  if (a.tile_exponent != b.tile_exponent) return fmt::format("layer {}: tiles of {} and {}", a.name, a.tile_texels(), b.tile_texels());
  if (a.finest != b.finest) return fmt::format("layer {}: finest level {} and {}", a.name, int{a.finest.value}, int{b.finest.value});
  if (a.data != b.data) {
    return fmt::format("layer {}: data {} x {} at {},{} and {} x {} at {},{}", a.name, a.data.width, a.data.height, a.data.x, a.data.y,
                       b.data.width, b.data.height, b.data.x, b.data.y);
  }
  if (a.grid != b.grid) {
    return fmt::format("layer {}: grid origin {}, {} step {}, {} and origin {}, {} step {}, {}", a.name, cli::format_exact(a.grid.origin_x),
                       cli::format_exact(a.grid.origin_y), cli::format_exact(a.grid.step_x), cli::format_exact(a.grid.step_y),
                       cli::format_exact(b.grid.origin_x), cli::format_exact(b.grid.origin_y), cli::format_exact(b.grid.step_x),
                       cli::format_exact(b.grid.step_y));
  }
  if (a.components != b.components || a.zero_is_nodata != b.zero_is_nodata)
    return fmt::format("layer {}: its samples are not worth the same (component ranges)", a.name);
  if (a.is_point_sampled != b.is_point_sampled)
    return fmt::format("layer {}: the values of coarser levels are picked in one and means in the other", a.name);
  return "";
}

// Two layers on one grid.
class LayerComparer {
 public:
  LayerComparer(const store::StoreReader& first, const LayerInfo& a, const store::StoreReader& second, const LayerInfo& b)
      : first_(first),
        second_(second),
        a_(a),
        b_(b),
        layout_(layout_of(a)),
        is_class_(empty_difference(a).is_class),
        payload_a_(a.tile_payload_bytes()),
        payload_b_(payload_a_.size()),
        texels_a_(std::size_t{a.tile_texels()} * a.tile_texels() * layout_.texel_bytes()),
        texels_b_(texels_a_.size()) {}

  // Tiles that neither has cost nothing: a layer may have room for many more than there are.
  [[nodiscard]] Result<LevelDifference> compare(Level level, cli::Progress& progress, std::uint64_t& tiles_done) {
    LevelDifference difference;
    difference.level = level.value;
    const auto counted = [&](const auto& look_at) {
      return [&, look_at](TileId tile) -> Result<void> {
        if (cli::interrupt_flag().load()) return fail(ErrorCode::kCancelled, "compare: stopped");
        progress.update(++tiles_done);
        return look_at(tile);
      };
    };
    VT_CHECK(first_.for_each_tile(a_.id, level, counted([&](TileId tile) { return compare_tile(tile, difference); })));
    VT_CHECK(second_.for_each_tile(b_.id, level, counted([&](TileId tile) -> Result<void> {
                                     VT_ASSIGN(const store::TileLookup in_first, first_.lookup(a_.id, tile));
                                     if (in_first.kind == store::TileKind::kAbsent) ++difference.tiles, ++difference.only_in_second;
                                     return {};
                                   })));
    return difference;
  }

 private:
  // A tile that the first one has.
  [[nodiscard]] Result<void> compare_tile(TileId tile, LevelDifference& difference) {
    VT_ASSIGN(const store::TileLookup in_second, second_.lookup(b_.id, tile));
    ++difference.tiles;
    if (in_second.kind == store::TileKind::kAbsent) {
      ++difference.only_in_first;
      return {};
    }
    if (a_.holds_blobs()) {
      VT_CHECK(first_.read_blob(a_.id, tile, payload_a_));
      VT_CHECK(second_.read_blob(b_.id, tile, payload_b_));
      difference.differing_tiles += payload_a_ == payload_b_ ? 0 : 1;
      return {};
    }
    VT_CHECK(first_.read(a_.id, tile, payload_a_));
    VT_CHECK(second_.read(b_.id, tile, payload_b_));
    add_texels(tile, payload_a_ == payload_b_, difference);
    return {};
  }

  void add_texels(TileId tile, bool is_equal, LevelDifference& difference) {
    const TexelRect place = rect_of(tile, a_.tile_exponent);
    const TexelRect part = intersect(place, a_.data_rect(tile.level));
    const bool is_srgb = a_.transfer == Transfer::kSrgb && !layout_.is_float;
    const auto texels = static_cast<std::uint64_t>(part.width * part.height);
    difference.texels += texels;
    if (is_equal) {
      difference.values.count += texels * static_cast<std::uint64_t>(layout_.channels);
      if (is_srgb) difference.linear.count += texels * 3;
      return;
    }
    ++difference.differing_tiles;
    decode_tile(a_, payload_a_, texels_a_);
    decode_tile(b_, payload_b_, texels_b_);
    const auto channels = static_cast<std::size_t>(layout_.channels);
    for (std::int64_t y = part.y - place.y; y < part.bottom() - place.y; ++y) {
      for (std::int64_t x = part.x - place.x; x < part.right() - place.x; ++x) {
        const std::size_t at = static_cast<std::size_t>(y * place.width + x) * channels;
        bool differs = false;
        bool only_in_first = false;
        bool only_in_second = false;
        for (std::size_t channel = 0; channel < channels; ++channel) {
          const double first = sample_at(texels_a_, at + channel, layout_.is_float);
          const double second = sample_at(texels_b_, at + channel, layout_.is_float);
          if (std::isnan(first) && std::isnan(second)) continue;  // two holes are equal
          only_in_first = only_in_first || std::isnan(second);
          only_in_second = only_in_second || std::isnan(first);
          differs = differs || !(first == second);
          if (!std::isnan(first) && !std::isnan(second)) add_pair(difference, first, second, is_class_, is_srgb && channel < 3);
        }
        difference.differing_texels += differs ? 1 : 0;
        difference.data_only_in_first += only_in_first ? 1 : 0;
        difference.data_only_in_second += only_in_second && !only_in_first ? 1 : 0;
      }
    }
  }

  const store::StoreReader& first_;
  const store::StoreReader& second_;
  const LayerInfo& a_;
  const LayerInfo& b_;
  TexelLayout layout_;
  bool is_class_;
  std::vector<std::byte> payload_a_;
  std::vector<std::byte> payload_b_;
  std::vector<std::byte> texels_a_;
  std::vector<std::byte> texels_b_;
};

}  // namespace

Result<Comparison> compare_stores(const CompareOptions& options) {
  VT_ASSIGN(const store::StoreReader first, cli::open_store("vtinspect", options.first));
  VT_ASSIGN(const store::StoreReader second, cli::open_store("vtinspect", options.second));
  std::vector<const LayerInfo*> wanted;
  if (options.layer.empty()) {
    for (const LayerInfo& layer : first.layers()) {
      if (layer.role == LayerRole::kTexture || options.all) wanted.push_back(&layer);
    }
  } else {
    VT_ASSIGN(const LayerInfo* const layer, choose_layer(first, options.layer));
    wanted.push_back(layer);
  }

  Comparison comparison;
  if (first.description().area != second.description().area) comparison.mismatches.emplace_back("the areas differ");
  if (options.layer.empty()) {
    for (const LayerInfo& layer : second.layers()) {
      const bool counts = layer.role == LayerRole::kTexture || options.all;
      if (counts && first.find_layer(layer.name) == nullptr) {
        comparison.mismatches.push_back(fmt::format("layer {}: only in {}", layer.name, options.second.string()));
      }
    }
  }
  cli::Progress progress({.mode = options.progress, .title = "comparing", .unit = "tiles"});
  std::uint64_t total = 0;
  for (const LayerInfo* layer : wanted) {
    const LayerInfo* const other = second.find_layer(layer->name);
    total += layer->tiles + (other == nullptr ? 0 : other->tiles);
  }
  progress.set_total(total);
  progress.update(0);
  std::uint64_t tiles_done = 0;
  for (const LayerInfo* layer : wanted) {
    const LayerInfo* const other = second.find_layer(layer->name);
    if (other == nullptr) {
      comparison.mismatches.push_back(fmt::format("layer {}: only in {}", layer->name, options.first.string()));
      continue;
    }
    if (std::string mismatch = grid_mismatch(*layer, *other); !mismatch.empty()) {
      comparison.mismatches.push_back(std::move(mismatch));
      continue;
    }
    LayerDifference difference = empty_difference(*layer);
    LayerComparer comparer(first, *layer, second, *other);
    for (int value = 0; value <= layer->finest.value; ++value) {
      VT_ASSIGN(LevelDifference level, comparer.compare(Level{static_cast<std::uint8_t>(value)}, progress, tiles_done));
      difference.levels.push_back(level);
    }
    comparison.layers.push_back(std::move(difference));
  }
  progress.finish();
  return comparison;
}

}  // namespace vt::inspect
