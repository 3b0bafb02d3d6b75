#include "tools/vtrender/terrain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vt::tools {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
// A patch is split while it would be wider than this many pixels, which leaves about 25 pixels for a quad.
constexpr double kPatchPixels = 400.0;

double length(const Vector3& a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }
Vector3 minus(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

struct Axes {
  Vector3 right, up, back;
};

Axes axes_of(const Camera& camera) {
  const double h = camera.heading_deg * kRadians;
  const double p = camera.pitch_deg * kRadians;
  const Vector3 forward{std::sin(h) * std::cos(p), std::cos(h) * std::cos(p), std::sin(p)};
  const Vector3 right{std::cos(h), -std::sin(h), 0.0};
  const Vector3 up{-std::sin(h) * std::sin(p), -std::cos(h) * std::sin(p), std::cos(p)};
  return {right, up, {-forward.x, -forward.y, -forward.z}};
}

}  // namespace

std::span<const std::uint16_t> patch_indices() {
  static const std::vector<std::uint16_t> kIndices = [] {
    std::vector<std::uint16_t> indices;
    // The grid has one ring of vertices more on every side: the skirt.
    constexpr int kSide = kPatchQuads + 3;
    for (int j = 0; j + 1 < kSide; ++j) {
      for (int i = 0; i + 1 < kSide; ++i) {
        const auto a = static_cast<std::uint16_t>(j * kSide + i);
        const auto b = static_cast<std::uint16_t>(a + 1);
        const auto c = static_cast<std::uint16_t>(a + kSide);
        const auto d = static_cast<std::uint16_t>(c + 1);
        indices.insert(indices.end(), {a, b, d, a, d, c});
      }
    }
    return indices;
  }();
  return kIndices;
}

Terrain::Terrain(const LayerInfo& layer, const VtMapping& mapping, Point2 metres, std::optional<runtime::HeightField> heights,
                 double exaggerate, int patch_texels)
    : mapping_(mapping),
      vt_exponent_(layer.vt_exponent()),
      data_rows_(layer.data.height),
      finest_(layer.finest),
      metres_(metres),
      heights_(std::move(heights)),
      exaggerate_(exaggerate),
      base_m_(heights_ ? heights_->min_height() : 0.0) {
  const Point2 north_west = mapping.uv_from_texel(layer.finest, {static_cast<double>(layer.data.x), static_cast<double>(layer.data.y)});
  const Point2 south_east =
      mapping.uv_from_texel(layer.finest, {static_cast<double>(layer.data.right()), static_cast<double>(layer.data.bottom())});
  data_uv_ = {north_west.x, south_east.y, south_east.x, north_west.y};
  deepest_ = std::max(0, vt_exponent_ - static_cast<int>(std::log2(std::max(patch_texels, 1))));
}

Vector3 Terrain::position(Point2 uv) const {
  const double z = heights_ ? (heights_->at(uv, base_m_) - base_m_) * exaggerate_ : 0.0;
  return {(uv.x - 0.5) * metres_.x, (uv.y - 0.5) * metres_.y, z};
}

Point2 Terrain::uv_at(const Vector3& place) const { return {place.x / metres_.x + 0.5, place.y / metres_.y + 0.5}; }

View Terrain::view(const Camera& camera, int width, int height) const {
  View view;
  view.eye = position({camera.u, camera.v});
  view.eye.z += camera.height_m;

  const Axes a = axes_of(camera);
  const double focal = 1.0 / std::tan(camera.fov_deg * kRadians / 2.0);
  const double aspect = static_cast<double>(width) / height;
  // Depth reaches from a hundredth of the height over ground to well past the area.
  const double near = std::max(camera.height_m * 0.02, 0.01);
  const double far = 4.0 * (metres_.x + metres_.y + std::abs(view.eye.z) + length(view.eye));
  const double zz = (far + near) / (near - far);
  const double zw = 2.0 * far * near / (near - far);
  const double fx = focal / aspect;
  // clip = projection * rotation; rows of the rotation are right, up, back.
  view.clip_from_offset = {fx * a.right.x,
                           focal * a.up.x,
                           zz * a.back.x,
                           -a.back.x,
                           fx * a.right.y,
                           focal * a.up.y,
                           zz * a.back.y,
                           -a.back.y,
                           fx * a.right.z,
                           focal * a.up.z,
                           zz * a.back.z,
                           -a.back.z,
                           0.0,
                           0.0,
                           zw,
                           0.0};
  view.pixels_per_radian = height / (camera.fov_deg * kRadians);
  return view;
}

