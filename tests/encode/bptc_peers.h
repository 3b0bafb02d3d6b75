// Decoders of BC7 and unsigned BC6H that others wrote: the OpenGL driver (Mesa's software one where there is no GPU), and OpenImageIO's
// reader of DDS files. An image is `width` x `height` texels, multiples of 4, of blocks in rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vt::encode {

enum class BptcFormat { kBc7, kBc6hUnsigned };

// RGBA, 4 floats a texel; values of BC7 are 0 to 1. Empty when this machine has no OpenGL context or the driver no BPTC; `why` says which.
[[nodiscard]] std::optional<std::vector<float>> decoded_by_opengl(BptcFormat format, std::span<const std::byte> blocks, std::size_t width,
                                                                  std::size_t height, std::string& why);

// The same through a file in `folder` with a DX10 header. Channels of BC6H: 3 in the file, alpha 1 here.
[[nodiscard]] std::optional<std::vector<float>> decoded_by_openimageio(BptcFormat format, std::span<const std::byte> blocks,
                                                                       std::size_t width, std::size_t height, const std::string& folder,
                                                                       std::string& why);

}  // namespace vt::encode
