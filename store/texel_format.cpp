#include "store/texel_format.h"

#include <array>

namespace vt {
namespace {

constexpr std::array<FormatInfo, 7> kFormats = {{
    {TexelFormat::kRgb8, "rgb8", 3, 1, 3},
    {TexelFormat::kRgba8, "rgba8", 4, 1, 4},
    {TexelFormat::kBc1, "bc1", 3, 4, 8},
    {TexelFormat::kR32Float, "r32f", 1, 1, 4},
    {TexelFormat::kRg32Float, "rg32f", 2, 1, 8},
    {TexelFormat::kRgba32Float, "rgba32f", 4, 1, 16},
    {TexelFormat::kHash128, "hash128", 1, 1, 16},
}};

}  // namespace

const FormatInfo& format_info(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgb8:
      return kFormats[0];
    case TexelFormat::kRgba8:
      return kFormats[1];
    case TexelFormat::kBc1:
      return kFormats[2];
    case TexelFormat::kR32Float:
      return kFormats[3];
    case TexelFormat::kRg32Float:
      return kFormats[4];
    case TexelFormat::kRgba32Float:
      return kFormats[5];
    case TexelFormat::kHash128:
      return kFormats[6];
  }
  __builtin_unreachable();
}

std::optional<TexelFormat> format_from_number(std::uint16_t number) {
  for (const FormatInfo& info : kFormats)
    if (static_cast<std::uint16_t>(info.format) == number) return info.format;
  return std::nullopt;
}

std::optional<TexelFormat> format_from_name(std::string_view name) {
  for (const FormatInfo& info : kFormats)
    if (info.name == name) return info.format;
  return std::nullopt;
}

}  // namespace vt
