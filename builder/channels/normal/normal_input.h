// Samples of a normal map as unit vectors. Owns what codes mean, the third component of maps that have two,
// and what is no data.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/channels/codec/channel_codec.h"
#include "store/result.h"

namespace vt::channels {

struct NormalInput {
  SampleLayout layout;
  bool centre_is_code = true;  // unsigned code 128 (32768) is 0; otherwise 127.5 (32767.5) is
  bool y_is_down = false;

  // `count` texels into planes 0 to 2, unit vectors, and 3, their weights. No data, weight 0: a sample that
  // is declared so, that is not finite, or that is too short to have a direction (codes: all components
  // within three quarters of a code from 0). Returns whether all weights are 1.
  bool decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const;
};

// kUsage, kUnsupported: see make_codec().
[[nodiscard]] Result<NormalInput> choose_normal_input(const Options& options, const SampleLayout& layout);

}  // namespace vt::channels
