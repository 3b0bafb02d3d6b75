#include "builder/source/picture/picture_header.h"

#include <fmt/format.h>

#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {

Result<PictureHeader> read_picture_header(const FileBytes& file, const PictureFormat& format) {
  VT_ASSIGN(PictureHeader header, format.read_header(HeaderBytes(file)));
  if (header.width < 1 || header.height < 1)
    return fail(ErrorCode::kInvalidData, fmt::format("{}: claims to be a picture of {} x {}, which is none; the file is damaged",
                                                     file.path().string(), header.width, header.height));
  if (header.least_file_bytes > file.size())
    return fail(
        ErrorCode::kInvalidData,
        fmt::format("{}: claims to be a picture of {} x {} with {} channels, which takes at least {} bytes in this format; the file has "
                    "{} and is damaged or incomplete",
                    file.path().string(), header.width, header.height, header.channels, header.least_file_bytes, file.size()));
  return header;
}

}  // namespace vt::source
