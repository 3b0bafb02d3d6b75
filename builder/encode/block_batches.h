// Walks an image in rows of 4x4 blocks and hands them out in batches of one block per SIMD lane. The last
// blocks of a row go through a padded copy, so that a batch encoder reads and writes whole batches only and
// never past the image. No allocation.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// An image and where its blocks go. Views of the caller's buffers.
struct BlockImage {
  const std::uint8_t* texels;
  std::size_t width, height, pitch;
  Quality quality;
  std::uint8_t* blocks;
};

// Checks the shapes that every block encoder promises to its callers.
inline BlockImage block_image(std::span<const std::byte> texels, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                              std::size_t texel_bytes, Quality quality, std::span<std::byte> blocks, std::size_t block_bytes) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(row_pitch_bytes >= width * texel_bytes);
  assert(width == 0 || height == 0 || texels.size() >= (height - 1) * row_pitch_bytes + width * texel_bytes);
  assert(blocks.size() == width / 4 * (height / 4) * block_bytes);
  static_cast<void>(texel_bytes);
  static_cast<void>(block_bytes);
  return {.texels = reinterpret_cast<const std::uint8_t*>(texels.data()),
          .width = width,
          .height = height,
          .pitch = row_pitch_bytes,
          .quality = quality,
          .blocks = reinterpret_cast<std::uint8_t*>(blocks.data())};
}

// `encode_batch(rows, pitch, out)` reads four rows of `lanes` * 4 texels of `texel_bytes`, and writes
// `block_bytes` per block, or only a part of them.
template <std::size_t lanes, std::size_t texel_bytes, std::size_t block_bytes, class EncodeBatch>
void for_each_batch(const BlockImage& image, const EncodeBatch& encode_batch) {
  constexpr std::size_t kBlockRowBytes = 4 * texel_bytes;
  constexpr std::size_t kBatchRowBytes = lanes * kBlockRowBytes;
  const std::size_t blocks_across = image.width / 4;
  for (std::size_t y = 0; y < image.height; y += 4) {
    const std::uint8_t* rows = image.texels + y * image.pitch;
    std::uint8_t* out = image.blocks + y / 4 * blocks_across * block_bytes;
    std::size_t x = 0;
    for (; x + lanes <= blocks_across; x += lanes) encode_batch(rows + x * kBlockRowBytes, image.pitch, out + x * block_bytes);
    if (x == blocks_across) continue;

    // The rest of the row, in a batch with idle lanes.
    const std::size_t rest = blocks_across - x;
    std::array<std::uint8_t, 4 * kBatchRowBytes> padded{};
    std::array<std::uint8_t, lanes * block_bytes> padded_out;
    for (std::size_t row = 0; row < 4; ++row)
      std::memcpy(padded.data() + row * kBatchRowBytes, rows + row * image.pitch + x * kBlockRowBytes, rest * kBlockRowBytes);
    // What the batch leaves alone keeps its bytes.
    std::memcpy(padded_out.data(), out + x * block_bytes, rest * block_bytes);
    encode_batch(padded.data(), kBatchRowBytes, padded_out.data());
    std::memcpy(out + x * block_bytes, padded_out.data(), rest * block_bytes);
  }
}

}  // namespace vt::encode
