// What the stored pieces of a TIFF under a window add to a content hash. Private to this folder.
#pragma once

#include "builder/source/cells/cell_store.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/tiff_decoder.h"
#include "store/io/content_hash.h"
#include "store/result.h"

namespace vt::source {

// The hashes of the stored pieces that the window touches, row by row.
[[nodiscard]] Result<void> hash_pieces(const TiffDecoder& decoder, const CellStore& cells, int plane, const Window& window,
                                       store::ContentHasher& content);

}  // namespace vt::source
