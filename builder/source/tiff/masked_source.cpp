#include "builder/source/tiff/masked_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/source/cells/cell_store.h"
#include "builder/source/source_common.h"
#include "builder/source/tiff/piece_hash.h"
#include "builder/source/tiff/tiff_layout.h"

namespace vt::source {
namespace {

constexpr int kMaxDirectories = 1024;

// What a covered sample is in the band that a mask becomes.
double covered_code(SampleType type) { return type == SampleType::kInt8 ? 127.0 : 255.0; }

// A mask may have one bit for every band; only a sample that all of them admit is covered.
template <class T>
void put_mask(const std::byte* in, int mask_bands, std::int64_t count, std::byte* out, std::size_t stride, double code) {
  for (std::int64_t i = 0; i < count; ++i, in += mask_bands, out += stride) {
    const bool covered = std::none_of(in, in + mask_bands, [](std::byte bit) { return bit == std::byte{0}; });
    store(out, static_cast<T>(covered ? code : 0.0));
  }
}

void put_mask_row(SampleType type, const std::byte* in, int mask_bands, std::int64_t count, std::byte* out, std::size_t stride) {
  const double code = covered_code(type);
  visit_sample_type(type, [&]<class T>(std::type_identity<T>) { put_mask<T>(in, mask_bands, count, out, stride, code); });
}

class MaskedSource final : public RasterSource {
 public:
  MaskedSource(std::unique_ptr<RasterSource> image, std::unique_ptr<TiffDecoder> mask, const std::shared_ptr<BlockCache>& cache,
               const std::shared_ptr<ScratchFile>& scratch)
      : image_(std::move(image)), mask_(std::move(mask)), cells_(*mask_, cache, scratch) {
    info_ = image_->info();
    if (info_.alpha_band >= 0) info_.unused.push_back({.what = "an alpha band beside the mask", .concern = Concern::kAll});
    info_.alpha_band = info_.bands++;
    info_.alpha_is_mask = true;
    info_.mask_bands = mask_->layout().bands;
    info_.meaning.push_back({.role = BandRole::kCoverage, .full_scale = covered_code(info_.sample_type)});
  }

  using RasterSource::read;
  Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                    store::ContentHasher* content) const override {
    VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
    VT_CHECK(image_->read(window, bands_of_image(bands), out, row_pitch_bytes, content));
    for (std::size_t i = 0; i < bands.size(); ++i)
      if (bands[i] == info_.alpha_band) VT_CHECK(read_mask(i, bands.size(), window, out, row_pitch_bytes));
    return content != nullptr ? hash_mask(window, bands, *content) : Result<void>();
  }

  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    VT_CHECK(image_->hash(window, bands_of_image(bands), content));
    return hash_mask(window, bands, content);
  }

  void release_rows_before(std::int64_t row) const override {
    image_->release_rows_before(row);
    cells_.release_rows_before(row);
  }
  // Image and mask are read one after the other.
  std::size_t resident_bytes() const override {
    return std::max(image_->resident_bytes(), mask_->resident_bytes() + cells_.resident_bytes());
  }
  std::uint64_t decoded_bytes() const override { return image_->decoded_bytes() + mask_->decoded_bytes(); }

 private:
  [[nodiscard]] std::vector<int> bands_of_image(std::span<const int> bands) const {
    std::vector<int> of_image(bands.begin(), bands.end());
    std::ranges::replace(of_image, info_.alpha_band, kLeaveAlone);
    return of_image;
  }

  [[nodiscard]] Result<void> read_mask(std::size_t out_band, std::size_t out_bands, const Window& window, std::span<std::byte> out,
                                       std::size_t pitch) const {
    const std::size_t bytes = sample_bytes(info_.sample_type);
    const std::size_t stride = bytes * out_bands;
    return cells_.visit(0, false, window, [&](const std::byte* in, std::int64_t in_pitch, const Window& part) {
      std::byte* target = out.data() + static_cast<std::size_t>(part.y - window.y) * pitch +
                          static_cast<std::size_t>(part.x - window.x) * stride + out_band * bytes;
      for (std::int64_t r = 0; r < part.height; ++r)
        put_mask_row(info_.sample_type, in + r * in_pitch, mask_->layout().bands, part.width, target + static_cast<std::size_t>(r) * pitch,
                     stride);
    });
  }

  [[nodiscard]] Result<void> hash_mask(const Window& window, std::span<const int> bands, store::ContentHasher& content) const {
    if (std::ranges::find(bands, info_.alpha_band) == bands.end()) return {};
    content.add(mask_->fingerprint().bytes);
    return hash_pieces(*mask_, cells_, 0, window, content);
  }

