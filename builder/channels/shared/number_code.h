// How one number of a texel is written: as a float, as a half, or as a 16-bit code over a range. Any thread.
#pragma once

#include <array>
#include <cstddef>

#include "store/layer.h"
#include "store/texel_format.h"

namespace vt::channels {

class NumberCode {
 public:
  // The code of one component of `format`: r32f, r16f, r16, bc4 and their relatives of more channels. `span`
  // is the least and the greatest number that codes have to express; floats and halves need none and write
  // numbers as they are. `zero_is_nodata`: numbers have the codes 1 to 65535, of a format with 16-bit codes.
  NumberCode(TexelFormat format, const std::array<double, 2>& span, bool zero_is_nodata);

  // What a decoded sample is worth, for the layer's description.
  [[nodiscard]] const ComponentRange& range() const { return range_; }
  // The least and the greatest number that can be written; others become those.
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double greatest() const { return greatest_; }
  // What write() puts, in bytes.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  // To nearest, codes with halves up, floats with halves to even. `value` is finite.
  void write(double value, std::byte* out) const;
  // NaN in floats and halves, code 0 otherwise.
  void write_nodata(std::byte* out) const;

 private:
  enum class Kind { kFloat, kHalf, kCode };

  Kind kind_ = Kind::kFloat;
  std::size_t bytes_ = 4;
  double least_ = 0.0;
  double greatest_ = 0.0;
  double codes_per_unit_ = 1.0;
  double first_code_ = 0.0;
  ComponentRange range_;
};

}  // namespace vt::channels
