#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "builder/source/block_cache.h"
#include "builder/source/file_bytes.h"
#include "builder/source/picture_module.h"
#include "builder/source/source_common.h"

namespace vt::source {
namespace {

constexpr std::int64_t kBandBytes = std::int64_t{2} << 20;  // of rows decoded together

std::optional<SampleType> sample_type_of(const OIIO::ImageSpec& spec) {
  if (!spec.channelformats.empty()) return SampleType::kFloat32;  // OpenEXR channels of several types
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      return SampleType::kUint8;
    case OIIO::TypeDesc::INT8:
      return SampleType::kInt8;
    case OIIO::TypeDesc::UINT16:
      return SampleType::kUint16;
    case OIIO::TypeDesc::INT16:
      return SampleType::kInt16;
    case OIIO::TypeDesc::UINT32:
      return SampleType::kUint32;
    case OIIO::TypeDesc::INT32:
      return SampleType::kInt32;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      return SampleType::kFloat32;
    case OIIO::TypeDesc::DOUBLE:
      return SampleType::kFloat64;
    default:
      return std::nullopt;
  }
}

OIIO::TypeDesc oiio_type(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return OIIO::TypeDesc::UINT8;
    case SampleType::kInt8:
      return OIIO::TypeDesc::INT8;
    case SampleType::kUint16:
      return OIIO::TypeDesc::UINT16;
    case SampleType::kInt16:
      return OIIO::TypeDesc::INT16;
    case SampleType::kUint32:
      return OIIO::TypeDesc::UINT32;
    case SampleType::kInt32:
      return OIIO::TypeDesc::INT32;
    case SampleType::kFloat32:
      return OIIO::TypeDesc::FLOAT;
    case SampleType::kFloat64:
      return OIIO::TypeDesc::DOUBLE;
  }
  return OIIO::TypeDesc::UNKNOWN;
}

double full_code(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return 255.0;
    case SampleType::kUint16:
      return 65535.0;
    case SampleType::kUint32:
      return 4294967295.0;
    default:
      return 1.0;  // signed types and floats are known to straighten_alpha()
  }
}

// One decoder. Most formats decode from the top only, so it matters which row comes next.
struct Input final : IdleReader {
  OIIO::ImageInput::unique_ptr decoder;
  std::int64_t next_row = 0;
};

Result<std::unique_ptr<Input>> open_input(const FileBytes& file) {
  VT_CHECK(file.check_unchanged());  // OpenImageIO opens it by its path
  const std::filesystem::path& path = file.path();
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);  // codes as they are in the file
  auto input = std::make_unique<Input>();
  input->decoder = OIIO::ImageInput::open(path.string(), &wish);
  if (!input->decoder) {
    const std::string reason = OIIO::geterror();
    const bool unknown = reason.find("could not find a format reader") != std::string::npos;
    return fail(unknown ? ErrorCode::kUnsupported : ErrorCode::kInvalidData,
                fmt::format("{}: cannot read it as a picture: {}", path.string(), reason));
  }
  return input;
}

// OpenImageIO 2.4 forgets to swap the bytes of 16-bit samples when a PNG is interlaced: wrong values without any error.
Result<bool> is_wide_interlaced_png(const FileBytes& file) {
  std::array<std::byte, 29> head{};
  VT_ASSIGN(const std::size_t got, file.read_some(0, head));
  const auto code = [&](std::size_t at) { return std::to_integer<int>(head[at]); };
  return got == head.size() && code(0) == 0x89 && code(1) == 'P' && code(2) == 'N' && code(3) == 'G' && code(24) == 16 && code(28) == 1;
}

Result<store::ContentHash> hash_file(const FileBytes& file) {
  store::ContentHasher hasher;
  Block buffer(std::size_t{1} << 20);
  for (std::uint64_t at = 0; at < file.size(); at += buffer.size()) {
    const auto part = std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), file.size() - at)));
    VT_ASSIGN(const std::size_t got, file.read_some(at, part));
    if (got != part.size())
      return fail(ErrorCode::kIo, fmt::format("{}: the file has become shorter while it is read", file.path().string()));
    hasher.add(part);
  }
  return hasher.digest();
}

class PictureSource final : public RasterSource {
 public:
  PictureSource(RasterInfo info, std::shared_ptr<const FileBytes> file, std::unique_ptr<Input> first, bool alpha_is_associated,
                std::shared_ptr<BlockCache> cache)
      : file_(std::move(file)), alpha_is_associated_(alpha_is_associated), cache_(std::move(cache)), id_(cache_->add_source()) {
    info_ = std::move(info);
    pixel_bytes_ = static_cast<std::size_t>(info_.bands) * sample_bytes(info_.sample_type);
    row_bytes_ = pixel_bytes_ * static_cast<std::size_t>(info_.width);
    give(std::move(first));
  }
  ~PictureSource() override { file_->pool()->readers().forget(this); }

