#include "builder/source/tiff/strip_unpackers.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace vt::source {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{256} << 10;

tl::unexpected<Error> ends_early() {
  return fail(ErrorCode::kCorrupt, "the strip's compressed bytes end early; it is damaged or incomplete");
}

class DeflateUnpacker final : public Unpacker {
 public:
  explicit DeflateUnpacker(StripBytes bytes) : bytes_(std::move(bytes)) {}
  ~DeflateUnpacker() override {
    if (is_open_) inflateEnd(&stream_);
  }
  Result<void> open() {
    if (inflateInit(&stream_) != Z_OK) return fail(ErrorCode::kInternal, "zlib: out of memory");
    is_open_ = true;
    return {};
  }
  Result<void> unpack(std::span<std::byte> out) override {
    while (!out.empty()) {
      if (stream_.avail_in == 0) {
        VT_ASSIGN(const auto piece, bytes_.next_piece());
        if (piece.empty()) return ends_early();
        stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(piece.data()));
        stream_.avail_in = static_cast<uInt>(piece.size());
      }
      const auto room = static_cast<uInt>(std::min<std::size_t>(out.size(), std::size_t{1} << 30));
      stream_.next_out = reinterpret_cast<Bytef*>(out.data());
      stream_.avail_out = room;
      const int status = inflate(&stream_, Z_NO_FLUSH);
      out = out.subspan(room - stream_.avail_out);
      if (status == Z_STREAM_END && !out.empty()) return ends_early();
      if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
        return fail(ErrorCode::kCorrupt, fmt::format("deflate: {}", stream_.msg == nullptr ? "damaged data" : stream_.msg));
    }
    return {};
  }

 private:
  StripBytes bytes_;
  z_stream stream_ = {};
  bool is_open_ = false;
};

class ZstdUnpacker final : public Unpacker {
 public:
  explicit ZstdUnpacker(StripBytes bytes) : bytes_(std::move(bytes)), stream_(ZSTD_createDStream(), &ZSTD_freeDStream) {}
  [[nodiscard]] bool is_open() const { return stream_ != nullptr; }
  Result<void> unpack(std::span<std::byte> out) override {
    ZSTD_outBuffer target{out.data(), out.size(), 0};
    bool may_hold_more = held_back_;
    while (target.pos < target.size) {
      if (input_.pos == input_.size && !may_hold_more) {
        VT_ASSIGN(const auto piece, bytes_.next_piece());
        if (piece.empty()) return ends_early();
        input_ = {piece.data(), piece.size(), 0};
      }
      const std::size_t status = ZSTD_decompressStream(stream_.get(), &target, &input_);
      if (ZSTD_isError(status) != 0) return fail(ErrorCode::kCorrupt, fmt::format("zstd: {}", ZSTD_getErrorName(status)));
      if (status == 0 && target.pos < target.size) return ends_early();
      // When the target is full the decoder may still hold bytes that need no further input.
      may_hold_more = target.pos == target.size;
    }
    held_back_ = may_hold_more;
    return {};
  }

 private:
  StripBytes bytes_;
  std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream_;
  ZSTD_inBuffer input_ = {nullptr, 0, 0};
  bool held_back_ = false;
};

