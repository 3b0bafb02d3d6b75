// The texel formats a tile may hold, and the byte arithmetic that follows from them. The runtime looks only at these, never at channel
// types.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vt {

// Numbers are on disk. Append; never renumber, never reuse. All multi-byte samples are little-endian, channels interleaved in the order
// named.
enum class TexelFormat : std::uint16_t {
  kRgb8 = 1,      // three unsigned bytes; the layer's transfer function says what a code means
  kRgba8 = 2,     // the same with straight (not premultiplied) coverage, linear, in the fourth byte
  kBc1 = 3,       // 4x4 blocks of 8 bytes, opaque four-colour mode
  kR32Float = 4,  // one IEEE 754 float; quiet NaN (0x7FC00000) is "no data"
  kRg32Float = 5,
  kRgba32Float = 6,
  kHash128 = 7,  // 16 bytes without a meaning to readers of textures, such as a content hash; no colour, no number, never averaged
};

// One row per format. A block is 1x1 texel for plain formats and 4x4 for the BCn family.
struct FormatInfo {
  TexelFormat format;
  std::string_view name;  // as on the command line
  std::uint8_t channels;
  std::uint8_t block_edge;   // texels along one side of a block
  std::uint8_t block_bytes;  // bytes of one block
};

[[nodiscard]] const FormatInfo& format_info(TexelFormat format);                    // `format` is one of the enumerators
[[nodiscard]] std::optional<TexelFormat> format_from_number(std::uint16_t number);  // for bytes read from a file
[[nodiscard]] std::optional<TexelFormat> format_from_name(std::string_view name);

// Bytes of a width x height rectangle of texels; both are multiples of the block edge.
[[nodiscard]] constexpr std::size_t payload_bytes(const FormatInfo& info, std::size_t width, std::size_t height) {
  return (width / info.block_edge) * (height / info.block_edge) * info.block_bytes;
}

}  // namespace vt
