// The texel formats a tile may hold, and the byte arithmetic that follows from them. What a decoded sample is
// worth follows from the layer's component ranges (store/layer.h). Plain values, any thread.
//
// A TexelFormat may hold any number: a store that a newer program wrote may have a layer in a format that
// this program does not know. Its tiles cannot be read; everything else about the store can.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vt {

// Numbers are on disk. Append; never renumber, never reuse; 0 is no format. All multi-byte samples are
// little-endian, channels interleaved in the order named.
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

// What this program knows of a format: all that differs from format to format and is no function. A block is
// 1x1 texel for plain formats and 4x4 for the BCn family.
struct FormatInfo {
  TexelFormat format;
  std::string_view name;  // as on the command line
  SampleKind samples;
  std::uint8_t channels;
  std::uint8_t block_edge;   // texels along one side of a block
  std::uint8_t block_bytes;  // bytes of one block; 0 for kBlob, whose tiles have no size in common
  // The plain formats on either side of blocks; a plain format is its own.
  TexelFormat encoded_from;  // what an encoder takes. 65535 in r16 and rg16 stands for the 255 that is decoded
  TexelFormat decoded_to;    // what a decoder gives for a graphics card that does not take the blocks
};

// A row whose texels are no blocks.
[[nodiscard]] constexpr FormatInfo plain_format(TexelFormat format, std::string_view name, SampleKind samples, std::uint8_t channels,
                                                std::uint8_t texel_bytes) {
  return {format, name, samples, channels, 1, texel_bytes, format, format};
}

// One row a format, in the order of the numbers, which begin at 1.
inline constexpr auto kTexelFormats = std::to_array<FormatInfo>({
    plain_format(TexelFormat::kRgb8, "rgb8", SampleKind::kUnorm8, 3, 3),
    plain_format(TexelFormat::kRgba8, "rgba8", SampleKind::kUnorm8, 4, 4),
    {TexelFormat::kBc1, "bc1", SampleKind::kBlock, 3, 4, 8, TexelFormat::kRgb8, TexelFormat::kRgba8},
    plain_format(TexelFormat::kR32Float, "r32f", SampleKind::kFloat, 1, 4),
    plain_format(TexelFormat::kRg32Float, "rg32f", SampleKind::kFloat, 2, 8),
    plain_format(TexelFormat::kRgba32Float, "rgba32f", SampleKind::kFloat, 4, 16),
    plain_format(TexelFormat::kHash128, "hash128", SampleKind::kOpaque, 1, 16),
    plain_format(TexelFormat::kR8, "r8", SampleKind::kUnorm8, 1, 1),
    plain_format(TexelFormat::kRg8, "rg8", SampleKind::kUnorm8, 2, 2),
    plain_format(TexelFormat::kR16, "r16", SampleKind::kUnorm16, 1, 2),
    plain_format(TexelFormat::kRg16, "rg16", SampleKind::kUnorm16, 2, 4),
    plain_format(TexelFormat::kRgba16, "rgba16", SampleKind::kUnorm16, 4, 8),
    plain_format(TexelFormat::kR16Float, "r16f", SampleKind::kHalf, 1, 2),
    plain_format(TexelFormat::kRg16Float, "rg16f", SampleKind::kHalf, 2, 4),
    plain_format(TexelFormat::kRgba16Float, "rgba16f", SampleKind::kHalf, 4, 8),
    plain_format(TexelFormat::kRgb9e5, "rgb9e5", SampleKind::kSharedExponent, 3, 4),
    {TexelFormat::kBc3, "bc3", SampleKind::kBlock, 4, 4, 16, TexelFormat::kRgba8, TexelFormat::kRgba8},
    {TexelFormat::kBc4, "bc4", SampleKind::kBlock, 1, 4, 8, TexelFormat::kR16, TexelFormat::kR8},
    {TexelFormat::kBc5, "bc5", SampleKind::kBlock, 2, 4, 16, TexelFormat::kRg16, TexelFormat::kRg8},
    {TexelFormat::kBc6h, "bc6h", SampleKind::kBlock, 3, 4, 16, TexelFormat::kRgba16Float, TexelFormat::kRgba16Float},
    {TexelFormat::kBc7, "bc7", SampleKind::kBlock, 4, 4, 16, TexelFormat::kRgba8, TexelFormat::kRgba8},
    plain_format(TexelFormat::kBlob, "blob", SampleKind::kOpaque, 1, 0),
});
inline constexpr FormatInfo kUnknownFormat = plain_format(TexelFormat{}, "unknown", SampleKind::kOpaque, 1, 0);