// TIFF 6.0 section 13: codes of 9 to 12 bits, most significant bit first, each width left one code early.
class LzwUnpacker final : public Unpacker {
 public:
  explicit LzwUnpacker(StripBytes bytes) : bytes_(std::move(bytes)) {
    for (std::size_t code = 0; code < kClear; ++code)
      table_[code] = {0, 1, static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code)};
  }

  Result<void> unpack(std::span<std::byte> out) override {
    while (!out.empty()) {
      if (given_ == word_.size()) VT_CHECK(next_word());
      const std::size_t count = std::min(out.size(), word_.size() - given_);
      std::memcpy(out.data(), word_.data() + given_, count);
      given_ += count;
      out = out.subspan(count);
    }
    return {};
  }

 private:
  static constexpr std::uint32_t kClear = 256;
  static constexpr std::uint32_t kEnd = 257;
  static constexpr std::uint32_t kMostCodes = 4096;
  static constexpr std::uint32_t kNone = kMostCodes;
  struct Entry {
    std::uint16_t prefix;
    std::uint16_t length;
    std::uint8_t first;
    std::uint8_t last;
  };

  Result<std::uint32_t> next_code() {
    while (held_bits_ < width_) {
      if (at_ == piece_.size()) {
        VT_ASSIGN(piece_, bytes_.next_piece());
        at_ = 0;
        if (piece_.empty()) return ends_early();
      }
      bits_ = bits_ << 8 | std::to_integer<std::uint32_t>(piece_[at_++]);
      held_bits_ += 8;
    }
    held_bits_ -= width_;
    return bits_ >> held_bits_ & ((1U << width_) - 1);
  }

  // The bytes of the next code into word_.
  Result<void> next_word() {
    VT_ASSIGN(std::uint32_t code, next_code());
    while (code == kClear) {
      next_ = kEnd + 1;
      width_ = 9;
      previous_ = kNone;
      VT_ASSIGN(code, next_code());
    }
    if (code == kEnd) return ends_early();
    const bool is_known = code < kClear || (code > kEnd && code < next_);
    const bool is_next = previous_ != kNone && code == next_ && next_ < kMostCodes;  // the previous word and its own first byte
    if (!is_known && !is_next) return fail(ErrorCode::kCorrupt, fmt::format("LZW: code {} where {} are known", code, next_));
    if (previous_ != kNone && next_ < kMostCodes) {
      const Entry& before = table_[previous_];
      const std::uint8_t last = is_known ? table_[code].first : before.first;
      table_[next_] = {static_cast<std::uint16_t>(previous_), static_cast<std::uint16_t>(before.length + 1), before.first, last};
      ++next_;
      if (next_ == (1U << width_) - 1 && width_ < 12) ++width_;
    }
    previous_ = code;

    word_.resize(table_[code].length);
    given_ = 0;
    std::uint32_t entry = code;
    for (std::size_t i = word_.size(); i-- > 0; entry = table_[entry].prefix) word_[i] = static_cast<std::byte>(table_[entry].last);
    return {};
  }

  StripBytes bytes_;
  std::span<const std::byte> piece_;
  std::size_t at_ = 0;
  std::uint32_t bits_ = 0;
  unsigned held_bits_ = 0;
  unsigned width_ = 9;
  std::array<Entry, kMostCodes> table_ = {};
  std::uint32_t next_ = kEnd + 1;  // the first code that is not known
  std::uint32_t previous_ = kNone;
  std::vector<std::byte> word_;
  std::size_t given_ = 0;  // of it
};

}  // namespace

Result<std::span<const std::byte>> StripBytes::next_piece() {
  piece_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left_, kPieceBytes)));
  if (piece_.empty()) return std::span<const std::byte>();
  VT_ASSIGN(const std::size_t got, file_->read_some(next_, piece_));
  if (got != piece_.size()) return fail(ErrorCode::kCorrupt, "the file ends early; it is incomplete");
  next_ += got;
  left_ -= got;
  return std::span<const std::byte>(piece_);
}

Result<std::unique_ptr<Unpacker>> make_deflate_unpacker(StripBytes bytes) {
  auto unpacker = std::make_unique<DeflateUnpacker>(std::move(bytes));
  VT_CHECK(unpacker->open());
  return unpacker;
}

Result<std::unique_ptr<Unpacker>> make_zstd_unpacker(StripBytes bytes) {
  auto unpacker = std::make_unique<ZstdUnpacker>(std::move(bytes));
  if (!unpacker->is_open()) return fail(ErrorCode::kInternal, "zstd: out of memory");
  return unpacker;
}

std::unique_ptr<Unpacker> make_lzw_unpacker(StripBytes bytes) { return std::make_unique<LzwUnpacker>(std::move(bytes)); }

}  // namespace vt::source
