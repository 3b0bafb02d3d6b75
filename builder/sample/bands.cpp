#include "builder/sample/bands.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "builder/sample/noise.h"

namespace vt::sample {
namespace {

// The class of most of the four texels; of equally many, the one with the largest number, which are the works
// of man.
std::uint8_t majority(std::array<Material, 4> classes) {
  std::sort(classes.begin(), classes.end());
  Material best = classes[0];
  int best_count = 0;
  for (const Material candidate : classes) {
    const auto count = static_cast<int>(std::count(classes.begin(), classes.end(), candidate));
    if (count < best_count) continue;
    best = candidate;
    best_count = count;
  }
  return static_cast<std::uint8_t>(best);
}

void copy_square(const Square& square, std::int64_t size, std::int64_t x0, Band& band) {
  const std::int64_t columns = std::min<std::int64_t>(kSquare, size - x0);
  for (std::int64_t y = 0; y < band.rows; ++y)
    std::memcpy(&band.rgb[static_cast<std::size_t>((y * size + x0) * 3)], &square.rgb[static_cast<std::size_t>(y * kSquare * 3)],
                static_cast<std::size_t>(columns * 3));
  for (std::int64_t y = 0; y < band.rows / kMaterialStep; ++y) {
    for (std::int64_t x = 0; x < columns / kMaterialStep; ++x) {
      const Material* texel = &square.material[static_cast<std::size_t>(y * kMaterialStep * kSquare + x * kMaterialStep)];
      band.material[static_cast<std::size_t>(y * (size / kMaterialStep) + x0 / kMaterialStep + x)] =
          majority({texel[0], texel[1], texel[kSquare], texel[kSquare + 1]});
    }
  }
  for (std::int64_t y = 0; y < band.rows / kHeightStep; ++y)
    std::copy_n(&square.height_m[static_cast<std::size_t>(y * kHeightSquare)], columns / kHeightStep,
                &band.height_m[static_cast<std::size_t>(y * (size / kHeightStep) + x0 / kHeightStep)]);
}

constexpr Light sodium(Position p, float height_m) { return {p, height_m, 1.0F, 0.62F, 0.28F, 70.0F}; }
constexpr Light white(Position p, float height_m, float power_w) { return {p, height_m, 1.0F, 0.93F, 0.82F, power_w}; }

}  // namespace

void paint_band(const World& world, std::int64_t size, std::int64_t index, Band& band) {
  band.rows = std::min<std::int64_t>(kSquare, size - index * kSquare);
  band.rgb.resize(static_cast<std::size_t>(size * band.rows * 3));
  band.material.resize(static_cast<std::size_t>(size / kMaterialStep * (band.rows / kMaterialStep)));
  band.height_m.resize(static_cast<std::size_t>(size / kHeightStep * (band.rows / kHeightStep)));

  struct Worker {
    explicit Worker(const World& w) : painter(std::make_unique<Painter>(w)), square(std::make_unique<Square>()) {}
    std::unique_ptr<Painter> painter;
    std::unique_ptr<Square> square;
  };
  tbb::enumerable_thread_specific<Worker> workers([&world] { return Worker(world); });
  tbb::parallel_for(std::int64_t{0}, band_count(size), [&](std::int64_t column) {
    Worker& worker = workers.local();
    worker.painter->paint(column * kSquare - size / 2, index * kSquare - size / 2, *worker.square);
    copy_square(*worker.square, size, column * kSquare, band);
  });
}

std::vector<Light> lights_of(const World& world, std::int64_t size) {
  const double half = static_cast<double>(size) * kTexelMetres / 2.0;
  std::vector<Light> lights;
  const auto add = [&](const Light& light) {
    if (light.position.x >= -half && light.position.x < half && light.position.y >= -half && light.position.y < half)
      lights.push_back(light);
  };

  // The scene's corners in coast coordinates; the bend of the streets moves them by less than 60 m.
  const double reach = half * 1.4 + 60.0;
  const double first_inland = World::kCentreInland - reach;
  const double last_inland = World::kCentreInland + reach;

  // Lamps beside the main roads, on alternating sides.
  for (std::int64_t i = floor_int(-reach / 40.0); i <= floor_int(reach / 40.0); ++i) {
    Position p = world.coast_road_point(static_cast<double>(i) * 40.0);
    const double side = i % 2 == 0 ? 5.4 : -5.4;
    p = {p.x + 0.6 * side, p.y + 0.8 * side};
    const Ground g = world.ground(p);
    if (g.dry_m > 0.0F && g.river_m > 0.0F && (g.town > -0.4F || i % 2 == 0)) add(sodium(p, 8.0F));
  }
  for (std::int64_t river = floor_int(-reach / World::kRiverSpacing); river <= floor_int(reach / World::kRiverSpacing) + 1; ++river) {
    for (std::int64_t i = floor_int(first_inland / 90.0); i <= floor_int(last_inland / 90.0); ++i) {
      Position p = world.valley_road_point(river, static_cast<double>(i) * 90.0);
      p = {p.x + 0.8 * 4.6, p.y - 0.6 * 4.6};
      const Ground g = world.ground(p);
      if (g.valley_road_m < 8.0F && g.river_m > 0.0F) add(sodium(p, 7.0F));
    }
  }

  // Streets and buildings of the towns.
  const std::int64_t last_i = floor_int(std::min(last_inland, World::kTownLimit) / static_cast<double>(World::kBlockInland));
  for (std::int64_t i = floor_int(std::max(first_inland, 0.0) / static_cast<double>(World::kBlockInland)); i <= last_i; ++i) {
    for (std::int64_t j = floor_int(-reach / static_cast<double>(World::kBlockShore));
         j <= floor_int(reach / static_cast<double>(World::kBlockShore)); ++j) {
      const Block block = world.block(i, j);
      if (!block.urban) continue;
      const double inland = static_cast<double>(i) * static_cast<double>(World::kBlockInland);
      const double shore = static_cast<double>(j) * static_cast<double>(World::kBlockShore);
      const double kerb = static_cast<double>(World::kStreetHalf) - 0.6;
      for (const double along : {15.0, 44.0, 73.0}) add(sodium(world.position_from_street(inland + kerb, shore + along), 6.0F));
      for (const double along : {14.0, 43.0}) add(sodium(world.position_from_street(inland + along, shore + kerb), 6.0F));
      if (block.use == Block::Use::kPark) add(white(world.position_from_street(inland + 29.0, shore + 44.0), 4.0F, 40.0F));
      for (const Building& b : block.buildings) {
        if (b.half_inland == 0.0F) continue;
        const double edge = static_cast<double>(b.inland - b.half_inland) - 0.5;
        const Position door = world.position_from_street(edge, static_cast<double>(b.shore));
        if (block.use == Block::Use::kIndustry) {
          add(white(door, b.eaves_m, 400.0F));
        } else if (unit(rehash(b.look, 20)) < 0.6F) {
          add(white(door, 2.5F, block.use == Block::Use::kCentre ? 60.0F : 25.0F));
        }
      }
    }
  }
  return lights;
}

}  // namespace vt::sample
