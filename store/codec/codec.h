// How a tile's bytes become what lies in the file: as they are, or compressed. Decoding checks every size
// before it writes. Threads: free functions, any thread; each thread keeps its own compressor state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "store/codec/prediction.h"
#include "store/result.h"

namespace vt::store {

// Numbers are on disk.
enum class Codec : std::uint8_t {
  kRaw = 0,
  kZstd = 1,
  kPredictedZstd = 2,  // a few bytes that name the predictors, then one frame with the planes of residuals
};

struct Compression {
  Codec codec = Codec::kRaw;
  int level = 0;  // 1..19 for zstd, with prediction where that is smaller
};

// "none" or "zstd:N". kUsage otherwise, and the message lists what is accepted.
[[nodiscard]] Result<Compression> parse_compression(std::string_view text);

struct EncodedPayload {
  Codec codec = Codec::kRaw;
  std::uint32_t raw_bytes = 0;
  std::vector<std::byte> bytes;
};

// The same without owning the bytes.
struct PayloadView {
  Codec codec = Codec::kRaw;
  std::uint32_t raw_bytes = 0;
  std::span<const std::byte> bytes;

  PayloadView() = default;
  PayloadView(Codec codec_in, std::uint32_t raw_bytes_in, std::span<const std::byte> bytes_in)
      : codec(codec_in), raw_bytes(raw_bytes_in), bytes(bytes_in) {}
  PayloadView(const EncodedPayload& payload)  // NOLINT: an owner is as good as a view wherever one is read
      : codec(payload.codec), raw_bytes(payload.raw_bytes), bytes(payload.bytes) {}
};

// The most that one tile may decode to.
inline constexpr std::size_t kMaxRawBytes = std::size_t{256} << 20;

// `shape` is the tile's (see tile_shape); one of another size counts as opaque, which is compressed without
// prediction. Falls back to kRaw when compression gains less than 3 %. kInvalidData when `raw` is over
// kMaxRawBytes.
[[nodiscard]] Result<EncodedPayload> encode_payload(std::span<const std::byte> raw, const TileShape& shape, Compression compression);
// The same without a copy where none is needed: the view is of `raw` itself or of `scratch`, which grows as
// needed and is best kept from call to call.
[[nodiscard]] Result<PayloadView> encode_payload(std::span<const std::byte> raw, const TileShape& shape, Compression compression,
                                                 std::vector<std::byte>& scratch);
// The same for bytes of which nothing is known, such as a blob: never predicted.
[[nodiscard]] Result<PayloadView> encode_payload(std::span<const std::byte> raw, Compression compression, std::vector<std::byte>& scratch);
// What a thread keeps for compressing payloads of that size; an upper bound.
[[nodiscard]] std::size_t compressor_bytes(Compression compression, std::size_t raw_bytes);
// `out` is exactly the raw size. kCorrupt when `stored` does not decode to exactly that many bytes, or is
// predicted and `shape` is opaque.
[[nodiscard]] Result<void> decode_payload(Codec codec, std::span<const std::byte> stored, const TileShape& shape, std::span<std::byte> out);

}  // namespace vt::store
