#include "builder/pyramid/edge_centres.h"

#include <algorithm>
#include <optional>

namespace vt::pyramid {

using channels::PlaneRule;

namespace {

// The heights of one level, at centres.
class Heights {
 public:
  Heights(const PlaneRows& rows, const LayerShape& layer, const channels::CentreRange& range, int weight_plane)
      : rows_(rows),
        range_(range),
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
    return static_cast<double>(rows_.row_or_nothing(y, 0)[x - active_.x]) / weight;
  }
  [[nodiscard]] std::optional<double> in_row(std::int64_t x, std::int64_t y) const {
    const auto here = mean(x, y);
    if (!here || filled_column_ == 1.0 || x != last_x_ || x == active_.x) return here;
    const auto before = mean(x - 1, y);
    return before ? straight_on(*before, *here, filled_column_) : *here;
  }
  [[nodiscard]] double straight_on(double before, double last, double filled) const {
    const double value = last + (last - before) * ((1.0 - filled) / (1.0 + filled));
    return std::clamp(value, std::min(double{range_.least}, last), std::max(double{range_.greatest}, last));
  }

  const PlaneRows& rows_;
  const channels::CentreRange& range_;
  int weight_plane_;
  TexelRect active_;
  std::int64_t last_x_;
  std::int64_t last_y_;
  double filled_column_;
  double filled_row_;
};

// As it lies in the plane, and as codecs read it there.
float weighted(double height, float weight) { return static_cast<float>(height * static_cast<double>(weight)); }
float stored(double height, float weight) { return weighted(height, weight) / weight; }

}  // namespace

void EdgeCentres::widen_bounds(PlaneRows& rows, const LayerShape& layer, std::int64_t y) const {
  if (std::ranges::count(rules_, PlaneRule::kLinear) == static_cast<std::ptrdiff_t>(rules_.size())) return;
  const Heights heights(rows, layer, range_, weight_plane_);
  const TexelRect& active = rows.plan().active;
  for (std::int64_t x = heights.first_cut(y, active.x, active.width); x < active.right(); ++x) {
    const auto centre = heights.at_centre(x, y);
    if (!centre) continue;
    const float height = stored(*centre, rows.row(y, weight_plane_)[x - active.x]);
    for (std::size_t p = 0; p < rules_.size(); ++p) {
      float& bound = rows.row(y, static_cast<int>(p))[x - active.x];
      if (rules_[p] == PlaneRule::kLeast) bound = std::min(bound, height);
      if (rules_[p] == PlaneRule::kGreatest) bound = std::max(bound, height);
    }
  }
}

void EdgeCentres::move(const PlaneRows& rows, const LayerShape& layer, std::int64_t y, std::int64_t x, std::int64_t count,
                       std::vector<float>& buffer, channels::ConstPlaneRow& row) const {
  const Heights heights(rows, layer, range_, weight_plane_);
  const std::int64_t first = heights.first_cut(y, x, count);
  if (first == x + count) return;
  // One texel at either end may be read as well.
  buffer.assign(row[0] - 1, row[0] + count + 1);
  for (std::int64_t i = first - x; i < count; ++i)
    if (const auto height = heights.at_centre(x + i, y))
      buffer[static_cast<std::size_t>(i) + 1] = weighted(*height, row[static_cast<std::size_t>(weight_plane_)][i]);
  row[0] = buffer.data() + 1;
}

}  // namespace vt::pyramid
