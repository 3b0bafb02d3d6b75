// Unpacks one compressed strip from its start, row by row, with a small piece of its stored bytes at a time:
// libtiff reads all of them first, and a strip may be as large as the file. For the lossless compressions of
// large rasters: deflate, LZW and zstd, with their predictors. A stream belongs to one thread at a time;
// StripStreamPool lends them out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "builder/source/tiff/tiff_layout.h"
#include "store/result.h"

namespace vt::source {

// Gives exactly as many bytes as are asked for, or fails.
class Unpacker {
 public:
  virtual ~Unpacker() = default;
  [[nodiscard]] virtual Result<void> unpack(std::span<std::byte> out) = 0;
};

class StripStream final : public IdleReader {
 public:
  struct Strip {
    std::uint64_t offset = 0;  // of the stored bytes in the file
    std::uint64_t bytes = 0;
    std::int64_t first_row = 0;
    int plane = 0;
    bool operator==(const Strip&) const = default;
  };

  // False: a compression, predictor or bit order that is left to libtiff.
  [[nodiscard]] static bool can_unpack(const TiffLayout& layout);
  // kUnsupported: LZW as it was before TIFF 5.0, which libtiff reads.
  [[nodiscard]] static Result<std::unique_ptr<StripStream>> open(std::shared_ptr<const FileBytes> file, const TiffLayout& layout,
                                                                 const Strip& strip);

  [[nodiscard]] const Strip& strip() const { return strip_; }
  [[nodiscard]] std::int64_t next_row() const { return next_row_; }
  // The next rows as libtiff gives them: predictor undone, native byte order. Whole rows of `row_bytes`.
  [[nodiscard]] Result<void> read_rows(std::span<std::byte> out, std::size_t row_bytes);

 private:
  StripStream(const TiffLayout& layout, const Strip& strip, std::unique_ptr<Unpacker> unpacker);

  Strip strip_;
  int bits_;
  int predictor_;
  int samples_;  // interleaved in a row
  bool is_swapped_;
  std::unique_ptr<Unpacker> unpacker_;
  std::int64_t next_row_;
  std::vector<std::byte> planes_;  // one row before its bytes are put together
};

// The streams of one directory of one file; idle ones wait in the file's ReaderPool.
class StripStreamPool {
 public:
  explicit StripStreamPool(std::shared_ptr<const FileBytes> file) : file_(std::move(file)) {}
  StripStreamPool(const StripStreamPool&) = delete;
  StripStreamPool& operator=(const StripStreamPool&) = delete;
  ~StripStreamPool() { file_->pool()->readers().forget(this); }

  // One that stands in this strip, closest before `row`, or at the strip's start.
  [[nodiscard]] Result<std::unique_ptr<StripStream>> borrow(const TiffLayout& layout, const StripStream::Strip& strip, std::int64_t row);
  void give(std::unique_ptr<StripStream> stream) { file_->pool()->readers().give(this, std::move(stream)); }

 private:
  std::shared_ptr<const FileBytes> file_;
};

}  // namespace vt::source
