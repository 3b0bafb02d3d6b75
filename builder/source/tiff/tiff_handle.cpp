#include "builder/source/tiff/tiff_handle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

namespace vt::source {

void swap_samples(int bits, std::span<std::byte> bytes) {
  std::uint8_t* data = reinterpret_cast<std::uint8_t*>(bytes.data());
  switch (bits) {
    case 16:
      TIFFSwabArrayOfShort(reinterpret_cast<std::uint16_t*>(data), static_cast<tmsize_t>(bytes.size() / 2));
      break;
    case 24:
      TIFFSwabArrayOfTriples(data, static_cast<tmsize_t>(bytes.size() / 3));
      break;
    case 32:
      TIFFSwabArrayOfLong(reinterpret_cast<std::uint32_t*>(data), static_cast<tmsize_t>(bytes.size() / 4));
      break;
    case 64:
      TIFFSwabArrayOfLong8(reinterpret_cast<std::uint64_t*>(data), static_cast<tmsize_t>(bytes.size() / 8));
      break;
    default:
      break;
  }
}

int TiffHandle::on_error(TIFF*, void* self, const char* module, const char* format, va_list arguments) {
  auto& handle = *static_cast<TiffHandle*>(self);
  if (!handle.error_.empty()) return 1;  // the first message names the cause
  std::array<char, 512> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  handle.error_ = fmt::format("{}: {}", module == nullptr ? "libtiff" : module, text.data());
  return 1;
}

int TiffHandle::on_warning(TIFF*, void* self, const char*, const char* format, va_list arguments) {
  auto& handle = *static_cast<TiffHandle*>(self);
  std::array<char, 512> buffer{};
  std::vsnprintf(buffer.data(), buffer.size(), format, arguments);
  const std::string_view text(buffer.data());
  constexpr std::string_view kDamage[] = {"Corrupt JPEG data", "Premature end of JPEG", "Bad code word", "Premature EO"};
  const bool damage = std::ranges::any_of(kDamage, [&](std::string_view words) { return text.find(words) != std::string_view::npos; });
  if (text.find("Incorrect count for \"") != std::string_view::npos) handle.saw_short_tables_ = true;
  if (damage && !handle.saw_damage_) {
    handle.saw_damage_ = true;
    if (handle.error_.empty()) handle.error_ = text;
  }
  return 1;
}

tmsize_t TiffHandle::on_read(thandle_t self, void* out, tmsize_t bytes) {
  auto& handle = *static_cast<TiffHandle*>(self);
  if (bytes <= 0) return 0;
  const auto got = handle.file_->read_some(handle.position_, {static_cast<std::byte*>(out), static_cast<std::size_t>(bytes)});
  if (!got) {
    handle.io_error_ = got.error();
    return -1;
  }
  handle.position_ += *got;
  return static_cast<tmsize_t>(*got);
}

toff_t TiffHandle::on_seek(thandle_t self, toff_t offset, int whence) {
  auto& handle = *static_cast<TiffHandle*>(self);
  switch (whence) {
    case SEEK_SET:
      handle.position_ = offset;
      break;
    case SEEK_CUR:
      handle.position_ += offset;
      break;
    case SEEK_END:
      handle.position_ = handle.file_->size() + offset;
      break;
    default:
      return static_cast<toff_t>(-1);
  }
  return handle.position_;
}

toff_t TiffHandle::on_size(thandle_t self) { return static_cast<TiffHandle*>(self)->file_->size(); }

Result<std::unique_ptr<TiffHandle>> TiffHandle::open(std::shared_ptr<const FileBytes> file, std::uint16_t directory) {
  const std::string name = file->path().string();
  std::unique_ptr<TiffHandle> handle(new TiffHandle(std::move(file)));
  std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  if (!options) return fail(ErrorCode::kInternal, name + ": out of memory");
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(kMaxTiffAllocation));
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &TiffHandle::on_error, handle.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &TiffHandle::on_warning, handle.get());
  // m: no memory map. D, O: offsets and byte counts of blocks are read when asked for, so that opening costs
  // the same for any file. c: a single strip stays one strip; we read parts of it ourselves.
  handle->tiff_ = TIFFClientOpenExt(
      name.c_str(), "rmDOc", handle.get(), &TiffHandle::on_read, [](thandle_t, void*, tmsize_t) -> tmsize_t { return 0; },
      &TiffHandle::on_seek, [](thandle_t) { return 0; }, &TiffHandle::on_size, [](thandle_t, void**, toff_t*) { return 0; },
      [](thandle_t, void*, toff_t) {}, options.get());
  if (handle->io_error_) return tl::unexpected(*handle->io_error_);
  if (handle->tiff_ == nullptr) {
    return fail(ErrorCode::kInvalidData,
                fmt::format("{}: damaged TIFF: {}", name, handle->error_.empty() ? "no directory" : handle->error_));
  }
  if (directory != 0 && TIFFSetDirectory(handle->tiff_, directory) == 0) {
    if (handle->io_error_) return tl::unexpected(*handle->io_error_);
    return fail(ErrorCode::kInvalidData, fmt::format("{}: damaged TIFF directory {}: {}", name, directory, handle->error_));
  }
  // Chroma is brought back to RGB by the JPEG decoder itself.
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(handle->tiff_, TIFFTAG_COMPRESSION, &compression);
  if (compression == COMPRESSION_JPEG) TIFFSetField(handle->tiff_, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  handle->clear_messages();
  return handle;
}

TiffHandle::~TiffHandle() {
  if (tiff_ != nullptr) TIFFClose(tiff_);
}

void TiffHandle::clear_messages() {
  error_.clear();
  io_error_.reset();
  saw_damage_ = false;
}

Result<TiffHandlePool::Lease> TiffHandlePool::borrow(std::int64_t near_scanline, int plane) {
  const auto closeness = [&](const IdleReader& idle) {
    const auto& handle = static_cast<const TiffHandle&>(idle);  // nobody else gives in our name
    const bool usable = near_scanline >= 0 && handle.scanline_plane == plane && handle.next_scanline <= near_scanline;
    return usable ? static_cast<double>(handle.next_scanline) : -1.0;
  };
  std::unique_ptr<TiffHandle> handle(static_cast<TiffHandle*>(file_->pool()->readers().take(this, closeness).release()));
  if (!handle) {
    VT_ASSIGN(handle, TiffHandle::open(file_, directory_));
  }
  return Lease(*this, std::move(handle));
}

}  // namespace vt::source
