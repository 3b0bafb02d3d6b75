#include "store/texel_format.h"

#include <algorithm>

namespace vt {
namespace {

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < kTexelFormats.size(); ++i)
    if (static_cast<std::size_t>(kTexelFormats[i].format) != i + 1) return false;
  return true;
}
static_assert(is_in_order());

}  // namespace

std::string format_name(TexelFormat format) {
  return is_known(format) ? std::string(format_info(format).name) : "format " + std::to_string(static_cast<unsigned>(format));
}

std::optional<TexelFormat> format_from_number(std::uint16_t number) {
  const auto format = static_cast<TexelFormat>(number);
  return is_known(format) ? std::optional(format) : std::nullopt;
}

std::optional<TexelFormat> format_from_name(std::string_view name) {
  const auto* const found = std::ranges::find(kTexelFormats, name, &FormatInfo::name);
  return found == kTexelFormats.end() ? std::nullopt : std::optional(found->format);
}

std::string format_names() {
  std::string names;
  for (const FormatInfo& info : kTexelFormats)
    if (has_samples(info)) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
}

}  // namespace vt
