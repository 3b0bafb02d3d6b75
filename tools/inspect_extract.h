// vtinspect extract: a window of one level as a picture or a georeferenced GeoTIFF, or all levels of a layer on one sheet.
// Streams bands of rows, so memory does not grow with the height of the window.
#pragma once

#include <filesystem>
#include <string>

#include "store/result.h"
#include "tools/cli_support.h"
#include "tools/inspect_common.h"

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
