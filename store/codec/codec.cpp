#include "store/codec/codec.h"

// For ZSTD_c_literalCompressionMode, which the library has had under this number since 1.3.9, and for
// ZSTD_estimateCStreamSize_usingCParams.
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include <algorithm>
#include <bitset>
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

tl::unexpected<Error> wrong_size(std::size_t found, std::size_t wanted) {
  return fail(ErrorCode::kCorrupt, "payload decodes to " + std::to_string(found) + " bytes, " + std::to_string(wanted) + " wanted");
}
tl::unexpected<Error> zstd_failure(std::size_t code) {
  return fail(ErrorCode::kInternal, std::string("zstd cannot compress: ") + ZSTD_getErrorName(code));
}

// How zstd looks for repetitions.
//
// Residuals have few, and looking for them at every byte costs more time than all the rest: going over them
// in steps leaves the work to the Huffman coder. On photographs that is smaller than what levels 1 to 9 make
// of the same residuals, and three times as fast as level 1.
struct Search {
  int step = 0;  // 0: as the level does
};
constexpr Search kLongSteps{1024};  // finds only flat areas
constexpr Search kShortSteps{8};
constexpr Search kByLevel{0};

std::size_t set_search(ZSTD_CCtx* context, Search search, int level) {
  std::size_t code = ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level);
  if (search.step == 0) return code;
  // A table for the steps of one plane; with steps this strategy would not compress what it finds no match
  // for, if it were not told to.
  const int hash_log = search.step > 100 ? 10 : 13;
  for (const auto& [parameter, value] : {std::pair{ZSTD_c_strategy, static_cast<int>(ZSTD_fast)},
                                         {ZSTD_c_minMatch, 7},
                                         {ZSTD_c_targetLength, search.step},
                                         {ZSTD_c_hashLog, hash_log},
                                         {ZSTD_c_literalCompressionMode, static_cast<int>(ZSTD_ps_enable)}})
    if (!ZSTD_isError(code)) code = ZSTD_CCtx_setParameter(context, parameter, value);
  return code;
}

// A payload in the making. The buffer only grows, since it is used again and again; what it holds past `size`
// means nothing.
struct Draft {
  std::vector<std::byte> buffer;
  std::size_t size = 0;

  void clear() { size = 0; }
  [[nodiscard]] std::span<std::byte> room(std::size_t bytes) {
    if (buffer.size() < size + bytes) buffer.resize(size + bytes);
    return std::span(buffer).subspan(size);
  }
};

// One frame of `bytes` after what `out` holds already. A block ends with each of `pieces` equal pieces
// (planes, or parts of them), so that each has Huffman tables of its own.
Result<void> append_frame(std::span<const std::byte> bytes, std::size_t pieces, Search search, int level, Draft& out) {
  ZSTD_CCtx* const context = compressor();
  ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
  std::size_t code = set_search(context, search, level);
  if (!ZSTD_isError(code)) code = ZSTD_CCtx_setPledgedSrcSize(context, bytes.size());
  if (ZSTD_isError(code)) return zstd_failure(code);

  // The bound is for one call; each flush may add the header of a block.
  const auto room = out.room(ZSTD_compressBound(bytes.size()) + 16 * pieces);
  ZSTD_outBuffer output{room.data(), room.size(), 0};
  const std::size_t piece_bytes = bytes.size() / pieces;
  for (std::size_t i = 0; i < pieces; ++i) {
    const auto piece = bytes.subspan(i * piece_bytes, piece_bytes);
    ZSTD_inBuffer input{piece.data(), piece.size(), 0};
    const std::size_t left = ZSTD_compressStream2(context, &output, &input, i + 1 == pieces ? ZSTD_e_end : ZSTD_e_flush);
    if (ZSTD_isError(left)) return zstd_failure(left);
    if (left != 0) return fail(ErrorCode::kInternal, "zstd wants more room than its bound");
  }
  out.size += output.pos;
  return {};
}

// What comes before the frame of a predicted payload: flags, then the predictor of each channel.
constexpr std::byte kSubtractsGreen{1};
std::size_t prediction_bytes(const TileShape& shape) { return 1 + shape.channels; }

void append_prediction(const Prediction& prediction, const TileShape& shape, Draft& out) {
  const auto room = out.room(prediction_bytes(shape));
  room[0] = prediction.subtracts_green ? kSubtractsGreen : std::byte{0};
  for (std::size_t c = 0; c < shape.channels; ++c) room[1 + c] = static_cast<std::byte>(prediction.predictors[c]);
  out.size += prediction_bytes(shape);
}

Result<Prediction> parse_prediction(std::span<const std::byte> bytes, const TileShape& shape) {
  const auto damaged = [](const char* sentence) { return fail(ErrorCode::kCorrupt, sentence); };
  if (bytes.size() < prediction_bytes(shape)) return damaged("the payload ends before its predictors");
  Prediction prediction{.subtracts_green = bytes[0] == kSubtractsGreen};
  const bool may_subtract = shape.samples == TileShape::Samples::kUint8 && shape.channels >= 3;
  if (bytes[0] != std::byte{0} && !(prediction.subtracts_green && may_subtract))
    return damaged("the payload's prediction flags are not known");
  for (std::size_t c = 0; c < shape.channels; ++c) {
    const auto number = std::to_integer<std::uint8_t>(bytes[1 + c]);
    if (number >= kPredictorCount) return damaged("the payload names a predictor that is not known");
    prediction.predictors[c] = static_cast<Predictor>(number);
  }
  return prediction;
}

