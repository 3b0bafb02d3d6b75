// What a person writes where rasters are wanted: a file, a folder of them, or a list in a text file. A mosaic
// of ten thousand files is named in one word.
#pragma once

#include <filesystem>
#include <vector>

#include "store/result.h"

namespace vt::pipeline {

// The files that `input` names, relative to `base` where it is relative:
// - `@FILE`: a text file with one file or folder a line, in its order, relative to the text file's own
// folder; blank lines and lines that
//   begin with # are passed over;
// - a folder: the rasters in it, known by their suffix, sorted by name; folders inside it are not entered.
// Rasters of formats that are not
//   read are among them, so that they are refused by name and not left out;
// - anything else: itself, whether it is there or not.
// kIo: a folder or a list cannot be read. kInvalidData: there is no raster in it.
[[nodiscard]] Result<std::vector<std::filesystem::path>> expand_input(const std::filesystem::path& input,
                                                                      const std::filesystem::path& base = {});

}  // namespace vt::pipeline
