#include "builder/encode/bc1/bc1_encoder.h"

#include <cassert>
#include <cstdint>

#include "builder/encode/block_batches.h"

// Vectors without a compile-time size cannot be members of the structs below.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bc1/bc1_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bc1/bc1_cluster_fit-inl.h"
#include "builder/encode/bc1/bc1_fit-inl.h"
#include "builder/encode/bc1/bc1_kernel-inl.h"

// The method, for as many blocks at once as a vector has float lanes:
//   1. Centre the texels on their rounded mean: sums stay small integers, which floats add exactly.
//   2. Start on the principal axis (power iteration on the covariance), end points at or inside the extreme projections.
//   3. Refine: give each texel the nearest of the four positions on the line, solve least squares for the end points, round each
//      channel's pair jointly to 5 or 6 bits. Keep the best of all passes.
//   4. Where one colour for the whole block is better (or the block is flat), take it from the table of best pairs.
//   5. Put color0 above color1, which is what selects the four-colour mode.
// No fused multiply-add and no approximate reciprocal, so that all targets round alike.
HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

template <Quality quality>
HWY_INLINE Choice fit(const Moments& moments, const Texels& texels) {
  if constexpr (quality == Quality::kFast) return line_or_single_color(fit_once(moments, texels), moments, texels);
  const Candidate line = fit_lines(moments, texels);
  const Choice choice = line_or_single_color(line, moments, texels);
  if constexpr (quality == Quality::kNormal) return choice;
  return best_of(choice, cluster_fit(line, moments, texels), moments, texels);
}

template <class Layout, std::size_t block_bytes, Quality quality>
void encode_at(const BlockImage& image) {
  for_each_batch<kMaxLanes, Layout::kTexelBytes, block_bytes>(image, [](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    Texels texels;
    const Moments moments = load_centred<Layout>(rows, pitch, texels);
    // The colours are the last 8 bytes of a block.
    store_blocks<block_bytes>(fit<quality>(moments, texels), blocks + block_bytes - 8);
  });
}

template <class Layout, std::size_t block_bytes>
void encode(const BlockImage& image) {
  switch (image.quality) {
    case Quality::kFast:
      return encode_at<Layout, block_bytes, Quality::kFast>(image);
    case Quality::kNormal:
      return encode_at<Layout, block_bytes, Quality::kNormal>(image);
    case Quality::kBest:
      return encode_at<Layout, block_bytes, Quality::kBest>(image);
  }
}

void encode_rgb(const BlockImage& image) { encode<Rgb8, 8>(image); }
void encode_rgbx(const BlockImage& image) { encode<Rgbx8, 8>(image); }
void encode_bc3_color_halves(const BlockImage& image) { encode<Rgba8, 16>(image); }

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_rgb);
HWY_EXPORT(encode_rgbx);
HWY_EXPORT(encode_bc3_color_halves);

void encode_bc1_image(std::span<const std::byte> rgb, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                      std::size_t bytes_per_texel, Quality quality, std::span<std::byte> blocks) {
  assert(bytes_per_texel == 3 || bytes_per_texel == 4);
  const BlockImage image = block_image(rgb, width, height, row_pitch_bytes, bytes_per_texel, quality, blocks, 8);
  if (width == 0 || height == 0) return;
  if (bytes_per_texel == 3) {
    HWY_DYNAMIC_DISPATCH(encode_rgb)(image);
  } else {
    HWY_DYNAMIC_DISPATCH(encode_rgbx)(image);
  }
}

void encode_bc3_color(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  const BlockImage image = block_image(rgba, width, height, row_pitch_bytes, 4, quality, blocks, 16);
  if (width == 0 || height == 0) return;
  HWY_DYNAMIC_DISPATCH(encode_bc3_color_halves)(image);
}

}  // namespace vt::encode
#endif  // HWY_ONCE
