#include "builder/sample/painter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "builder/sample/noise.h"

namespace vt::sample {
namespace {

// Trees and houses cast shadows into the square from at most this many texels outside it.
constexpr int kApron = 32;
constexpr int kWide = kSquare + 2 * kApron;
// Elevation nodes under the wide square, with one more on each side for interpolation, and one more for
// slopes.
constexpr int kNodes = kWide / kHeightStep + 4;

// The sun stands in the north-west, as on shaded maps: lit from the south, mountains look like valleys to
// many people.
constexpr float kSunEast = -0.5206F;
constexpr float kSunNorth = 0.5206F;
constexpr float kSunUp = 0.6767F;
// A shadow falls by this much over one texel step to the south-east: tan(elevation) * sqrt(2) * 0.5 m.
constexpr float kShadowDrop = 0.65F;

enum Salt : std::uint32_t { kTreeSalt = 100, kGrainSalt, kVoidSalt };

struct Rgb {
  float r, g, b;
};
constexpr Rgb operator*(Rgb c, float k) { return {c.r * k, c.g * k, c.b * k}; }
constexpr Rgb operator*(Rgb c, Rgb d) { return {c.r * d.r, c.g * d.g, c.b * d.b}; }
constexpr Rgb operator+(Rgb c, Rgb d) { return {c.r + d.r, c.g + d.g, c.b + d.b}; }
constexpr Rgb blend(Rgb a, Rgb b, float t) { return {mix(a.r, b.r, t), mix(a.g, b.g, t), mix(a.b, b.b, t)}; }

// Landscape values that are interpolated between elevation nodes.
enum Field : int {
  kHeight,
  kDry,
  kRiver,
  kCoastRoad,
  kValleyRoad,
  kTown,
  kMoisture,
  kStreetInland,
  kStreetShore,
  kSlopeEast,
  kSlopeNorth,
  kForest,
  kHollow,
  kFieldCount
};
using Fields = std::array<float, kFieldCount>;

// What stands on the ground at a texel.
enum class Thing : std::uint8_t { kNothing, kTree, kRoof };

// What a point of the ground is, before trees and houses.
struct Surface {
  Material material;
  Parcel parcel;                 // of a field
  float street_m = 1000.0F;      // distance from the centre of a town street
  const Block* block = nullptr;  // the town block it belongs to
};

}  // namespace

struct Painter::Scratch {
  // Node grids, one per field.
  std::array<std::array<float, std::size_t{kNodes} * kNodes>, kFieldCount> nodes;
  // Things on the wide square.
  std::array<float, std::size_t{kWide} * kWide> thing_m;   // height above ground
  std::array<float, std::size_t{kWide} * kWide> shadow_m;  // height of the shadow's upper edge
  std::array<Thing, std::size_t{kWide} * kWide> thing;
  std::array<std::uint32_t, std::size_t{kWide} * kWide> look;
  std::array<std::int8_t, std::size_t{kWide} * kWide> tilt_east;  // slope of the thing's surface, in 1/32
  std::array<std::int8_t, std::size_t{kWide} * kWide> tilt_north;
  // Town blocks under the wide square.
  std::int64_t first_inland = 0, first_shore = 0, count_inland = 0, count_shore = 0;
  std::vector<Block> blocks;
  // One row of grain, coarse to fine, with one texel more on each side.
  std::array<float, kWide> broad, middle, fine;

  std::int64_t column = 0, row = 0;  // of the wide square's north-west texel

  [[nodiscard]] Position position(double x, double y) const {
    return {(static_cast<double>(column) + x + 0.5) * kTexelMetres, -(static_cast<double>(row) + y + 0.5) * kTexelMetres};
  }
  // Texel (x, y) of the wide square in node units; node (2, 2) is the wide square's first elevation texel.
  [[nodiscard]] Fields interpolate(float x, float y) const {
    const float node_x = (x + 0.5F) / kHeightStep + 1.5F;
    const float node_y = (y + 0.5F) / kHeightStep + 1.5F;
    const int i = static_cast<int>(node_x);
    const int j = static_cast<int>(node_y);
    const float tx = node_x - static_cast<float>(i);
    const float ty = node_y - static_cast<float>(j);
    Fields fields{};
    for (std::size_t f = 0; f < kFieldCount; ++f) {
      const float* upper = &nodes[f][static_cast<std::size_t>(j * kNodes + i)];
      const float* lower = upper + kNodes;
      fields[f] = mix(mix(upper[0], lower[0], ty), mix(upper[1], lower[1], ty), tx);
    }
    return fields;
  }
  [[nodiscard]] const Block* block_at(std::int64_t inland, std::int64_t shore) const {
    const std::int64_t i = inland - first_inland;
    const std::int64_t j = shore - first_shore;
    if (i < 0 || j < 0 || i >= count_inland || j >= count_shore) return nullptr;
    return &blocks[static_cast<std::size_t>(i * count_shore + j)];
  }

