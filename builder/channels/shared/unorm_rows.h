// UnormCode::code() for rows: SIMD, run-time dispatch, the same codes on every CPU target. Pure functions,
// any thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/channels/shared/unorm_code.h"

namespace vt::channels {

// `count` values, none of them NaN, to as many codes.
void unorm_codes(const UnormCode& code, std::size_t count, const float* values, std::uint16_t* codes);

}  // namespace vt::channels
