// Writes a frame as a picture file. The only part of vtrender that sees OpenImageIO.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "store/result.h"

namespace vt::tools {

// `rgba` as glReadPixels gives it: rows from the bottom. The suffix of `path` chooses the format; alpha is dropped.
[[nodiscard]] Result<void> write_picture(const std::filesystem::path& path, int width, int height, std::span<const std::uint8_t> rgba);

}  // namespace vt::tools