  void fill_nodes(const World& world);
  void fill_blocks(const World& world);
  void build_houses();
  void plant_trees(const World& world);
  void cast_shadows();
  void fill_grain(const World& world, int y);
  [[nodiscard]] Surface surface(const World& world, const Fields& f, Position p) const;
};

void Painter::Scratch::fill_nodes(const World& world) {
  for (int j = 0; j < kNodes; ++j) {
    for (int i = 0; i < kNodes; ++i) {
      const Ground g = world.ground(position((i - 2) * kHeightStep + 1.5, (j - 2) * kHeightStep + 1.5));
      const auto at = static_cast<std::size_t>(j * kNodes + i);
      nodes[kHeight][at] = g.height_m;
      nodes[kDry][at] = g.dry_m;
      nodes[kRiver][at] = g.river_m;
      nodes[kCoastRoad][at] = g.coast_road_m;
      nodes[kValleyRoad][at] = g.valley_road_m;
      nodes[kTown][at] = g.town;
      nodes[kMoisture][at] = g.moisture;
      nodes[kStreetInland][at] = g.street_inland;
      nodes[kStreetShore][at] = g.street_shore;
      nodes[kSlopeEast][at] = nodes[kSlopeNorth][at] = nodes[kForest][at] = nodes[kHollow][at] = 0.0F;
    }
  }
  constexpr float kNodeMetres = static_cast<float>(kTexelMetres) * kHeightStep;
  const auto& height = nodes[kHeight];
  for (int j = 1; j + 1 < kNodes; ++j) {
    for (int i = 1; i + 1 < kNodes; ++i) {
      const auto at = static_cast<std::size_t>(j * kNodes + i);
      const float east = (height[at + 1] - height[at - 1]) / (2.0F * kNodeMetres);
      const float north = (height[at - kNodes] - height[at + kNodes]) / (2.0F * kNodeMetres);
      const float slope = std::sqrt(east * east + north * north);
      nodes[kSlopeEast][at] = east;
      nodes[kSlopeNorth][at] = north;
      nodes[kHollow][at] = (height[at + 1] + height[at - 1] + height[at - kNodes] + height[at + kNodes]) * 0.25F - height[at];
      const float moist = nodes[kMoisture][at];
      const float h = height[at];
      // Forest likes slopes that no plough climbs, river banks and middle heights; not the coast, cliffs or
      // the heights.
      nodes[kForest][at] = 0.95F * moist + 0.5F * smoothstep(0.08F, 0.3F, slope) + 0.55F * smoothstep(40.0F, 110.0F, h) +
                           0.4F * (1.0F - smoothstep(0.0F, 26.0F, nodes[kRiver][at])) - 0.42F -
                           2.2F * smoothstep(230.0F, 380.0F, h + 70.0F * moist) - 1.4F * smoothstep(0.75F, 1.05F, slope) -
                           1.2F * (1.0F - smoothstep(2.0F, 7.0F, h));
    }
  }
}

void Painter::Scratch::fill_blocks(const World& world) {
  blocks.clear();
  count_inland = count_shore = 0;
  const auto& town = nodes[kTown];
  if (*std::max_element(town.begin(), town.end()) < -0.5F) return;
  const auto inland = std::minmax_element(nodes[kStreetInland].begin(), nodes[kStreetInland].end());
  const auto shore = std::minmax_element(nodes[kStreetShore].begin(), nodes[kStreetShore].end());
  first_inland = floor_int(static_cast<double>(*inland.first / World::kBlockInland)) - 1;
  first_shore = floor_int(static_cast<double>(*shore.first / World::kBlockShore)) - 1;
  count_inland = floor_int(static_cast<double>(*inland.second / World::kBlockInland)) + 2 - first_inland;
  count_shore = floor_int(static_cast<double>(*shore.second / World::kBlockShore)) + 2 - first_shore;
  blocks.reserve(static_cast<std::size_t>(count_inland * count_shore));
  for (std::int64_t i = 0; i < count_inland; ++i)
    for (std::int64_t j = 0; j < count_shore; ++j) blocks.push_back(world.block(first_inland + i, first_shore + j));
}

Surface Painter::Scratch::surface(const World& world, const Fields& f, Position p) const {
  Surface s{};
  const float grain = f[kMoisture];
  const float slope = std::sqrt(f[kSlopeEast] * f[kSlopeEast] + f[kSlopeNorth] * f[kSlopeNorth]);

  // Main roads first: they bridge the rivers.
  if (f[kDry] > -2.5F && (f[kCoastRoad] < 4.2F || f[kValleyRoad] < 3.2F) && (f[kDry] > 0.5F || f[kRiver] < 6.0F)) {
    s.material = Material::kRoad;
    return s;
  }
  if (f[kDry] < 0.0F || f[kRiver] < 0.0F) {
    s.material = Material::kWater;
    return s;
  }

  if (!blocks.empty()) {
    const float inland = f[kStreetInland] / World::kBlockInland;
    const float shore = f[kStreetShore] / World::kBlockShore;
    const std::int64_t i = floor_int(static_cast<double>(inland));
    const std::int64_t j = floor_int(static_cast<double>(shore));
    const float in_i = (inland - static_cast<float>(i)) * World::kBlockInland;
    const float in_j = (shore - static_cast<float>(j)) * World::kBlockShore;
    const std::int64_t next_i = in_i < World::kBlockInland / 2.0F ? i - 1 : i + 1;
    const std::int64_t next_j = in_j < World::kBlockShore / 2.0F ? j - 1 : j + 1;
    const float street_i = std::min(in_i, World::kBlockInland - in_i);
    const float street_j = std::min(in_j, World::kBlockShore - in_j);
    const auto urban = [this](std::int64_t a, std::int64_t b) {
      const Block* block = block_at(a, b);
      return block != nullptr && block->urban;
    };
    // A street runs along every side of a town block, its corners included.
    const bool own = urban(i, j);
    const float edge_i = street_i - World::kStreetHalf;
    const float edge_j = street_j - World::kStreetHalf;
    if (own || ((edge_i < 0.0F) && urban(next_i, j)) || ((edge_j < 0.0F) && urban(i, next_j)) ||
        (edge_i < 0.0F && edge_j < 0.0F && urban(next_i, next_j))) {
      if (edge_i < 0.0F && (own || urban(next_i, j) || edge_j < 0.0F)) s.street_m = street_i;
      if (edge_j < 0.0F && (own || urban(i, next_j) || edge_i < 0.0F)) s.street_m = std::min(s.street_m, street_j);
      if (s.street_m < World::kStreetHalf) {
        s.material = Material::kRoad;
        return s;
      }
      if (own) {
        s.block = block_at(i, j);
        s.material = Material::kGrass;
        return s;
      }
    }
  }

  if (f[kDry] < 1.5F + 1.2F * grain && slope < 0.5F) {
    s.material = Material::kSand;
    return s;
  }
  if (f[kHeight] + 60.0F * grain > 400.0F + 140.0F * smoothstep(0.7F, 1.3F, slope) && slope < 1.3F) {
    s.material = Material::kSnow;
    return s;
  }
  if (slope > 0.72F + 0.16F * grain - 0.1F * smoothstep(300.0F, 420.0F, f[kHeight])) {
    s.material = Material::kRock;
    return s;
  }
  if (f[kForest] > 0.0F) {
    s.material = Material::kForest;
    return s;
  }
  s.material = Material::kGrass;
  if (f[kHeight] > 3.5F && f[kHeight] < 42.0F && slope < 0.22F && f[kRiver] > 12.0F && std::min(f[kCoastRoad], f[kValleyRoad]) > 7.0F) {
    s.parcel = world.parcel(p);
    if (s.parcel.edge_m > 1.4F) s.material = Material::kField;
  }
  return s;
}

void Painter::Scratch::build_houses() {
  if (std::none_of(blocks.begin(), blocks.end(), [](const Block& b) { return b.urban; })) return;
  for (int y = 0; y < kWide; ++y) {
    for (int x = 0; x < kWide; ++x) {
      const float node_x = (static_cast<float>(x) + 0.5F) / kHeightStep + 1.5F;
      const float node_y = (static_cast<float>(y) + 0.5F) / kHeightStep + 1.5F;
      const int ni = static_cast<int>(node_x);
      const int nj = static_cast<int>(node_y);
      const float tx = node_x - static_cast<float>(ni);
      const float ty = node_y - static_cast<float>(nj);
      const auto node = static_cast<std::size_t>(nj * kNodes + ni);
      const auto bilinear = [&](int field) {
        const float* upper = &nodes[static_cast<std::size_t>(field)][node];
        return mix(mix(upper[0], upper[kNodes], ty), mix(upper[1], upper[kNodes + 1], ty), tx);
      };
      const float inland = bilinear(kStreetInland);
      const float shore = bilinear(kStreetShore);
      const Block* block = block_at(floor_int(static_cast<double>(inland / World::kBlockInland)),
                                    floor_int(static_cast<double>(shore / World::kBlockShore)));
      if (block == nullptr || !block->urban) continue;
      for (const Building& b : block->buildings) {
        const float d_inland = inland - b.inland;
        const float d_shore = shore - b.shore;
        if (!(std::fabs(d_inland) < b.half_inland && std::fabs(d_shore) < b.half_shore)) continue;
        const auto at = static_cast<std::size_t>(y * kWide + x);
        const float half = b.ridge_along_shore ? b.half_inland : b.half_shore;
        const float off = b.ridge_along_shore ? d_inland : d_shore;
        const float pitch = (b.ridge_m - b.eaves_m) / half;
        thing[at] = Thing::kRoof;
        thing_m[at] = b.ridge_m - pitch * std::fabs(off);
        look[at] = b.look;
        // Downhill away from the ridge.
        const float slope = off > 0.0F ? -pitch : pitch;
        tilt_east[at] = static_cast<std::int8_t>(32.0F * slope * (b.ridge_along_shore ? 0.6F : 0.8F));
        tilt_north[at] = static_cast<std::int8_t>(32.0F * slope * (b.ridge_along_shore ? 0.8F : -0.6F));
        break;
      }
    }
  }
}

void Painter::Scratch::plant_trees(const World& world) {
  // At most one tree per cell of 8.5 texels, on a sixteenth of a texel: exact in float wherever the square
  // begins.
  constexpr std::int64_t kCell = 136;
  constexpr double kSixteenth = 1.0 / 16.0;
  const std::uint32_t salt = world.salt(kTreeSalt);
  for (std::int64_t cell_y = floor_int(static_cast<double>(row * 16) / kCell); cell_y <= (row + kWide) * 16 / kCell; ++cell_y) {
    for (std::int64_t cell_x = floor_int(static_cast<double>(column * 16) / kCell); cell_x <= (column + kWide) * 16 / kCell; ++cell_x) {
      const std::uint32_t h = hash(salt, cell_x, cell_y);
      const double exact_x = static_cast<double>(cell_x * kCell + static_cast<std::int64_t>(h % kCell) - column * 16) * kSixteenth;
      const double exact_y = static_cast<double>(cell_y * kCell + static_cast<std::int64_t>(rehash(h, 1) % kCell) - row * 16) * kSixteenth;
      if (exact_x < 0.0 || exact_y < 0.0 || exact_x > kWide - 1 || exact_y > kWide - 1) continue;
      const Position p = position(exact_x, exact_y);
      const auto x = static_cast<float>(exact_x);
      const auto y = static_cast<float>(exact_y);
      if (thing[static_cast<std::size_t>(static_cast<int>(y + 0.5F) * kWide + static_cast<int>(x + 0.5F))] == Thing::kRoof) continue;

      const Fields f = interpolate(x, y);
      const float wish = unit(rehash(h, 2));
      if (std::min(f[kCoastRoad], f[kValleyRoad]) < 7.5F) continue;
      float chance = 0.0F;
      if (f[kForest] > -0.12F || wish < 0.5F) {
        const Surface s = surface(world, f, p);
        if (s.material == Material::kForest) chance = 0.93F;
        if (s.material == Material::kGrass) {
          chance = s.block != nullptr    ? (s.block->use == Block::Use::kPark    ? 0.5F
                                            : s.block->use == Block::Use::kHomes ? 0.15F
                                                                                 : 0.03F)
                   : f[kForest] > -0.12F ? 0.35F
                   : f[kHeight] < 330.0F ? 0.02F
                                         : 0.0F;
          // Hedges between the fields.
          if (s.block == nullptr && s.parcel.id != 0 && s.parcel.edge_m < 1.4F && (s.parcel.id >> 7U & 3U) != 0) chance = 0.42F;
        }
      }
      if (wish >= chance) continue;

      // Broad crowns below, narrow conifers above.
      const bool conifer = unit(rehash(h, 3)) < smoothstep(70.0F, 240.0F, f[kHeight]) * 0.95F + 0.06F;
      const float size = unit(rehash(h, 4));
      const float radius = conifer ? 1.5F + 1.1F * size : 2.1F + 2.0F * size * size;
      const float top = conifer ? 6.0F + 5.0F * size : 4.5F + 5.0F * size;
      const float radius_texels = radius / static_cast<float>(kTexelMetres);
      const int first_x = std::max(0, static_cast<int>(x - radius_texels));
      const int last_x = std::min(kWide - 1, static_cast<int>(x + radius_texels) + 1);
      const int first_y = std::max(0, static_cast<int>(y - radius_texels));
      const int last_y = std::min(kWide - 1, static_cast<int>(y + radius_texels) + 1);
      const float inverse = 1.0F / (radius_texels * radius_texels);
      const std::uint32_t crown = (h & ~1U) | (conifer ? 1U : 0U);
      for (int ty = first_y; ty <= last_y; ++ty) {
        for (int tx = first_x; tx <= last_x; ++tx) {
          const float dx = static_cast<float>(tx) - x;
          const float dy = static_cast<float>(ty) - y;
          // A ragged edge: each texel of a crown sticks out a little or not.
          const float ragged = unit(hash(h, tx + column, ty + row)) * 0.45F;
          const float r2 = (dx * dx + dy * dy) * inverse * (0.8F + ragged);
          if (r2 >= 1.0F) continue;
          const float z = conifer ? top * (1.0F - 0.55F * std::sqrt(r2)) : top * (0.55F + 0.45F * std::sqrt(1.0F - r2));
          const auto at = static_cast<std::size_t>(ty * kWide + tx);
          // The higher one is seen. Equal heights of different trees are as good as impossible, and then the
          // order of cells decides.
          if (thing[at] == Thing::kRoof || z <= thing_m[at]) continue;
          const float lean = (conifer ? 1.3F : 1.0F) / radius_texels;
          thing[at] = Thing::kTree;
          thing_m[at] = z;
          look[at] = crown;
          tilt_east[at] = static_cast<std::int8_t>(-32.0F * dx * lean);
          tilt_north[at] = static_cast<std::int8_t>(32.0F * dy * lean);
        }
      }
    }
  }
}

void Painter::Scratch::cast_shadows() {
  // The sun is exactly north-west, so a shadow moves one texel east and one south at a time.
  std::fill_n(shadow_m.begin(), kWide, -1000.0F);
  for (int y = 1; y < kWide; ++y) {
    const auto here = static_cast<std::size_t>(y) * kWide;
    const auto above = here - kWide;
    shadow_m[here] = -1000.0F;
    for (std::size_t x = 1; x < kWide; ++x) shadow_m[here + x] = std::max(thing_m[above + x - 1], shadow_m[above + x - 1]) - kShadowDrop;
  }
}

void Painter::Scratch::fill_grain(const World& world, int y) {
  // Value noise with lattices of 2^k texels, a row at a time: two lattice values per cell, straight lines
  // between.
  const auto add = [&](std::array<float, kWide>& out, int log2_cell, float amplitude) {
    const int cell = 1 << log2_cell;
    const std::uint32_t salt = world.salt(kGrainSalt) + static_cast<std::uint32_t>(log2_cell);
    const std::int64_t world_y = row + y;
    const std::int64_t cell_y = world_y >> log2_cell;
    const float inverse = 1.0F / static_cast<float>(cell);
    const float ty = static_cast<float>(world_y - (cell_y << log2_cell)) * inverse;
    const float ease = ty * ty * (3.0F - 2.0F * ty);
    const auto lattice = [&](std::int64_t cell_x) {
      const float upper = unit(hash(salt, cell_x, cell_y));
      const float lower = unit(hash(salt, cell_x, cell_y + 1));
      return (2.0F * mix(upper, lower, ease) - 1.0F) * amplitude;
    };
    // The wide square starts at a multiple of 4; larger cells may begin before it.
    std::int64_t cell_x = column >> log2_cell;
    int x = static_cast<int>((cell_x << log2_cell) - column);
    float left = lattice(cell_x);
    for (; x < kWide; x += cell, ++cell_x) {
      const float right = lattice(cell_x + 1);
      const float step = (right - left) * inverse;
      const int first = std::max(x, 0);
      const int last = std::min(x + cell, kWide);
      for (int i = first; i < last; ++i) out[static_cast<std::size_t>(i)] += left + step * static_cast<float>(i - x);
      left = right;
    }
  };
  broad.fill(0.0F);
  middle.fill(0.0F);
  fine.fill(0.0F);
  add(broad, 7, 0.5F);
  add(broad, 6, 0.4F);
  add(broad, 5, 0.3F);
  add(middle, 4, 0.4F);
  add(middle, 3, 0.4F);
  add(middle, 2, 0.3F);
  add(fine, 1, 0.5F);
  add(fine, 0, 0.5F);
}

namespace {

constexpr std::array<Rgb, 8> kCrops{{{0.30F, 0.235F, 0.095F},   // ripe wheat
                                     {0.105F, 0.165F, 0.035F},  // young grain
                                     {0.155F, 0.105F, 0.068F},  // ploughed
                                     {0.33F, 0.285F, 0.165F},   // stubble
                                     {0.085F, 0.135F, 0.04F},   // pasture
                                     {0.36F, 0.32F, 0.045F},    // rapeseed
                                     {0.065F, 0.12F, 0.03F},    // maize
                                     {0.20F, 0.20F, 0.075F}}};  // hay
constexpr std::array<float, 8> kRowContrast{0.06F, 0.10F, 0.16F, 0.10F, 0.02F, 0.05F, 0.16F, 0.08F};

constexpr std::array<Rgb, 8> kRoofs{{{0.30F, 0.105F, 0.06F},
                                     {0.26F, 0.085F, 0.05F},
                                     {0.34F, 0.14F, 0.085F},
                                     {0.19F, 0.10F, 0.065F},
                                     {0.085F, 0.085F, 0.095F},
                                     {0.15F, 0.15F, 0.155F},
                                     {0.24F, 0.235F, 0.22F},
                                     {0.29F, 0.12F, 0.07F}}};

Rgb water_color(float depth_m, float broad, float middle, float fine) {
  constexpr Rgb kSand{0.30F, 0.30F, 0.22F};
  constexpr Rgb kShallow{0.06F, 0.19F, 0.20F};
  constexpr Rgb kDeep{0.010F, 0.042F, 0.085F};
  // Light that comes back from the bottom fades with depth.
  const float bottom = 1.0F / (1.0F + 0.9F * depth_m + 0.25F * depth_m * depth_m);
  const float body = 1.0F / (1.0F + 0.012F * depth_m * depth_m);
  Rgb c = blend(blend(kDeep, kShallow, body), kSand, bottom * 0.75F);
  c = c * (1.0F + 0.10F * broad + 0.05F * middle * (1.0F - body) + 0.035F * fine);
  // Surf.
  const float foam = smoothstep(0.0F, 0.05F, 0.42F + 0.35F * middle - depth_m) * smoothstep(-0.15F, 0.35F, fine + middle);
  return blend(c, {0.72F, 0.74F, 0.74F}, 0.75F * foam);
}

Rgb field_color(const Parcel& parcel, float broad, float middle, float fine) {
  const std::size_t crop = parcel.id >> 3U & 7U;
  const float shade = 0.86F + 0.28F * unit(rehash(parcel.id, 1));
  // Rows every 1.5 m to 4 m, and the tracks of the tractor every eighteen metres.
  const float spacing = 1.5F + 2.5F * unit(rehash(parcel.id, 2));
  const float turns = parcel.across_m / spacing;
  const float phase = turns - static_cast<float>(floor_int(static_cast<double>(turns)));
  const float row = (phase < 0.5F ? phase : 1.0F - phase) * 4.0F - 1.0F;
  const float tracks = parcel.across_m / 18.0F;
  const float track_phase = (tracks - static_cast<float>(floor_int(static_cast<double>(tracks)))) * 18.0F;
  const bool in_track = (track_phase < 0.5F || (track_phase > 1.8F && track_phase < 2.3F)) && crop != 4;
  const Rgb color = kCrops[crop] * (shade * (1.0F + kRowContrast[crop] * row + 0.16F * broad + 0.13F * middle + 0.07F * fine));
  return in_track ? blend(color, {0.19F, 0.15F, 0.10F}, 0.3F) : color;
}

std::uint8_t code_of(float linear) {
  // A square root is close to the display's curve and, unlike a power, rounds the same way everywhere.
  const float code = 255.0F * std::sqrt(std::clamp(linear, 0.0F, 1.0F)) + 0.5F;
  return static_cast<std::uint8_t>(code);
}

}  // namespace

Painter::Painter(const World& world) : world_(world), scratch_(std::make_unique<Scratch>()) {}
Painter::~Painter() = default;

void Painter::paint(std::int64_t column, std::int64_t row, Square& out) {
  Scratch& s = *scratch_;
  s.column = column - kApron;
  s.row = row - kApron;
  s.thing.fill(Thing::kNothing);
  s.thing_m.fill(0.0F);
  s.fill_nodes(world_);
  s.fill_blocks(world_);
  s.build_houses();
  s.plant_trees(world_);
  s.cast_shadows();

  for (int y = 0; y < kSquare; ++y) {
    s.fill_grain(world_, y + kApron);
    for (int x = 0; x < kSquare; ++x) {
      const int wide_x = x + kApron;
      const int wide_y = y + kApron;
      const auto at = static_cast<std::size_t>(wide_y * kWide + wide_x);
      const Position p = s.position(wide_x, wide_y);
      const Fields f = s.interpolate(static_cast<float>(wide_x), static_cast<float>(wide_y));
      const Surface surface = s.surface(world_, f, p);
      const auto grain_at = static_cast<std::size_t>(wide_x);
      const float broad = s.broad[grain_at];
      const float middle = s.middle[grain_at];
      const float fine = s.fine[grain_at];
      const float slope = std::sqrt(f[kSlopeEast] * f[kSlopeEast] + f[kSlopeNorth] * f[kSlopeNorth]);

      Material material = surface.material;
      float tilt_east = f[kSlopeEast];
      float tilt_north = f[kSlopeNorth];
      float relief = 0.0F;  // strength of the small bumps
      Rgb color{};
      switch (material) {
        case Material::kWater: {
          const float depth = f[kRiver] < 0.0F ? std::min(-f[kRiver] * 0.22F, 2.6F) + 0.3F : -f[kDry];
          color = water_color(depth, broad, middle, fine);
          if (f[kRiver] < 0.0F) color = blend(color, {0.035F, 0.075F, 0.07F}, 0.6F);
          tilt_east = tilt_north = 0.0F;
          break;
        }
        case Material::kSand:
          color = blend({0.30F, 0.255F, 0.175F}, {0.46F, 0.40F, 0.285F}, smoothstep(0.1F, 0.9F, f[kDry] + 0.3F * middle)) *
                  (1.0F + 0.08F * middle + 0.06F * fine);
          break;
        case Material::kSnow:
          color = Rgb{0.62F, 0.645F, 0.68F} * (0.97F + 0.05F * middle + 0.02F * fine);
          relief = 0.10F;
          break;
        case Material::kRock: {
          // Beds of lighter and darker stone.
          const float bed = f[kHeight] * 0.045F + 1.6F * broad + 0.25F * middle;
          const float phase = bed - static_cast<float>(floor_int(static_cast<double>(bed)));
          const float strata = phase < 0.5F ? phase : 1.0F - phase;
          color = blend({0.135F, 0.122F, 0.108F}, {0.27F, 0.25F, 0.225F}, std::clamp(0.2F + strata * 0.9F + 0.4F * middle, 0.0F, 1.0F)) *
                  (1.0F + 0.20F * middle + 0.24F * fine);
          relief = 0.85F;
          break;
        }
        case Material::kForest:
          color = Rgb{0.052F, 0.062F, 0.026F} * (1.0F + 0.3F * middle + 0.2F * fine);
          break;
        case Material::kField:
          color = field_color(surface.parcel, broad, middle, fine);
          break;
        case Material::kRoad: {
          const float from_main = std::min(f[kCoastRoad], f[kValleyRoad]);
          color = Rgb{0.105F, 0.105F, 0.112F} * (1.0F + 0.06F * middle + 0.06F * fine);
          if (from_main < 4.2F) {
            // A broken line in the middle, a solid one at each side of the coast road.
            const CoastFrame frame = coast_frame(p);
            const double along = f[kCoastRoad] < 4.2F ? frame.shore : frame.inland;
            const bool dash = floor_int(along / 5.0) % 2 == 0;
            if ((from_main < 0.3F && dash) || (f[kCoastRoad] < 4.2F && f[kCoastRoad] > 3.4F && f[kCoastRoad] < 3.8F))
              color = {0.5F, 0.5F, 0.48F};
          } else if (surface.street_m > 2.35F) {
            color = Rgb{0.27F, 0.265F, 0.25F} * (1.0F + 0.08F * fine);  // pavement
          }
          break;
        }
        case Material::kGrass:
        case Material::kBuilding: {
          const float dry = std::clamp(0.5F - 0.75F * f[kMoisture] + 0.25F * broad, 0.0F, 1.0F);
          color = blend({0.062F, 0.108F, 0.027F}, {0.175F, 0.165F, 0.068F}, dry);
          // Heath and bare ground towards the heights.
          color = blend(color, {0.155F, 0.135F, 0.085F}, 0.75F * smoothstep(200.0F, 400.0F, f[kHeight] + 60.0F * broad));
          color = blend(color, {0.19F, 0.175F, 0.155F}, 0.8F * smoothstep(0.45F, 0.75F, slope + 0.15F * middle));
          color = blend(color, {0.33F, 0.29F, 0.19F}, 0.7F * (1.0F - smoothstep(1.2F, 3.4F, f[kDry] + 0.8F * middle)));
          color = color * (1.0F + 0.16F * middle + 0.13F * fine);
          relief = 0.12F;
          if (surface.block != nullptr) {
            const bool paved = surface.block->use == Block::Use::kCentre || surface.block->use == Block::Use::kIndustry;
            const Rgb lawn = Rgb{0.072F, 0.115F, 0.034F} * (1.0F + 0.2F * middle + 0.14F * fine);
            color = paved ? Rgb{0.21F, 0.205F, 0.19F} * (1.0F + 0.12F * middle + 0.06F * fine) : blend(lawn, color, 0.35F);
          }
          break;
        }
      }

      // Trees and roofs cover the ground.
      const Thing thing = s.thing[at];
      float shadow_gap = s.shadow_m[at] - s.thing_m[at];
      float sky = 1.0F;
      if (thing == Thing::kRoof) {
        material = Material::kBuilding;
        const std::uint32_t look = s.look[at];
        const bool flat = s.tilt_east[at] == 0 && s.tilt_north[at] == 0;
        color = (flat ? kRoofs[4 + (look >> 5U & 3U)] : kRoofs[look >> 5U & 7U]) * (0.85F + 0.3F * unit(rehash(look, 9)));
        color = color * (1.0F + 0.05F * middle + 0.10F * fine);
        tilt_east = static_cast<float>(s.tilt_east[at]) / 32.0F;
        tilt_north = static_cast<float>(s.tilt_north[at]) / 32.0F;
        relief = 0.0F;
      } else if (thing == Thing::kTree) {
        if (material != Material::kWater && material != Material::kRoad) material = Material::kForest;
        const std::uint32_t look = s.look[at];
        const float tone = unit(rehash(look, 5));
        const float yellow = unit(rehash(look, 6));
        const Rgb leaf = (look & 1U) != 0 ? blend({0.020F, 0.040F, 0.018F}, {0.036F, 0.056F, 0.024F}, tone)
                                          : blend({0.042F, 0.078F, 0.020F}, {0.092F, 0.118F, 0.030F}, yellow * yellow);
        color = leaf * ((0.8F + 0.4F * tone) * (1.0F + 0.30F * broad + 0.22F * fine));
        tilt_east = tilt_east + static_cast<float>(s.tilt_east[at]) / 32.0F;
        tilt_north = tilt_north + static_cast<float>(s.tilt_north[at]) / 32.0F;
        relief = 0.5F;
      }

      // Sun and sky. Small bumps tilt the surface a little; only their east-west part, which the diagonal sun
      // shows as well.
      const float bump =
          relief * ((s.middle[grain_at + 1] - s.middle[grain_at - 1]) * 1.2F + (s.fine[grain_at + 1] - s.fine[grain_at - 1]) * 0.5F);
      const float east = tilt_east + bump;
      const float facing = (kSunUp - kSunEast * east - kSunNorth * tilt_north) / std::sqrt(1.0F + east * east + tilt_north * tilt_north);
      float sun = std::max(0.0F, facing);
      if (material != Material::kWater) sun *= 1.0F - 0.85F * std::clamp(shadow_gap * 1.6F + 0.5F, 0.0F, 1.0F);
      if (thing == Thing::kNothing) sky = std::clamp(1.0F - 0.05F * shadow_gap, 0.75F, 1.0F);
      sky *= std::clamp(1.0F - 0.7F * f[kHollow], 0.6F, 1.25F);
      const Rgb light = Rgb{1.42F, 1.34F, 1.20F} * sun + Rgb{0.20F, 0.25F, 0.33F} * sky;
      const Rgb seen = color * light + Rgb{0.004F, 0.006F, 0.010F};  // a breath of haze

      const auto pixel = static_cast<std::size_t>(y * kSquare + x);
      out.material[pixel] = material;
      out.rgb[pixel * 3] = code_of(seen.r);
      out.rgb[pixel * 3 + 1] = code_of(seen.g);
      out.rgb[pixel * 3 + 2] = code_of(seen.b);
    }
  }

  // Heights, with a few small voids where a radar would have seen nothing: on steep ground.
  for (int j = 0; j < kHeightSquare; ++j) {
    for (int i = 0; i < kHeightSquare; ++i) {
      const int node_x = i + kApron / kHeightStep + 2;
      const int node_y = j + kApron / kHeightStep + 2;
      const auto at = static_cast<std::size_t>(node_y * kNodes + node_x);
      const Position p = s.position((node_x - 2) * kHeightStep + 1.5, (node_y - 2) * kHeightStep + 1.5);
      constexpr double kVoidCell = 420.0;
      const std::int64_t cell_x = floor_int(p.x / kVoidCell);
      const std::int64_t cell_y = floor_int(p.y / kVoidCell);
      const std::uint32_t h = hash(world_.salt(kVoidSalt), cell_x, cell_y);
      // The middle half of the cell, so that a void never crosses into the next one.
      const double dx = p.x - (static_cast<double>(cell_x) + 0.25 + 0.5 * static_cast<double>(unit(rehash(h, 1)))) * kVoidCell;
      const double dy = p.y - (static_cast<double>(cell_y) + 0.25 + 0.5 * static_cast<double>(unit(rehash(h, 2)))) * kVoidCell;
      const double radius = 5.0 + 12.0 * static_cast<double>(unit(rehash(h, 3)));
      const bool is_void = unit(h) < 0.5F && dx * dx + dy * dy < radius * radius && s.nodes[kHeight][at] > 130.0F;
      out.height_m[static_cast<std::size_t>(j * kHeightSquare + i)] = is_void ? kVoid : s.nodes[kHeight][at];
    }
  }
}

}  // namespace vt::sample
