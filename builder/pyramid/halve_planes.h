// One row of planes of a coarser level from the rows of the finer one, by the layer's kernel.
//
// At the edges of the data rectangle kernels see the data mirrored, values and weights alike; across the seam
// of a closed layer they see the other side. Where the rectangle cuts texels of the coarser level, because it
// ends at an odd column or row, such a texel keeps half of what it has with the mirrored data: the part
// inside. So sums over all texels are the same at every level, up to rounding. One object per thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/pyramid/plane_rows.h"

namespace vt::pyramid {

class PlaneHalver {
 public:
  // Rows have at most `widest` floats.
  PlaneHalver(std::span<const channels::PlaneRule> rules, int weight_plane, const HalvingKernel& kernel, std::int64_t widest);

  // How many rows of a level have to be kept: those under the kernel, and a few for whoever they are passed
  // on to.
  [[nodiscard]] static int rows_needed(const HalvingKernel& kernel) { return kernel.taps + 4; }
  // Row coarse.next() can be made.
  [[nodiscard]] bool is_ready(const PlaneRows& fine, const PlaneRows& coarse) const {
    return fine.is_full() || 2 * coarse.next() + 1 + kernel_.reach() < fine.next();
  }
  // Writes it.
  void make_row(const PlaneRows& fine, PlaneRows& coarse);

 private:
  // A run of the coarser level.
  struct Strip {
    TexelRect rect;
    std::int64_t source = 0;   // place of the first texel under it, in rows of the finer level; may be -1
    bool cuts_west = false;    // its first texel reaches over the west edge of the data
    bool cuts_east = false;    // its last one over the east edge
    channels::PlaneRow out{};  // at its first texel
  };

  [[nodiscard]] static Strip strip_of(const PlaneRows& fine, const ColumnRun& run, const channels::PlaneRow& row);
  [[nodiscard]] bool is_linear(int plane) const { return rules_[static_cast<std::size_t>(plane)] == channels::PlaneRule::kLinear; }
  [[nodiscard]] bool is_whole(const Strip& strip) const;

  void take_extremes(const PlaneRows& fine, std::int64_t y, const Strip& strip) const;
  [[nodiscard]] bool halve_pairs(const PlaneRows& fine, std::int64_t y, const Strip& strip) const;
  [[nodiscard]] bool add_up_rows(const PlaneRows& fine, std::int64_t y);
  void mirror_ends(const PlaneRows& fine, float* row) const;
  [[nodiscard]] bool halve_wide(const PlaneRows& fine, std::int64_t y, const Strip& strip, bool rows_are_opaque);
  void limit_ringing(const PlaneRows& fine, std::int64_t y, const Strip& strip, bool rows_are_opaque);
  [[nodiscard]] bool keep_inner_halves(const PlaneRows& fine, std::int64_t y, const Strip& strip) const;
  [[nodiscard]] float* added(int plane) { return added_.data() + plane * widest_ + PlaneRows::kPad; }

  HalvingKernel kernel_;
  std::vector<channels::PlaneRule> rules_;
  int weight_plane_;
  std::vector<int> value_planes_;  // linear, without the weight
  std::int64_t widest_;
  std::vector<float> added_;  // of kernels of more than two taps: for each plane the rows added up, columns as in rows of the finer level
  std::vector<float> scratch_;
};

}  // namespace vt::pyramid
