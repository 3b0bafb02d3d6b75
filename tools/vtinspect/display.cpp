#include "tools/vtinspect/display.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/channels/all_channels.h"
#include "builder/channels/shared/srgb.h"
#include "tools/vtinspect/layer_values.h"

namespace vt::inspect {
namespace {

constexpr std::size_t kMostKept = 1 << 16;
constexpr double kShareOfLamps = 1.0 / 200.0;

}  // namespace

Display::Display(const LayerInfo& layer) {
  const TexelLayout layout = layout_of(layer);
  const ClassTable classes = class_table_of(layer);
  if (classes.has_colors() && layout.channels == 1) classes_ = classes;
  channels_ = layout.channels == 1 && !classes_.has_colors() ? 1 : 3;
  shows_bytes_ = !layout.is_float && !classes_.has_colors();
  const channels::Shown shown = channels::kind_of(layer.channel).shown;
  const bool is_direction = shown == channels::Shown::kDirections && !layer.is_part && layout.is_float;
  has_only_xy_ = is_direction && layout.channels == 2;
  channels_with_values_ =
      has_only_xy_ ? 3 : std::min<std::size_t>(static_cast<std::size_t>(channels_), static_cast<std::size_t>(layout.channels));
  if (classes_.has_colors()) channels_with_values_ = 3;
  is_light_ = shown == channels::Shown::kLight && layout.is_float;
  if (!layout.is_float || classes_.has_colors()) fixed_range_ = ValueRange{0.0F, 255.0F};
  if (is_direction) fixed_range_ = ValueRange{-1.0F, 1.0F};
}

std::array<float, 3> Display::shown(std::span<const float> texel) const {
  std::array<float, 3> values{};
  if (classes_.has_colors()) {
    const auto color = std::isfinite(texel[0]) ? classes_.color_of(static_cast<int>(texel[0])) : std::nullopt;
    for (std::size_t c = 0; c < 3; ++c) values[c] = color ? static_cast<float>((*color)[c]) : std::numeric_limits<float>::quiet_NaN();
    return values;
  }
  for (std::size_t c = 0; c < std::min<std::size_t>(texel.size(), 3); ++c) values[c] = texel[c];
  if (has_only_xy_) values[2] = std::sqrt(std::max(0.0F, 1.0F - values[0] * values[0] - values[1] * values[1]));
  return values;
}

float Display::tone(float value, const ValueRange& range) const {
  if (!(range.max > range.min)) return 127.5F;
  const float share = std::clamp((value - range.min) / (range.max - range.min), 0.0F, 1.0F);
  return 255.0F * (is_light_ ? static_cast<float>(channels::srgb_from_linear(share)) : share);
}

RangeFinder::RangeFinder(const LayerInfo& layer)
    : is_light_(channels::kind_of(layer.channel).shown == channels::Shown::kLight),
      min_(std::numeric_limits<float>::infinity()),
      max_(-std::numeric_limits<float>::infinity()) {}

void RangeFinder::add(std::span<const float> values) {
  for (const float value : values) {
    if (!std::isfinite(value)) {
      has_holes_ = true;
      continue;
    }
    min_ = std::min(min_, value);
    max_ = std::max(max_, value);
    if (!is_light_ || seen_++ % stride_ != 0) continue;
    kept_.push_back(value);
    if (kept_.size() < kMostKept) continue;
    for (std::size_t i = 0; i < kMostKept / 2; ++i) kept_[i] = kept_[2 * i];
    kept_.resize(kMostKept / 2);
    stride_ *= 2;
  }
}

ValueRange RangeFinder::range() const {
  if (min_ > max_) return {0.0F, 0.0F};  // nothing but holes
  if (!is_light_) return {min_, max_};
  std::vector<float> values = kept_;
  const auto at = static_cast<std::ptrdiff_t>(static_cast<double>(values.size() - 1) * (1.0 - kShareOfLamps));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  const float white = values[static_cast<std::size_t>(at)];
  return {0.0F, white > 0.0F ? white : max_};
}

}  // namespace vt::inspect
