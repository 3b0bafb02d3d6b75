// The sample world: what is where, as pure functions of (seed, position). The painter and the file writer ask
// here and nowhere else, which is why all layers agree. Positions are metres east (x) and north (y) of the
// scene's centre. Any thread.
//
// The plan: the sea in the south-south-west, a beach, a coastal plain with fields and towns, wooded hills,
// then mountains with snow in the north-north-east. Distances from the coast are measured along `inland`,
// distances along the coast along `shore`; rivers run down to the sea.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vt::sample {

// Classes of materials.tif. 0 is left free for "none".
enum class Material : std::uint8_t { kWater = 1, kSand, kGrass, kForest, kRock, kSnow, kField, kRoad, kBuilding };

struct Position {
  double x;
  double y;
};

// The landscape at a point, without what stands on it.
struct Ground {
  float height_m;      // of the surface: 0 on the sea, the water level on rivers and lakes
  float dry_m;         // height before water fills it; below 0 under the sea
  float river_m;       // distance from the nearest river bank, negative on the water
  float coast_road_m;  // distance from the centre line
  float valley_road_m;
  float town;                         // above 0 where a town may stand
  float moisture;                     // about -1..1
  float street_inland, street_shore;  // coordinates of the towns' slightly bent street grid
};

// Buildings stand on lots, lots in blocks between streets.
struct Building {
  float inland, shore;            // centre in street coordinates
  float half_inland, half_shore;  // metres; 0: the lot is empty
  float eaves_m, ridge_m;         // heights above ground; equal for a flat roof
  bool ridge_along_shore;
  std::uint32_t look;  // random bits for the painter
};

struct Block {
  bool urban = false;
  enum class Use : std::uint8_t { kHomes, kCentre, kIndustry, kPark } use = Use::kHomes;
  std::array<Building, 8> buildings{};
};

// A field of the patchwork, and where in it a point lies.
struct Parcel {
  std::uint32_t id;  // random bits, one per field
  float edge_m;      // distance from the nearest edge
  float across_m;    // position across the rows of the crop
};

class World {
 public:
  explicit World(std::uint64_t seed);

  [[nodiscard]] Ground ground(Position p) const;
  [[nodiscard]] Parcel parcel(Position p) const;

  // The block of the street grid with the given indices.
  static constexpr float kBlockInland = 58.0F;
  static constexpr float kBlockShore = 88.0F;
  static constexpr float kStreetHalf = 3.25F;
  [[nodiscard]] Block block(std::int64_t inland_index, std::int64_t shore_index) const;

  // Where a point of the street grid lies on the ground.
  [[nodiscard]] Position position_from_street(double inland, double shore) const;

  // Points of the road centre lines, for street lamps.
  [[nodiscard]] Position coast_road_point(double shore) const;
  [[nodiscard]] Position valley_road_point(std::int64_t river, double inland) const;
  [[nodiscard]] std::uint32_t salt(std::uint32_t use) const;

  static constexpr double kTownLimit = 900.0;  // no town stands further inland than this
  static constexpr double kRiverSpacing = 4200.0;
  static constexpr double kCentreInland = 700.0;  // how far inland the centre of the scene lies

 private:
  struct Curve {
    float value, slope;
  };
  [[nodiscard]] Curve river_course(std::int64_t river, double inland) const;  // its `shore` coordinate
  [[nodiscard]] Curve coast_road(double shore) const;                         // its `inland` coordinate
  [[nodiscard]] Curve valley_road(std::int64_t river, double inland) const;
  [[nodiscard]] float eroded(Position p) const;
  [[nodiscard]] float town_density(double inland, double shore) const;

  std::uint32_t seed_;
};

// `inland` and `shore` axes: a rotation by rational numbers, so that it is exact enough everywhere.
struct CoastFrame {
  double inland, shore;
};
constexpr CoastFrame coast_frame(Position p) { return {0.6 * p.x + 0.8 * p.y + World::kCentreInland, 0.8 * p.x - 0.6 * p.y}; }
constexpr Position position_from_coast(double inland, double shore) {
  const double i = inland - World::kCentreInland;
  return {0.6 * i + 0.8 * shore, 0.8 * i - 0.6 * shore};
}

}  // namespace vt::sample
