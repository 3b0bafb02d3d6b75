#include "builder/pyramid/class_carry.h"

namespace vt::pyramid {
namespace {

void put_number(std::uint64_t number, std::vector<std::byte>& out) {
  for (; number >= 0x80; number >>= 7) out.push_back(static_cast<std::byte>(number | 0x80));
  out.push_back(static_cast<std::byte>(number));
}

}  // namespace

void pack_texel(std::span<const ClassCount> classes, std::vector<std::byte>& out) {
  put_number(classes.size(), out);
  std::uint64_t least = 0;  // that the next class can be
  for (const ClassCount count : classes) {
    put_number(class_of(count) - least, out);
    put_number(area_of(count), out);
    least = class_of(count) + 1;
  }
}

bool CountReader::read_number(std::size_t& at, std::uint64_t& number) const {
  number = 0;
  for (int shift = 0; shift <= kAreaBits && at < bytes_.size(); shift += 7) {
    const auto digit = std::to_integer<std::uint64_t>(bytes_[at++]);
    number |= (digit & 0x7F) << shift;
    if (digit < 0x80) return true;
  }
  return false;
}

Result<void> CountReader::read(std::vector<ClassCount>& texel) {
  const auto corrupt = [&](const char* what) {
    return fail(ErrorCode::kCorrupt, std::string("a tile of carry of classes: ") + what + " at byte " + std::to_string(at_));
  };
  texel.clear();
  std::size_t at = at_;
  std::uint64_t size = 0;
  if (!read_number(at, size)) return corrupt("no number of classes");
  std::uint64_t left = full_area_;
  std::uint64_t least = 0;
  for (std::uint64_t i = 0; i < size; ++i) {
    std::uint64_t step = 0;
    std::uint64_t area = 0;
    if (!read_number(at, step) || !read_number(at, area)) return corrupt("a list of classes that ends early");
    const std::uint64_t id = least + step;
    if (id > static_cast<std::uint64_t>(classes_.greatest) || id == static_cast<std::uint64_t>(classes_.no_data))
      return corrupt("a number that is no class");
    if (area == 0 || area > left) return corrupt("areas that a texel cannot have");
    left -= area;
    least = id + 1;
    texel.push_back(class_count(id, area));
  }
  at_ = at;
  return {};
}

}  // namespace vt::pyramid
