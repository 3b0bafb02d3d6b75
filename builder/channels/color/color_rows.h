// The inner loops of opaque 8-bit colour: codes to light and light to codes, a row at a time, SIMD with
// run-time dispatch. Table look-ups and comparisons only, so every CPU gives the same bits as CodeTable does
// code by code. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/channels/shared/srgb.h"

namespace vt::channels {

// `rgb` holds `count` texels of three codes; each plane receives `count` values of light.
void light_from_rgb8(const std::uint8_t* rgb, std::size_t count, const CodeTable& table, float* red, float* green, float* blue);

// The way back, to the code of the nearest light; the first texel lies in an even column.
void rgb8_from_light(const float* red, const float* green, const float* blue, std::size_t count, const CodeTable& table, std::uint8_t* rgb);

}  // namespace vt::channels
