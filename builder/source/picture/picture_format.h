// The formats that OpenImageIO decodes for us, one file each: PNG in png.cpp and so on. Constant data.
#pragma once

#include "builder/source/picture/picture_header.h"
#include "store/result.h"

namespace vt::source {

class HeaderBytes;  // header_bytes.h

struct PictureFormat {
  const char* reader;  // what OpenImageIO calls its reader of it
  // What a header claims, before any decoder is started. kInvalidData: damaged.
  Result<PictureHeader> (*read_header)(const HeaderBytes& file);
  bool has_rows_in_any_order = false;  // most formats decode from the top only
};

extern const PictureFormat kPngFormat;
extern const PictureFormat kJpegFormat;
extern const PictureFormat kJpeg2000Format;
extern const PictureFormat kOpenExrFormat;
extern const PictureFormat kRadianceFormat;
extern const PictureFormat kPnmFormat;

}  // namespace vt::source
