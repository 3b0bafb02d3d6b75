#include "builder/source/geotiff_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <optional>

#include "builder/source/cell_store.h"
#include "builder/source/source_common.h"
#include "builder/source/tiff_decoder.h"
#include "builder/source/tiff_layout.h"

namespace vt::source {
namespace {

constexpr int kMaxDirectories = 1024;
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
    if (bands[i] >= layout.bands) continue;  // the mask's band
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

// A mask may have one bit for every band; only a sample that all of them admit is covered.
template <class T>
void put_mask(const std::byte* in, int mask_bands, std::int64_t count, std::byte* out, std::size_t stride) {
  for (std::int64_t i = 0; i < count; ++i, in += mask_bands, out += stride) {
    const bool covered = std::none_of(in, in + mask_bands, [](std::byte bit) { return bit == std::byte{0}; });
    const T value = static_cast<T>(covered ? 255 : 0);
    std::memcpy(out, &value, sizeof value);
  }
}

void put_mask_row(SampleType type, const std::byte* in, int mask_bands, std::int64_t count, std::byte* out, std::size_t stride) {
  switch (type) {
    case SampleType::kUint8:
    case SampleType::kInt8:
      put_mask<std::uint8_t>(in, mask_bands, count, out, stride);
      break;
    case SampleType::kUint16:
    case SampleType::kInt16:
      put_mask<std::uint16_t>(in, mask_bands, count, out, stride);
      break;
    case SampleType::kUint32:
    case SampleType::kInt32:
      put_mask<std::uint32_t>(in, mask_bands, count, out, stride);
      break;
    case SampleType::kFloat32:
      put_mask<float>(in, mask_bands, count, out, stride);
      break;
    case SampleType::kFloat64:
      put_mask<double>(in, mask_bands, count, out, stride);
      break;
  }
}

class GeoTiffSource final : public RasterSource {
 public:
  GeoTiffSource(RasterInfo info, std::unique_ptr<TiffDecoder> image, std::unique_ptr<TiffDecoder> mask,
                const std::shared_ptr<BlockCache>& cache, const std::shared_ptr<ScratchFile>& scratch)
      : image_(std::move(image)), mask_(std::move(mask)), image_cells_(*image_, cache, image_->is_direct() ? nullptr : scratch) {
    if (mask_) mask_cells_.emplace(*mask_, cache, scratch);
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
    for (std::size_t i = 0; mask_ && i < bands.size(); ++i) {
      if (bands[i] == image_->layout().bands) VT_CHECK(read_mask(i, bands.size(), window, out, row_pitch_bytes));
    }
    return content != nullptr ? hash_mask(window, bands, *content) : Result<void>();
  }

  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    content.add(image_->fingerprint().bytes);
    for (const PlanePicks& plane : picks_by_plane(image_->layout(), bands)) {
      VT_CHECK(image_->is_direct() ? hash_plane_direct(plane, window, content)
                                   : hash_pieces(*image_, image_cells_, plane.plane, window, content));
    }
    return hash_mask(window, bands, content);
  }

  void release_rows_before(std::int64_t row) const override {
    image_cells_.release_rows_before(row);
    if (mask_cells_) mask_cells_->release_rows_before(row);
  }

  std::size_t resident_bytes() const override {
    // Image and mask are read one after the other.
    const std::size_t image = image_->resident_bytes() + (image_->is_direct() ? kBytesAtOnce : image_cells_.resident_bytes());
    return mask_ ? std::max(image, mask_->resident_bytes() + mask_cells_->resident_bytes()) : image;
  }

  std::uint64_t decoded_bytes() const override { return image_->decoded_bytes() + (mask_ ? mask_->decoded_bytes() : 0); }

 private:
  // The hashes of the stored pieces that the window touches, row by row.
  static Result<void> hash_pieces(const TiffDecoder& decoder, const CellStore& cells, int plane, const Window& window,
                                  store::ContentHasher& content) {
    const CellGrid& grid = decoder.grid();
    const std::int64_t last_x = (window.x + window.width - 1) / grid.block_width;
    const std::int64_t first_cell = grid.cell_of_row(window.y);
    const std::int64_t last_cell = grid.cell_of_row(window.y + window.height - 1);
    for (std::int64_t cell_y = decoder.first_cell_of_piece(first_cell); cell_y <= last_cell; cell_y += decoder.cells_per_piece()) {
      for (std::int64_t cell_x = window.x / grid.block_width; cell_x <= last_x; ++cell_x) {
        VT_ASSIGN(const store::ContentHash hash,
                  cells.cache().hash(cells.key(cell_x, cell_y, plane), [&] { return decoder.hash_piece(cell_x, cell_y, plane); }));
        content.add(hash.bytes);
      }
    }
    return {};
  }

  Result<void> hash_mask(const Window& window, std::span<const int> bands, store::ContentHasher& content) const {
    if (!mask_ || std::ranges::find(bands, image_->layout().bands) == bands.end()) return {};
    content.add(mask_->fingerprint().bytes);
    return hash_pieces(*mask_, *mask_cells_, 0, window, content);
  }

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

