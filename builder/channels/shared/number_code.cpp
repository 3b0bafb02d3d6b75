#include "builder/channels/shared/number_code.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <limits>

#include "store/texel/half.h"

namespace vt::channels {

NumberCode::NumberCode(TexelFormat format, const std::array<double, 2>& span, bool zero_is_nodata) {
  switch (format_info(format).samples) {
    case SampleKind::kFloat:
      greatest_ = std::numeric_limits<float>::max();
      least_ = -greatest_;
      return;
    case SampleKind::kHalf:
      kind_ = Kind::kHalf;
      bytes_ = 2;
      greatest_ = 65504.0;
      least_ = -greatest_;
      return;
    case SampleKind::kUnorm16:
    case SampleKind::kBlock:
      break;
    case SampleKind::kUnorm8:
    case SampleKind::kSharedExponent:
    case SampleKind::kOpaque:
      assert(false && "a format that numbers are not stored in");
      break;
  }
  kind_ = Kind::kCode;
  bytes_ = 2;
  least_ = span[0];
  greatest_ = span[1];
  first_code_ = zero_is_nodata ? 1.0 : 0.0;
  const double width = greatest_ - least_;
  assert(width > 0.0);
  codes_per_unit_ = (65535.0 - first_code_) / width;
  // Blocks are decoded to the scale of 0 to 255, whichever 16-bit codes they were made from.
  const bool is_block = format_info(format).samples == SampleKind::kBlock;
  range_.scale = is_block ? width / 255.0 : width / (65535.0 - first_code_);
  range_.offset = least_ - first_code_ * range_.scale;
  assert(!is_block || !zero_is_nodata);
}

void NumberCode::write(double value, std::byte* out) const {
  const double inside = std::clamp(value, least_, greatest_);
  if (kind_ == Kind::kFloat) {
    const auto number = static_cast<float>(inside);
    std::memcpy(out, &number, sizeof number);
    return;
  }
  const std::uint16_t code = kind_ == Kind::kHalf ? half_from_float(static_cast<float>(inside))
                                                  : static_cast<std::uint16_t>((inside - least_) * codes_per_unit_ + first_code_ + 0.5);
  std::memcpy(out, &code, sizeof code);
}

void NumberCode::write_nodata(std::byte* out) const {
  if (kind_ == Kind::kFloat) {
    const float hole = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(out, &hole, sizeof hole);
    return;
  }
  const std::uint16_t code = kind_ == Kind::kHalf ? kHalfNoData : std::uint16_t{0};
  std::memcpy(out, &code, sizeof code);
}

}  // namespace vt::channels
