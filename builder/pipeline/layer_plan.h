// From what a user asks for to what will be built: the layer's grid, its levels, how the work is cut, what it costs. Nothing is written
// here.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/resample/base_sampler.h"
#include "store/codec.h"
#include "store/layer.h"
#include "store/result.h"

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

// What an existing store already fixes.
struct DatasetFrame {
  geo::Crs crs;
  std::optional<Area> area;
};

struct LayerPlan {
  LayerRequest request;
  LayerInfo info;  // as it goes into the store
  geo::Crs crs;
  pyramid::HalvingKernel kernel;
  store::Compression compression;
  std::shared_ptr<const resample::BaseSampler> sampler;
  nlohmann::ordered_json settings;  // everything that decides the layer's bytes: two runs with equal settings may share work
  std::vector<std::string> warnings;

  [[nodiscard]] Area extent() const;  // of the data rectangle, CRS units
};

// Opens the sources. Errors name the file and say which option helps. `source_cache_bytes`: decoded source blocks kept, all sources
// together.
[[nodiscard]] Result<LayerPlan> plan_layer(const LayerRequest& request, const std::optional<DatasetFrame>& frame,
                                           std::size_t source_cache_bytes);

// One pass over the pyramid: blocks of the base level, each filtered through `outputs` levels, and the level above them kept as carry for
// the next tier.
struct Tier {
  Level base;
  int outputs = 1;
  bool has_carry = false;
  TexelRect data;                 // of the base level
  std::int64_t block_texels = 0;  // along one edge of a block, base level
  std::int64_t first_column = 0;  // of blocks
  std::int64_t first_row = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;

  [[nodiscard]] std::int64_t blocks() const { return columns * rows; }
  // Block `index` counts along rows, north to south. Unclipped.
  [[nodiscard]] TexelRect block(std::int64_t index) const;
  // The tile of the carry level that a block is responsible for.
  [[nodiscard]] TileId carry_tile(std::int64_t index) const;
  // The block that is responsible for a carry tile.
  [[nodiscard]] std::int64_t block_of_carry(TileId tile) const;
};

// A block spans 2^levels tiles along an edge, so one carry tile each.
[[nodiscard]] std::vector<Tier> plan_tiers(const LayerInfo& info, int levels);

// Resident bytes that one worker needs for a block of that size.
[[nodiscard]] std::size_t worker_bytes(const LayerPlan& plan, int levels);

// The largest block (2^levels tiles) that fits `threads` workers into `memory_bytes`, at most 4096 texels wide. kUsage when not even the
// smallest does.
[[nodiscard]] Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes);

// Figures for --dry-run.
struct PlanCost {
  std::uint64_t texels = 0;  // of all levels, data only
  std::uint64_t tiles = 0;
  std::uint64_t raw_bytes = 0;
};
[[nodiscard]] PlanCost plan_cost(const LayerInfo& info);

}  // namespace vt::pipeline
