// From what a user asks for to what will be built: the layer's grid, its levels, its sources in their places.
// Nothing is written here.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/pipeline/plan/source_load.h"
#include "builder/pipeline/plan/tiers.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/pyramid/layer_shape.h"
#include "builder/resample/base_sampler.h"
#include "store/codec/codec.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::pipeline {

// What an existing store already fixes.
struct DatasetFrame {
  geo::Crs crs;
  std::optional<Area> area;
  // The area of layers that are planned for the same new store: those after them lie over them, in the same
  // turn round the globe.
  std::optional<Area> planned = std::nullopt;
  std::map<std::string, LayerInfo> layers = {};  // its textures, by name
};

struct LayerPlan {
  LayerRequest request;
  LayerInfo info;                // as it goes into the store: the layer itself, which is the first of its parts
  std::vector<LayerInfo> parts;  // all of them, see channels::Part; the same place and size, formats of their own
  geo::Crs crs;
  bool is_closed = false;  // the data rectangle is the whole circle of longitudes: its columns go on from the last to the first
  pyramid::HalvingKernel kernel;
  resample::Method resampling = resample::Method::kBilinear;
  store::Compression compression;
  std::shared_ptr<const channels::ChannelCodec> codec;   // of the first source; all write the same texels
  std::shared_ptr<const resample::BaseSampler> sampler;  // null: planned without sources
  SourceLoad source_load;
  TexelRect covered;                // texels that the sources can touch, counted from the data rectangle's corner
  nlohmann::ordered_json settings;  // everything that decides the layer's bytes: two runs with equal settings may share work
  nlohmann::ordered_json recipe;    // how it was asked for, for the layer's metadata; decides nothing. null: not kept
  std::vector<std::string> warnings;

  [[nodiscard]] const channels::Part& part(std::size_t i) const { return codec->parts()[i]; }
  [[nodiscard]] Area extent() const;  // of the data rectangle, CRS units
  [[nodiscard]] pyramid::LayerShape shape() const { return {.data = info.data, .is_closed = is_closed}; }
};

// Areas of classes are counted in 1 / 2^area_exponent of a texel of the finest level: 0, unless texels may
// lie over many samples.
[[nodiscard]] int area_exponent(const LayerPlan& plan);

struct PlanOptions {
  bool may_lack_sources = false;  // a layer that says what to expect is planned even if its sources are not there; it cannot be built
  std::size_t source_cache_bytes = std::size_t{32} << 20;  // decoded source blocks kept, all sources together
  const LayerInfo* existing = nullptr;  // the layer is there: its grid, its size, its scale of light and what it calls "no data" are taken
  int threads = 0;                      // that open sources; 0: as many as the machine has
  std::filesystem::path
      scratch_folder;  // where decoded samples of sources without tiles wait, see builder/source/cells/cell_store.h; empty: none
};

// Opens the sources. Errors name the file and say which option helps.
[[nodiscard]] Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame,
                                           const PlanOptions& options);
[[nodiscard]] inline Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame,
                                                  std::size_t source_cache_bytes) {
  return plan_layer(request, frame, PlanOptions{.source_cache_bytes = source_cache_bytes});
}

}  // namespace vt::pipeline
