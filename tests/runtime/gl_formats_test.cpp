// Every texel format with samples has its row in the runtime's tables.
#include "runtime/gl_formats.h"

#include <gtest/gtest.h>

#include <vector>

#include "store/texel/texel_decoder.h"
#include "tests/support/format_lists.h"

namespace vt::runtime {
namespace {

TEST(GlFormats, EveryFormatWithSamplesHasARow) {
  for (const TexelFormat format : vt::test::formats_with_samples()) {
    const FormatInfo& info = format_info(format);
    const GlFormat& row = gl_format(info.format);
    EXPECT_EQ(row.format, info.format);
    EXPECT_FALSE(row.shader.is_none()) << info.name;
    EXPECT_EQ(row.shader.compressed, is_block_format(info)) << info.name;
    EXPECT_EQ(row.blocks != BlockSupport::kNotBlocks, is_block_format(info)) << info.name;
    EXPECT_TRUE(row.fixed.is_none() || row.fixed.compressed == is_block_format(info)) << info.name;
  }
}

// What a card that takes no blocks gets is a format that it does take, and is filled to its end.
TEST(GlFormats, EveryBlockFormatIsDecodedToAPlainOne) {
  for (const TexelFormat format : vt::test::formats_where(is_block_format)) {
    const FormatInfo& info = format_info(format);
    const FormatInfo& plain = format_info(info.decoded_to);
    EXPECT_FALSE(gl_format(plain.format).shader.is_none()) << info.name;
    EXPECT_FALSE(gl_format(plain.format).shader.compressed) << info.name;
    EXPECT_FALSE(gl_format(plain.format).fixed.compressed) << info.name;
    // OpenGL 1.2 has no halves, so bc6h cannot be drawn there.
    EXPECT_EQ(gl_format(plain.format).fixed.is_none(), info.format == TexelFormat::kBc6h) << info.name;
    const std::vector<std::byte> blocks(payload_bytes(info, 4, 8), std::byte{0x22});
    std::vector<std::byte> once(payload_bytes(plain, 4, 8), std::byte{0});
    std::vector<std::byte> again(once.size(), std::byte{0xFF});
    store::decode_blocks(info.format, blocks, 4, 8, once);
    store::decode_blocks(info.format, blocks, 4, 8, again);
    EXPECT_EQ(once, again) << info.name;
  }
}

}  // namespace
}  // namespace vt::runtime
