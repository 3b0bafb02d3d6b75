// Georeferenced windows of samples from raster files, in the file's own sample type. Leaves all
// interpretation (colour, height, resampling) to later folders. raster_format.h knows which reader a file's
// content needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "builder/source/band_meaning.h"
#include "builder/source/sample_type.h"
#include "store/io/content_hash.h"
#include "store/result.h"

namespace vt::source {

using vt::SampleType;
class BlockCache;   // block_cache.h
class FilePool;     // file_pool.h
class ScratchFile;  // scratch_file.h

// Something that a file holds, that could change what its samples mean or where they lie, and that is not
// used.
enum class Concern : std::uint8_t { kAll, kColor, kHeights };  // the layers to which it would make a difference
struct UnusedFact {
  std::string what;  // "an ICC profile (tag 34675)"
  Concern concern = Concern::kAll;
  std::string instead = {};  // what is done without it, and how the user gets it; "" where nothing is to be said
};

struct RasterInfo {
  std::filesystem::path path;
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 0;  // a mask, inside the file or beside it, counts as one more band, the last
  SampleType sample_type = SampleType::kUint8;
  std::vector<BandMeaning> meaning;    // of each band
  HeightMeaning heights;               // of whichever band holds heights
  int alpha_band = -1;                 // index of the coverage band (declared alpha, or the mask); -1: none
  bool alpha_is_mask = false;          // it is a mask: no band of the raster itself
  int mask_bands = 1;                  // of the mask: one for all bands, or one for each, which here is one that has to say yes in all
  bool alpha_is_straightened = false;  // the file's colours are multiplied by their coverage; what read() gives are not
  std::vector<UnusedFact> unused;
  std::vector<std::filesystem::path> companions;  // other files that were read because they belong to this one: NAME.msk, NAME.aux.xml
  geo::GeoTransform transform;                    // meaningful when `has_transform`
  bool has_transform = false;
  std::string place_problem;             // why there is no transform although the file tries to give one, and what to do
  std::optional<geo::Crs> crs;           // of the file or of OpenOptions
  std::optional<geo::Crs> declared_crs;  // the file's own
  std::string declared_crs_text;         // what the file calls it, also when it is one that we do not know; "" when it declares none
  std::string crs_problem;               // why `declared_crs` is empty although the file declares one
  std::int64_t block_width = 0;          // of the file's tiles or strips
  std::int64_t block_height = 0;
  bool tiled = false;
  bool is_picture = false;  // read through OpenImageIO
  std::string compression;  // for reports: "none", "deflate", "lzw", "zstd", "jpeg", ...
};

// A window in samples.
struct Window {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

inline constexpr int kLeaveAlone = -1;  // in place of a band

class RasterSource {
 public:
  virtual ~RasterSource() = default;
  [[nodiscard]] const RasterInfo& info() const { return info_; }

  // Reads `window`, which lies inside the raster, of the given bands (indices into 0..bands-1, any order;
  // kLeaveAlone leaves its place in `out` as it is) into `out`: rows top to bottom, bands interleaved per
  // sample, native byte order, `row_pitch_bytes` from row to row (at least width * bands.size() * sample
  // bytes). Any number of threads at once. Resident memory: a bounded number of decoded blocks, never the
  // image, never a memory map. kCorrupt or kIo: message names file, row and column. Short or damaged files
  // are errors, never zeros.
  //
  // `content`, when given, is fed with what the file stores for this window: enough that two equal feeds for
  // the same window and bands mean equal samples. Uncompressed files give the samples themselves, so that
  // only the window counts; of compressed files every block that the window touches counts whole; a file that
  // is known as one stream only (PNG, JPEG) counts whole. What the caller gave (nodata, extent, what the
  // samples are for) is not part of it.
  [[nodiscard]] virtual Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out,
                                          std::size_t row_pitch_bytes, store::ContentHasher* content) const = 0;
  [[nodiscard]] Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out,
                                  std::size_t row_pitch_bytes) const {
    return read(window, bands, out, row_pitch_bytes, nullptr);
  }

  // Feeds what read() would feed for the same window and bands, at the price of reading the stored bytes:
  // nothing is decoded.
  [[nodiscard]] virtual Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const = 0;

  // A hint: samples above `row` will hardly be read again, what is kept of them may go. Reading them remains
  // right, only dear.
  virtual void release_rows_before(std::int64_t row) const { static_cast<void>(row); }

  // Bytes that one thread inside read() may hold at most, beyond the caller's buffer and the shared cache.
  [[nodiscard]] virtual std::size_t resident_bytes() const = 0;
  // Bytes of samples decoded so far, by all threads. More than the raster holds: something was decoded twice.
  // 0: nothing needs decoding.
  [[nodiscard]] virtual std::uint64_t decoded_bytes() const = 0;

 protected:
  RasterInfo info_;
};

struct OpenOptions {
  // Replace what the file says (or supply it where the file says nothing).
  std::optional<geo::Crs> crs;
  // In place of a CRS in a file that declares none.
  std::optional<geo::Crs> fallback_crs = {};
  std::optional<Area> extent;  // outer edges in CRS units; west of east, or east of west across the antimeridian where the CRS has turns
  // The stored code that means "no data", whatever the file declares: of palettes an index.
  std::optional<double> nodata;
  // Off: samples are colours, so palettes are expanded (to RGB, with alpha where some entries are clear) and
  // MinIsWhite is inverted. On: samples are numbers (heights, classes) and are given as they are stored;
  // pictures whose decoder cannot do that are refused.
  bool as_numbers = false;
  // Decoded blocks kept, by all sources that are given the same cache. Without one the source makes its own
  // of `cache_bytes`.
  std::shared_ptr<BlockCache> cache;
  std::size_t cache_bytes = std::size_t{32} << 20;
  // Open descriptors and decoders, of all sources that are given the same pool. Without one the source makes
  // its own, and then keeps a descriptor: give one where there may be many sources.
  std::shared_ptr<FilePool> files;
  // Disk space for the samples of sources that would otherwise be decoded over and over: see cell_store.h for
  // which. Without one they are.
  std::shared_ptr<ScratchFile> scratch;
};

// Any number of threads at once. Chooses by content, not by suffix. kIo missing or unreadable, kInvalidData
// damaged, kUnsupported a valid file of a kind we do not read (says which tag and value).
[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path, const OpenOptions& options = {});

}  // namespace vt::source
