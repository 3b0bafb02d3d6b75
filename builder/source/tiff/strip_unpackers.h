// The decompressors behind StripStream, each over a feed of stored bytes. Private to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "builder/source/tiff/strip_stream.h"
#include "store/result.h"

namespace vt::source {

// The stored bytes of a strip, a piece at a time.
class StripBytes {
 public:
  StripBytes(std::shared_ptr<const FileBytes> file, std::uint64_t offset, std::uint64_t bytes)
      : file_(std::move(file)), next_(offset), left_(bytes) {}
  // What follows the last piece; empty at the end of the strip. Valid until the next call.
  [[nodiscard]] Result<std::span<const std::byte>> next_piece();

 private:
  std::shared_ptr<const FileBytes> file_;
  std::uint64_t next_;
  std::uint64_t left_;
  std::vector<std::byte> piece_;
};

[[nodiscard]] Result<std::unique_ptr<Unpacker>> make_deflate_unpacker(StripBytes bytes);
[[nodiscard]] Result<std::unique_ptr<Unpacker>> make_zstd_unpacker(StripBytes bytes);
[[nodiscard]] std::unique_ptr<Unpacker> make_lzw_unpacker(StripBytes bytes);

}  // namespace vt::source
