// One libtiff reader over a shared file, with its own error channel: nothing is printed, nothing is
// memory-mapped, no global handler is touched. A handle belongs to one thread at a time; TiffHandlePool lends
// them out.
#pragma once

#include <tiffio.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "builder/source/files/file_bytes.h"
#include "store/result.h"

namespace vt::source {

class TiffHandle final : public IdleReader {
 public:
  // Opens the file and makes `directory` current (0 is the first).
  [[nodiscard]] static Result<std::unique_ptr<TiffHandle>> open(std::shared_ptr<const FileBytes> file, std::uint16_t directory = 0);
  ~TiffHandle() override;

  [[nodiscard]] TIFF* get() const { return tiff_; }

  // What libtiff said since clear_messages(). Damaged JPEG and fax streams are only warnings to their
  // decoders, which invent the missing samples; here they count as errors.
  [[nodiscard]] const std::string& error() const { return error_; }
  [[nodiscard]] bool saw_damage() const { return saw_damage_; }
  void clear_messages();
  // Why the operating system did not give the file's bytes, when that is the cause of a failure.
  [[nodiscard]] const std::optional<Error>& io_error() const { return io_error_; }
  // A table of block offsets or sizes had fewer entries than there are blocks; libtiff made up zeros. Never
  // cleared.
  [[nodiscard]] bool saw_short_tables() const { return saw_short_tables_; }

  // Sequential decoding of one huge strip: which row comes next without starting over. -1: none.
  std::int64_t next_scanline = -1;
  int scanline_plane = 0;

 private:
  explicit TiffHandle(std::shared_ptr<const FileBytes> file) : file_(std::move(file)) {}
  static int on_error(TIFF*, void* self, const char* module, const char* format, va_list arguments);
  static int on_warning(TIFF*, void* self, const char* module, const char* format, va_list arguments);
  static tmsize_t on_read(thandle_t self, void* out, tmsize_t bytes);
  static toff_t on_seek(thandle_t self, toff_t offset, int whence);
  static toff_t on_size(thandle_t self);

  std::shared_ptr<const FileBytes> file_;
  std::uint64_t position_ = 0;
  TIFF* tiff_ = nullptr;
  std::string error_;
  std::optional<Error> io_error_;
  bool saw_damage_ = false;
  bool saw_short_tables_ = false;
};

// The handles of one directory of one file. Idle ones wait in the file's ReaderPool, which may close them.
class TiffHandlePool {
 public:
  TiffHandlePool(std::shared_ptr<const FileBytes> file, std::uint16_t directory) : file_(std::move(file)), directory_(directory) {}
  TiffHandlePool(const TiffHandlePool&) = delete;
  TiffHandlePool& operator=(const TiffHandlePool&) = delete;
  ~TiffHandlePool() { file_->pool()->readers().forget(this); }

  class Lease {
   public:
    Lease(TiffHandlePool& pool, std::unique_ptr<TiffHandle> handle) : pool_(&pool), handle_(std::move(handle)) {}
    Lease(Lease&&) noexcept = default;
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
      if (handle_) pool_->give(std::move(handle_));
    }
    TiffHandle* operator->() const { return handle_.get(); }
    TiffHandle& operator*() const { return *handle_; }

   private:
    TiffHandlePool* pool_;
    std::unique_ptr<TiffHandle> handle_;
  };
  // `near_scanline`: prefer the handle that stands closest before this row of `plane`, see next_scanline.
  [[nodiscard]] Result<Lease> borrow(std::int64_t near_scanline = -1, int plane = 0);
  // A handle of this file that stands at this directory.
  void give(std::unique_ptr<TiffHandle> handle) { file_->pool()->readers().give(this, std::move(handle)); }

 private:
  std::shared_ptr<const FileBytes> file_;
  std::uint16_t directory_;
};

// Samples of 16, 24, 32 or 64 bits to the other byte order, in place.
void swap_samples(int bits, std::span<std::byte> bytes);

// Largest single allocation that libtiff may make on behalf of a file: compressed bytes of one block, and
// tables.
inline constexpr std::uint64_t kMaxTiffAllocation = std::uint64_t{1} << 30;

}  // namespace vt::source
