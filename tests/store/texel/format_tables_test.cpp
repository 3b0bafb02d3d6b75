// Every texel format has its row in every table of store/. (A table without a row does not compile; here it
// is seen to work.)
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "store/texel/block_enlarger.h"
#include "store/texel/texel_decoder.h"
#include "store/texel_format.h"

namespace vt::store {
namespace {

TEST(FormatTables, ThePlainFormatsOnEitherSideOfBlocksArePlain) {
  for (const FormatInfo& info : kTexelFormats) {
    for (const TexelFormat plain : {info.encoded_from, info.decoded_to}) {
      EXPECT_FALSE(is_block_format(format_info(plain))) << info.name;
      EXPECT_GE(format_info(plain).channels, info.channels) << info.name;
      EXPECT_EQ(plain == info.format, !is_block_format(info)) << info.name;
    }
    EXPECT_EQ(info.block_edge, is_block_format(info) ? 4 : 1) << info.name;
  }
}

TEST(FormatTables, NamesAreUniqueAndFound) {
  std::set<std::string_view> names;
  for (const FormatInfo& info : kTexelFormats) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_EQ(format_from_name(info.name), info.format);
    EXPECT_EQ(format_from_number(static_cast<std::uint16_t>(info.format)), info.format);
    EXPECT_EQ(format_name(info.format), info.name);
  }
}

// "| rgb8 | 1 | 1 | 3 | three u8 |" is {"rgb8", "1", "1", "3", "three u8"}.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream row(line.substr(1));
  for (std::string cell; std::getline(row, cell, '|');) {
    const std::size_t first = cell.find_first_not_of(' ');
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
  }
  return cells;
}

// Section 8 of the format document has one row a format, in the order of the numbers.
TEST(FormatTables, TheDocumentHasTheRowsOfTheProgram) {
  std::ifstream document(VT_SOURCE_DIR "/schemas/tile-store.md");
  std::string line;
  while (std::getline(document, line) && line != "| format | number | edge | block_bytes | a block is |") continue;
  ASSERT_TRUE(std::getline(document, line)) << "no table of formats";
  std::size_t rows = 0;
  while (std::getline(document, line) && line.starts_with('|')) {
    const std::vector<std::string> cells = cells_of(line);
    ASSERT_LT(rows, kTexelFormats.size()) << line;
    const FormatInfo& info = kTexelFormats[rows++];
    const bool is_blob = info.format == TexelFormat::kBlob;
    ASSERT_GE(cells.size(), 5U) << line;
    EXPECT_EQ(cells[0], info.name);
    EXPECT_EQ(cells[1], std::to_string(static_cast<int>(info.format))) << line;
    EXPECT_EQ(cells[2], is_blob ? "" : std::to_string(info.block_edge)) << line;
    EXPECT_EQ(cells[3], is_blob ? "" : std::to_string(info.block_bytes)) << line;
  }
  EXPECT_EQ(rows, kTexelFormats.size()) << "rows are missing";
}

TEST(FormatTables, EveryFormatWithSamplesIsDecodedWhole) {
  for (const FormatInfo& info : kTexelFormats) {
    if (!has_samples(info)) continue;
    const std::vector<std::byte> payload(payload_bytes(info, 8, 4), std::byte{0x11});
    std::vector<float> samples(8UL * 4 * info.channels, std::numeric_limits<float>::quiet_NaN());
    decode_texels(info.format, payload, 8, 4, samples);
    for (const float sample : samples) EXPECT_TRUE(std::isfinite(sample)) << info.name;
  }
}

// A block of one colour is that colour however it is enlarged.
TEST(FormatTables, EveryBlockFormatIsEnlarged) {
  for (const FormatInfo& info : kTexelFormats) {
    if (!is_block_format(info)) continue;
    // All bits zero is black in bc1 to bc5; in bc6h it is black of mode 0, and in bc7, whose mode 0 has its
    // lowest bit set, two subsets of it.
    std::vector<std::byte> coarse(info.block_bytes);
    coarse[0] = info.format == TexelFormat::kBc7 ? std::byte{2} : std::byte{0};
    std::vector<float> wanted(16UL * info.channels);
    decode_texels(info.format, coarse, 4, 4, wanted);
    for (const int steps : {1, 2, 5}) {
      std::vector<std::byte> fine(info.block_bytes, std::byte{0xEE});
      enlarge_block(info.format, coarse, 1, 0, steps, fine);
      std::vector<float> got(wanted.size(), -1.0F);
      decode_texels(info.format, fine, 4, 4, got);
      EXPECT_EQ(got, wanted) << info.name << " " << steps;
    }
  }
}

struct Row {
  TexelFormat format;
};
constexpr std::array kTwoRows = {Row{TexelFormat::kBc1}, Row{TexelFormat::kBc7}};
constexpr bool is_one_of_two(const FormatInfo& info) { return info.format == TexelFormat::kBc1 || info.format == TexelFormat::kBc7; }
constexpr std::array kTwice = {Row{TexelFormat::kBc1}, Row{TexelFormat::kBc7}, Row{TexelFormat::kBc1}};
constexpr std::array kUnknownRow = {Row{TexelFormat::kBc1}, Row{TexelFormat::kBc7}, Row{static_cast<TexelFormat>(99)}};
static_assert(has_one_row_each(kTwoRows, is_one_of_two));
static_assert(!has_one_row_each(kTwoRows, is_block_format), "rows are missing");
static_assert(!has_one_row_each(kTwice, is_one_of_two), "a row is there twice");
static_assert(!has_one_row_each(kUnknownRow, is_one_of_two), "a row is of no format");

}  // namespace
}  // namespace vt::store
