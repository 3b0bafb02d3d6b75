#include "tools/vtbench/inputs/large_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "store/format/layout.h"
#include "store/index/index_builder.h"
#include "store/index/new_store.h"
#include "store/io/uuid.h"
#include "tools/cli/cli_support.h"

namespace vt::bench {
namespace {

constexpr std::uint8_t kTileExponent = 8;
constexpr std::size_t kValues = 7;

std::uint64_t tiles_of(std::uint64_t side) {
  std::uint64_t tiles = side * side;
  for (; side > 1; tiles += side * side) side = (side + 1) / 2;
  return tiles;
}

Result<void> visit_square(std::uint64_t side, std::uint64_t first, int levels,
                          const std::function<Result<void>(std::uint64_t, std::uint64_t)>& visit) {
  const std::uint64_t x = store::morton_column(first);
  const std::uint64_t y = store::morton_column(first >> 1);
  const std::uint64_t edge = std::uint64_t{1} << levels;
  if (x >= side || y >= side) return {};
  if (x + edge <= side && y + edge <= side) return visit(first, edge * edge);
  for (std::uint64_t quarter = 0; quarter < 4; ++quarter)
    VT_CHECK(visit_square(side, first + quarter * (edge / 2) * (edge / 2), levels - 1, visit));
  return {};
}

// Pages behind each other in the order in which they are finished.
struct AppendPages final : store::IndexBuilder::Sink {
  explicit AppendPages(store::NewStore& new_store) : target(new_store) {}
  Result<store::Reference> place_page(std::uint64_t key, int, std::span<const std::byte> payload) override {
    return target.append(store::RecordType::kPage, key, payload);
  }
  store::NewStore& target;
};

}  // namespace

IndexShape::IndexShape(std::uint64_t tiles) {
  // All levels together have about four thirds of the finest one.
  side_ = static_cast<std::uint64_t>(std::sqrt(0.75 * static_cast<double>(tiles)));
  while (side_ > 1 && tiles_of(side_ - 1) >= tiles) --side_;
  while (tiles_of(side_) < tiles) ++side_;
  while ((std::uint64_t{1} << finest_.value) < side_) ++finest_.value;
}

std::uint64_t IndexShape::side(Level level) const {
  const int steps = finest_.value - level.value;
  return (side_ + (std::uint64_t{1} << steps) - 1) >> steps;
}

std::uint64_t IndexShape::tiles() const { return tiles_of(side_); }

LayerInfo IndexShape::layer() const {
  LayerInfo layer;
  layer.name = "index";
  layer.format = TexelFormat::kRgb8;
  layer.transfer = Transfer::kSrgb;
  layer.tile_exponent = kTileExponent;
  layer.finest = finest_;
  const auto edge = static_cast<std::int64_t>(side_ << kTileExponent);
  layer.data = {0, 0, edge, edge};
  return layer;
}

TileId IndexShape::any_tile(std::mt19937_64& random) const {
  std::uint64_t number = random() % tiles();
  for (Level level = finest_;; --level.value) {
    const std::uint64_t columns = side(level);
    if (number < columns * columns)
      return {level, static_cast<std::uint32_t>(number % columns), static_cast<std::uint32_t>(number / columns)};
    number -= columns * columns;
  }
}

Result<void> IndexShape::for_each_run(Level level, const std::function<Result<void>(std::uint64_t, std::uint64_t)>& visit) const {
  return visit_square(side(level), 0, level.value, visit);
}

std::vector<TileId> anywhere(const IndexShape& shape, std::size_t count, std::mt19937_64& random) {
  std::vector<TileId> tiles;
  tiles.reserve(count);
  while (tiles.size() < count) tiles.push_back(shape.any_tile(random));
  return tiles;
}

std::vector<TileId> flight(const IndexShape& shape, std::size_t count, std::mt19937_64& random) {
  constexpr int kLevels = 5;
  constexpr std::int64_t kReach = 32;
  constexpr std::size_t kLookupsPerStep = 16;
  const auto columns = static_cast<std::int64_t>(shape.side(shape.finest()));
  std::int64_t x = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(columns));
  std::int64_t y = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(columns));
  std::int64_t step = 1;
  std::vector<TileId> tiles;
  tiles.reserve(count);
  while (tiles.size() < count) {
    if (tiles.size() % kLookupsPerStep == 0) {
      if (x + step < 0 || x + step >= columns) step = -step;
      if (columns > 1) x += step;
    }
    const int steps = static_cast<int>(random() % kLevels);
    if (steps > shape.finest().value) continue;
    const Level level{static_cast<std::uint8_t>(shape.finest().value - steps)};
    const auto limit = static_cast<std::int64_t>(shape.side(level)) - 1;
    const auto near = [&](std::int64_t center) {
      const auto offset = static_cast<std::int64_t>(random() % (2 * kReach)) - kReach;
      return static_cast<std::uint32_t>(std::clamp<std::int64_t>((center >> steps) + offset, 0, limit));
    };
    const std::uint32_t column = near(x);
    tiles.push_back({level, column, near(y)});
  }
  return tiles;
}

