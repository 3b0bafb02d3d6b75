#include "builder/encode/bc4/bc4_encoder.h"

#include <cstdint>

#include "builder/encode/block_batches.h"

// Vectors without a compile-time size cannot be members of structs.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/encode/bc4/bc4_encoder.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "builder/encode/bc4/bc4_kernel-inl.h"
#include "builder/encode/bc4/bc4_refine-inl.h"
#include "builder/encode/bc4/bc4_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {

template <Quality quality>
HWY_INLINE Ends fit(const Texels& texels) {
  if constexpr (quality == Quality::kFast) return fit_extremes(texels);
  const Ends refined_ends = fit_least_squares(texels);
  if constexpr (quality == Quality::kNormal) return refined_ends;
  return search(refined_ends, texels);
}

// One batch: `rows` four rows of texels, `pitch` apart.
struct R16 {
  static constexpr std::size_t kTexelBytes = 2;
  static constexpr std::size_t kBlockBytes = 8;
  template <Quality quality>
  static HWY_INLINE void encode(const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    Texels r;
    load_r16(rows, pitch, r);
    store_blocks<kBlockBytes>(fit<quality>(r), r, blocks);
  }
};

struct Rg16 {
  static constexpr std::size_t kTexelBytes = 4;
  static constexpr std::size_t kBlockBytes = 16;
  template <Quality quality>
  static HWY_INLINE void encode(const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    Texels channels[2];
    load_rg16(rows, pitch, channels[0], channels[1]);
    for (std::size_t c = 0; c < 2; ++c) store_blocks<kBlockBytes>(fit<quality>(channels[c]), channels[c], blocks + c * 8);
  }
};

struct Alpha8 {
  static constexpr std::size_t kTexelBytes = 4;
  static constexpr std::size_t kBlockBytes = 16;
  template <Quality quality>
  static HWY_INLINE void encode(const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) {
    Texels a;
    load_alpha8(rows, pitch, a);
    store_blocks<kBlockBytes>(fit<quality>(a), a, blocks);
  }
};

template <class Layout, Quality quality>
void encode_at(const BlockImage& image) {
  for_each_batch<kMaxLanes, Layout::kTexelBytes, Layout::kBlockBytes>(
      image,
      [](const std::uint8_t* rows, std::size_t pitch, std::uint8_t* blocks) { Layout::template encode<quality>(rows, pitch, blocks); });
}

template <class Layout>
void encode(const BlockImage& image) {
  switch (image.quality) {
    case Quality::kFast:
      return encode_at<Layout, Quality::kFast>(image);
    case Quality::kNormal:
      return encode_at<Layout, Quality::kNormal>(image);
    case Quality::kBest:
      return encode_at<Layout, Quality::kBest>(image);
  }
}

void encode_r16(const BlockImage& image) { encode<R16>(image); }
void encode_rg16(const BlockImage& image) { encode<Rg16>(image); }
void encode_alpha8(const BlockImage& image) { encode<Alpha8>(image); }

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::encode {

HWY_EXPORT(encode_r16);
HWY_EXPORT(encode_rg16);
HWY_EXPORT(encode_alpha8);

void encode_bc4_image(std::span<const std::byte> r16, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  const BlockImage image = block_image(r16, width, height, row_pitch_bytes, 2, quality, blocks, 8);
  if (width != 0 && height != 0) HWY_DYNAMIC_DISPATCH(encode_r16)(image);
}

void encode_bc5_image(std::span<const std::byte> rg16, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  const BlockImage image = block_image(rg16, width, height, row_pitch_bytes, 4, quality, blocks, 16);
  if (width != 0 && height != 0) HWY_DYNAMIC_DISPATCH(encode_rg16)(image);
}

void encode_bc3_alpha(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  const BlockImage image = block_image(rgba, width, height, row_pitch_bytes, 4, quality, blocks, 16);
  if (width != 0 && height != 0) HWY_DYNAMIC_DISPATCH(encode_alpha8)(image);
}

}  // namespace vt::encode
#endif  // HWY_ONCE