// How often eight residuals in a row are zero, as in maps, graphics and photographs that were enlarged: then
// repetitions are worth looking for. (The top bytes of longer samples are nearly always zero, and tell
// nothing.)
double flat_share(std::span<const std::byte> residuals, const TileShape& shape) {
  const std::size_t plane_bytes = shape.plane_bytes();
  std::size_t zero_words = 0;
  std::size_t words = 0;
  for (std::size_t plane = 0; plane < shape.planes(); ++plane) {
    if (shape.sample_bytes() > 1 && plane % shape.sample_bytes() == 0) continue;
    for (std::size_t at = plane * plane_bytes; at + 8 <= (plane + 1) * plane_bytes; at += 8, ++words) {
      std::uint64_t word = 0;
      std::memcpy(&word, residuals.data() + at, sizeof word);
      zero_words += word == 0 ? 1 : 0;
    }
  }
  return words == 0 ? 0.0 : static_cast<double>(zero_words) / static_cast<double>(words);
}

// At most a quarter of all byte values, on a sample: the colours of a map, the numbers of classes.
bool has_few_values(std::span<const std::byte> raw) {
  constexpr std::size_t kSampled = 4096;
  std::bitset<256> found;
  // An odd stride, to come to every channel.
  for (std::size_t at = 0; at < raw.size(); at += raw.size() / kSampled | 1) found.set(std::to_integer<std::size_t>(raw[at]));
  return found.count() <= 64;
}

// Tries what the level is worth and keeps the smallest. A photograph at level 1 is tried only once, at levels
// 2 to 8 twice.
class ZstdEncoder {
 public:
  // The payload is left in `scratch`, unless it is kRaw's.
  ZstdEncoder(std::span<const std::byte> raw, int level, std::vector<std::byte>& scratch) : raw_(raw), level_(level), scratch_(scratch) {
    best_.buffer.swap(scratch);
  }
  ~ZstdEncoder() { best_.buffer.swap(scratch_); }
  ZstdEncoder(const ZstdEncoder&) = delete;
  ZstdEncoder& operator=(const ZstdEncoder&) = delete;

  [[nodiscard]] Result<PayloadView> run(const TileShape& shape) {
    if (shape.is_predictable() && shape.raw_bytes() == raw_.size() && !raw_.empty()) {
      VT_CHECK(try_predicted(shape));
      // Maps and graphics, whose patterns prediction tears apart, and what it gains nothing on.
      const bool is_likely_pattern = is_flat_ && (level_ > 1 || best_.size < raw_.size() / 8 || has_few_values(raw_));
      if (!is_likely_pattern && !is_thorough() && !is_too_large(best_.size)) return best();
    }
    VT_CHECK(try_plain());
    if (is_too_large(best_.size)) return PayloadView(Codec::kRaw, static_cast<std::uint32_t>(raw_.size()), raw_);
    return best();
  }

 private:
  // From here on zstd finds what little repeats in photographs, too; below it would cost ten times the time
  // for nothing.
  [[nodiscard]] bool is_thorough() const { return level_ >= 9; }
  [[nodiscard]] PayloadView best() const {
    return {codec_, static_cast<std::uint32_t>(raw_.size()), std::span(best_.buffer).first(best_.size)};
  }
  // Below 3 % the time to decompress costs more than the bytes do.
  [[nodiscard]] bool is_too_large(std::size_t bytes) const { return bytes * 100 > raw_.size() * 97; }

  [[nodiscard]] Result<void> try_predicted(const TileShape& shape) {
    thread_local std::vector<std::byte> planes;
    planes.resize(std::max(planes.size(), raw_.size()));
    const auto residuals = std::span(planes).first(raw_.size());
    const Prediction prediction = choose_prediction(raw_, shape);
    split_into_residuals(raw_, shape, prediction, residuals);
    // A quarter parts flat tiles from aerial photographs of open sea, which the search makes larger. A higher
    // level has the time to see.
    const double share = flat_share(residuals, shape);
    is_flat_ = share >= 0.25;
    const bool may_repeat = share >= 0.0625;
    const auto try_search = [&](Search search, std::size_t pieces) -> Result<void> {
      trial().clear();
      append_prediction(prediction, shape, trial());
      VT_CHECK(append_frame(residuals, pieces, search, level_, trial()));
      keep_if_smaller(Codec::kPredictedZstd);
      return {};
    };
    const Search steps = is_flat_ ? kShortSteps : kLongSteps;
    VT_CHECK(try_search(steps, shape.planes()));
    if (level_ == 1) return {};
    // Where one half of a tile is sea and the other city.
    if (shape.plane_bytes() % 4 == 0) VT_CHECK(try_search(steps, 4 * shape.planes()));
    if (!may_repeat && !is_thorough()) return {};
    return try_search(kByLevel, shape.planes());
  }
  [[nodiscard]] Result<void> try_plain() {
    trial().clear();
    VT_CHECK(append_frame(raw_, 1, kByLevel, level_, trial()));
    keep_if_smaller(Codec::kZstd);
    return {};
  }

