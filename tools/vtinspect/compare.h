// vtinspect compare: two stores layer by layer and tile by tile, or a layer's finest level with a raster
// file, in what the channel means; JSON in schemas/vtinspect-compare.schema.json.
#pragma once

#include <filesystem>
#include <string>

#include "store/result.h"
#include "tools/cli/cli_support.h"

namespace vt::inspect {

struct CompareOptions {
  std::filesystem::path first;
  std::filesystem::path second;  // a store, by its suffix .vts or its first bytes, or a raster that vtbuild reads
  std::string layer;             // "" means all texture layers
  bool all = false;              // carry layers too
  double tolerance = 0.0;        // greatest absolute error that still counts as the same, in codes or in the layer's unit
  bool json = false;
  cli::ProgressMode progress = cli::ProgressMode::kAuto;
};

// 0 when equal or within the tolerance, 3 when they differ.
[[nodiscard]] Result<int> run_compare(const CompareOptions& options);

}  // namespace vt::inspect
