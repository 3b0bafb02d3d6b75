// The counts of classes of one tile of carry as bytes: for each texel, row by row, the number of its classes,
// then for each class in ascending order how many classes lie between it and the one before, and its area.
// All numbers are in base 128, the lowest digits first, with the top bit set in all bytes of a number but the
// last. Counts of one tile have one spelling. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "builder/pyramid/class_counts.h"
#include "store/result.h"

namespace vt::pyramid {

// Appends one texel.
void pack_texel(std::span<const ClassCount> classes, std::vector<std::byte>& out);

// Reads what pack_texel wrote, texel after texel. A failed read leaves the reader where it was.
class CountReader {
 public:
  // `bytes` outlive the reader; a texel covers `full_area`.
  CountReader(std::span<const std::byte> bytes, const channels::ClassCounting& classes, std::uint64_t full_area)
      : bytes_(bytes), classes_(classes), full_area_(full_area) {}

  // The next texel, replacing what is in `texel`. kCorrupt: the bytes end, a number is too long, a class is
  // none or comes twice, an area is 0 or all areas together are more than the texel has.
  [[nodiscard]] Result<void> read(std::vector<ClassCount>& texel);
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  [[nodiscard]] bool read_number(std::size_t& at, std::uint64_t& number) const;

  std::span<const std::byte> bytes_;
  channels::ClassCounting classes_;
  std::uint64_t full_area_;
  std::size_t at_ = 0;
};

}  // namespace vt::pyramid
