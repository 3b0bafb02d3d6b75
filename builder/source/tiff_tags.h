// One TIFF directory's entries as the file has them, for the tags that libtiff does not know: found by number, checked against the file,
// converted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/source/file_bytes.h"
#include "store/content_hash.h"
#include "store/result.h"

namespace vt::source {

class TiffTags {
 public:
  // `offset` of the directory in the file. kInvalidData: it does not fit into the file.
  [[nodiscard]] static Result<TiffTags> read(std::shared_ptr<const FileBytes> file, std::uint64_t offset);

  // Values of an integer or floating-point tag; empty when the tag is absent, of another type, or points out of the file.
  [[nodiscard]] std::vector<double> numbers(std::uint16_t tag) const;
  [[nodiscard]] std::string text(std::uint16_t tag) const;  // without closing NULs
  // Type, count and the values as they are stored; that it is absent also counts.
  void feed(std::uint16_t tag, store::ContentHasher& content) const;
  [[nodiscard]] bool is_big_endian() const { return big_endian_; }

 private:
  struct Entry {
    std::uint16_t tag = 0;
    std::uint16_t type = 0;
    std::uint64_t count = 0;
    std::uint64_t place = 0;  // of the values in the file
  };
  [[nodiscard]] std::vector<std::byte> bytes_of(const Entry& entry, std::size_t value_bytes) const;
  [[nodiscard]] const Entry* find(std::uint16_t tag) const;

  std::shared_ptr<const FileBytes> file_;
  bool big_endian_ = false;
  std::vector<Entry> entries_;
};

}  // namespace vt::source
