// One batch of BC1 blocks, one per float lane: colours as vectors, loading, and sums. Included once per SIMD
// target by bc1_encoder.cpp. No fused multiply-add and no approximate reciprocal, so that all targets round
// alike.
#if defined(VT_BUILDER_ENCODE_BC1_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_BC1_KERNEL_INL_H_
#undef VT_BUILDER_ENCODE_BC1_KERNEL_INL_H_
#else
#define VT_BUILDER_ENCODE_BC1_KERNEL_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "builder/encode/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

HWY_INLINE F float_from(I value) { return hn::ConvertTo(FloatTag(), value); }
HWY_INLINE I truncated(F value) { return hn::ConvertTo(IntTag(), value); }

// One colour per block, and the arithmetic on it.
struct Rgb {
  F r, g, b;
};
HWY_INLINE Rgb operator+(const Rgb& p, const Rgb& q) { return {hn::Add(p.r, q.r), hn::Add(p.g, q.g), hn::Add(p.b, q.b)}; }
HWY_INLINE Rgb operator-(const Rgb& p, const Rgb& q) { return {hn::Sub(p.r, q.r), hn::Sub(p.g, q.g), hn::Sub(p.b, q.b)}; }
HWY_INLINE Rgb operator*(const Rgb& p, F k) { return {hn::Mul(p.r, k), hn::Mul(p.g, k), hn::Mul(p.b, k)}; }
HWY_INLINE F dot(const Rgb& p, const Rgb& q) { return hn::Add(hn::Add(hn::Mul(p.r, q.r), hn::Mul(p.g, q.g)), hn::Mul(p.b, q.b)); }

// The texels of one batch, each vector one texel of every block, less `mean`.
struct Texels {
  HWY_ALIGN_MAX float r[16][kMaxLanes];
  HWY_ALIGN_MAX float g[16][kMaxLanes];
  HWY_ALIGN_MAX float b[16][kMaxLanes];
  HWY_ALIGN_MAX float weight[16][kMaxLanes];  // 1, or 0 for texels that do not count, which lie on the mean

  HWY_INLINE Rgb get(std::size_t i) const {
    const FloatTag f;
    return {hn::Load(f, r[i]), hn::Load(f, g[i]), hn::Load(f, b[i])};
  }
  HWY_INLINE void set(std::size_t i, const Rgb& texel) {
    const FloatTag f;
    hn::Store(texel.r, f, r[i]);
    hn::Store(texel.g, f, g[i]);
    hn::Store(texel.b, f, b[i]);
  }
};

struct Moments {
  F count;       // of the texels that count; the others lie on `mean`
  Rgb mean;      // rounded to integers
  Rgb sum;       // of the centred texels
  Rgb squares;   // sums of r*r, g*g, b*b
  F rg, rb, gb;  // sums of products
};

// Four texels of a row, in the four bytes of a lane, leftmost lowest. `a` is the fourth byte of each texel,
// if there is one.
struct PackedRow {
  U r, g, b, a;
};

// Taking the interleaved colours apart leaves four neighbouring texels in each 32-bit lane: no transposition
// is needed to have one block per lane.
template <std::size_t bytes_per_texel>
HWY_INLINE PackedRow load_row(const std::uint8_t* row) {
  const UintTag u;
#if HWY_TARGET == HWY_SCALAR
  std::uint32_t r = 0, g = 0, b = 0, a = 0;
  for (std::size_t i = 4; i-- > 0;) {
    r = r << 8U | row[i * bytes_per_texel];
    g = g << 8U | row[i * bytes_per_texel + 1];
    b = b << 8U | row[i * bytes_per_texel + 2];
    if constexpr (bytes_per_texel == 4) a = a << 8U | row[i * 4 + 3];
  }
  return {hn::Set(u, r), hn::Set(u, g), hn::Set(u, b), hn::Set(u, a)};
#else
  const hn::Repartition<std::uint8_t, FloatTag> bytes;
  auto r = hn::Zero(bytes), g = r, b = r, a = r;
  if constexpr (bytes_per_texel == 3) {
    hn::LoadInterleaved3(bytes, row, r, g, b);
  } else {
    hn::LoadInterleaved4(bytes, row, r, g, b, a);
  }
  return {hn::BitCast(u, r), hn::BitCast(u, g), hn::BitCast(u, b), hn::BitCast(u, a)};
#endif
}

