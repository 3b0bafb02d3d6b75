// From filtered rows to stored tiles: what a block's cascade gives goes into bands of tiles, one for each
// part of each level, and from there through the encoders into the store. On the way what is stored is
// measured against the planes, and what it cannot say is counted. One object a block; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/encode/reference_rows.h"
#include "builder/encode/tile_band.h"
#include "builder/pipeline/blocks/block_quality.h"
#include "builder/pipeline/blocks/build_stats.h"
#include "builder/pipeline/blocks/put_tile.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pipeline/plan/tiers.h"
#include "builder/pyramid/cascade.h"
#include "store/store_writer.h"

namespace vt::pipeline {

struct LayerIds {
  std::vector<LayerId> parts;  // as plan.parts
  LayerId carry;               // meaningful when a tier has carry
  LayerId marks;
  LayerId quality;

  [[nodiscard]] LayerId texture() const { return parts.front(); }
};

// Where the tiles go. All of it outlives the output.
struct TileTarget {
  const LayerPlan& plan;
  const LayerIds& ids;
  store::StoreWriter& writer;
  TileCounts& counts;
  StageClock& clock;
};

class TileOutput final : public pyramid::RowSink {
 public:
  TileOutput(const TileTarget& to, const Tier& tier, const pyramid::Cascade& cascade);

  // ---- From the cascade ----

  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override;

  // ---- From feed_rows(): rows of the base whose bytes are those of the sources, for the first part ----

  bool expect_texels(std::int64_t y);
  void texels(std::int64_t y, const std::byte* texels, const channels::ConstPlaneRow& planes, bool opaque);

  // ---- When all rows have come ----

  // The first error; rows after it are passed over.
  [[nodiscard]] const Result<void>& status() const { return status_; }
  // What was measured of all tiles of the block: for each level the sums over its parts.
  [[nodiscard]] BlockQuality quality() const;

 private:
  [[nodiscard]] encode::TileBand& band_of(int k, std::size_t part) { return bands_[static_cast<std::size_t>(k) * parts_ + part]; }
  void add_row(encode::TileBand& band, std::size_t part, std::int64_t y, const channels::RowNeighbourhood& rows);
  void store_finished(encode::TileBand& band, std::size_t part);

  TileTarget to_;
  std::size_t parts_;
  TexelRect base_core_;
  LossCounts losses_;                              // of the base, when it is the finest level
  std::vector<bool> has_base_texels_;              // by row of the core
  std::vector<encode::ReferenceRows> references_;  // by level, for the bands of all parts
  std::vector<encode::TileBand> bands_;            // the parts of the base, those of the next coarser level, ...
  Result<void> status_;
};

}  // namespace vt::pipeline
