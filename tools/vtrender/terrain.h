// The terrain that vtrender draws: square patches of the dataset, finer near the eye, cut along the grid that
// tiles lie on, so that a patch always fits a tile. Also the camera. No OpenGL.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/virtual_texture.h"

namespace vt::tools {

struct Vector3 {
  double x = 0.0;  // metres to the east of the area's center
  double y = 0.0;  // to the north
  double z = 0.0;  // up
};

struct Camera {
  double u = 0.5;  // over the dataset's area
  double v = 0.5;
  double height_m = 1000.0;  // above the surface under it
  double heading_deg = 0.0;  // clockwise from north
  double pitch_deg = -30.0;  // above the horizon
  double fov_deg = 45.0;     // vertical
};

// What the camera is in the scene: the eye, and the matrix that takes offsets from the eye to clip space
// (column major).
struct View {
  Vector3 eye;
  std::array<double, 16> clip_from_offset{};
  double pixels_per_radian = 1.0;
};

// A patch: kPatchQuads x kPatchQuads quads and a skirt that hides the cracks to coarser neighbours.
inline constexpr int kPatchQuads = 16;
struct Patch {
  runtime::UvBox uv;
  Point2 uv_origin;  // its middle; texture coordinates count from here
  Vector3 origin;    // positions count from here
  double radius_m = 0.0;
  std::vector<float> positions;  // x, y, z
  std::vector<float> texcoords;  // (u, v) - uv_origin
};
[[nodiscard]] std::span<const std::uint16_t> patch_indices();  // triangles, the same for every patch

class Terrain {
 public:
  // `metres` are the ground extents of the area; heights may be absent.
  Terrain(const LayerInfo& layer, const VtMapping& mapping, Point2 metres, std::optional<runtime::HeightField> heights, double exaggerate,
          int patch_texels);

  [[nodiscard]] Vector3 position(Point2 uv) const;  // on the surface
  [[nodiscard]] Point2 uv_at(const Vector3& place) const;
  [[nodiscard]] View view(const Camera& camera, int width, int height) const;
  [[nodiscard]] Camera default_camera(double aspect) const;
  // Over the southern part of the data, looking north and a little down, so low that the finest texels are
  // larger than pixels near by.
  [[nodiscard]] Camera flight_camera() const;
  // Where the middle of the lower half of the picture meets the ground: a good paging center.
  [[nodiscard]] Point2 look_at(const Camera& camera) const;

  // The patches to draw. They are made when first seen and kept; pointers stay good.
  void visible(const View& view, std::vector<const Patch*>& out);

 private:
  void descend(int depth, std::int64_t column, std::int64_t row, const View& view, std::vector<const Patch*>& out);
  [[nodiscard]] std::unique_ptr<Patch> make_patch(const runtime::UvBox& uv) const;

  VtMapping mapping_;
  runtime::UvBox data_uv_;
  int vt_exponent_;
  std::int64_t data_rows_;
  Level finest_;
  Point2 metres_;
  std::optional<runtime::HeightField> heights_;
  double exaggerate_;
  double base_m_;
  int deepest_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Patch>> patches_;
};

}  // namespace vt::tools
