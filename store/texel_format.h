// The texel formats a tile may hold, and the byte arithmetic that follows from them. What a decoded sample is worth follows from the
// layer's component ranges (store/layer.h). Plain values, any thread.
//
// A TexelFormat may hold any number: a store that a newer program wrote may have a layer in a format that this program does not know. Its
// tiles cannot be read; everything else about the store can.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vt {

// Numbers are on disk. Append; never renumber, never reuse; 0 is no format. All multi-byte samples are little-endian, channels interleaved
// in the order named.
enum class TexelFormat : std::uint16_t {
  kRgb8 = 1,      // three unsigned bytes; the layer's transfer function says what a code means
  kRgba8 = 2,     // the same with straight (not premultiplied) coverage, linear, in the fourth byte
  kBc1 = 3,       // 4x4 blocks of 8 bytes, opaque four-colour mode
  kR32Float = 4,  // one IEEE 754 float; quiet NaN (0x7FC00000) is "no data"
  kRg32Float = 5,
  kRgba32Float = 6,
  kHash128 = 7,  // 16 bytes without a meaning to readers of textures, such as a content hash; no colour, no number, never averaged
  kR8 = 8,
  kRg8 = 9,
  kR16 = 10,  // unsigned 16-bit codes
  kRg16 = 11,
  kRgba16 = 12,
  kR16Float = 13,  // IEEE 754 binary16; quiet NaN (0x7E00) is "no data"
  kRg16Float = 14,
  kRgba16Float = 15,
  kRgb9e5 = 16,  // three 9-bit mantissas and one 5-bit exponent, as OpenGL's GL_UNSIGNED_INT_5_9_9_9_REV lays them out in 32 bits
  kBc3 = 17,     // 16 bytes: a BC4 block of alpha, then a BC1 block in four-colour mode
  kBc4 = 18,     // 8 bytes, one unsigned channel
  kBc5 = 19,     // 16 bytes: two BC4 blocks
  kBc6h = 20,    // 16 bytes, three unsigned half floats
  kBc7 = 21,     // 16 bytes, RGB or RGBA
  kBlob = 22,    // one string of bytes a tile, of any length; only in carry layers
};

// What a sample is, decoded.
enum class SampleKind : std::uint8_t {
  kUnorm8,          // a code, 0 to 255
  kUnorm16,         // a code, 0 to 65535
  kHalf,            // a number
  kFloat,           // a number
  kSharedExponent,  // a number from 0 to 65408
  kBlock,           // decoded out of a 4x4 block: a code from 0 to 255, fractions and all; a number for bc6h
  kOpaque,          // none: bytes that nobody averages, draws or compares but by equality
};

// One row per format. A block is 1x1 texel for plain formats and 4x4 for the BCn family.
struct FormatInfo {
  TexelFormat format;
  std::string_view name;  // as on the command line
  SampleKind samples;
  std::uint8_t channels;
  std::uint8_t block_edge;   // texels along one side of a block
  std::uint8_t block_bytes;  // bytes of one block; 0 for kBlob, whose tiles have no size in common
};

// Whether this program knows the format: it is one of the enumerators.
[[nodiscard]] bool is_known(TexelFormat format);
// A format that is not known has a row of opaque samples whose tiles have no size.
[[nodiscard]] const FormatInfo& format_info(TexelFormat format);
// The format's name, "format 99" of one that is not known.
[[nodiscard]] std::string format_name(TexelFormat format);
[[nodiscard]] std::optional<TexelFormat> format_from_number(std::uint16_t number);
[[nodiscard]] std::optional<TexelFormat> format_from_name(std::string_view name);

// Bytes of a width x height rectangle of texels; both are multiples of the block edge. 0 for kBlob.
[[nodiscard]] constexpr std::size_t payload_bytes(const FormatInfo& info, std::size_t width, std::size_t height) {
  return (width / info.block_edge) * (height / info.block_edge) * info.block_bytes;
}

// Bytes of one number in a plain format, 0 where samples are not numbers of whole bytes.
[[nodiscard]] constexpr std::size_t sample_bytes(SampleKind kind) {
  switch (kind) {
    case SampleKind::kUnorm8:
      return 1;
    case SampleKind::kUnorm16:
    case SampleKind::kHalf:
      return 2;
    case SampleKind::kFloat:
      return 4;
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      return 0;
  }
  return 0;
}

}  // namespace vt