// Whether this program knows the format: it is one of the enumerators.
[[nodiscard]] constexpr bool is_known(TexelFormat format) {
  const auto number = static_cast<std::size_t>(format);
  return number >= 1 && number <= kTexelFormats.size();
}
// A format that is not known has a row of opaque samples whose tiles have no size.
[[nodiscard]] constexpr const FormatInfo& format_info(TexelFormat format) {
  return is_known(format) ? kTexelFormats[static_cast<std::size_t>(format) - 1] : kUnknownFormat;
}
// The format's name, "format 99" of one that is not known.
[[nodiscard]] std::string format_name(TexelFormat format);
[[nodiscard]] std::optional<TexelFormat> format_from_number(std::uint16_t number);
[[nodiscard]] std::optional<TexelFormat> format_from_name(std::string_view name);
// All that hold numbers, for messages: "rgb8, rgba8, ...".
[[nodiscard]] std::string format_names();

[[nodiscard]] constexpr bool is_block_format(const FormatInfo& info) { return info.samples == SampleKind::kBlock; }
[[nodiscard]] constexpr bool has_samples(const FormatInfo& info) { return info.samples != SampleKind::kOpaque; }
// Blocks of colours, whose codec ties the channels of a texel together: bc1, bc3 and bc7.
[[nodiscard]] constexpr bool is_color_block(const FormatInfo& info) {
  return is_block_format(info) && format_info(info.decoded_to).samples == SampleKind::kUnorm8 && info.channels >= 3;
}

// For the tables of functions that other files have, with a row for each of some formats; a row's first
// member is `format`. Whether there is one row for each format that `wanted` picks, and no other: a
// static_assert of it makes a format without a row an error of the compiler.
template <class Rows, class Wanted>
[[nodiscard]] consteval bool has_one_row_each(const Rows& rows, const Wanted& wanted) {
  std::size_t picked = 0;
  for (const FormatInfo& info : kTexelFormats) {
    std::size_t found = 0;
    for (const auto& row : rows) found += row.format == info.format ? 1 : 0;
    if (found != (wanted(info) ? 1U : 0U)) return false;
    picked += found;
  }
  return picked == rows.size();
}
// The row of `format`, which has one.
template <class Rows>
[[nodiscard]] constexpr const auto& row_of(const Rows& rows, TexelFormat format) {
  std::size_t at = 0;
  while (rows[at].format != format) {
    ++at;
    assert(at < rows.size() && "a format that the table has no row for");
  }
  return rows[at];
}

// Bytes of a width x height rectangle of texels; both are multiples of the block edge. 0 for kBlob.
[[nodiscard]] constexpr std::size_t payload_bytes(const FormatInfo& info, std::size_t width, std::size_t height) {
  return (width / info.block_edge) * (height / info.block_edge) * info.block_bytes;
}

// The greatest code of samples that are codes, 0 of others. What blocks decode to is on the scale of 8 bits.
[[nodiscard]] constexpr int greatest_code(SampleKind kind) {
  switch (kind) {
    case SampleKind::kUnorm8:
    case SampleKind::kBlock:
      return 255;
    case SampleKind::kUnorm16:
      return 65535;
    case SampleKind::kHalf:
    case SampleKind::kFloat:
    case SampleKind::kSharedExponent:
    case SampleKind::kOpaque:
      return 0;
  }
  return 0;
}

// How a plain format's samples can say that there is no data.
enum class NodataSample : std::uint8_t {
  kNone,
  kZero,  // code 0 of layers whose zero_is_nodata is set
  kNan,   // quiet NaN
};
[[nodiscard]] constexpr NodataSample nodata_sample(SampleKind kind) {
  switch (kind) {
    case SampleKind::kUnorm8:
    case SampleKind::kUnorm16:
      return NodataSample::kZero;
    case SampleKind::kHalf:
    case SampleKind::kFloat:
      return NodataSample::kNan;
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      return NodataSample::kNone;
  }
  return NodataSample::kNone;
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
