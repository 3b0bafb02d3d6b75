// What a user asks for: one layer, its sources and its settings. Plain values, as the command line or a scene
// description give them.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_settings.h"
#include "builder/encode/quality.h"
#include "builder/geo/crs.h"
#include "builder/resample/grid/placed_source.h"
#include "builder/source/sample_type.h"
#include "store/channel.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/texel_format.h"

namespace vt::pipeline {

// What says how much of a sample is covered by data.
struct CoverageChoice {
  enum class Kind : std::uint8_t {
    kAuto,  // what the file declares: a mask, or an alpha band (one that is named among the bands, when bands are named)
    kNone,  // nothing: every sample is wholly covered
    kBand,  // this band
  };
  Kind kind = Kind::kAuto;
  int band = 0;  // of kBand, counted from 1
  [[nodiscard]] bool operator==(const CoverageChoice&) const = default;
};
// "auto", "none" or a band's number. kUsage.
[[nodiscard]] Result<CoverageChoice> coverage_choice_from(std::string_view text);

struct SourceRequest {
  std::filesystem::path path;
  std::optional<geo::Crs> crs;           // whatever the file says
  std::optional<geo::Crs> stated_crs;    // of a file that declares none; one that declares another is refused
  std::optional<geo::Crs> fallback_crs;  // of a file that declares none; one that declares another keeps it
  std::optional<Area> extent;            // outer edges in CRS units, for pictures that carry none; west > east across the antimeridian
  std::vector<double> nodata;            // one value for all bands, or one for each band that is read; empty: what the file says
  std::vector<int> bands;                // counted from 1, in the order red, green, blue (or the one value); empty: the file's own order
  CoverageChoice coverage;
};

// What the samples of sources that are not there yet will be like: enough to plan with.
struct ExpectedSamples {
  SampleType type = SampleType::kUint8;
  int bands = 3;  // of values
  bool has_alpha = false;
  std::optional<double> nodata;
};

struct LayerRequest {
  std::string name;
  ChannelType channel = ChannelType::kColor;
  std::vector<SourceRequest> sources;                  // later ones lie over earlier ones
  std::optional<TexelFormat> format;                   // default: the channel's, with coverage when the source has it
  channels::Options options;                           // of the channel, see builder/channels/codec/channel_options.h
  std::string kernel;                                  // "": the channel's own, see layer_kernel.h
  encode::Quality quality = encode::Quality::kNormal;  // of block compression
  std::string compression = "zstd:3";
  int tile_texels = 256;
  std::optional<double> gsd_m;  // metres per texel of the finest level (of the grid if projected, on the ground if in degrees); default:
                                // the first source's own grid
  std::optional<geo::Crs> crs;  // of the dataset; default: the store's, or the first source's
  std::optional<Area> area;     // outer edges of the layer in CRS units, widened to whole texels; west > east across the antimeridian;
                                // default: all that the sources cover
  std::optional<std::array<double, 2>> range;  // sample values of black and white
  std::optional<resample::Method> resample;    // of sources on another grid; default: bilinear, of classes nearest
  std::optional<ExpectedSamples> expected;     // for a plan without sources
};

// kUsage: the range does not go upwards. Stores that were built before this was refused are updated all the
// same.
[[nodiscard]] Result<void> check_range(const LayerRequest& request);

}  // namespace vt::pipeline
