// What one TIFF directory says about its samples, checked. No pixel is touched here; the place on the Earth
// is in tiff_place.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/source/band_meaning.h"
#include "builder/source/metadata/gdal_metadata.h"
#include "builder/source/metadata/tiff_tags.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/tiff_handle.h"
#include "store/result.h"

namespace vt::source {

// How stored samples become ours.
enum class SampleRecipe : std::uint8_t {
  kNative,       // whole bytes in one of our sample types
  kPackedBits,   // 1..7 bits to uint8, 9..15 to uint16, 17..31 to uint32, codes unchanged
  kHalfFloat,    // 16-bit floating point to float32
  kFloat24,      // 24-bit floating point to float32
  kLibtiffRgba,  // YCbCr without JPEG, CMYK, CIE L*a*b*, old JPEG: libtiff's own conversion to 8-bit RGB
};

// The stored side.
struct TiffLayout {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t block_width = 0;   // of a tile, or the width of the raster
  std::int64_t block_height = 0;  // of a tile, or rows per strip
  std::int64_t blocks_across = 0;
  std::int64_t blocks_down = 0;
  bool tiled = false;
  bool planar_separate = false;
  int samples_per_pixel = 1;
  int bits = 8;
  std::uint16_t compression = 1;
  int predictor = 1;
  bool fill_order_reversed = false;
  bool byte_swapped = false;

  // Our side.
  SampleRecipe recipe = SampleRecipe::kNative;
  SampleType sample_type = SampleType::kUint8;
  int bands = 1;                     // after palette expansion and conversion to RGB
  std::vector<BandMeaning> meaning;  // of each
  int alpha_band = -1;
  bool alpha_is_associated = false;
  bool invert = false;  // MinIsWhite: value becomes max_code - value, but not of the alpha band
  double max_code = 0.0;
  std::vector<std::uint32_t> palette;  // R | G << 8 | B << 16 | A << 24; empty: no expansion
  std::optional<double> fill;          // what a block that was never written holds: the nodata value, or 0
  std::vector<UnusedFact> unused;

  [[nodiscard]] std::int64_t rows_in_block(std::int64_t block_y) const;  // inside the raster
  [[nodiscard]] int bands_per_plane() const { return planar_separate ? 1 : bands; }
};

// A short name for reports, "compression 65000" for what we have never heard of.
[[nodiscard]] std::string compression_name(std::uint16_t compression);

// kUnsupported names the tag and the value that we do not read; kIo and kInvalidData as of TiffTags. Of
// `options`, what concerns samples (nodata, as_numbers); `beside`: what a file beside the TIFF declares,
// which goes before what the TIFF does.
[[nodiscard]] Result<TiffLayout> read_tiff_layout(const TiffHandle& handle, const TiffTags& tags, const std::string& name,
                                                  const OpenOptions& options, const DeclaredMetadata& beside);
// The hash of everything in the directory that the meaning of the stored bytes depends on: sizes, sample
// format, compression and its tables, colours. kIo.
[[nodiscard]] Result<store::ContentHash> decode_fingerprint(const TiffTags& tags);

}  // namespace vt::source