  using RasterSource::read;
  Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                    store::ContentHasher* content) const override {
    VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
    if (content != nullptr) VT_CHECK(hash(window, bands, *content));
    const std::size_t bytes = sample_bytes(info_.sample_type);
    const std::int64_t bottom = window.y + window.height;
    for (std::int64_t band = window.y / info_.block_height; band <= (bottom - 1) / info_.block_height; ++band) {
      VT_ASSIGN(const BlockPtr rows, cache_->get({.source = id_, .block = static_cast<std::uint64_t>(band)}, [&] { return decode(band); }));
      const std::int64_t top = band * info_.block_height;
      for (std::int64_t y = std::max(window.y, top); y < std::min(bottom, top + info_.block_height); ++y) {
        const std::byte* from =
            rows->data() + static_cast<std::size_t>(y - top) * row_bytes_ + static_cast<std::size_t>(window.x) * pixel_bytes_;
        std::byte* to = out.data() + static_cast<std::size_t>(y - window.y) * row_pitch_bytes;
        for (std::int64_t x = 0; x < window.width; ++x, from += pixel_bytes_) {
          for (const int wanted : bands) {
            std::memcpy(to, from + static_cast<std::size_t>(wanted) * bytes, bytes);
            to += bytes;
          }
        }
      }
    }
    return {};
  }

  // OpenImageIO does not tell where in the file a window is stored: any change of the file is a change everywhere.
  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    VT_ASSIGN(const store::ContentHash whole, cache_->hash({.source = id_, .block = 0}, [&] { return hash_file(*file_); }));
    content.add(whole.bytes);
    return {};
  }

  std::size_t resident_bytes() const override { return row_bytes_ * static_cast<std::size_t>(info_.block_height); }

 private:
  // The idle decoder that stands closest before `row`, or any, or a new one.
  Result<std::unique_ptr<Input>> borrow(std::int64_t row) const {
    const auto closeness = [row](const IdleReader& idle) {
      const std::int64_t next_row = static_cast<const Input&>(idle).next_row;
      return next_row <= row ? static_cast<double>(next_row) : -1.0;
    };
    std::unique_ptr<Input> input(static_cast<Input*>(file_->pool()->readers().take(this, closeness).release()));
    if (input) return input;
    return open_input(*file_);
  }
  void give(std::unique_ptr<Input> input) const { file_->pool()->readers().give(this, std::move(input)); }

  Result<Block> decode(std::int64_t band) const {
    const std::int64_t top = band * info_.block_height;
    const std::int64_t rows = std::min(info_.block_height, info_.height - top);
    VT_ASSIGN(std::unique_ptr<Input> input, borrow(top));
    Block block(static_cast<std::size_t>(rows) * row_bytes_);
    const OIIO::ImageSpec& spec = input->decoder->spec();
    const int y_begin = spec.y + static_cast<int>(top);
    const int y_end = y_begin + static_cast<int>(rows);
    const OIIO::TypeDesc type = oiio_type(info_.sample_type);
    bool ok = false;
    std::string thrown;
    try {
      ok = info_.tiled ? input->decoder->read_tiles(0, 0, spec.x, spec.x + spec.width, y_begin, y_end, spec.z, spec.z + 1, 0,
                                                    spec.nchannels, type, block.data())
                       : input->decoder->read_scanlines(0, 0, y_begin, y_end, spec.z, 0, spec.nchannels, type, block.data());
    } catch (const std::exception& problem) {  // OpenEXR throws through some readers
      thrown = problem.what();
    }
    std::string reason = input->decoder->geterror();
    if (reason.empty()) reason = thrown;
    if (!ok || !reason.empty()) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{}: row {}, column 0: {}", info_.path.string(), top, reason.empty() ? "cannot be decoded" : reason));
    }
    input->next_row = top + rows;
    give(std::move(input));
    if (alpha_is_associated_) straighten_alpha(info_.sample_type, block, info_.bands, info_.alpha_band, full_code(info_.sample_type));
    return block;
  }

  std::shared_ptr<const FileBytes> file_;
  bool alpha_is_associated_;
  std::size_t pixel_bytes_ = 0;
  std::size_t row_bytes_ = 0;
  std::shared_ptr<BlockCache> cache_;
  std::uint64_t id_;  // of this source in cache_
};

}  // namespace

namespace {

Result<std::unique_ptr<RasterSource>> read_picture(std::shared_ptr<const FileBytes> file, const OpenOptions& options) {
  const std::filesystem::path path = file->path();
  VT_ASSIGN(std::unique_ptr<Input> input, open_input(*file));
  const OIIO::ImageSpec& spec = input->decoder->spec();
  const auto unsupported = [&](const std::string& what) {
    return fail(ErrorCode::kUnsupported, fmt::format("{} ({}): {}", path.string(), input->decoder->format_name(), what));
  };
  VT_ASSIGN(const bool is_misread, is_wide_interlaced_png(*file));
  if (is_misread) return unsupported("a 16-bit PNG that is interlaced is not decoded reliably; save it without interlacing");
  if (spec.deep || spec.depth > 1) return unsupported("deep and volume pictures are not read");
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) {
    return fail(ErrorCode::kInvalidData,
                fmt::format("{}: a picture of {} x {} x {}", path.string(), spec.width, spec.height, spec.nchannels));
  }
  const auto type = sample_type_of(spec);
  if (!type) return unsupported(fmt::format("samples of type {}", spec.format.c_str()));

  RasterInfo info;
  info.path = path;
  info.width = spec.width;
  info.height = spec.height;
  info.bands = spec.nchannels;
  info.sample_type = *type;
  info.alpha_band = spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels ? spec.alpha_channel : -1;
  info.tiled = spec.tile_width > 0 && spec.tile_height > 0;
  info.compression = spec.get_string_attribute("compression", input->decoder->format_name());
  const std::int64_t row_bytes = info.width * info.bands * static_cast<std::int64_t>(sample_bytes(*type));
  info.block_width = info.width;
  info.block_height = info.tiled ? spec.tile_height : std::clamp<std::int64_t>(kBandBytes / row_bytes, 1, info.height);
  if (row_bytes > kMaxCellBytes / info.block_height)
    return unsupported(fmt::format("rows of {} bytes are more than this program holds", row_bytes));
  VT_CHECK(apply_options(options, info));
  const bool associated = info.alpha_band >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
  return std::make_unique<PictureSource>(std::move(info), std::move(file), std::move(input), associated, cache_of(options));
}

}  // namespace
}  // namespace vt::source

extern "C" const vt::source::PictureModule vt_picture_module = {.open_picture = vt::source::read_picture};
