// A small file that is read whole: a scene, a list, a table. Any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "store/result.h"

namespace vt::text {

// kIo: it cannot be read, is a folder, a pipe or a device (which might have no end, or never begin), or is
// longer than `most_bytes`. The message names the file.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path, std::size_t most_bytes);

}  // namespace vt::text