Camera Terrain::default_camera(double aspect) const {
  // From the south, high enough to see the data whole.
  Camera camera{.u = 0.5, .v = 0.5, .height_m = 0.0, .heading_deg = 0.0, .pitch_deg = -38.0, .fov_deg = 40.0};
  const Point2 middle{(data_uv_.u_min + data_uv_.u_max) / 2.0, (data_uv_.v_min + data_uv_.v_max) / 2.0};
  const double width = (data_uv_.u_max - data_uv_.u_min) * metres_.x;
  const double depth = (data_uv_.v_max - data_uv_.v_min) * metres_.y;
  const double half = std::tan(camera.fov_deg * kRadians / 2.0);
  const double pitch = -camera.pitch_deg * kRadians;
  // The near edge must fit across the picture, the depth from top to bottom.
  const double across = width / 2.0 / (half * aspect) + depth / 2.0 * std::cos(pitch);
  const double along = depth / 2.0 * std::sin(pitch) / half + depth / 2.0 * std::cos(pitch);
  const double distance = 1.05 * std::max(across, along);
  camera.u = middle.x;
  camera.v = middle.y - distance * std::cos(pitch) / metres_.y;
  camera.height_m = distance * std::sin(pitch) + position(middle).z - position({camera.u, camera.v}).z;
  return camera;
}

Camera Terrain::flight_camera() const {
  constexpr double kTexelsHigh = 600.0;  // at 720 pixels and 45 degrees a pixel is as wide as a texel at 920 texels' distance
  const double texels_high = std::min(kTexelsHigh, 0.15 * static_cast<double>(data_rows_));
  const double texel_m = metres_.y * (data_uv_.v_max - data_uv_.v_min) / static_cast<double>(data_rows_);
  return {.u = (data_uv_.u_min + data_uv_.u_max) / 2.0,
          .v = data_uv_.v_min + 0.1 * (data_uv_.v_max - data_uv_.v_min),
          .height_m = texels_high * texel_m,
          .heading_deg = 0.0,
          .pitch_deg = -20.0,
          .fov_deg = 45.0};
}

Point2 Terrain::look_at(const Camera& camera) const {
  Vector3 eye = position({camera.u, camera.v});
  const double ground = eye.z;
  eye.z += camera.height_m;
  const double down = (camera.pitch_deg - camera.fov_deg / 4.0) * kRadians;
  const double heading = camera.heading_deg * kRadians;
  const double drop = std::max(-std::tan(down), 0.05);
  const double reach = (eye.z - std::min(ground, eye.z)) / drop;
  return uv_at({eye.x + std::sin(heading) * reach, eye.y + std::cos(heading) * reach, 0.0});
}

void Terrain::visible(const View& view, std::vector<const Patch*>& out) {
  out.clear();
  descend(0, 0, 0, view, out);
}

