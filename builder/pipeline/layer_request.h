// What a user asks for: one layer, its sources and its settings. Plain values, as the command line or a scene description give them.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "store/channel.h"
#include "store/layer.h"
#include "store/texel_format.h"

namespace vt::pipeline {

struct SourceRequest {
  std::filesystem::path path;
  std::optional<geo::Crs> crs;           // whatever the file says
  std::optional<geo::Crs> fallback_crs;  // when the file says nothing
  std::optional<Area> extent;            // outer edges in CRS units, for pictures that carry none
  std::optional<double> nodata;
  std::vector<int> bands;  // counted from 1, in the order red, green, blue (or the one value); empty: the file's own order
};

struct LayerRequest {
  std::string name;
  ChannelType channel = ChannelType::kColor;
  std::vector<SourceRequest> sources;  // later ones lie over earlier ones
  std::optional<TexelFormat> format;   // default: the channel's, with coverage when the source has it
  std::string kernel;                  // "" = kaiser3 for colour, box for elevation
  std::string compression = "zstd:3";
  int tile_texels = 256;
  std::optional<double> gsd_m;  // metres per texel of the finest level (of the grid if projected, on the ground if in degrees); default:
                                // the first source's own grid
  std::optional<geo::Crs> crs;  // of the dataset; default: the store's, or the first source's
  std::optional<std::array<double, 2>> range;  // sample values of black and white
};

}  // namespace vt::pipeline
