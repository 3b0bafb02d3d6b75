#include "builder/channels/codec/channel_codec.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "builder/channels/samples/read_samples.h"
#include "builder/channels/samples/wide_value.h"

namespace vt::channels {

SampleLayout ChannelCodec::weighed_by_coverage(const SampleLayout& layout, CoverageUse use) {
  if (!layout.has_alpha) return layout;
  covered_layout_ = layout;
  coverage_use_ = use;
  SampleLayout values = layout;
  values.has_alpha = false;
  return values;
}

bool ChannelCodec::decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
  return covered_layout_ ? decode_covered(samples, count, out) : decode_values(samples, count, out);
}

// Piece by piece: values and coverage are taken apart, and the planes of the values are multiplied by the
// coverage.
bool ChannelCodec::decode_covered(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
  constexpr std::int64_t kAtOnce = 128;
  constexpr std::size_t kMostValueBytes = 8 * kMaxPlanes;
  const SampleLayout& layout = *covered_layout_;
  const std::size_t texel_bytes = layout.texel_bytes();
  const std::size_t value_bytes = texel_bytes - sample_bytes(layout.type);
  const double full = layout.full_alpha();
  std::array<std::byte, kAtOnce * kMostValueBytes> values;
  std::array<float, kAtOnce> coverage;
  bool opaque = true;
  for (std::int64_t first = 0; first < count; first += kAtOnce) {
    const std::int64_t piece = std::min(kAtOnce, count - first);
    for (std::int64_t i = 0; i < piece; ++i, samples += texel_bytes) {
      std::memcpy(values.data() + static_cast<std::size_t>(i) * value_bytes, samples, value_bytes);
      const double share = read_sample(layout.type, samples + value_bytes) / full;
      // A coverage that is no number is none.
      const double clamped = share > 0.0 ? std::min(share, 1.0) : 0.0;
      coverage[static_cast<std::size_t>(i)] =
          static_cast<float>(coverage_use_ == CoverageUse::kHalf ? (clamped >= 0.5 ? 1.0 : 0.0) : clamped);
    }
    PlaneRow planes = out;
    for (int p = 0; p < source_planes_; ++p) planes[static_cast<std::size_t>(p)] += first;
    opaque = decode_values(values.data(), piece, planes) && opaque;
    for (std::int64_t i = 0; i < piece; ++i) {
      const float weight = coverage[static_cast<std::size_t>(i)];
      if (weight == 1.0F) continue;
      opaque = false;
      for (std::size_t p = 0; p < static_cast<std::size_t>(source_planes_); ++p) {
        if (has_remainder(rules_, p)) {
          // A sum and what its floats miss: the product is rounded once, in double precision.
          const double product = (static_cast<double>(planes[p][i]) + static_cast<double>(planes[p + 1][i])) * static_cast<double>(weight);
          split_wide(product, planes[p][i], planes[p + 1][i]);
          ++p;
        } else {
          planes[p][i] *= weight;
        }
      }
    }
  }
  return opaque;
}

void ChannelCodec::derive_row(std::int64_t, const PlaneRow&) const {}

void ChannelCodec::count_losses(const ConstPlaneRow&, bool, std::int64_t, std::int64_t, std::int64_t, std::span<LossCount>) const {}

bool ChannelCodec::has_data(std::size_t, const ConstPlaneRow& planes, std::int64_t count) const {
  const float* const weights = planes[static_cast<std::size_t>(weight_plane())];
  return std::any_of(weights, weights + count, [](float weight) { return weight > 0.0F; });
}

}  // namespace vt::channels
