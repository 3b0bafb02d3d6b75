// What a row of source samples looks like and what its numbers mean: made of what a reader knows of the bands
// that a channel asked for. Plain values.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/source/sample_type.h"

namespace vt::channels {

// The samples that mean "no data": one value for all bands, or one for each. A texel is no data when all its
// values are (of horizons, when any is). Which samples equal a declared value, see nodata_range().
class NodataKey {
 public:
  NodataKey(double value) : values_{value} {}  // NOLINT(google-explicit-constructor): most rasters have one value
  // `values` is not empty.
  explicit NodataKey(std::vector<double> values) : values_(std::move(values)) {}

  [[nodiscard]] double of(std::size_t band) const { return values_[band < values_.size() ? band : values_.size() - 1]; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  // NaN equals NaN.
  [[nodiscard]] bool operator==(const NodataKey& other) const;

 private:
  std::vector<double> values_;
};

// `value_bands` values, then one coverage sample when `has_alpha`, interleaved, native byte order.
struct SampleLayout {
  SampleType type = SampleType::kUint8;
  int value_bands = 3;
  bool has_alpha = false;
  std::optional<NodataKey> nodata;  // NaN and infinities always are no data
  // Source values that mean black and white, for colour from samples that are not 8 or 16 bit codes.
  std::optional<std::array<double, 2>> range;
  // The samples that mean "all of it", where they are not the type's own, see full_scale(SampleType): 15 of
  // codes of 4 bits.
  std::optional<double> value_full_scale;
  std::optional<double> alpha_full_scale;
  // The meaning of numbers with a unit: value = offset + scale * sample, in `unit` as the file writes it.
  // Empty: the file declares nothing.
  std::optional<double> scale;
  std::optional<double> offset;
  std::string unit;
  bool counts_down = false;  // heights are depths

  [[nodiscard]] std::size_t texel_bytes() const { return sample_bytes(type) * static_cast<std::size_t>(value_bands + (has_alpha ? 1 : 0)); }
  [[nodiscard]] double full_value() const { return value_full_scale.value_or(full_scale(type)); }
  [[nodiscard]] double full_alpha() const { return alpha_full_scale.value_or(full_scale(type)); }
  [[nodiscard]] bool operator==(const SampleLayout&) const = default;
};

}  // namespace vt::channels
