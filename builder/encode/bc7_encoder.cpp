#include "builder/encode/bc7_encoder.h"

#include <cstdint>

#include "builder/encode/bc7_block.h"
#include "builder/encode/block_batches.h"

// Vectors without a compile-time size cannot be members of structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bc7_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bc7_fit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

// Four texels of a row in the four bytes of a lane, leftmost lowest, for each channel.
struct PackedRow {
  U channel[4];
};

HWY_INLINE PackedRow load_row(const std::uint8_t* row) {
#if HWY_TARGET == HWY_SCALAR
  PackedRow packed;
  for (std::size_t c = 0; c < 4; ++c)
    packed.channel[c] = bits(row[c] | static_cast<std::uint32_t>(row[4 + c]) << 8U | static_cast<std::uint32_t>(row[8 + c]) << 16U |
                             static_cast<std::uint32_t>(row[12 + c]) << 24U);
  return packed;
#else
  // Taking the channels apart leaves four neighbouring texels in each 32-bit lane: that is one block per lane.
  const hn::Repartition<std::uint8_t, FloatTag> bytes;
  hn::Vec<decltype(bytes)> r, g, b, a;
  hn::LoadInterleaved4(bytes, row, r, g, b, a);
  const UintTag u;
  return {{hn::BitCast(u, r), hn::BitCast(u, g), hn::BitCast(u, b), hn::BitCast(u, a)}};
#endif
}

// The texels of one batch, and what they are like.
struct Batch {
  Texels<4> rgba;
  FloatMask is_flat;    // one colour
  FloatMask is_opaque;  // alpha 255 throughout
};

HWY_INLINE void load_batch(const std::uint8_t* rows, std::size_t pitch, Batch& batch) {
  const IntTag i32;
  Color<4> low, high;
  for (int c = 0; c < 4; ++c) low.c[c] = constant(255.0F), high.c[c] = zero();
  for (std::size_t y = 0; y < 4; ++y) {
    PackedRow row = load_row(rows + y * pitch);
    for (std::size_t x = 0; x < 4; ++x) {
      for (int c = 0; c < 4; ++c) {
        const F value = hn::ConvertTo(FloatTag(), hn::BitCast(i32, hn::And(row.channel[c], bits(0xFF))));
        row.channel[c] = hn::ShiftRight<8>(row.channel[c]);
        batch.rgba.set(y * 4 + x, c, value);
        low.c[c] = hn::Min(low.c[c], value);
        high.c[c] = hn::Max(high.c[c], value);
      }
    }
  }
  F spread = zero();
  for (int c = 0; c < 4; ++c) spread = hn::Add(spread, hn::Sub(high.c[c], low.c[c]));
  batch.is_flat = hn::Eq(spread, zero());
  batch.is_opaque = hn::Eq(low.c[3], constant(255.0F));
}

// A vector of Bc7Choice, and the squared error of each.
struct Choices {
  F error;
  U head;
  U ends[6];
  U indices[2];
  U alpha_indices[2];
};

HWY_INLINE void write_blocks(const Choices& choices, std::uint8_t* blocks) {
  const UintTag u;
  HWY_ALIGN_MAX std::uint32_t head[kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t ends[6][kMaxLanes];
  HWY_ALIGN_MAX std::uint32_t indices[4][kMaxLanes];
  hn::Store(choices.head, u, head);
  for (std::size_t end = 0; end < 6; ++end) hn::Store(choices.ends[end], u, ends[end]);
  for (std::size_t half = 0; half < 2; ++half) {
    hn::Store(choices.indices[half], u, indices[half]);
    hn::Store(choices.alpha_indices[half], u, indices[2 + half]);
  }
  for (std::size_t lane = 0; lane < kMaxLanes; ++lane) {
    Bc7Choice choice;
    choice.head = head[lane];
    for (std::size_t end = 0; end < 6; ++end) choice.ends[end] = ends[end][lane];
    choice.indices = indices[0][lane] | std::uint64_t{indices[1][lane]} << 32U;
    choice.alpha_indices = indices[2][lane] | std::uint64_t{indices[3][lane]} << 32U;
    write_bc7_block(choice, std::span<std::byte, 16>(reinterpret_cast<std::byte*>(blocks) + lane * 16, 16));
  }
}

HWY_INLINE Choices mode6(const Batch& batch, int passes) {
  const SubsetCode<4> fit = fitted<CodeFormat<7, 2>, 4>(batch.rgba, WholeBlock(), batch.is_opaque, passes);
  Choices choices;
  choices.error = fit.error;
  choices.head = hn::Or(bits(6), hn::ShiftLeft<Bc7Choice::kLowestBitShift>(fit.lowest));
  for (U& end : choices.ends) end = bits(0);
  choices.ends[0] = fit.end0.code;
  choices.ends[1] = fit.end1.code;
  for (int half = 0; half < 2; ++half) {
    choices.indices[half] = fit.indices[half];
    choices.alpha_indices[half] = bits(0);
  }
  return choices;
}

// As many blocks as there are lanes, side by side. `blocks` takes 16 bytes of each.
HWY_INLINE void encode_batch(const std::uint8_t* rows, std::size_t pitch, Quality quality, std::uint8_t* blocks) {
  Batch batch;
  load_batch(rows, pitch, batch);
  Choices best = mode6(batch, quality == Quality::kFast ? 2 : 4);

  U color = bits(0);
  for (int c = 4; c-- > 0;) color = hn::Or(hn::ShiftLeft<8>(color), integer_bits(batch.rgba.get(0).c[c]));
  best.head = select(batch.is_flat, bits(Bc7Choice::kSolid), best.head);
  best.ends[0] = select(batch.is_flat, color, best.ends[0]);
  write_blocks(best, blocks);
}

void encode_rgba(const BlockJob& job) {
  for_each_batch<kMaxLanes, 4, 16>(
      job, [&job](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) { encode_batch(rows, pitch, job.quality, blocks); });
}

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_rgba);

void encode_bc7_image(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  HWY_DYNAMIC_DISPATCH(encode_rgba)(block_job(rgba, width, height, row_pitch_bytes, 4, quality, blocks, 16));
}

}  // namespace vt::encode
#endif  // HWY_ONCE
