// How a layer's values become a picture for people: which channels are shown, what is black and what is
// white. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "store/layer.h"
#include "tools/vtinspect/class_names.h"

namespace vt::inspect {

// Black and white of a picture, in values of the layer.
struct ValueRange {
  float min = 0.0F;
  float max = 255.0F;
};

class Display {
 public:
  explicit Display(const LayerInfo& layer);

  // The layer's own channels are what is shown, byte for byte.
  [[nodiscard]] bool shows_bytes() const { return shows_bytes_; }
  // Grey or three colours; coverage is not among them.
  [[nodiscard]] int channels() const { return channels_; }
  // How many of those say something: of two components the third colour stays dark.
  [[nodiscard]] std::size_t channels_with_values() const { return channels_with_values_; }
  // What black and white are whatever the values are: codes, components of directions. nullopt: what the
  // values reach.
  [[nodiscard]] std::optional<ValueRange> fixed_range() const { return fixed_range_; }

  // The values to show of a texel. A direction of which x and y are stored gets its z, a class its colour,
  // where its layer's table has colours. NaN: no data.
  [[nodiscard]] std::array<float, 3> shown(std::span<const float> texel) const;
  // 0 to 255. Light is shown as the sRGB code of its share of the range, all else in proportion.
  [[nodiscard]] float tone(float value, const ValueRange& range) const;

 private:
  int channels_;
  std::size_t channels_with_values_;
  bool shows_bytes_;
  bool has_only_xy_ = false;
  bool is_light_ = false;
  std::optional<ValueRange> fixed_range_;
  ClassTable classes_;  // with colours, or empty
};

// The range of values that are seen bit by bit: from the least to the greatest; of light up to the value that
// one in 200 exceeds, so that a few lamps do not leave the rest black.
class RangeFinder {
 public:
  explicit RangeFinder(const LayerInfo& layer);

  // One texel's values as Display::shown gives them.
  void add(std::span<const float> values);
  [[nodiscard]] ValueRange range() const;
  [[nodiscard]] bool has_holes() const { return has_holes_; }

 private:
  bool is_light_;
  bool has_holes_ = false;
  float min_;
  float max_;
  // Every stride-th value of light; the stride doubles when there are too many.
  std::vector<float> kept_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

}  // namespace vt::inspect
