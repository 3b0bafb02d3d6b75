// One TIFF directory's entries as the file has them, for the tags that libtiff does not know: found by
// number, checked against the file, converted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "store/io/content_hash.h"
#include "store/result.h"

namespace vt::source {

class TiffTags {
 public:
  // `offset` of the directory in the file. kInvalidData: it does not fit into the file. kIo: it cannot be
  // read.
  [[nodiscard]] static Result<TiffTags> read(std::shared_ptr<const FileBytes> file, std::uint64_t offset);

  [[nodiscard]] bool has(std::uint16_t tag) const { return find(tag) != nullptr; }
  // Values of an integer, fraction or floating-point tag; empty when the tag is absent. A tag that is there
  // but cannot be had is an error, never an absent tag: kIo the file cannot be read, kInvalidData it is of
  // another type, too long, or points out of the file.
  [[nodiscard]] Result<std::vector<double>> numbers(std::uint16_t tag) const;
  // Without closing NULs. Errors as of numbers().
  [[nodiscard]] Result<std::string> text(std::uint16_t tag) const;
  // Type, count and the values as they are stored; that it is absent also counts, and so does that its values
  // lie outside the file. kIo.
  [[nodiscard]] Result<void> feed(std::uint16_t tag, store::ContentHasher& content) const;
  [[nodiscard]] bool is_big_endian() const { return big_endian_; }

 private:
  struct Entry {
    std::uint16_t tag = 0;
    std::uint16_t type = 0;
    std::uint64_t count = 0;
    std::uint64_t place = 0;  // of the values in the file
  };
  [[nodiscard]] Result<std::vector<std::byte>> bytes_of(const Entry& entry) const;
  [[nodiscard]] tl::unexpected<Error> unusable(const Entry& entry, const std::string& why) const;
  [[nodiscard]] const Entry* find(std::uint16_t tag) const;

  std::shared_ptr<const FileBytes> file_;
  bool big_endian_ = false;
  std::vector<Entry> entries_;
};

}  // namespace vt::source
