#include "builder/source/tiff/geotiff_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <optional>

#include "builder/source/cells/cell_store.h"
#include "builder/source/metadata/gdal_metadata.h"
#include "builder/source/source_common.h"
#include "builder/source/tiff/masked_source.h"
#include "builder/source/tiff/piece_hash.h"
#include "builder/source/tiff/tiff_decoder.h"
#include "builder/source/tiff/tiff_layout.h"
#include "builder/source/tiff/tiff_place.h"

namespace vt::source {
namespace {

constexpr std::int64_t kBytesAtOnce = std::int64_t{1} << 20;  // of one direct read

// From which band of a plane to which place in the output's sample.
struct BandPick {
  int from = 0;
  int to = 0;
};

template <std::size_t kBytes>
void gather_samples(const std::byte* in, std::size_t in_stride, std::byte* out, std::size_t out_stride, std::int64_t count,
                    std::span<const BandPick> picks) {
  for (const BandPick& pick : picks) {
    const std::byte* from = in + static_cast<std::size_t>(pick.from) * kBytes;
    std::byte* to = out + static_cast<std::size_t>(pick.to) * kBytes;
    for (std::int64_t i = 0; i < count; ++i, from += in_stride, to += out_stride) std::memcpy(to, from, kBytes);
  }
}

// What one plane of the file contributes to a read.
struct PlanePicks {
  int plane = 0;
  int plane_bands = 1;
  std::vector<BandPick> picks;
  int out_bands = 1;
  std::size_t bytes = 1;  // of a sample

  [[nodiscard]] std::int64_t in_stride() const { return static_cast<std::int64_t>(bytes) * plane_bands; }

  // All bands of the plane, in order, and nothing else in the output.
  [[nodiscard]] bool is_plain_copy() const {
    if (out_bands != plane_bands || static_cast<int>(picks.size()) != out_bands) return false;
    return std::ranges::all_of(picks, [](const BandPick& pick) { return pick.from == pick.to; });
  }

  void copy_row(const std::byte* in, std::byte* out, std::int64_t count) const {
    const std::size_t in_stride = bytes * static_cast<std::size_t>(plane_bands);
    const std::size_t out_stride = bytes * static_cast<std::size_t>(out_bands);
    if (is_plain_copy()) {
      std::memcpy(out, in, in_stride * static_cast<std::size_t>(count));
      return;
    }
    switch (bytes) {
      case 1:
        gather_samples<1>(in, in_stride, out, out_stride, count, picks);
        break;
      case 2:
        gather_samples<2>(in, in_stride, out, out_stride, count, picks);
        break;
      case 4:
        gather_samples<4>(in, in_stride, out, out_stride, count, picks);
        break;
      default:
        gather_samples<8>(in, in_stride, out, out_stride, count, picks);
        break;
    }
  }
};

std::vector<PlanePicks> picks_by_plane(const TiffLayout& layout, std::span<const int> bands) {
  std::vector<PlanePicks> planes;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (bands[i] == kLeaveAlone) continue;
    const int plane = layout.planar_separate ? bands[i] : 0;
    auto found = std::ranges::find(planes, plane, &PlanePicks::plane);
    if (found == planes.end()) {
      planes.push_back({.plane = plane,
                        .plane_bands = layout.bands_per_plane(),
                        .picks = {},
                        .out_bands = static_cast<int>(bands.size()),
                        .bytes = sample_bytes(layout.sample_type)});
      found = planes.end() - 1;
    }
    found->picks.push_back({.from = layout.planar_separate ? 0 : bands[i], .to = static_cast<int>(i)});
  }
  return planes;
}

class GeoTiffSource final : public RasterSource {
 public:
  GeoTiffSource(RasterInfo info, std::unique_ptr<TiffDecoder> image, const std::shared_ptr<BlockCache>& cache,
                const std::shared_ptr<ScratchFile>& scratch)
      : image_(std::move(image)), image_cells_(*image_, cache, image_->is_direct() ? nullptr : scratch) {
    info_ = std::move(info);
  }