  std::unique_ptr<RasterSource> image_;
  std::unique_ptr<TiffDecoder> mask_;
  CellStore cells_;
};

// The directory at which `handle` stands as a mask; null when it has another size than the raster.
Result<std::unique_ptr<TiffDecoder>> read_mask_directory(TiffHandle& handle, const std::shared_ptr<const FileBytes>& file, int directory,
                                                         const RasterInfo& info, const BlockCache& cache) {
  const std::string name = file->path().string() + " (mask)";
  VT_ASSIGN(const TiffTags tags, TiffTags::read(file, TIFFCurrentDirOffset(handle.get())));
  VT_ASSIGN(TiffLayout layout, read_tiff_layout(handle, tags, name, OpenOptions{.as_numbers = true}, {}));
  if (layout.width != info.width || layout.height != info.height) return std::unique_ptr<TiffDecoder>();
  if (layout.sample_type != SampleType::kUint8 || layout.planar_separate)
    return fail(ErrorCode::kUnsupported, fmt::format("{}: a transparency mask of {} bands and {} bits", name, layout.bands, layout.bits));
  layout.fill.reset();
  VT_ASSIGN(auto at_mask, TiffHandle::open(file, static_cast<std::uint16_t>(directory)));
  VT_ASSIGN(const store::ContentHash fingerprint, decode_fingerprint(tags));
  return TiffDecoder::create(std::move(at_mask), file, static_cast<std::uint16_t>(directory), std::move(layout), fingerprint, cache);
}

}  // namespace

Result<std::unique_ptr<TiffDecoder>> find_mask_inside(const std::shared_ptr<const FileBytes>& file, const RasterInfo& info,
                                                      const BlockCache& cache, int& pages) {
  VT_ASSIGN(const auto owner, TiffHandle::open(file));
  TiffHandle& handle = *owner;
  std::unique_ptr<TiffDecoder> mask;
  for (int directory = 1; directory < kMaxDirectories && TIFFLastDirectory(handle.get()) == 0; ++directory) {
    handle.clear_messages();
    const bool was_read = TIFFReadDirectory(handle.get()) == 1;
    if (handle.io_error()) break;
    // Whether it is that of a mask, which decides what is data, is written in it.
    if (!was_read)
      return fail(
          ErrorCode::kInvalidData,
          fmt::format("{}: its directory {} cannot be read ({}), and could be that of a mask; write the picture alone into a new file, "
                      "for example with gdal_translate -mask none",
                      file->path().string(), directory, handle.error().empty() ? "damaged, or one that was there" : handle.error()));
    std::uint32_t type = 0;
    TIFFGetField(handle.get(), TIFFTAG_SUBFILETYPE, &type);
    if ((type & FILETYPE_REDUCEDIMAGE) != 0) continue;
    if ((type & FILETYPE_MASK) == 0) {
      ++pages;
    } else if (!mask) {
      VT_ASSIGN(mask, read_mask_directory(handle, file, directory, info, cache));
      if (!mask) ++pages;  // of another size, so it is of something else
    }
  }
  if (handle.io_error()) return tl::unexpected(*handle.io_error());
  if (TIFFLastDirectory(handle.get()) == 0)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: more than {} directories, one of which could be that of a mask; write the picture "
                            "alone into a new file, for example with gdal_translate -mask none",
                            file->path().string(), kMaxDirectories));
  return mask;
}

Result<std::unique_ptr<TiffDecoder>> find_mask_beside(RasterInfo& info, const OpenOptions& options, const BlockCache& cache) {
  std::filesystem::path path = info.path;
  path += ".msk";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::unique_ptr<TiffDecoder>();
  VT_ASSIGN(const std::shared_ptr<const FileBytes> file, FileBytes::open(path, options.files));
  VT_ASSIGN(auto handle, TiffHandle::open(file));
  VT_ASSIGN(auto mask, read_mask_directory(*handle, file, 0, info, cache));
  info.companions.push_back(path);
  if (mask) return mask;
  return fail(ErrorCode::kInvalidData,
              fmt::format("{}: as the name says it is the mask of {}, but it is of another size; mend it, move it away, or read the raster "
                          "without its coverage",
                          path.string(), info.path.filename().string()));
}

std::unique_ptr<RasterSource> with_mask(std::unique_ptr<RasterSource> image, std::unique_ptr<TiffDecoder> mask,
                                        const std::shared_ptr<BlockCache>& cache, const std::shared_ptr<ScratchFile>& scratch) {
  return std::make_unique<MaskedSource>(std::move(image), std::move(mask), cache, scratch);
}

}  // namespace vt::source