  static Draft& trial() {
    thread_local Draft draft;
    return draft;
  }
  void keep_if_smaller(Codec codec) {
    if (codec_ != Codec::kRaw && trial().size >= best_.size) return;
    codec_ = codec;
    std::swap(best_, trial());
  }

  std::span<const std::byte> raw_;
  int level_;
  std::vector<std::byte>& scratch_;
  Draft best_;
  Codec codec_ = Codec::kRaw;  // nothing was tried
  bool is_flat_ = false;
};

// Exactly one frame of exactly out.size() bytes: the library would also unpack several in a row, which
// another reader need not.
Result<void> decode_frame(std::span<const std::byte> stored, std::span<std::byte> out) {
  const std::size_t frame = ZSTD_findFrameCompressedSize(stored.data(), stored.size());
  if (ZSTD_isError(frame) || frame != stored.size()) return fail(ErrorCode::kCorrupt, "the payload is not exactly one zstd frame");
  const std::size_t size = ZSTD_decompressDCtx(decompressor(), out.data(), out.size(), stored.data(), stored.size());
  if (ZSTD_isError(size)) return fail(ErrorCode::kCorrupt, std::string("payload does not decompress: ") + ZSTD_getErrorName(size));
  if (size != out.size()) return wrong_size(size, out.size());
  return {};
}

Result<void> decode_predicted(std::span<const std::byte> stored, const TileShape& shape, std::span<std::byte> out) {
  if (!shape.is_predictable()) return fail(ErrorCode::kCorrupt, "the payload is predicted, in a format that cannot be");
  if (shape.raw_bytes() != out.size()) return wrong_size(shape.raw_bytes(), out.size());
  VT_ASSIGN(const Prediction prediction, parse_prediction(stored, shape));
  thread_local std::vector<std::byte> planes;
  planes.resize(std::max(planes.size(), out.size()));
  const auto residuals = std::span(planes).first(out.size());
  VT_CHECK(decode_frame(stored.subspan(prediction_bytes(shape)), residuals));
  join_residuals(residuals, shape, prediction, out);
  return {};
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

Result<PayloadView> encode_payload(std::span<const std::byte> raw, const TileShape& shape, Compression compression,
                                   std::vector<std::byte>& scratch) {
  if (raw.size() > kMaxRawBytes)
    return fail(ErrorCode::kInvalidData,
                "a tile of " + std::to_string(raw.size()) + " bytes is over the limit of 256 MiB; use smaller tiles");
  switch (compression.codec) {
    case Codec::kRaw:
      return PayloadView(Codec::kRaw, static_cast<std::uint32_t>(raw.size()), raw);
    case Codec::kZstd:
      return ZstdEncoder(raw, compression.level, scratch).run(shape);
    case Codec::kPredictedZstd:
      break;  // a choice of this function's, not of its caller's
  }
  return fail(ErrorCode::kUsage, "codec " + std::to_string(static_cast<int>(compression.codec)) + " cannot be asked for");
}

Result<PayloadView> encode_payload(std::span<const std::byte> raw, Compression compression, std::vector<std::byte>& scratch) {
  return encode_payload(raw, TileShape{}, compression, scratch);
}

Result<EncodedPayload> encode_payload(std::span<const std::byte> raw, const TileShape& shape, Compression compression) {
  std::vector<std::byte> scratch;
  VT_ASSIGN(const PayloadView view, encode_payload(raw, shape, compression, scratch));
  return EncodedPayload{.codec = view.codec, .raw_bytes = view.raw_bytes, .bytes = {view.bytes.begin(), view.bytes.end()}};
}

// The context, the residuals and two frames to choose from.
std::size_t compressor_bytes(Compression compression, std::size_t raw_bytes) {
  if (compression.codec == Codec::kRaw) return 0;
  return ZSTD_estimateCStreamSize_usingCParams(ZSTD_getCParams(compression.level, raw_bytes, 0)) + raw_bytes +
         2 * ZSTD_compressBound(raw_bytes);
}

Result<void> decode_payload(Codec codec, std::span<const std::byte> stored, const TileShape& shape, std::span<std::byte> out) {
  switch (codec) {
    case Codec::kRaw:
      if (stored.size() != out.size()) return wrong_size(stored.size(), out.size());
      if (!out.empty()) std::memcpy(out.data(), stored.data(), out.size());
      return {};
    case Codec::kZstd:
      return decode_frame(stored, out);
    case Codec::kPredictedZstd:
      return decode_predicted(stored, shape, out);
  }
  return fail(ErrorCode::kUnsupported, "codec " + std::to_string(static_cast<int>(codec)) + " is not known");
}

}  // namespace vt::store