Result<void> write_index(const std::filesystem::path& path, const IndexShape& shape,
                         const std::function<Result<void>(std::uint64_t done)>& progress) {
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  // Pages, and a few per cent for half empty ones along the edges.
  const std::uint64_t wanted = shape.tiles() * 17 + (std::uint64_t{1} << 24);
  std::error_code problem;
  const auto space = std::filesystem::space(folder, problem);
  if (!problem && space.available < wanted)
    return fail(ErrorCode::kIo, folder.string() + ": has room for " + cli::format_bytes(space.available) + ", the index takes " +
                                    cli::format_bytes(wanted) + "; free some space or choose another --scratch");

  VT_ASSIGN(const auto target, store::NewStore::begin(path, {.sync = false}));
  store::Catalog catalog;
  catalog.layers.push_back({.info = shape.layer(), .roots = std::vector<store::Reference>(shape.finest().value + std::size_t{1})});
  LayerInfo& info = catalog.layers.front().info;
  info.state = LayerState::kComplete;
  VT_ASSIGN(const std::uint64_t catalog_room, store::NewStore::catalog_room(catalog));
  VT_ASSIGN(const std::uint64_t catalog_at, target->reserve(catalog_room));

  std::array<store::Reference, kValues> values;
  for (std::size_t i = 0; i < kValues; ++i) {
    const std::array<std::byte, 3> texel = {static_cast<std::byte>(i), std::byte{1}, std::byte{2}};
    VT_ASSIGN(values[i], target->append(store::RecordType::kConstant, 0, texel));
  }
  AppendPages pages(*target);
  for (int number = 0; number <= shape.finest().value; ++number) {
    const Level level{static_cast<std::uint8_t>(number)};
    store::IndexBuilder builder(pages, info.id, level);
    const auto add_run = [&](std::uint64_t first, std::uint64_t count) -> Result<void> {
      for (std::uint64_t morton = first; morton < first + count; ++morton) {
        VT_CHECK(builder.add(morton, values[(morton * 0x9E3779B97F4A7C15 >> 32) % kValues]));
        if (++info.tiles % (1 << 20) == 0) VT_CHECK(progress(info.tiles));
      }
      return {};
    };
    VT_CHECK(shape.for_each_run(level, add_run));
    VT_ASSIGN(catalog.layers.front().roots[level.value], builder.finish());
  }
  info.constant_tiles = info.tiles;
  info.stored_bytes = info.tiles * values.front().record_bytes();
  return target->publish(catalog, {.uuid = store::random_uuid(), .catalog_at = catalog_at});
}

Result<void> warm_index(const store::StoreReader& reader, LayerId layer, const IndexShape& shape) {
  for (int number = 0; number <= shape.finest().value; ++number) {
    const Level level{static_cast<std::uint8_t>(number)};
    std::uint64_t next_leaf = 0;
    const auto touch = [&](std::uint64_t first, std::uint64_t count) -> Result<void> {
      for (std::uint64_t leaf = std::max(next_leaf, first / store::kPageSlots); leaf <= (first + count - 1) / store::kPageSlots; ++leaf) {
        VT_CHECK(reader.lookup(layer, store::tile_from_morton(level, std::max(first, leaf * store::kPageSlots))));
        next_leaf = leaf + 1;
      }
      return {};
    };
    VT_CHECK(shape.for_each_run(level, touch));
  }
  return {};
}

}  // namespace vt::bench