void Terrain::descend(int depth, std::int64_t column, std::int64_t row, const View& view, std::vector<const Patch*>& out) {
  // The node is a square of the padded square, cut to the data: its edges are tile edges of every level that
  // is coarse enough.
  const double size = std::ldexp(1.0, vt_exponent_ - depth);
  const double x = static_cast<double>(column) * size;
  const double y = static_cast<double>(row) * size;
  const Point2 north_west = mapping_.uv_from_texel(finest_, {x, y});
  const Point2 south_east = mapping_.uv_from_texel(finest_, {x + size, y + size});
  const runtime::UvBox uv{std::max(north_west.x, data_uv_.u_min), std::max(south_east.y, data_uv_.v_min),
                          std::min(south_east.x, data_uv_.u_max), std::min(north_west.y, data_uv_.v_max)};
  if (uv.u_min >= uv.u_max || uv.v_min >= uv.v_max) return;

  const double width_m = std::max((uv.u_max - uv.u_min) * metres_.x, (uv.v_max - uv.v_min) * metres_.y);
  const Vector3 middle = position({(uv.u_min + uv.u_max) / 2.0, (uv.v_min + uv.v_max) / 2.0});
  const Vector3 offset = minus(middle, view.eye);
  const double relief = heights_ ? (heights_->max_height() - heights_->min_height()) * exaggerate_ : 0.0;
  const double radius = 0.7072 * width_m + relief;
  const auto& m = view.clip_from_offset;
  // Outside one of the four side planes (or behind the eye) by more than its radius: not visible.
  const double w = m[3] * offset.x + m[7] * offset.y + m[11] * offset.z;
  if (w < -radius) return;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vector3 n{m[3] + sign * m[static_cast<std::size_t>(axis)], m[7] + sign * m[static_cast<std::size_t>(4 + axis)],
                      m[11] + sign * m[static_cast<std::size_t>(8 + axis)]};
      if (n.x * offset.x + n.y * offset.y + n.z * offset.z < -radius * length(n)) return;
    }
  }

  const double distance = std::max(length(offset) - width_m / 2.0, 1e-9);
  if (depth < deepest_ && width_m / distance * view.pixels_per_radian > kPatchPixels) {
    for (int child = 0; child < 4; ++child) descend(depth + 1, column * 2 + child % 2, row * 2 + child / 2, view, out);
    return;
  }
  const std::uint64_t key =
      (static_cast<std::uint64_t>(depth) << 58) | (static_cast<std::uint64_t>(row) << 29) | static_cast<std::uint64_t>(column);
  std::unique_ptr<Patch>& patch = patches_[key];
  if (!patch) patch = make_patch(uv);
  out.push_back(patch.get());
}

std::unique_ptr<Patch> Terrain::make_patch(const runtime::UvBox& uv) const {
  auto patch = std::make_unique<Patch>();
  patch->uv = uv;
  patch->uv_origin = {(uv.u_min + uv.u_max) / 2.0, (uv.v_min + uv.v_max) / 2.0};
  patch->origin = position(patch->uv_origin);
  const double skirt = 0.03 * std::max((uv.u_max - uv.u_min) * metres_.x, (uv.v_max - uv.v_min) * metres_.y);
  for (int j = -1; j <= kPatchQuads + 1; ++j) {
    for (int i = -1; i <= kPatchQuads + 1; ++i) {
      const double fu = std::clamp(i, 0, kPatchQuads) / static_cast<double>(kPatchQuads);
      const double fv = std::clamp(j, 0, kPatchQuads) / static_cast<double>(kPatchQuads);
      const Point2 at{uv.u_min * (1.0 - fu) + uv.u_max * fu, uv.v_min * (1.0 - fv) + uv.v_max * fv};
      Vector3 p = minus(position(at), patch->origin);
      if (i < 0 || j < 0 || i > kPatchQuads || j > kPatchQuads) p.z -= heights_ ? skirt : 0.0;
      patch->positions.insert(patch->positions.end(), {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      patch->texcoords.insert(patch->texcoords.end(),
                              {static_cast<float>(at.x - patch->uv_origin.x), static_cast<float>(at.y - patch->uv_origin.y)});
      patch->radius_m = std::max(patch->radius_m, length(p));
    }
  }
  return patch;
}

}  // namespace vt::tools
