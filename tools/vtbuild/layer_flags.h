// The flags of `vtbuild layer` that say what a layer is, and the request that they make. Older stores
// remember these flags, so they stay readable (recipe.h). One thread.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"

namespace vt::tools {

struct LayerFlags {
  std::vector<std::string> inputs;
  std::string output;
  std::string channel;
  std::string name;
  std::string kernel;
  std::string format;
  std::string quality = "normal";
  std::string compression = "zstd:3";
  int tile = 256;
  double gsd = 0.0;
  std::string crs;
  std::string source_crs;
  std::string extent;
  std::string bands;
  std::string range;
  std::string nodata;
  std::string alpha;
  std::string area;
  std::string resample;
  channels::Options options;

  void add_to(CLI::App& command);
};

// What the flags ask for, with inputs and files as they were typed: see
// builder/pipeline/request/expand_request.h. kUsage.
[[nodiscard]] Result<pipeline::LayerRequest> asked_request(const LayerFlags& flags);

}  // namespace vt::tools
