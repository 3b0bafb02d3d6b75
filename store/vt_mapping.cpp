#include "store/vt_mapping.h"

#include <cmath>

namespace vt {

VtMapping::VtMapping(const Area& area, const LayerInfo& layer)
    : area_(area),
      grid_(layer.grid),
      data_x_(static_cast<double>(layer.data.x)),
      data_y_(static_cast<double>(layer.data.y)),
      finest_(layer.finest.value),
      vt_exponent_(layer.vt_exponent()) {}

Point2 VtMapping::texel_from_crs(Level level, Point2 crs) const {
  const double scale = std::ldexp(1.0, level.value - finest_);
  return {((crs.x - grid_.origin_x) / grid_.step_x + data_x_) * scale, ((grid_.origin_y - crs.y) / grid_.step_y + data_y_) * scale};
}

Point2 VtMapping::crs_from_texel(Level level, Point2 texel) const {
  const double scale = std::ldexp(1.0, finest_ - level.value);
  return {grid_.origin_x + (texel.x * scale - data_x_) * grid_.step_x, grid_.origin_y - (texel.y * scale - data_y_) * grid_.step_y};
}

Point2 VtMapping::crs_from_uv(Point2 uv) const {
  // Exact at both ends of the area, which west + u * (east - west) is not.
  return {area_.west * (1.0 - uv.x) + area_.east * uv.x, area_.south * (1.0 - uv.y) + area_.north * uv.y};
}

Point2 VtMapping::uv_from_crs(Point2 crs) const {
  return {(crs.x - area_.west) / (area_.east - area_.west), (crs.y - area_.south) / (area_.north - area_.south)};
}

Point2 VtMapping::texel_from_uv(Level level, Point2 uv) const { return texel_from_crs(level, crs_from_uv(uv)); }
Point2 VtMapping::uv_from_texel(Level level, Point2 texel) const { return uv_from_crs(crs_from_texel(level, texel)); }

VtMapping::Affine VtMapping::st_from_uv() const {
  const double size = std::ldexp(1.0, vt_exponent_);
  const double scale_x = (area_.east - area_.west) / grid_.step_x / size;
  const double scale_y = (area_.north - area_.south) / grid_.step_y / size;
  const double offset_x = ((area_.west - grid_.origin_x) / grid_.step_x + data_x_) / size;
  // Rows count from the north, t from the south edge of the padded square.
  const double offset_y = 1.0 - ((grid_.origin_y - area_.south) / grid_.step_y + data_y_) / size;
  return {scale_x, scale_y, offset_x, offset_y};
}

}  // namespace vt
