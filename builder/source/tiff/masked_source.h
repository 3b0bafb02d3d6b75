// Any raster together with its mask: coverage that is stored apart from the bands, as a directory of its own
// in a TIFF or in a file NAME.msk beside a file of any format. The mask becomes one more band, the last:
// full_scale where a sample is covered, else 0.
#pragma once

#include <filesystem>
#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/tiff_decoder.h"
#include "store/result.h"

namespace vt::source {

// The transparency mask of the full-size image among the later directories of a TIFF; null when there is
// none. `pages` counts directories that are further pictures: neither masks nor smaller copies. Damage behind
// the first directory is not ours to judge, but a read error is. kIo, kUnsupported.
[[nodiscard]] Result<std::unique_ptr<TiffDecoder>> find_mask_inside(const std::shared_ptr<const FileBytes>& file, const RasterInfo& info,
                                                                    const BlockCache& cache, int& pages);
// NAME.msk beside the raster, which `info` is told was read; null when there is none. kIo, kInvalidData: it
// is no mask of this raster. kUnsupported.
[[nodiscard]] Result<std::unique_ptr<TiffDecoder>> find_mask_beside(RasterInfo& info, const OpenOptions& options, const BlockCache& cache);

// `mask` is as large as `image`. `cache` and `scratch` as in OpenOptions.
[[nodiscard]] std::unique_ptr<RasterSource> with_mask(std::unique_ptr<RasterSource> image, std::unique_ptr<TiffDecoder> mask,
                                                      const std::shared_ptr<BlockCache>& cache,
                                                      const std::shared_ptr<ScratchFile>& scratch);

}  // namespace vt::source
