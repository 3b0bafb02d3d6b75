// Heights at the centres of texels that the edge of the data rectangle cuts.
//
// The mean over the part of such a texel that has data belongs to the middle of that part, up to half a texel
// from the texel's own centre. With `filled` the part of the last column that has data, the middles of the
// last two columns lie (1 + filled) / 2 texels apart and the last centre (1 - filled) / 2 beyond the last
// middle, so a straight line through both has there
//   last + (last - before) * (1 - filled) / (1 + filled).
// Along rows first, then along columns: exact for heights a + b x + c y + d x y. Where the column before has
// no data the mean stays. Pure functions on the rows of a level; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pyramid/plane_rows.h"

namespace vt::pyramid {

class EdgeCentres {
 public:
  // The values are those of plane 0, and of its remainder when there is one.
  EdgeCentres(const channels::CentreRange& range, std::span<const channels::PlaneRule> rules, int weight_plane)
      : range_(range),
        rules_(rules.begin(), rules.end()),
        is_wide_(rules_.size() > 1 && rules_[1] == channels::PlaneRule::kRemainder),
        weight_plane_(weight_plane) {}

  // Widens row `y`, which is written: bounds hold the values at the centres too, here and so in all coarser
  // levels.
  void widen_bounds(PlaneRows& rows, const LayerShape& layer, std::int64_t y) const;
  // `row` points at column `x` of row `y`, of which `count` columns are of interest: points it at values at
  // the centres where the edge cuts any of them. They lie in `buffer`.
  void move(const PlaneRows& rows, const LayerShape& layer, std::int64_t y, std::int64_t x, std::int64_t count, std::vector<float>& buffer,
            channels::ConstPlaneRow& row) const;

 private:
  channels::CentreRange range_;
  std::vector<channels::PlaneRule> rules_;
  bool is_wide_;
  int weight_plane_;
};

}  // namespace vt::pyramid
