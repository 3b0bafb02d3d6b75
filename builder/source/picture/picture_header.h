// What the header of a picture claims and says besides its samples, read before any decoder is started:
// OpenImageIO takes memory for what a header claims, and does not tell what it leaves unused. Each format
// parses as much as that needs. Any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

struct PictureFormat;  // picture_format.h

struct PictureHeader {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int channels = 0;
  std::uint64_t least_file_bytes = 0;  // no file of this format that holds such a picture is shorter
  // What the decoder does not give as it is in the file: codes whose largest is no 255 or 65535 come as if it
  // were ("codes of 12 bits", "" for others), and signed ones wrong.
  std::string expanded_codes;
  bool is_signed = false;
  bool alpha_is_straight = false;  // the file says that colours are not multiplied by their coverage, in a way the decoder does not tell
  int orientation = 1;             // as TIFF tag 274 counts: 1 is upright
  std::string orientation_source;  // "the Exif data"
  std::optional<Window> display;   // OpenEXR: what is shown, in samples of the picture; absent when it is the picture itself
  std::string place_problem;       // the file says where it lies, in a way that is not read
  std::vector<UnusedFact> unused;
};

// kInvalidData: damaged, or shorter than the picture that it claims can be; the message says both sizes.
[[nodiscard]] Result<PictureHeader> read_picture_header(const FileBytes& file, const PictureFormat& format);

}  // namespace vt::source
