// The format of a part that holds more or fewer numbers a texel than the part beside it. Any thread.
#pragma once

#include <cassert>
#include <optional>

#include "store/texel_format.h"

namespace vt::channels {

// The format whose samples are like those of `format`, `channels` of them a texel, if there is one. Blocks
// have one or two: bc4 and bc5.
[[nodiscard]] inline std::optional<TexelFormat> find_format_of_channels(TexelFormat format, int channels) {
  const FormatInfo& wanted = format_info(format);
  if (wanted.channels == channels) return format;
  assert(wanted.samples != SampleKind::kBlock || channels <= 2);
  for (const FormatInfo& info : kTexelFormats)
    if (info.samples == wanted.samples && info.channels == channels) return info.format;
  return std::nullopt;
}
// The same, where there has to be one.
[[nodiscard]] inline TexelFormat format_of_channels(TexelFormat format, int channels) {
  const std::optional<TexelFormat> found = find_format_of_channels(format, channels);
  assert(found && "a format of so many channels");
  return found.value_or(format);
}

}  // namespace vt::channels