// How texels are laid out, and which of them count.
struct Rgb8 {
  static constexpr std::size_t kTexelBytes = 3;
  static constexpr bool kByAlpha = false;
};
struct Rgbx8 {
  static constexpr std::size_t kTexelBytes = 4;
  static constexpr bool kByAlpha = false;
};
// Texels of alpha 0 do not count, except in a block where all are.
struct Rgba8 {
  static constexpr std::size_t kTexelBytes = 4;
  static constexpr bool kByAlpha = true;
};

HWY_INLINE U low_byte(U word) { return hn::And(word, hn::Set(UintTag(), 0xFF)); }
HWY_INLINE F float_of_byte(U word) { return float_from(hn::BitCast(IntTag(), low_byte(word))); }

// 1 for a texel that counts, else 0. `alpha` is in the low byte.
HWY_INLINE F counted_weight(U alpha, hn::Mask<UintTag> all_count) {
  const auto counts = hn::Or(all_count, hn::Ne(low_byte(alpha), hn::Zero(UintTag())));
  return hn::IfThenElseZero(hn::RebindMask(FloatTag(), counts), constant(1.0F));
}

// Texels that do not count are put on the mean, where they add nothing to any sum of centred texels.
template <class Layout>
HWY_INLINE Moments load_centred(const std::uint8_t* rows, std::size_t pitch, Texels& texels) {
  const UintTag u;
  PackedRow packed[4];
  U any_alpha = hn::Zero(u);
  for (std::size_t y = 0; y < 4; ++y) {
    packed[y] = load_row<Layout::kTexelBytes>(rows + y * pitch);
    any_alpha = hn::Or(any_alpha, packed[y].a);
  }
  const auto all_count = hn::Eq(any_alpha, hn::Zero(u));

  const F zero = hn::Zero(FloatTag());
  Rgb sum{zero, zero, zero};
  F count = constant(Layout::kByAlpha ? 0.0F : 16.0F);
  for (std::size_t i = 0; i < 16; ++i) {
    const PackedRow& row = packed[i / 4];
    const int shift = static_cast<int>(i % 4 * 8);
    Rgb texel{float_of_byte(hn::ShiftRightSame(row.r, shift)), float_of_byte(hn::ShiftRightSame(row.g, shift)),
              float_of_byte(hn::ShiftRightSame(row.b, shift))};
    texels.set(i, texel);
    F weight = constant(1.0F);
    if constexpr (Layout::kByAlpha) {
      weight = counted_weight(hn::ShiftRightSame(row.a, shift), all_count);
      texel = texel * weight;
      count = hn::Add(count, weight);
    }
    hn::Store(weight, FloatTag(), texels.weight[i]);
    sum = sum + texel;
  }

  Moments moments;
  const F half = constant(0.5F);
  const F per_count = hn::Div(constant(1.0F), count);
  moments.count = count;
  moments.mean = {float_from(truncated(hn::Add(hn::Mul(sum.r, per_count), half))),
                  float_from(truncated(hn::Add(hn::Mul(sum.g, per_count), half))),
                  float_from(truncated(hn::Add(hn::Mul(sum.b, per_count), half)))};
  moments.sum = sum - moments.mean * count;
  F rr = zero, gg = zero, bb = zero, rg = zero, rb = zero, gb = zero;
  for (std::size_t i = 0; i < 16; ++i) {
    Rgb texel = texels.get(i) - moments.mean;
    if constexpr (Layout::kByAlpha) texel = texel * hn::Load(FloatTag(), texels.weight[i]);
    texels.set(i, texel);
    rr = hn::Add(rr, hn::Mul(texel.r, texel.r));
    gg = hn::Add(gg, hn::Mul(texel.g, texel.g));
    bb = hn::Add(bb, hn::Mul(texel.b, texel.b));
    rg = hn::Add(rg, hn::Mul(texel.r, texel.g));
    rb = hn::Add(rb, hn::Mul(texel.r, texel.b));
    gb = hn::Add(gb, hn::Mul(texel.g, texel.b));
  }
  moments.squares = {rr, gg, bb};
  moments.rg = rg, moments.rb = rb, moments.gb = gb;
  return moments;
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif  // per-target include guard