  // Uncompressed files: straight from the file, the operating system's cache is the cache. Calls use(rectangle in a block, its first row
  // and column in the raster) for pieces of about kBytesAtOnce.
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

  Result<void> read_mask(std::size_t out_band, std::size_t out_bands, const Window& window, std::span<std::byte> out,
                         std::size_t pitch) const {
    const std::size_t bytes = sample_bytes(info_.sample_type);
    const std::size_t stride = bytes * out_bands;
    return mask_cells_->visit(0, false, window, [&](const std::byte* in, std::int64_t in_pitch, const Window& part) {
      std::byte* target = out.data() + static_cast<std::size_t>(part.y - window.y) * pitch +
                          static_cast<std::size_t>(part.x - window.x) * stride + out_band * bytes;
      for (std::int64_t r = 0; r < part.height; ++r) {
        put_mask_row(info_.sample_type, in + r * in_pitch, mask_->layout().bands, part.width, target + static_cast<std::size_t>(r) * pitch,
                     stride);
      }
    });
  }

  std::unique_ptr<TiffDecoder> image_;
  std::unique_ptr<TiffDecoder> mask_;
  CellStore image_cells_;
  std::optional<CellStore> mask_cells_;
};

// The transparency mask of the full-size image, when there is one among the later directories. Damage behind the first directory is not
// ours to judge.
Result<std::unique_ptr<TiffDecoder>> find_mask(const std::shared_ptr<const FileBytes>& file, const TiffLayout& image,
                                               const BlockCache& cache) {
  VT_ASSIGN(const auto handle_owner, TiffHandle::open(file));
  TiffHandle& handle = *handle_owner;
  for (int directory = 1; directory < kMaxDirectories && TIFFReadDirectory(handle.get()) == 1; ++directory) {
    std::uint32_t type = 0;
    TIFFGetField(handle.get(), TIFFTAG_SUBFILETYPE, &type);
    if ((type & FILETYPE_MASK) == 0 || (type & FILETYPE_REDUCEDIMAGE) != 0) continue;
    VT_ASSIGN(const TiffTags tags, TiffTags::read(file, TIFFCurrentDirOffset(handle.get())));
    VT_ASSIGN(TiffLayout layout, read_tiff_layout(handle, tags, file->path().string() + " (mask)", false));
    if (layout.width != image.width || layout.height != image.height) continue;
    if (layout.sample_type != SampleType::kUint8 || layout.planar_separate) {
      return fail(ErrorCode::kUnsupported,
                  fmt::format("{}: a transparency mask of {} bands and {} bits", file->path().string(), layout.bands, layout.bits));
    }
    layout.invert = false;
    layout.fill.reset();
    VT_ASSIGN(auto at_mask, TiffHandle::open(file, static_cast<std::uint16_t>(directory)));
    return TiffDecoder::create(std::move(at_mask), file, static_cast<std::uint16_t>(directory), std::move(layout), decode_fingerprint(tags),
                               cache);
  }
  return std::unique_ptr<TiffDecoder>();
}

}  // namespace

Result<std::unique_ptr<RasterSource>> open_geotiff(std::shared_ptr<const FileBytes> file, const OpenOptions& options) {
  const std::string name = file->path().string();
  const std::shared_ptr<BlockCache> cache = cache_of(options);
  VT_ASSIGN(auto handle, TiffHandle::open(file));
  VT_ASSIGN(const TiffTags tags, TiffTags::read(file, TIFFCurrentDirOffset(handle->get())));
  VT_ASSIGN(TiffLayout layout, read_tiff_layout(*handle, tags, name, !options.palette_indices));
  TiffPlace place = read_tiff_place(tags);

  RasterInfo info;
  info.path = file->path();
  info.width = layout.width;
  info.height = layout.height;
  info.bands = layout.bands;
  info.sample_type = layout.sample_type;
  info.alpha_band = layout.alpha_band;
  info.alpha_is_straightened = layout.alpha_is_associated;
  info.nodata = layout.nodata;
  info.block_width = layout.block_width;
  info.block_height = layout.block_height;
  info.tiled = layout.tiled;
  info.compression = compression_name(layout.compression);
  info.crs = std::move(place.keys.crs);
  info.crs_problem = std::move(place.keys.problem);
  if (place.transform) {
    info.transform = *place.transform;
    info.has_transform = true;
  }
  VT_CHECK(apply_options(options, info));

  std::unique_ptr<TiffDecoder> mask;
  if (TIFFLastDirectory(handle->get()) == 0) {
    VT_ASSIGN(mask, find_mask(file, layout, *cache));
  }
  if (mask) {
    info.alpha_band = info.bands;
    ++info.bands;
  }
  VT_ASSIGN(auto image, TiffDecoder::create(std::move(handle), file, 0, std::move(layout), decode_fingerprint(tags), *cache));
  return std::make_unique<GeoTiffSource>(std::move(info), std::move(image), std::move(mask), cache, options.scratch);
}

}  // namespace vt::source
