// The finest level on its way into a cascade: the same for a build and for whoever makes tiles again to hold
// them beside it.
#pragma once

#include <cstdint>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pipeline/plan/wrapped_chunk.h"
#include "builder/pyramid/cascade.h"
#include "store/tile_id.h"

namespace vt::pipeline {

// Feeds the rows of `rect`, which `chunk` holds, and so all of their planes or areas of classes. Rows whose
// texels are bytes of the sources are given to `sink` as such: it is a RowSink with
//   bool expect_texels(y)                          row y will come as texels, not as planes; said before its planes are sent on. False: no
//   void texels(y, texels, planes, opaque)         those of the core, after what ending the row has sent on
// `decode(y, planes)` is WrappedChunk::decode_row, with what the caller wants around it.
template <class Sink, class Decode>
void feed_rows(const WrappedChunk& chunk, const TexelRect& rect, const channels::ChannelCodec& codec, pyramid::Cascade& cascade, Sink& sink,
               const Decode& decode) {
  const TexelRect active = cascade.level(0).active;
  const TexelRect core = cascade.level(0).core;
  for (std::int64_t y = rect.y; y < rect.bottom(); ++y) {
    if (!chunk.class_areas().empty()) {
      cascade.put_area_row(chunk.class_areas(), y - rect.y, sink);
      continue;
    }
    const channels::PlaneRow planes = cascade.begin_row();
    const bool opaque = decode(y, planes);
    const std::byte* const texels = y >= core.y && y < core.bottom() ? chunk.texel_row(codec, y, core.x) : nullptr;
    // Rows of planes come out one row late: the texels of this row follow what ending it sends on.
    const bool is_taken = texels != nullptr && sink.expect_texels(y);
    cascade.end_row(opaque, sink);
    if (!is_taken) continue;
    channels::ConstPlaneRow core_planes{};
    for (std::size_t p = 0; p < static_cast<std::size_t>(codec.planes()); ++p) core_planes[p] = planes[p] + (core.x - active.x);
    sink.texels(y, texels, core_planes, opaque);
  }
}

}  // namespace vt::pipeline
