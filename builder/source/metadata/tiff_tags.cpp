#include "builder/source/metadata/tiff_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>

namespace vt::source {
namespace {

constexpr std::uint64_t kMaxEntries = 4096;
constexpr std::uint64_t kMaxTagBytes = std::uint64_t{16} << 20;

std::uint64_t integer(std::span<const std::byte> bytes, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[big_endian ? i : bytes.size() - 1 - i]);
  }
  return value;
}

// Bytes of one value by TIFF 6.0 type number; 0 for types that we have no use for.
std::size_t value_size(std::uint16_t type) {
  switch (type) {
    case 1:
    case 2:
    case 6:
    case 7:
      return 1;
    case 3:
    case 8:
      return 2;
    case 4:
    case 9:
    case 11:
    case 13:
      return 4;
    case 5:
    case 10:
    case 12:
    case 16:
    case 17:
    case 18:
      return 8;
    default:
      return 0;
  }
}

double number(std::uint16_t type, std::span<const std::byte> bytes, bool big_endian) {
  const std::uint64_t raw = integer(bytes, big_endian);
  switch (type) {
    case 8:
      return static_cast<std::int16_t>(raw);
    case 9:
      return static_cast<std::int32_t>(raw);
    case 11:
      return std::bit_cast<float>(static_cast<std::uint32_t>(raw));
    case 12:
      return std::bit_cast<double>(raw);
    case 17:
      return static_cast<double>(static_cast<std::int64_t>(raw));
    case 5:
    case 10: {
      // A fraction: two 32-bit integers, the denominator second.
      const auto part = [&](std::size_t at) {
        const auto code = static_cast<std::uint32_t>(integer(bytes.subspan(at, 4), big_endian));
        return type == 5 ? static_cast<double>(code) : static_cast<double>(static_cast<std::int32_t>(code));
      };
      return part(0) / part(4);
    }
    default:
      return static_cast<double>(raw);
  }
}

}  // namespace

Result<TiffTags> TiffTags::read(std::shared_ptr<const FileBytes> file, std::uint64_t offset) {
  const std::string name = file->path().string();
  TiffTags tags;
  tags.file_ = std::move(file);
  std::array<std::byte, 4> magic{};
  VT_ASSIGN(std::size_t got, tags.file_->read_some(0, magic));
  tags.big_endian_ = magic[0] == std::byte{'M'};
  const bool big_tiff = integer(std::span(magic).subspan(2), tags.big_endian_) == 43;
  const std::size_t count_bytes = big_tiff ? 8 : 2;
  const std::size_t entry_bytes = big_tiff ? 20 : 12;

  std::array<std::byte, 8> head{};
  VT_ASSIGN(got, tags.file_->read_some(offset, std::span(head).first(count_bytes)));
  const std::uint64_t count = integer(std::span(head).first(count_bytes), tags.big_endian_);
  std::vector<std::byte> table(static_cast<std::size_t>(std::min(count, kMaxEntries)) * entry_bytes);
  if (got == count_bytes) {
    VT_ASSIGN(got, tags.file_->read_some(offset + count_bytes, table));
  }
  if (got != table.size())
    return fail(ErrorCode::kInvalidData, fmt::format("{}: the TIFF directory at byte {} reaches beyond the file", name, offset));

  for (std::size_t at = 0; at < table.size(); at += entry_bytes) {
    const auto entry = std::span(table).subspan(at, entry_bytes);
    const std::size_t size_bytes = big_tiff ? 8 : 4;
    Entry e{.tag = static_cast<std::uint16_t>(integer(entry.subspan(0, 2), tags.big_endian_)),
            .type = static_cast<std::uint16_t>(integer(entry.subspan(2, 2), tags.big_endian_)),
            .count = integer(entry.subspan(4, size_bytes), tags.big_endian_),
            .place = integer(entry.subspan(4 + size_bytes, size_bytes), tags.big_endian_)};
    const std::size_t bytes = value_size(e.type);
    if (bytes == 0) continue;
    if (e.count <= size_bytes / bytes) e.place = offset + count_bytes + at + 4 + size_bytes;  // short values live in the entry itself
    tags.entries_.push_back(e);
  }
  return tags;
}

const TiffTags::Entry* TiffTags::find(std::uint16_t tag) const {
  const auto found = std::ranges::find(entries_, tag, &Entry::tag);
  return found == entries_.end() ? nullptr : &*found;
}

tl::unexpected<Error> TiffTags::unusable(const Entry& entry, const std::string& why) const {
  return fail(ErrorCode::kInvalidData,
              fmt::format("{}: TIFF tag {} {}; the file is damaged or incomplete", file_->path().string(), entry.tag, why));
}

Result<std::vector<std::byte>> TiffTags::bytes_of(const Entry& entry) const {
  const std::size_t value_bytes = value_size(entry.type);
  if (entry.count > kMaxTagBytes / value_bytes)
    return unusable(entry, fmt::format("claims {} values, more than {} MB", entry.count, kMaxTagBytes >> 20));
  std::vector<std::byte> bytes(static_cast<std::size_t>(entry.count) * value_bytes);
  VT_ASSIGN(const std::size_t got, file_->read_some(entry.place, bytes));
  if (got != bytes.size())
    return unusable(entry, fmt::format("has {} bytes at {}, but the file has {}", bytes.size(), entry.place, file_->size()));
  return bytes;
}

Result<std::vector<double>> TiffTags::numbers(std::uint16_t tag) const {
  const Entry* entry = find(tag);
  if (entry == nullptr) return std::vector<double>{};
  if (entry->type == 2 || entry->type == 7) return unusable(*entry, fmt::format("is of type {}, wanted numbers", entry->type));
  VT_ASSIGN(const std::vector<std::byte> bytes, bytes_of(*entry));
  const std::size_t size = value_size(entry->type);
  std::vector<double> values;
  values.reserve(bytes.size() / size);
  for (std::size_t at = 0; at < bytes.size(); at += size)
    values.push_back(number(entry->type, std::span(bytes).subspan(at, size), big_endian_));
  return values;
}

Result<void> TiffTags::feed(std::uint16_t tag, store::ContentHasher& content) const {
  const Entry* entry = find(tag);
  const std::array<std::uint64_t, 3> head = {tag, entry == nullptr ? 0U : entry->type, entry == nullptr ? 0U : entry->count};
  content.add(std::as_bytes(std::span(head)));
  if (entry == nullptr) return {};
  const Result<std::vector<std::byte>> bytes = bytes_of(*entry);
  if (bytes) content.add(*bytes);
  return bytes || bytes.error().code != ErrorCode::kIo ? Result<void>{} : tl::unexpected(bytes.error());
}

Result<std::string> TiffTags::text(std::uint16_t tag) const {
  const Entry* entry = find(tag);
  if (entry == nullptr) return std::string{};
  if (value_size(entry->type) != 1) return unusable(*entry, fmt::format("is of type {}, wanted text", entry->type));
  VT_ASSIGN(const std::vector<std::byte> bytes, bytes_of(*entry));
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (!text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

}  // namespace vt::source
