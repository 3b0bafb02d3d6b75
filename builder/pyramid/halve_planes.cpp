#include "builder/pyramid/halve_planes.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "builder/channels/shared/coverage.h"
#include "builder/pyramid/reduce_rows.h"

namespace vt::pyramid {
namespace {

using channels::ConstPlaneRow;
using channels::PlaneRow;
using channels::PlaneRule;

// A column or row that lies inside, found by mirroring at the edges as often as it takes.
std::int64_t mirrored(std::int64_t at, std::int64_t begin, std::int64_t end) {
  const std::int64_t count = end - begin;
  std::int64_t from_begin = (at - begin) % (2 * count);
  if (from_begin < 0) from_begin += 2 * count;
  return begin + (from_begin < count ? from_begin : 2 * count - 1 - from_begin);
}

std::int64_t mirrored_row(const PlaneRows& rows, std::int64_t y) {
  const TexelRect& data = rows.plan().data;
  return mirrored(y, data.y, data.bottom());
}

template <class Row>
Row shifted(Row row, std::int64_t places) {
  for (auto& plane : row)
    if (plane != nullptr) plane += places;
  return row;
}

}  // namespace

PlaneHalver::PlaneHalver(std::span<const PlaneRule> rules, int weight_plane, const HalvingKernel& kernel, std::int64_t widest)
    : kernel_(kernel), rules_(rules.begin(), rules.end()), weight_plane_(weight_plane), widest_(widest) {
  for (int p = 0; p < static_cast<int>(rules_.size()); ++p)
    if (is_linear(p) && p != weight_plane) value_planes_.push_back(p);
  if (kernel.taps == 2) return;
  assert(std::ranges::count(rules_, PlaneRule::kRemainder) == 0);
  added_.assign(rules_.size() * static_cast<std::size_t>(widest), 0.0F);
  scratch_.assign((value_planes_.size() + 1) * halve_scratch_floats(static_cast<std::size_t>(widest) / 2), 0.0F);
}

void PlaneHalver::make_row(const PlaneRows& fine, PlaneRows& coarse) {
  const std::int64_t y = coarse.next();
  const PlaneRow row = coarse.begin_row();
  const bool is_wide = kernel_.taps > 2;
  const bool rows_are_opaque = is_wide && add_up_rows(fine, y);
  bool opaque = true;
  for (const ColumnRun& run : coarse.runs()) {
    const Strip strip = strip_of(fine, run, row);
    take_extremes(fine, y, strip);
    const bool strip_is_opaque = is_wide ? halve_wide(fine, y, strip, rows_are_opaque) : halve_pairs(fine, y, strip);
    opaque = opaque && strip_is_opaque;
  }
  coarse.end_row(opaque);
}

PlaneHalver::Strip PlaneHalver::strip_of(const PlaneRows& fine, const ColumnRun& run, const PlaneRow& row) {
  const BlockLevel& plan = fine.plan();
  Strip strip{.rect = run.rect};
  const std::int64_t column = 2 * run.rect.x;
  const bool is_beyond = run.at > 0;
  if (is_beyond && fine.runs().size() > 1) {
    const ColumnRun& beyond = fine.runs()[1];
    strip.source = beyond.at + column - beyond.rect.x;
  } else {
    // The other end of a level that wraps follows on the active columns.
    const std::int64_t turn = is_beyond && fine.wraps() ? plan.data.width : 0;
    strip.source = (run.rect.x == 0 ? column + turn : column - turn) - plan.active.x;
  }
  if (fine.ends_in_x()) {
    strip.cuts_west = column < plan.data.x;
    strip.cuts_east = 2 * run.rect.right() > plan.data.right();
  }
  strip.out = shifted(row, run.at);
  return strip;
}

bool PlaneHalver::is_whole(const Strip& strip) const {
  const float* const weights = strip.out[static_cast<std::size_t>(weight_plane_)];
  return std::all_of(weights, weights + strip.rect.width, [](float w) { return w == 1.0F; });
}

void PlaneHalver::take_extremes(const PlaneRows& fine, std::int64_t y, const Strip& strip) const {
  const auto count = static_cast<std::size_t>(strip.rect.width);
  for (int p = 0; p < static_cast<int>(rules_.size()); ++p) {
    const PlaneRule rule = rules_[static_cast<std::size_t>(p)];
    if (rule != PlaneRule::kLeast && rule != PlaneRule::kGreatest) continue;
    const float* const upper = fine.row_or_nothing(2 * y, p) + strip.source;
    const float* const lower = fine.row_or_nothing(2 * y + 1, p) + strip.source;
    float* const out = strip.out[static_cast<std::size_t>(p)];
    if (rule == PlaneRule::kLeast)
      least_of_four(upper, lower, count, out);
    else
      greatest_of_four(upper, lower, count, out);
  }
}

// The box and the point kernel. Outside the data there is nothing, which gives a cut texel the half of its
// mirrored self that it keeps.
bool PlaneHalver::halve_pairs(const PlaneRows& fine, std::int64_t y, const Strip& strip) const {
  const bool has_both = fine.has(2 * y) && fine.has(2 * y + 1);
  const bool opaque = has_both && fine.is_opaque(2 * y) && fine.is_opaque(2 * y + 1) && !strip.cuts_west && !strip.cuts_east;
  const auto count = static_cast<std::size_t>(strip.rect.width);
  for (int p = 0; p < static_cast<int>(rules_.size()); ++p) {
    const bool is_remainder = rules_[static_cast<std::size_t>(p)] == PlaneRule::kRemainder;
    if (!is_linear(p) && !is_remainder) continue;
    const auto fine_row = [&](std::int64_t row, int plane) { return fine.row_or_nothing(row, plane) + strip.source; };
    float* const out = strip.out[static_cast<std::size_t>(p)];
    if (opaque && p == weight_plane_)
      std::fill_n(out, count, 1.0F);
    else if (kernel_.is_point)
      pick_first(fine_row(2 * y, p), count, out);
    else if (is_remainder)
      remainder_of_four({fine_row(2 * y, p - 1), fine_row(2 * y, p)}, {fine_row(2 * y + 1, p - 1), fine_row(2 * y + 1, p)},
                        strip.out[static_cast<std::size_t>(p) - 1], count, out);
    else
      halve_two_rows(fine_row(2 * y, p), fine_row(2 * y + 1, p), kernel_, count, out);
  }
  return opaque || is_whole(strip);
}

// Returns whether all weights under the kernel are 1; if so, those of added() mean nothing.
bool PlaneHalver::add_up_rows(const PlaneRows& fine, std::int64_t y) {
  std::array<std::int64_t, kMaxTaps> rows{};
  bool opaque = true;
  for (int t = 0; t < kernel_.taps; ++t) {
    rows[static_cast<std::size_t>(t)] = mirrored_row(fine, 2 * y - kernel_.reach() + t);
    opaque = opaque && fine.is_opaque(rows[static_cast<std::size_t>(t)]);
  }
  using Taps = std::array<const float*, kMaxTaps>;
  const auto taps_of = [&](int plane) {
    Taps taps{};
    for (std::size_t t = 0; t < static_cast<std::size_t>(kernel_.taps); ++t)
      taps[t] = fine.row_or_nothing(rows[t], plane) - PlaneRows::kPad;
    return taps;
  };
  const auto count = static_cast<std::size_t>(fine.stride());
  std::array<Taps, channels::kMaxPlanes> values;
  std::array<const float* const*, channels::kMaxPlanes> of_planes{};
  std::array<float*, channels::kMaxPlanes> sums{};
  for (std::size_t i = 0; i < value_planes_.size(); ++i) {
    values[i] = taps_of(value_planes_[i]);
    of_planes[i] = values[i].data();
    sums[i] = added(value_planes_[i]) - PlaneRows::kPad;
    combine_rows(of_planes[i], kernel_, count, sums[i]);
  }
  if (!opaque) {
    const Taps weights = taps_of(weight_plane_);
    const auto upper = static_cast<std::size_t>(kernel_.reach());
    mean_of_rows(weights[upper], weights[upper + 1], count, added(weight_plane_) - PlaneRows::kPad);
    combine_partial_rows(weights.data(), std::span(of_planes).first(value_planes_.size()), kernel_, count, sums.data());
  }
  if (fine.ends_in_x()) {
    for (const int p : value_planes_) mirror_ends(fine, added(p));
    if (!opaque) mirror_ends(fine, added(weight_plane_));
  }
  return opaque;
}

// Texels past the data's west and east edge, as far as taps reach.
void PlaneHalver::mirror_ends(const PlaneRows& fine, float* row) const {
  const TexelRect& data = fine.plan().data;
  const TexelRect& active = fine.plan().active;
  const auto fill = [&](std::int64_t column) {
    const std::int64_t source = mirrored(column, data.x, data.right());
    if (source >= active.x && source < active.right()) row[column - active.x] = row[source - active.x];
  };
  for (std::int64_t i = 1; i <= kernel_.reach() + 1; ++i) {
    if (active.x == data.x) fill(data.x - i);
    if (active.right() == data.right()) fill(data.right() - 1 + i);
  }
}

bool PlaneHalver::halve_wide(const PlaneRows& fine, std::int64_t y, const Strip& strip, bool rows_are_opaque) {
  const auto count = static_cast<std::size_t>(strip.rect.width);
  std::array<const float*, channels::kMaxPlanes> rows{};
  std::array<float*, channels::kMaxPlanes> out{};
  for (std::size_t i = 0; i < value_planes_.size(); ++i) {
    rows[i] = added(value_planes_[i]) + strip.source;
    out[i] = strip.out[static_cast<std::size_t>(value_planes_[i])];
    pyramid::halve_row(rows[i], kernel_, count, scratch_.data(), out[i]);
  }
  float* const weights = strip.out[static_cast<std::size_t>(weight_plane_)];
  if (rows_are_opaque) {
    std::fill_n(weights, count, 1.0F);
  } else {
    const float* const added_weights = added(weight_plane_) + strip.source;
    mean_of_pairs(added_weights, count, weights);
    halve_partial_row(added_weights, std::span(rows).first(value_planes_.size()), kernel_, count, scratch_.data(), out.data());
  }
  if (kernel_.limits_ringing) limit_ringing(fine, y, strip, rows_are_opaque);
  return !keep_inner_halves(fine, y, strip) && (rows_are_opaque || is_whole(strip));
}

// Keeps every value between the least and the greatest of the 4 x 4 texels under the kernel's main lobe, so
// that its negative lobes sharpen edges but leave no rings beside them. What lies outside the data has no
// say, as if it were mirrored.
void PlaneHalver::limit_ringing(const PlaneRows& fine, std::int64_t y, const Strip& strip, bool rows_are_opaque) {
  const auto limit_covered = [&](std::int64_t first, std::int64_t count) {
    std::array<ConstPlaneRow, 4> rows;
    for (std::size_t t = 0; t < rows.size(); ++t)
      rows[t] = fine.planes_or_nothing(2 * y - 1 + static_cast<std::int64_t>(t), strip.source + 2 * first);
    channels::limit_to_covered(rows, rules_, weight_plane_, count, shifted(strip.out, first));
  };
  const std::int64_t width = strip.rect.width;
  const TexelRect& data = fine.plan().data;
  const std::int64_t column = fine.plan().active.x + strip.source;  // under the first texel
  const std::int64_t west = fine.ends_in_x() && column - 1 < data.x ? 1 : 0;
  const std::int64_t east = fine.ends_in_x() && column + 2 * width >= data.right() ? 1 : 0;
  if (!rows_are_opaque || width <= west + east) return limit_covered(0, width);
  if (west > 0) limit_covered(0, 1);
  if (east > 0) limit_covered(width - 1, 1);
  for (const int p : value_planes_) {
    std::array<const float*, 4> rows{};
    for (std::size_t t = 0; t < rows.size(); ++t)
      rows[t] = fine.row_or_nothing(mirrored_row(fine, 2 * y - 1 + static_cast<std::int64_t>(t)), p) + strip.source + 2 * west;
    limit_to_four_rows(rows.data(), static_cast<std::size_t>(width - west - east), scratch_.data(),
                       strip.out[static_cast<std::size_t>(p)] + west);
  }
}

// Keeps the inner halves of texels that the edges of the data cut. Returns whether there are any.
bool PlaneHalver::keep_inner_halves(const PlaneRows& fine, std::int64_t y, const Strip& strip) const {
  const TexelRect& data = fine.plan().data;
  const bool cuts_row = 2 * y < data.y || 2 * y + 1 >= data.bottom();
  if (!cuts_row && !strip.cuts_west && !strip.cuts_east) return false;
  for (int p = 0; p < static_cast<int>(rules_.size()); ++p) {
    if (!is_linear(p)) continue;
    float* const out = strip.out[static_cast<std::size_t>(p)];
    if (strip.cuts_west) out[0] *= 0.5F;
    if (strip.cuts_east) out[strip.rect.width - 1] *= 0.5F;
    for (std::int64_t i = 0; cuts_row && i < strip.rect.width; ++i) out[i] *= 0.5F;
  }
  return true;
}

}  // namespace vt::pyramid
