// vtinspect extract: a window of one level as a picture or a georeferenced GeoTIFF, or all levels of a layer
// on one sheet.
//
// Where there are no data, in a tile or where none is, a reader of the GeoTIFF sees:
//   color         coverage 0 in the fourth band; a fourth band is added where tiles of an opaque layer are absent. (Inside the tiles of an
//                 opaque layer there is no such place.)
//   elevation     GDAL_NODATA, the source's number, or NaN where that number is also a height of this level; the fill height where voids
//                 are filled
//   normal, horizon, sensor   GDAL_NODATA NaN. (Block formats have no code for it: inside their tiles such texels show their neighbours.)
//   material      GDAL_NODATA, the class that stands for no data; shares of classes are 0
//   illumination  no light, and coverage 0 in the fourth band where there is one
//   mask          0: where nothing is known nothing is inside
//
// Streams bands of rows, so memory does not grow with the height of the window.
#pragma once

#include <filesystem>
#include <string>

#include "store/result.h"
#include "tools/cli/cli_support.h"
#include "tools/vtinspect/layer_values.h"

namespace vt::inspect {

struct ExtractOptions {
  std::filesystem::path store;
  std::filesystem::path output;  // .png, .exr or .tif
  LayerChoice choice;
  std::string window;   // "X,Y,W,H" in the level's data rectangle; "" means all of it
  bool mosaic = false;  // all levels on one sheet
  cli::ProgressMode progress = cli::ProgressMode::kAuto;
};

[[nodiscard]] Result<int> run_extract(const ExtractOptions& options);

}  // namespace vt::inspect
