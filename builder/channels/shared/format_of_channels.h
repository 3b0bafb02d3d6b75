// The format of a part that holds more or fewer numbers a texel than the part beside it. Any thread.
#pragma once

#include <cassert>

#include "store/texel_format.h"

namespace vt::channels {

// The format whose samples are like those of `format`, `channels` of them a texel; there has to be one.
// Blocks have one or two: bc4 and bc5.
[[nodiscard]] inline TexelFormat format_of_channels(TexelFormat format, int channels) {
  const FormatInfo& wanted = format_info(format);
  if (wanted.channels == channels) return format;
  assert(wanted.samples != SampleKind::kBlock || channels <= 2);
  for (const FormatInfo& info : kTexelFormats)
    if (info.samples == wanted.samples && info.channels == channels) return info.format;
  assert(false);
  return format;
}

}  // namespace vt::channels
