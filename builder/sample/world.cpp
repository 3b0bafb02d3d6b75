#include "builder/sample/world.h"

#include <algorithm>
#include <cmath>

#include "builder/sample/noise.h"

namespace vt::sample {
namespace {

// One number per use of randomness; the order is part of the scene.
enum Salt : std::uint32_t {
  kCoastSalt = 1,
  kHillSalt,
  kMountainSalt,
  kRangeSalt,
  kRiverSalt,
  kLakeSalt,
  kRoadSalt,
  kValleySalt,
  kTownSalt,
  kBendSalt,
  kBlockSalt,
  kMoistureSalt,
  kParcelSalt,
  kParcelBendSalt,
  kPlainSalt
};

constexpr double kTownSpacing = 1500.0;

// The lake: where along a river the valley widens.
constexpr float kLakeFirst = 1010.0F;
constexpr float kLakeLast = 1230.0F;

// Water level along a river, a function of the distance inland only, so that water never flows uphill.
float water_level(float inland) {
  const float plain = 0.012F * std::max(0.0F, inland - 220.0F);
  // Level on the lake; below and above it the river makes up for it.
  const float t = inland < kLakeFirst ? inland : inland < kLakeLast ? kLakeFirst : inland - (kLakeLast - kLakeFirst);
  const float climb = std::max(0.0F, t - 700.0F);
  return plain * (inland < kLakeFirst ? 1.0F : 0.0F) + (inland < kLakeFirst ? 0.0F : 0.012F * (kLakeFirst - 220.0F)) +
         climb * climb / (climb + 900.0F) * 0.35F;
}

}  // namespace

World::World(std::uint64_t seed) : seed_(hash(static_cast<std::uint32_t>(seed), static_cast<std::int64_t>(seed >> 32U), 77)) {}

std::uint32_t World::salt(std::uint32_t use) const { return seed_ + use * 0x9E3779B9U; }

World::Curve World::river_course(std::int64_t river, double inland) const {
  const std::uint32_t s = salt(kRiverSalt) + static_cast<std::uint32_t>(river) * 101U;
  const Noise1 a = noise1(s, inland / 620.0);
  const Noise1 b = noise1(s + 1, inland / 240.0);
  const Noise1 c = noise1(s + 2, inland / 75.0);
  return {static_cast<float>(static_cast<double>(river) * kRiverSpacing) - 330.0F + 170.0F * a.value + 60.0F * b.value + 9.0F * c.value,
          170.0F / 620.0F * a.slope + 60.0F / 240.0F * b.slope + 9.0F / 75.0F * c.slope};
}

World::Curve World::coast_road(double shore) const {
  const Noise1 a = noise1(salt(kRoadSalt), shore / 540.0);
  const Noise1 b = noise1(salt(kRoadSalt) + 1, shore / 170.0);
  return {430.0F + 70.0F * a.value + 14.0F * b.value, 70.0F / 540.0F * a.slope + 14.0F / 170.0F * b.slope};
}

World::Curve World::valley_road(std::int64_t river, double inland) const {
  const Curve course = river_course(river, inland);
  const Noise1 a = noise1(salt(kValleySalt), inland / 190.0);
  const float lake = smoothstep(kLakeFirst - 130.0F, kLakeFirst, static_cast<float>(inland)) *
                     (1.0F - smoothstep(kLakeLast, kLakeLast + 130.0F, static_cast<float>(inland)));
  return {course.value + 58.0F + 12.0F * a.value + 85.0F * lake, course.slope + 12.0F / 190.0F * a.slope};
}

Position World::coast_road_point(double shore) const { return position_from_coast(coast_road(shore).value, shore); }
Position World::valley_road_point(std::int64_t river, double inland) const {
  return position_from_coast(inland, valley_road(river, inland).value);
}

// Mountains: each octave of noise weighs less where the octaves before are steep, as if their slopes were
// washed smooth. The construction is Inigo Quilez's derivative-damped sum (iquilezles.org, "value noise
// derivatives"). About 0..1.3.
float World::eroded(Position p) const {
  double x = p.x / 820.0;
  double y = p.y / 820.0;
  float sum = 0.0F;
  float amplitude = 0.5F;
  float slope_x = 0.0F;
  float slope_y = 0.0F;
  for (std::uint32_t octave = 0; octave < 9; ++octave) {
    const Noise2 n = noise2(salt(kMountainSalt) + octave, x, y);
    slope_x += n.slope_x;
    slope_y += n.slope_y;
    sum += amplitude * (n.value * 0.5F + 0.5F) / (1.0F + 0.35F * (slope_x * slope_x + slope_y * slope_y));
    amplitude *= 0.5F;
    const double rotated = 2.0 * (0.8 * x - 0.6 * y);
    y = 2.0 * (0.6 * x + 0.8 * y);
    x = rotated;
  }
  return sum;
}

float World::town_density(double inland, double shore) const {
  const std::int64_t nearest = floor_int(shore / kTownSpacing + 0.5);
  float density = -1.0F;
  for (std::int64_t town = nearest - 1; town <= nearest + 1; ++town) {
    const std::uint32_t h = hash(salt(kTownSalt), town, 0);
    // The first town is where a picture of the middle of the scene shows it well.
    const float along = town == 0 ? 230.0F : static_cast<float>(static_cast<double>(town) * kTownSpacing) + 500.0F * (unit(h) - 0.5F);
    const float radius = town == 0 ? 430.0F : 220.0F + 200.0F * unit(rehash(h, 1));
    const float d_inland = (static_cast<float>(inland) - 340.0F) * 1.35F;
    const float d_shore = static_cast<float>(shore) - along;
    density = std::max(density, 1.0F - std::sqrt(d_inland * d_inland + d_shore * d_shore) / radius);
  }
  return density;
}

Ground World::ground(Position p) const {
  const CoastFrame frame = coast_frame(p);
  const auto inland = static_cast<float>(frame.inland);

  // The coast line wanders; `from_sea` is the distance from it, roughly.
  const Noise2 bay = noise2(salt(kCoastSalt), p.x / 760.0, p.y / 760.0);
  const Noise2 cove = noise2(salt(kCoastSalt) + 1, p.x / 260.0, p.y / 260.0);
  const Noise2 rocks = noise2(salt(kCoastSalt) + 2, p.x / 70.0, p.y / 70.0);
  const Noise2 stones = noise2(salt(kCoastSalt) + 3, p.x / 19.0, p.y / 19.0);
  const float from_sea = inland + 190.0F * bay.value + 70.0F * cove.value + 14.0F * rocks.value + 3.0F * stones.value;

  // Sea bed, beach, plain.
  float height = from_sea < 0.0F ? 0.075F * from_sea : 0.045F * std::min(from_sea, 90.0F) + 0.018F * std::max(0.0F, from_sea - 90.0F);
  const Noise2 plain = noise2(salt(kPlainSalt), p.x / 310.0, p.y / 310.0);
  height += smoothstep(60.0F, 300.0F, from_sea) * 5.0F * plain.value;

  // Hills, then mountains.
  const Noise2 range = noise2(salt(kRangeSalt), p.x / 2300.0, p.y / 2300.0);
  const float mountain = smoothstep(640.0F, 1650.0F, from_sea + 120.0F * range.value) * (0.9F + 0.3F * range.value);
  const float hill = smoothstep(560.0F, 950.0F, from_sea);
  if (hill > 0.0F || mountain > 0.0F) {
    const float relief = eroded(p);
    height += hill * 95.0F * std::max(0.0F, relief - 0.12F) + mountain * (150.0F + 950.0F * relief);
  }

  // Rivers carve their valleys down to their level.
  const std::int64_t river = floor_int((frame.shore + 330.0) / kRiverSpacing + 0.5);
  const Curve course = river_course(river, frame.inland);
  const float off_course = static_cast<float>(frame.shore) - course.value;
  float from_course = std::fabs(off_course) / std::sqrt(1.0F + course.slope * course.slope);
  const float lake = smoothstep(kLakeFirst - 30.0F, kLakeFirst + 130.0F, inland + 50.0F * cove.value) *
                     (1.0F - smoothstep(kLakeLast - 130.0F, kLakeLast + 30.0F, inland - 50.0F * bay.value));
  const Noise2 lake_shape = noise2(salt(kLakeSalt), p.x / 140.0, p.y / 140.0);
  const float width = mix(13.0F - 0.0045F * std::clamp(inland, 0.0F, 2000.0F), 88.0F + 52.0F * lake_shape.value, lake) +
                      2.5F * rocks.value + 0.8F * stones.value;
  // Off the coast the river narrows to nothing.
  const float river_m = from_course - std::max(width, 2.0F) + 0.9F * std::max(0.0F, -from_sea);
  const float level = water_level(inland);
  const float valley_half = 60.0F + 260.0F * mountain + 40.0F * lake;
  const float carve = 1.0F - smoothstep(18.0F + 62.0F * smoothstep(600.0F, 900.0F, inland), 80.0F + valley_half + 60.0F * lake, river_m);
  const float valley_floor = level + 0.8F + 0.03F * std::max(0.0F, river_m) + 1.2F * (plain.value + 1.0F);
  if (from_sea > -100.0F)
    height = mix(
        height, std::min(height, valley_floor) + 0.12F * (std::max(height, valley_floor) - valley_floor) * smoothstep(4.0F, 90.0F, river_m),
        carve);
  if (river_m < 0.0F && from_sea > -60.0F) height = std::min(height, level - 0.4F + 0.12F * river_m);

  Ground ground{};
  ground.dry_m = height;
  ground.river_m = from_sea > -60.0F ? river_m : 1000.0F;
  ground.height_m = std::max(height, 0.0F);
  if (ground.river_m < 0.0F) ground.height_m = level;

  const Curve road = coast_road(frame.shore);
  ground.coast_road_m = std::fabs(inland - road.value) / std::sqrt(1.0F + road.slope * road.slope);
  const Curve lane = valley_road(river, frame.inland);
  ground.valley_road_m = inland < road.value || inland > 1900.0F
                             ? 1000.0F
                             : std::fabs(static_cast<float>(frame.shore) - lane.value) / std::sqrt(1.0F + lane.slope * lane.slope);

  const Noise2 bend_a = noise2(salt(kBendSalt), p.x / 330.0, p.y / 330.0);
  const Noise2 bend_b = noise2(salt(kBendSalt) + 1, p.x / 330.0, p.y / 330.0);
  ground.street_inland = inland + 22.0F * bend_a.value;
  ground.street_shore = static_cast<float>(frame.shore) + 22.0F * bend_b.value;
  ground.town = town_density(frame.inland, frame.shore);

  const Noise2 wet_a = noise2(salt(kMoistureSalt), p.x / 420.0, p.y / 420.0);
  const Noise2 wet_b = noise2(salt(kMoistureSalt) + 1, p.x / 110.0, p.y / 110.0);
  const Noise2 wet_c = noise2(salt(kMoistureSalt) + 2, p.x / 31.0, p.y / 31.0);
  ground.moisture = 0.62F * wet_a.value + 0.34F * wet_b.value + 0.2F * wet_c.value;
  return ground;
}

Position World::position_from_street(double inland, double shore) const {
  // Fixed-point iteration: the bend changes slowly (at most 0.3 m per m), so five steps leave less than 0.1
  // m.
  Position p = position_from_coast(inland, shore);
  for (int step = 0; step < 5; ++step) {
    const Noise2 bend_a = noise2(salt(kBendSalt), p.x / 330.0, p.y / 330.0);
    const Noise2 bend_b = noise2(salt(kBendSalt) + 1, p.x / 330.0, p.y / 330.0);
    p = position_from_coast(inland - 22.0 * static_cast<double>(bend_a.value), shore - 22.0 * static_cast<double>(bend_b.value));
  }
  return p;
}

Block World::block(std::int64_t inland_index, std::int64_t shore_index) const {
  Block block;
  const double centre_inland = (static_cast<double>(inland_index) + 0.5) * static_cast<double>(kBlockInland);
  const double centre_shore = (static_cast<double>(shore_index) + 0.5) * static_cast<double>(kBlockShore);
  const std::uint32_t h = hash(salt(kBlockSalt), inland_index, shore_index);
  const float density = town_density(centre_inland, centre_shore) + 0.22F * (unit(h) - 0.5F);
  if (density < 0.12F) return block;
  // Dry, level and clear of the river at the centre and at the corners.
  for (const auto& [corner_inland, corner_shore] : {std::array{0.0, 0.0}, {-0.5, -0.5}, {-0.5, 0.5}, {0.5, -0.5}, {0.5, 0.5}}) {
    const Ground g = ground(position_from_street(centre_inland + corner_inland * static_cast<double>(kBlockInland),
                                                 centre_shore + corner_shore * static_cast<double>(kBlockShore)));
    if (g.dry_m < 2.2F || g.river_m < 14.0F || g.height_m > 60.0F) return block;
  }
  block.urban = true;
  const float kind = unit(rehash(h, 1));
  block.use = kind < 0.09F                     ? Block::Use::kPark
              : kind < 0.2F && density < 0.55F ? Block::Use::kIndustry
              : density > 0.62F                ? Block::Use::kCentre
                                               : Block::Use::kHomes;
  if (block.use == Block::Use::kPark) return block;

  constexpr std::size_t kColumns = 4;
  for (std::size_t i = 0; i < block.buildings.size(); ++i) {
    Building& b = block.buildings[i];
    b.look = rehash(h, 10 + static_cast<std::uint32_t>(i));
    const float r0 = unit(rehash(b.look, 1)), r1 = unit(rehash(b.look, 2)), r2 = unit(rehash(b.look, 3)), r3 = unit(rehash(b.look, 4));
    const float lot_inland = kBlockInland / 2.0F - kStreetHalf - 2.0F;
    const float lot_shore = (kBlockShore - 2.0F * kStreetHalf - 4.0F) / kColumns;
    const float row = i / kColumns == 0 ? -0.5F : 0.5F;
    const float column = static_cast<float>(i % kColumns) - 1.5F;
    b.inland = static_cast<float>(centre_inland) + row * lot_inland;
    b.shore = static_cast<float>(centre_shore) + column * lot_shore;
    b.ridge_along_shore = r3 < 0.6F;
    switch (block.use) {
      case Block::Use::kHomes:
        if (r0 < 0.1F) continue;
        b.inland += row * 5.0F + 3.0F * (r1 - 0.5F);
        b.shore += 4.0F * (r2 - 0.5F);
        b.half_inland = 4.0F + 1.6F * r1;
        b.half_shore = 4.2F + 2.4F * r2;
        b.eaves_m = 4.0F + 2.0F * r0;
        b.ridge_m = b.eaves_m + 2.6F;
        break;
      case Block::Use::kCentre:
        if (r0 < 0.05F) continue;
        b.inland += row * 1.5F;
        b.half_inland = 9.0F + 1.8F * r1;
        b.half_shore = 8.2F + 1.8F * r2;
        b.eaves_m = 8.0F + 3.4F * r0;
        b.ridge_m = b.eaves_m + (r3 < 0.55F ? 2.6F : 0.0F);
        break;
      case Block::Use::kIndustry:
        // Two halls instead of eight houses.
        if (i % kColumns != 1) continue;
        if (r0 < 0.15F) continue;
        b.shore = static_cast<float>(centre_shore) + (r1 - 0.5F) * 10.0F;
        b.half_inland = 9.0F + 2.0F * r2;
        b.half_shore = 25.0F + 8.0F * r0;
        b.eaves_m = b.ridge_m = 8.0F + 2.0F * r2;
        break;
      case Block::Use::kPark:
        continue;
    }
    // Not on the main roads.
    const Ground g = ground(position_from_street(b.inland, b.shore));
    const float clear = 5.5F + std::max(b.half_inland, b.half_shore);
    if (g.coast_road_m < clear || g.valley_road_m < clear) b.half_inland = b.half_shore = 0.0F;
  }
  return block;
}

Parcel World::parcel(Position p) const {
  // A rotated grid of columns, each with its own row heights, bent a little.
  const Noise2 bend_a = noise2(salt(kParcelBendSalt), p.x / 410.0, p.y / 410.0);
  const Noise2 bend_b = noise2(salt(kParcelBendSalt) + 1, p.x / 410.0, p.y / 410.0);
  const double a = (12.0 * p.x + 5.0 * p.y) / 13.0 + 30.0 * static_cast<double>(bend_a.value);
  const double b = (12.0 * p.y - 5.0 * p.x) / 13.0 + 30.0 * static_cast<double>(bend_b.value);
  constexpr double kWidth = 118.0;
  constexpr double kLength = 150.0;
  const std::uint32_t s = salt(kParcelSalt);
  const auto column_edge = [s](std::int64_t i) {
    return (static_cast<double>(i) + 0.5 * static_cast<double>(unit(hash(s, i, -1)))) * kWidth;
  };
  std::int64_t column = floor_int(a / kWidth);
  if (a < column_edge(column)) --column;
  const auto row_edge = [s, column](std::int64_t j) {
    return (static_cast<double>(j) + 0.6 * static_cast<double>(unit(hash(s + 1, column, j)))) * kLength;
  };
  std::int64_t row = floor_int(b / kLength);
  if (b < row_edge(row)) --row;

  Parcel parcel{};
  parcel.id = hash(s + 2, column, row);
  const double edge =
      std::min(std::min(a - column_edge(column), column_edge(column + 1) - a), std::min(b - row_edge(row), row_edge(row + 1) - b));
  parcel.edge_m = static_cast<float>(edge);
  parcel.across_m = static_cast<float>((parcel.id & 1U) != 0 ? a : b);
  return parcel;
}

}  // namespace vt::sample
