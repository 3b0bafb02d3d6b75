// One batch of BC4 blocks, one per float lane: loading, the fit by extremes and by least squares, and the
// bits. Included once per SIMD target by bc4_encoder.cpp. No fused multiply-add and no approximate
// reciprocal, so that all targets round alike.
#if defined(VT_BUILDER_ENCODE_BC4_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC4_KERNEL_INL_H_
#undef VT_BUILDER_ENCODE_BC4_KERNEL_INL_H_
#else
#define VT_BUILDER_ENCODE_BC4_KERNEL_INL_H_
#endif

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "builder/encode/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

HWY_INLINE F float_from(U value) { return hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), value)); }
HWY_INLINE F square(F value) { return hn::Mul(value, value); }

// Values are counted in parts of a 16-bit step, 35 to the step: then sevenths and fifths between two codes
// are whole numbers below 2^24, and every difference of a texel and a palette value is exact in float.
constexpr float kParts = 35.0F;
constexpr float kCode = 257.0F * kParts;
constexpr float kTop = 255.0F * kCode;
constexpr float kSeventh = kCode / 7.0F;
constexpr float kFifth = kCode / 5.0F;
static_assert(kSeventh == 1285.0F && kFifth == 1799.0F);

// The texels of one channel of one batch, each vector one texel of every block.
struct Texels {
  HWY_ALIGN_MAX float x[16][kMaxLanes];

  HWY_INLINE F get(std::size_t i) const { return hn::Load(FloatTag(), x[i]); }
  HWY_INLINE void set(std::size_t i, U value16) { hn::Store(hn::Mul(float_from(value16), constant(kParts)), FloatTag(), x[i]); }
};

static_assert(std::endian::native == std::endian::little, "words are taken apart by shifts");

// `words` 32-bit words of each of four rows of a block lie together; deinterleaving gives one block per lane.
template <std::size_t words>
HWY_INLINE void load_words(const std::uint8_t* row, U (&out)[words]) {
  const UintTag u;
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t i = 0; i < words; ++i) {
    std::uint32_t word;
    std::memcpy(&word, row + i * 4, 4);
    out[i] = hn::Set(u, word);
  }
#else
  const auto* from = reinterpret_cast<const std::uint32_t*>(row);
  if constexpr (words == 2) {
    hn::LoadInterleaved2(u, from, out[0], out[1]);
  } else {
    hn::LoadInterleaved4(u, from, out[0], out[1], out[2], out[3]);
  }
#endif
}

HWY_INLINE U low_half(U word) { return hn::And(word, hn::Set(UintTag(), 0xFFFF)); }
HWY_INLINE U high_half(U word) { return hn::ShiftRight<16>(word); }

HWY_INLINE void load_r16(const std::uint8_t* rows, std::size_t pitch, Texels& r) {
  for (std::size_t y = 0; y < 4; ++y) {
    U words[2];
    load_words(rows + y * pitch, words);
    for (std::size_t i = 0; i < 2; ++i) {
      r.set(y * 4 + i * 2, low_half(words[i]));
      r.set(y * 4 + i * 2 + 1, high_half(words[i]));
    }
  }
}

HWY_INLINE void load_rg16(const std::uint8_t* rows, std::size_t pitch, Texels& r, Texels& g) {
  for (std::size_t y = 0; y < 4; ++y) {
    U words[4];
    load_words(rows + y * pitch, words);
    for (std::size_t i = 0; i < 4; ++i) {
      r.set(y * 4 + i, low_half(words[i]));
      g.set(y * 4 + i, high_half(words[i]));
    }
  }
}

HWY_INLINE void load_alpha8(const std::uint8_t* rows, std::size_t pitch, Texels& a) {
  for (std::size_t y = 0; y < 4; ++y) {
    U words[4];
    load_words(rows + y * pitch, words);
    // 257 a: the byte twice.
    for (std::size_t i = 0; i < 4; ++i) {
      const U alpha = hn::ShiftRight<24>(words[i]);
      a.set(y * 4 + i, hn::Or(alpha, hn::ShiftLeft<8>(alpha)));
    }
  }
}

// End points as codes (whole numbers), low <= high, and whether the mode is that of six values.
// Not six: low < high.
struct Ends {
  F low, high;
  FloatMask six;
  F error;
};

HWY_INLINE Ends better(const Ends& p, const Ends& q) {
  const FloatMask use_q = hn::Lt(q.error, p.error);
  return {.low = hn::IfThenElse(use_q, q.low, p.low),
          .high = hn::IfThenElse(use_q, q.high, p.high),
          .six = hn::Or(hn::And(use_q, q.six), hn::AndNot(use_q, p.six)),
          .error = hn::Min(p.error, q.error)};
}

