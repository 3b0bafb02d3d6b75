// Which blocks of a plan there is anything to do for, and which blocks of the next tier depend on them. A
// dataset may be a few islands in a million by a million texels: what is found here is in proportion to the
// data, not to the grid. Immutable after construction; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pyramid/cascade.h"

namespace vt::pipeline {

class WorkMap {
 public:
  // `plan` outlives the map.
  WorkMap(const LayerPlan& plan, int block_levels);

  [[nodiscard]] const std::vector<Tier>& tiers() const { return tiers_; }
  // The block's levels, as it filters them.
  [[nodiscard]] std::vector<pyramid::BlockLevel> plan_block(std::size_t tier, std::int64_t index) const;
  // The block's texels and its apron, on the tier's base level: inside the data, but columns of a closed
  // layer may count on past the edges.
  [[nodiscard]] TexelRect active(std::size_t tier, std::int64_t index) const;
  // Some source may have data under the block or its apron. Blocks that are not touched have no tiles and no
  // carry.
  [[nodiscard]] bool is_touched(std::size_t tier, std::int64_t index) const;
  // All of them, ascending.
  [[nodiscard]] std::vector<std::int64_t> touched(std::size_t tier) const;
  // Blocks of the next tier that read the carry of this one.
  [[nodiscard]] std::vector<std::int64_t> dependents(std::size_t tier, std::int64_t index) const;
  // Texels of the tier's base level that the block is responsible for: the measure of its work.
  [[nodiscard]] std::uint64_t core_texels(std::size_t tier, std::int64_t index) const;

 private:
  [[nodiscard]] std::int64_t seam_apron(std::size_t tier) const;
  [[nodiscard]] std::vector<TexelRect> seen(std::size_t tier, std::int64_t index) const;
  void collect(std::size_t tier, const TexelRect& blocks, std::size_t wanted, std::vector<std::int64_t>& out) const;

  const LayerPlan& plan_;
  std::vector<Tier> tiers_;
  std::vector<std::int64_t> aprons_;  // of each tier, base texels
};

}  // namespace vt::pipeline
