#include "store/texel_format.h"

#include <algorithm>
#include <array>

namespace vt {
namespace {

// In the order of their numbers, which begin at 1.
constexpr std::array<FormatInfo, 22> kFormats = {{
    {TexelFormat::kRgb8, "rgb8", SampleKind::kUnorm8, 3, 1, 3},
    {TexelFormat::kRgba8, "rgba8", SampleKind::kUnorm8, 4, 1, 4},
    {TexelFormat::kBc1, "bc1", SampleKind::kBlock, 3, 4, 8},
    {TexelFormat::kR32Float, "r32f", SampleKind::kFloat, 1, 1, 4},
    {TexelFormat::kRg32Float, "rg32f", SampleKind::kFloat, 2, 1, 8},
    {TexelFormat::kRgba32Float, "rgba32f", SampleKind::kFloat, 4, 1, 16},
    {TexelFormat::kHash128, "hash128", SampleKind::kOpaque, 1, 1, 16},
    {TexelFormat::kR8, "r8", SampleKind::kUnorm8, 1, 1, 1},
    {TexelFormat::kRg8, "rg8", SampleKind::kUnorm8, 2, 1, 2},
    {TexelFormat::kR16, "r16", SampleKind::kUnorm16, 1, 1, 2},
    {TexelFormat::kRg16, "rg16", SampleKind::kUnorm16, 2, 1, 4},
    {TexelFormat::kRgba16, "rgba16", SampleKind::kUnorm16, 4, 1, 8},
    {TexelFormat::kR16Float, "r16f", SampleKind::kHalf, 1, 1, 2},
    {TexelFormat::kRg16Float, "rg16f", SampleKind::kHalf, 2, 1, 4},
    {TexelFormat::kRgba16Float, "rgba16f", SampleKind::kHalf, 4, 1, 8},
    {TexelFormat::kRgb9e5, "rgb9e5", SampleKind::kSharedExponent, 3, 1, 4},
    {TexelFormat::kBc3, "bc3", SampleKind::kBlock, 4, 4, 16},
    {TexelFormat::kBc4, "bc4", SampleKind::kBlock, 1, 4, 8},
    {TexelFormat::kBc5, "bc5", SampleKind::kBlock, 2, 4, 16},
    {TexelFormat::kBc6h, "bc6h", SampleKind::kBlock, 3, 4, 16},
    {TexelFormat::kBc7, "bc7", SampleKind::kBlock, 4, 4, 16},
    {TexelFormat::kBlob, "blob", SampleKind::kOpaque, 1, 1, 0},
}};

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < kFormats.size(); ++i)
    if (static_cast<std::size_t>(kFormats[i].format) != i + 1) return false;
  return true;
}
static_assert(is_in_order());

constexpr FormatInfo kUnknownFormat = {TexelFormat{}, "unknown", SampleKind::kOpaque, 1, 1, 0};

}  // namespace

bool is_known(TexelFormat format) {
  const auto number = static_cast<std::size_t>(format);
  return number >= 1 && number <= kFormats.size();
}

const FormatInfo& format_info(TexelFormat format) {
  return is_known(format) ? kFormats[static_cast<std::size_t>(format) - 1] : kUnknownFormat;
}

std::string format_name(TexelFormat format) {
  return is_known(format) ? std::string(format_info(format).name) : "format " + std::to_string(static_cast<unsigned>(format));
}

std::optional<TexelFormat> format_from_number(std::uint16_t number) {
  const auto format = static_cast<TexelFormat>(number);
  return is_known(format) ? std::optional(format) : std::nullopt;
}

std::optional<TexelFormat> format_from_name(std::string_view name) {
  const auto* const found = std::find_if(kFormats.begin(), kFormats.end(), [&](const FormatInfo& info) { return info.name == name; });
  return found == kFormats.end() ? std::nullopt : std::optional(found->format);
}

}  // namespace vt