  using RasterSource::read;
  Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                    store::ContentHasher* content) const override {
    VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
    if (content != nullptr) content->add(image_->fingerprint().bytes);
    for (const PlanePicks& plane : picks_by_plane(image_->layout(), bands)) {
      if (image_->is_direct()) {
        VT_CHECK(read_plane_direct(plane, window, out, row_pitch_bytes, content));
      } else {
        VT_CHECK(read_plane(plane, window, out, row_pitch_bytes));
        if (content != nullptr) VT_CHECK(hash_pieces(*image_, image_cells_, plane.plane, window, *content));
      }
    }
    return {};
  }

  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    content.add(image_->fingerprint().bytes);
    for (const PlanePicks& plane : picks_by_plane(image_->layout(), bands)) {
      VT_CHECK(image_->is_direct() ? hash_plane_direct(plane, window, content)
                                   : hash_pieces(*image_, image_cells_, plane.plane, window, content));
    }
    return {};
  }

  void release_rows_before(std::int64_t row) const override { image_cells_.release_rows_before(row); }

  std::size_t resident_bytes() const override {
    return image_->resident_bytes() + (image_->is_direct() ? kBytesAtOnce : image_cells_.resident_bytes());
  }

  std::uint64_t decoded_bytes() const override { return image_->decoded_bytes(); }

 private:
  Result<void> read_plane(const PlanePicks& plane, const Window& window, std::span<std::byte> out, std::size_t pitch) const {
    const std::size_t out_stride = plane.bytes * static_cast<std::size_t>(plane.out_bands);
    const bool all_bands = static_cast<int>(plane.picks.size()) == plane.plane_bands;
    return image_cells_.visit(plane.plane, all_bands, window, [&](const std::byte* in, std::int64_t in_pitch, const Window& part) {
      std::byte* target =
          out.data() + static_cast<std::size_t>(part.y - window.y) * pitch + static_cast<std::size_t>(part.x - window.x) * out_stride;
      for (std::int64_t r = 0; r < part.height; ++r)
        plane.copy_row(in + r * in_pitch, target + static_cast<std::size_t>(r) * pitch, part.width);
    });
  }

  // Uncompressed files: straight from the file, the operating system's cache is the cache. Calls
  // use(rectangle in a block, its first row and column in the raster) for pieces of about kBytesAtOnce.
  template <class Use>
  Result<void> for_each_rect(const PlanePicks& plane, const Window& window, const Use& use) const {
    const TiffLayout& layout = image_->layout();
    const std::int64_t right = window.x + window.width;
    const std::int64_t bottom = window.y + window.height;
    for (std::int64_t block_y = window.y / layout.block_height; block_y <= (bottom - 1) / layout.block_height; ++block_y) {
      const std::int64_t block_top = block_y * layout.block_height;
      for (std::int64_t block_x = window.x / layout.block_width; block_x <= (right - 1) / layout.block_width; ++block_x) {
        const std::int64_t block_left = block_x * layout.block_width;
        const std::int64_t left = std::max(window.x, block_left);
        const std::int64_t columns = std::min(right, block_left + layout.block_width) - left;
        const std::int64_t rows_at_once = std::max<std::int64_t>(1, kBytesAtOnce / (columns * plane.in_stride()));
        std::int64_t row = std::max(window.y, block_top);
        for (const std::int64_t end = std::min(bottom, block_top + layout.block_height); row < end;) {
          const std::int64_t rows = std::min(rows_at_once, end - row);
          VT_CHECK(use(TiffDecoder::BlockRect{.block_x = block_x,
                                              .block_y = block_y,
                                              .plane = plane.plane,
                                              .row = row - block_top,
                                              .rows = rows,
                                              .column = left - block_left,
                                              .columns = columns},
                       row, left));
          row += rows;
        }
      }
    }
    return {};
  }

  Result<void> read_plane_direct(const PlanePicks& plane, const Window& window, std::span<std::byte> out, std::size_t pitch,
                                 store::ContentHasher* content) const {
    const std::size_t out_stride = plane.bytes * static_cast<std::size_t>(plane.out_bands);
    Block buffer;
    return for_each_rect(plane, window, [&](const TiffDecoder::BlockRect& rect, std::int64_t row, std::int64_t left) -> Result<void> {
      std::byte* target =
          out.data() + static_cast<std::size_t>(row - window.y) * pitch + static_cast<std::size_t>(left - window.x) * out_stride;
      const auto row_bytes = static_cast<std::size_t>(rect.columns * plane.in_stride());
      const std::size_t bytes = row_bytes * static_cast<std::size_t>(rect.rows);
      const bool straight = plane.is_plain_copy() && (rect.rows == 1 || pitch == row_bytes);
      if (!straight) buffer.resize(bytes);
      const std::span<std::byte> samples = straight ? std::span(target, bytes) : std::span(buffer);
      VT_CHECK(image_->read_direct(rect, samples));
      if (content != nullptr) content->add(samples);
      for (std::int64_t r = 0; !straight && r < rect.rows; ++r)
        plane.copy_row(buffer.data() + static_cast<std::size_t>(r) * row_bytes, target + static_cast<std::size_t>(r) * pitch, rect.columns);
      return {};
    });
  }

  Result<void> hash_plane_direct(const PlanePicks& plane, const Window& window, store::ContentHasher& content) const {
    Block buffer;
    return for_each_rect(plane, window, [&](const TiffDecoder::BlockRect& rect, std::int64_t, std::int64_t) -> Result<void> {
      buffer.resize(static_cast<std::size_t>(rect.columns * rect.rows * plane.in_stride()));
      VT_CHECK(image_->read_direct(rect, buffer));
      content.add(buffer);
      return {};
    });
  }

  std::unique_ptr<TiffDecoder> image_;
  CellStore image_cells_;
};

