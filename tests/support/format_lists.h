// Lists of texel formats that tests walk, from the program's table. Pure functions, any thread.
#pragma once

#include <vector>

#include "store/texel_format.h"

namespace vt::test {

template <class Wanted>
[[nodiscard]] std::vector<TexelFormat> formats_where(const Wanted& wanted) {
  std::vector<TexelFormat> formats;
  for (const FormatInfo& info : kTexelFormats)
    if (wanted(info)) formats.push_back(info.format);
  return formats;
}

// All but blobs, whose tiles have no size in common.
[[nodiscard]] inline std::vector<TexelFormat> texture_formats() {
  return formats_where([](const FormatInfo& info) { return info.format != TexelFormat::kBlob; });
}

// Those whose texels can be decoded.
[[nodiscard]] inline std::vector<TexelFormat> formats_with_samples() { return formats_where(has_samples); }

}  // namespace vt::test
