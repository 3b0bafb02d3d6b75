// Colour information that a file carries and that is not used: colours are taken for sRGB, whatever a file
// says. Private to this folder.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "builder/source/metadata/tiff_tags.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

// `what` with its article: "a gamma of 0.5".
[[nodiscard]] UnusedFact unused_color(const std::string& what);
[[nodiscard]] UnusedFact unused_inks();
// Nothing for a profile that says sRGB.
void note_profile(std::span<const std::byte> profile, std::vector<UnusedFact>& unused);
// x and y of white, red, green and blue. Nothing when they are those of sRGB. `name` is what the file calls
// them.
void note_primaries(const std::array<double, 8>& xy, const std::string& name, std::vector<UnusedFact>& unused);
// kIo, kInvalidData: a tag cannot be had.
[[nodiscard]] Result<void> note_tiff_colors(const TiffTags& tags, std::vector<UnusedFact>& unused);

}  // namespace vt::source
