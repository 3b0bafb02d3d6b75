// Blocks decoded by the OpenGL driver (Mesa's software one where there is no GPU): an independent decoder for
// every format it knows.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vt::encode {

// Internal formats, from the registry's gl.xml.
enum class GlBlockFormat : unsigned {
  kRgbaDxt5 = 0x83F3,              // BC3
  kRedRgtc1 = 0x8DBB,              // BC4
  kRgRgtc2 = 0x8DBD,               // BC5
  kRgbaBptcUnorm = 0x8E8C,         // BC7
  kRgbBptcUnsignedFloat = 0x8E8F,  // BC6H
};

// RGBA, 4 floats a texel, 0 to 1 but for floats, of `width` x `height` texels (multiples of 4) of blocks in
// rows. Empty when this machine has no OpenGL context or the driver refuses the format; `why` says which.
[[nodiscard]] std::optional<std::vector<float>> decoded_by_opengl(GlBlockFormat format, std::span<const std::byte> blocks,
                                                                  std::size_t width, std::size_t height, std::string& why);

}  // namespace vt::encode
