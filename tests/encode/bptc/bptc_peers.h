// BC7 and unsigned BC6H decoded by OpenImageIO's reader of DDS files: an independent decoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vt::encode {

enum class BptcFormat { kBc7, kBc6hUnsigned };

// RGBA, 4 floats a texel, values of BC7 0 to 1 and alpha of BC6H 1, of `width` x `height` texels (multiples
// of 4) of blocks in rows. Goes through a file in `folder` with a DX10 header. Empty when OpenImageIO refuses
// it; `why` says how.
[[nodiscard]] std::optional<std::vector<float>> decoded_by_openimageio(BptcFormat format, std::span<const std::byte> blocks,
                                                                       std::size_t width, std::size_t height, const std::string& folder,
                                                                       std::string& why);

}  // namespace vt::encode