struct Range {
  F low, high;  // of the texels
};
HWY_INLINE Range range_of(const Texels& texels) {
  Range range{texels.get(0), texels.get(0)};
  for (std::size_t i = 1; i < 16; ++i) {
    range.low = hn::Min(range.low, texels.get(i));
    range.high = hn::Max(range.high, texels.get(i));
  }
  return range;
}

// A number to the nearest code.
HWY_INLINE F code_of(F value) { return clamped(hn::Round(hn::Mul(value, constant(1.0F / kCode))), 0.0F, 255.0F); }

// Position 0..`last` of a texel between the end points, each end point inclusive, and how far the texel is
// from it.
struct Scale {
  F origin, step, per_step, last;

  HWY_INLINE Scale(F low, F high, F unit, F last_position)
      : origin(hn::Mul(low, constant(kCode))), step(hn::Mul(hn::Sub(high, low), unit)), last(last_position) {
    per_step = hn::IfThenElseZero(hn::Gt(step, hn::Zero(FloatTag())), hn::Div(constant(1.0F), step));
  }
  HWY_INLINE F position(F from_origin) const {
    return hn::Min(hn::Max(hn::Round(hn::Mul(from_origin, per_step)), hn::Zero(FloatTag())), last);
  }
};

// The fast fit: the extremes, as they are.
HWY_INLINE Ends fit_extremes(const Texels& texels) {
  const Range range = range_of(texels);
  const F low = code_of(range.low);
  const F high = code_of(range.high);
  return {.low = low, .high = high, .six = hn::Eq(low, high), .error = hn::Zero(FloatTag())};
}

// The bits of every block: `block_bytes` apart.
template <std::size_t block_bytes>
HWY_INLINE void store_blocks(const Ends& ends, const Texels& texels, std::uint8_t* blocks) {
  const IntTag i32;
  const UintTag u;
  const F zero = hn::Zero(FloatTag());
  const F one = constant(1.0F);
  const F last = hn::IfThenElse(ends.six, constant(5.0F), constant(7.0F));
  const Scale scale(ends.low, ends.high, hn::IfThenElse(ends.six, constant(kFifth), constant(kSeventh)), last);
  U halves[2];
  for (std::size_t half = 0; half < 2; ++half) {
    halves[half] = hn::Zero(u);
    for (std::size_t i = 8; i-- > 0;) {
      const F x = texels.get(half * 8 + i);
      const F from_origin = hn::Sub(x, scale.origin);
      const F position = scale.position(from_origin);
      // Index 0 is the first end point, 1 the second, the rest lies between: the first is the higher one in
      // the mode of eight values.
      const F from_first = hn::IfThenElse(ends.six, position, hn::Sub(last, position));
      F index = hn::Add(from_first, one);
      index = hn::IfThenElse(hn::Eq(from_first, last), one, index);
      index = hn::IfThenElse(hn::Eq(from_first, zero), zero, index);
      // Index 6 is 0 and index 7 is 255.
      const F distance = hn::Abs(hn::Sub(from_origin, hn::Mul(position, scale.step)));
      const F from_top = hn::Sub(constant(kTop), x);
      const F to_extreme = hn::Min(x, from_top);
      const FloatMask extreme = hn::And(ends.six, hn::Lt(to_extreme, distance));
      index = hn::IfThenElse(extreme, hn::IfThenElse(hn::Lt(from_top, x), constant(7.0F), constant(6.0F)), index);
      halves[half] = hn::Or(hn::ShiftLeft<3>(halves[half]), hn::BitCast(u, hn::ConvertTo(i32, index)));
    }
  }
  const F first = hn::IfThenElse(ends.six, ends.low, ends.high);
  const F second = hn::IfThenElse(ends.six, ends.high, ends.low);
  const U codes = hn::BitCast(u, hn::Or(hn::ConvertTo(i32, first), hn::ShiftLeft<8>(hn::ConvertTo(i32, second))));

  HWY_ALIGN_MAX std::uint32_t block_codes[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t block_halves[2][kMaxLanes];
  hn::Store(codes, u, block_codes);
  hn::Store(halves[0], u, block_halves[0]);
  hn::Store(halves[1], u, block_halves[1]);
  for (std::size_t i = 0; i < hn::Lanes(u); ++i) {
    const std::uint64_t block = block_codes[i] | std::uint64_t{block_halves[0][i]} << 16U | std::uint64_t{block_halves[1][i]} << 40U;
    std::memcpy(blocks + i * block_bytes, &block, 8);
  }
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // per-target include guard
