// A few rows of planes with room on either side, as codecs see them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "builder/channels/codec/channel_codec.h"

namespace vt::channels {

class Rows {
 public:
  explicit Rows(std::int64_t width) : width_(width), floats_(static_cast<std::size_t>((width + 2 * kPad) * kMaxPlanes * 3), 0.0F) {}

  [[nodiscard]] PlaneRow row(int index) {
    PlaneRow planes{};
    for (int p = 0; p < kMaxPlanes; ++p)
      planes[static_cast<std::size_t>(p)] = floats_.data() + (index * kMaxPlanes + p) * (width_ + 2 * kPad) + kPad;
    return planes;
  }
  [[nodiscard]] RowNeighbourhood middle(bool opaque) {
    const auto fixed = [](const PlaneRow& from) {
      ConstPlaneRow to{};
      for (std::size_t p = 0; p < to.size(); ++p) to[p] = from[p];
      return to;
    };
    return {fixed(row(0)), fixed(row(1)), fixed(row(2)), opaque};
  }

 private:
  static constexpr std::int64_t kPad = 4;
  std::int64_t width_;
  std::vector<float> floats_;
};

template <class T>
[[nodiscard]] const std::byte* bytes_of(const std::vector<T>& values) {
  return reinterpret_cast<const std::byte*>(values.data());
}

}  // namespace vt::channels
