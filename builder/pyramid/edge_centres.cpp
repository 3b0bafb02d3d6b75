#include "builder/pyramid/edge_centres.h"

#include <algorithm>
#include <optional>

#include "builder/channels/samples/wide_value.h"

namespace vt::pyramid {

using channels::PlaneRule;

namespace {

// The heights of one level, at centres.
class Heights {
 public:
  Heights(const PlaneRows& rows, const LayerShape& layer, const channels::CentreRange& range, bool is_wide, int weight_plane)
      : rows_(rows),
        range_(range),
        is_wide_(is_wide),
        weight_plane_(weight_plane),
        active_(rows.plan().active),
        last_x_(rows.plan().data.right() - 1),
        last_y_(rows.plan().data.bottom() - 1),
        filled_column_(layer.filled_column(rows.plan().depth)),
        filled_row_(layer.filled_row(rows.plan().depth)) {}

  // The columns of a row, among `count` from `x` on, whose texels are cut: from the first one to x + count.
  [[nodiscard]] std::int64_t first_cut(std::int64_t y, std::int64_t x, std::int64_t count) const {
    if (filled_row_ < 1.0 && y == last_y_) return x;
    return filled_column_ < 1.0 && last_x_ == x + count - 1 ? last_x_ : x + count;
  }
  // nullopt: no data.
  [[nodiscard]] std::optional<double> at_centre(std::int64_t x, std::int64_t y) const {
    const auto here = in_row(x, y);
    if (!here || filled_row_ == 1.0 || y != last_y_ || y == active_.y) return here;
    const auto before = in_row(x, y - 1);
    return before ? straight_on(*before, *here, filled_row_) : *here;
  }

 private:
  [[nodiscard]] std::optional<double> mean(std::int64_t x, std::int64_t y) const {
    const double weight = rows_.row_or_nothing(y, weight_plane_)[x - active_.x];
    if (!(weight > 0.0)) return std::nullopt;
    const auto in_plane = [&](int plane) { return static_cast<double>(rows_.row_or_nothing(y, plane)[x - active_.x]); };
    return (is_wide_ ? in_plane(0) + in_plane(1) : in_plane(0)) / weight;
  }
  [[nodiscard]] std::optional<double> in_row(std::int64_t x, std::int64_t y) const {
    const auto here = mean(x, y);
    if (!here || filled_column_ == 1.0 || x != last_x_ || x == active_.x) return here;
    const auto before = mean(x - 1, y);
    return before ? straight_on(*before, *here, filled_column_) : *here;
  }
  [[nodiscard]] double straight_on(double before, double last, double filled) const {
    const double value = last + (last - before) * ((1.0 - filled) / (1.0 + filled));
    return std::clamp(value, std::min(range_.least, last), std::max(range_.greatest, last));
  }

  const PlaneRows& rows_;
  const channels::CentreRange& range_;
  bool is_wide_;
  int weight_plane_;
  TexelRect active_;
  std::int64_t last_x_;
  std::int64_t last_y_;
  double filled_column_;
  double filled_row_;
};

// As it lies in the plane, or in two.
struct Weighted {
  float nearest;
  float remainder;
};
Weighted weighted(double height, float weight) {
  const double product = height * static_cast<double>(weight);
  const auto nearest = static_cast<float>(product);
  return {nearest, channels::remainder_of(product, nearest)};
}
// As codecs read it there.
double read_back(const Weighted& height, bool is_wide, float weight) {
  return is_wide ? (static_cast<double>(height.nearest) + static_cast<double>(height.remainder)) / static_cast<double>(weight)
                 : static_cast<double>(height.nearest / weight);
}

}  // namespace

void EdgeCentres::widen_bounds(PlaneRows& rows, const LayerShape& layer, std::int64_t y) const {
  const auto is_bound = [](PlaneRule rule) { return rule == PlaneRule::kLeast || rule == PlaneRule::kGreatest; };
  if (std::ranges::none_of(rules_, is_bound)) return;
  const Heights heights(rows, layer, range_, is_wide_, weight_plane_);
  const TexelRect& active = rows.plan().active;
  for (std::int64_t x = heights.first_cut(y, active.x, active.width); x < active.right(); ++x) {
    const auto centre = heights.at_centre(x, y);
    if (!centre) continue;
    const float weight = rows.row(y, weight_plane_)[x - active.x];
    const double height = read_back(weighted(*centre, weight), is_wide_, weight) - range_.bounds_origin;
    for (std::size_t p = 0; p < rules_.size(); ++p) {
      float& bound = rows.row(y, static_cast<int>(p))[x - active.x];
      if (rules_[p] == PlaneRule::kLeast) bound = std::min(bound, channels::float_below(height));
      if (rules_[p] == PlaneRule::kGreatest) bound = std::max(bound, channels::float_above(height));
    }
  }
}

void EdgeCentres::move(const PlaneRows& rows, const LayerShape& layer, std::int64_t y, std::int64_t x, std::int64_t count,
                       std::vector<float>& buffer, channels::ConstPlaneRow& row) const {
  const Heights heights(rows, layer, range_, is_wide_, weight_plane_);
  const std::int64_t first = heights.first_cut(y, x, count);
  if (first == x + count) return;
  // One texel at either end may be read as well.
  const auto stride = static_cast<std::size_t>(count) + 2;
  const std::size_t planes = is_wide_ ? 2 : 1;
  buffer.resize(planes * stride);
  for (std::size_t p = 0; p < planes; ++p) std::copy_n(row[p] - 1, stride, buffer.begin() + static_cast<std::ptrdiff_t>(p * stride));
  for (std::int64_t i = first - x; i < count; ++i)
    if (const auto height = heights.at_centre(x + i, y)) {
      const auto place = static_cast<std::size_t>(i) + 1;
      const Weighted value = weighted(*height, row[static_cast<std::size_t>(weight_plane_)][i]);
      buffer[place] = value.nearest;
      if (is_wide_) buffer[stride + place] = value.remainder;
    }
  for (std::size_t p = 0; p < planes; ++p) row[p] = buffer.data() + p * stride + 1;
}

}  // namespace vt::pyramid
