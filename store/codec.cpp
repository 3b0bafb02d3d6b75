#include "store/codec.h"

#define ZSTD_STATIC_LINKING_ONLY  // ZSTD_estimateCCtxSize_usingCParams
#include <zstd.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <memory>
#include <string>

namespace vt::store {
namespace {

struct FreeZstd {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// A context is a few hundred kilobytes and slow to make, so each thread keeps one.
ZSTD_CCtx* compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeZstd> context(ZSTD_createCCtx());
  return context.get();
}
ZSTD_DCtx* decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeZstd> context(ZSTD_createDCtx());
  return context.get();
}

}  // namespace

Result<Compression> parse_compression(std::string_view text) {
  if (text == "none") return Compression{};
  constexpr std::string_view kPrefix = "zstd:";
  if (text.starts_with(kPrefix)) {
    const std::string_view digits = text.substr(kPrefix.size());
    int level = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), level);
    if (error == std::errc{} && end == digits.data() + digits.size() && level >= 1 && level <= 19) return Compression{Codec::kZstd, level};
  }
  return fail(ErrorCode::kUsage,
              "compression '" + std::string(text) + "' is not known; use none, or zstd:N with N from 1 (fast) to 19 (small)");
}

Result<PayloadView> encode_payload(std::span<const std::byte> raw, Compression compression, std::vector<std::byte>& scratch) {
  if (raw.size() > kMaxRawBytes)
    return fail(ErrorCode::kInvalidData,
                "a tile of " + std::to_string(raw.size()) + " bytes is over the limit of 256 MiB; use smaller tiles");
  const auto raw_bytes = static_cast<std::uint32_t>(raw.size());
  switch (compression.codec) {
    case Codec::kRaw:
      return PayloadView(Codec::kRaw, raw_bytes, raw);
    case Codec::kZstd: {
      scratch.resize(std::max(scratch.size(), ZSTD_compressBound(raw.size())));
      const std::size_t size = ZSTD_compressCCtx(compressor(), scratch.data(), scratch.size(), raw.data(), raw.size(), compression.level);
      if (ZSTD_isError(size)) return fail(ErrorCode::kInternal, std::string("zstd cannot compress: ") + ZSTD_getErrorName(size));
      // Below 3 % the time to decompress costs more than the bytes do.
      if (size * 100 > raw.size() * 97) return PayloadView(Codec::kRaw, raw_bytes, raw);
      return PayloadView(Codec::kZstd, raw_bytes, std::span(scratch).first(size));
    }
  }
  return fail(ErrorCode::kUsage, "codec " + std::to_string(static_cast<int>(compression.codec)) + " is not known");
}

Result<EncodedPayload> encode_payload(std::span<const std::byte> raw, Compression compression) {
  std::vector<std::byte> scratch;
  VT_ASSIGN(const PayloadView view, encode_payload(raw, compression, scratch));
  return EncodedPayload{.codec = view.codec, .raw_bytes = view.raw_bytes, .bytes = {view.bytes.begin(), view.bytes.end()}};
}

std::size_t compressor_bytes(Compression compression, std::size_t raw_bytes) {
  if (compression.codec == Codec::kRaw) return 0;
  return ZSTD_estimateCCtxSize_usingCParams(ZSTD_getCParams(compression.level, raw_bytes, 0));
}

Result<void> decode_payload(Codec codec, std::span<const std::byte> stored, std::span<std::byte> out) {
  const auto wrong_size = [&](std::size_t found) {
    return fail(ErrorCode::kCorrupt, "payload decodes to " + std::to_string(found) + " bytes, " + std::to_string(out.size()) + " wanted");
  };
  switch (codec) {
    case Codec::kRaw:
      if (stored.size() != out.size()) return wrong_size(stored.size());
      if (!out.empty()) std::memcpy(out.data(), stored.data(), out.size());
      return {};
    case Codec::kZstd: {
      // Exactly one frame: the library would also unpack several in a row, which another reader need not.
      const std::size_t frame = ZSTD_findFrameCompressedSize(stored.data(), stored.size());
      if (ZSTD_isError(frame) || frame != stored.size()) return fail(ErrorCode::kCorrupt, "the payload is not exactly one zstd frame");
      const std::size_t size = ZSTD_decompressDCtx(decompressor(), out.data(), out.size(), stored.data(), stored.size());
      if (ZSTD_isError(size)) return fail(ErrorCode::kCorrupt, std::string("payload does not decompress: ") + ZSTD_getErrorName(size));
      if (size != out.size()) return wrong_size(size);
      return {};
    }
  }
  return fail(ErrorCode::kUnsupported, "codec " + std::to_string(static_cast<int>(codec)) + " is not known");
}

}  // namespace vt::store
