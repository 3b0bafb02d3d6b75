// Where the tiles of each level lie around the paging center, and the texture transforms that follow
// (equations of the virtual-texture paper, the others of which are in tests/support/paper_equations.h). Pure
// functions and values, no GL, no store; any thread. All arithmetic is double; tile origins are integers, so
// nothing drifts.
//
// Spaces, as in store/vt_mapping.h: (s, t) runs 0..1 over the layer's padded square from its south-west
// corner; texel rows count from the north. (U, V) is one tile's own texture space, 0..1 from its south-west
// corner. Names without a comment of their own are the paper's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/virtual_texture.h"
#include "store/layer.h"
#include "store/vt_mapping.h"

namespace vt::runtime {

// --- The texture transform of one axis; `paper_level` 0 is the finest ------------------------------------------------------------------

// Equation 1: U = scale * u + trans.
struct Linear {
  double scale = 1.0;
  double trans = 0.0;
  [[nodiscard]] double operator()(double u) const { return scale * u + trans; }
};
// Equation 5 for coordinates that count from `origin`: U = scale * (u - origin) + trans. The large terms
// cancel before they are scaled.
[[nodiscard]] Linear local_transform(double center, int tile, int paper_level, int vt, double origin);

// --- Boxes in (s, t) ----------------------------------------------------------------------------------------------------------------

struct Box {
  double s_min = 0.0;
  double t_min = 0.0;
  double s_max = 0.0;
  double t_max = 0.0;
  bool operator==(const Box&) const = default;

  [[nodiscard]] bool contains(const Box& b) const { return b.s_min >= s_min && b.s_max <= s_max && b.t_min >= t_min && b.t_max <= t_max; }
  // Share some area, or, where `b` is a line or a point, touch.
  [[nodiscard]] bool meets(const Box& b) const {
    return axis_meets(s_min, s_max, b.s_min, b.s_max) && axis_meets(t_min, t_max, b.t_min, b.t_max);
  }
  [[nodiscard]] Box grown_by(double margin) const { return {s_min - margin, t_min - margin, s_max + margin, t_max + margin}; }

 private:
  [[nodiscard]] static bool axis_meets(double a0, double a1, double b0, double b1) {
    return b0 < b1 ? (a0 < b1 && b0 < a1) : (a0 <= b0 && b0 <= a1);
  }
};
[[nodiscard]] Box union_of(const Box& a, const Box& b);

// --- The paging grid ----------------------------------------------------------------------------------------------------------------

// One level as the runtime keeps it: n x n tile textures of 2^tile_exponent texels around a center. Tile size
// and n are the runtime's own choice and need not be the store's.
struct LevelLayout {
  Level level;
  int tile_exponent = 9;
  int tiles_per_side = 1;
  int mips = 1;          // mip levels in each tile texture, copied from this level and the `mips - 1` coarser ones
  std::int64_t hop = 1;  // tile origins are multiples of this many texels of the level: a power of two
  bool operator==(const LevelLayout&) const = default;

  [[nodiscard]] std::int64_t tile_texels() const { return std::int64_t{1} << tile_exponent; }
  [[nodiscard]] std::int64_t box_texels() const { return tile_texels() * tiles_per_side; }
};

// A virtual texture's levels, finest first; the last is one tile over the whole padded square.
struct VtLayout {
  int vt_exponent = 0;
  int store_tile_exponent = 0;
  Level finest;
  TexelRect data;  // at the finest level
  std::vector<LevelLayout> levels;

  [[nodiscard]] std::int64_t width(Level level) const { return std::int64_t{1} << (store_tile_exponent + level.value); }
};

// Makes a legal layout from wishes: tiles are never wider than their level, hops keep every mip on the texel
// grid of the level that it is copied from (an origin is a multiple of 2^(mips-1) texels, 4 * 2^(mips-1) for
// block formats), and mips stop at the store's root. kUsage when a wish is out of its range.
[[nodiscard]] Result<VtLayout> make_layout(const LayerInfo& layer, const LayoutOptions& options);

// The north-west texel of a tile (or of a level's n x n box) on its own level.
struct TexelOrigin {
  std::int64_t x = 0;
  std::int64_t y = 0;
  bool operator==(const TexelOrigin&) const = default;
};

// Where the level's n x n box goes for a center in (s, t): on the hop grid, inside the padded square and, as
// far as possible, over data. `current`, where the box is now, is kept while the center stays within
// `hysteresis` hops of where a change would be due, so that a center that swings across a grid line loads
// nothing.
[[nodiscard]] TexelOrigin box_origin(const VtLayout& layout, const LevelLayout& level, double s, double t,
                                     const TexelOrigin* current = nullptr, double hysteresis = 0.25);

// A box of `texels` texels square at `origin`, in (s, t). Exact.
[[nodiscard]] Box box_at(const VtLayout& layout, Level level, TexelOrigin origin, std::int64_t texels);
// The (s, t) of a tile's center. Exact.
[[nodiscard]] Point2 center_of(const VtLayout& layout, const LevelLayout& level, TexelOrigin tile);

// What a texture matrix or a shader needs: U = scale_x * du + trans_x, V_gl = scale_y * dv + trans_y, where
// (du, dv) = (u, v) - origin are the dataset's coordinates counted from a place near the geometry. V_gl
// counts from the tile's northern row, which is the first row of the texture as uploaded; so scale_y is
// negative.
struct TileMatrix {
  double scale_x = 1.0;
  double scale_y = -1.0;
  double trans_x = 0.0;
  double trans_y = 1.0;
};
[[nodiscard]] TileMatrix tile_matrix(const VtLayout& layout, const LevelLayout& level, TexelOrigin tile,
                                     const VtMapping::Affine& st_from_uv, Point2 uv_origin);

}  // namespace vt::runtime