void note_heights(const TiffPlace& place, RasterInfo& info) {
  if (!place.keys.vertical) return;
  const geo::VerticalMeaning& vertical = *place.keys.vertical;
  info.heights = {.scale = place.height_scale, .offset = place.height_offset, .counts_down = vertical.counts_down};
  if (vertical.metres_per_unit) info.heights.unit = fmt::format("{} m", *vertical.metres_per_unit);
  if (!vertical.unit_problem.empty()) info.heights.unit = vertical.unit_problem;
  if (!vertical.name.empty())
    info.unused.push_back({.what = fmt::format("the vertical datum {}", vertical.name), .concern = Concern::kHeights});
}

}  // namespace

Result<std::unique_ptr<RasterSource>> open_geotiff(std::shared_ptr<const FileBytes> file, const OpenOptions& options) {
  const std::string name = file->path().string();
  const std::shared_ptr<BlockCache> cache = cache_of(options);
  VT_ASSIGN(auto handle, TiffHandle::open(file));
  VT_ASSIGN(const TiffTags tags, TiffTags::read(file, TIFFCurrentDirOffset(handle->get())));
  RasterInfo info;
  info.path = file->path();
  VT_ASSIGN(const DeclaredMetadata beside, read_aux_xml(info));
  VT_ASSIGN(TiffLayout layout, read_tiff_layout(*handle, tags, name, options, beside));
  VT_ASSIGN(TiffPlace place, read_tiff_place(tags));
  VT_ASSIGN(const store::ContentHash fingerprint, decode_fingerprint(tags));

  info.width = layout.width;
  info.height = layout.height;
  info.bands = layout.bands;
  info.sample_type = layout.sample_type;
  info.meaning = layout.meaning;
  info.alpha_band = layout.alpha_band;
  info.alpha_is_straightened = layout.alpha_is_associated;
  info.unused.insert(info.unused.end(), layout.unused.begin(), layout.unused.end());
  info.block_width = layout.block_width;
  info.block_height = layout.block_height;
  info.tiled = layout.tiled;
  info.compression = compression_name(layout.compression);
  info.declared_crs = std::move(place.keys.crs);
  info.declared_crs_text = std::move(place.keys.declared);
  info.crs_problem = std::move(place.keys.problem);
  if (place.transform) {
    info.transform = *place.transform;
    info.has_transform = true;
  }
  note_heights(place, info);
  info.place_problem = std::move(place.problem);
  info.unused.insert(info.unused.end(), place.unused.begin(), place.unused.end());
  VT_CHECK(apply_options(options, info));

  std::unique_ptr<TiffDecoder> mask;
  int pages = 0;
  if (TIFFLastDirectory(handle->get()) == 0) {
    VT_ASSIGN(mask, find_mask_inside(file, info, *cache, pages));
  }
  if (pages > 0)
    info.unused.push_back({.what = pages == 1 ? "a second picture in the file" : fmt::format("{} further pictures in the file", pages)});
  if (!mask) {
    VT_ASSIGN(mask, find_mask_beside(info, options, *cache));
  }
  VT_ASSIGN(auto image, TiffDecoder::create(std::move(handle), file, 0, std::move(layout), fingerprint, *cache));
  std::unique_ptr<RasterSource> source = std::make_unique<GeoTiffSource>(std::move(info), std::move(image), cache, options.scratch);
  return mask ? with_mask(std::move(source), std::move(mask), cache, options.scratch) : std::move(source);
}

}  // namespace vt::source
