// The cascade of channels whose levels are weighted sums of planes, with planes of least and greatest values
// beside them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "builder/pyramid/cascade.h"
#include "builder/pyramid/edge_centres.h"
#include "builder/pyramid/halve_planes.h"
#include "builder/pyramid/plane_rows.h"

namespace vt::pyramid {

// How the planes of a codec become those of a coarser level.
struct PlaneMeaning {
  std::span<const channels::PlaneRule> rules;
  int weight_plane = 0;
  std::optional<channels::CentreRange> centre_range = {};
};

class PlaneCascade final : public Cascade {
 public:
  // levels[0].active is not empty; they are levels of `layer`. Tiles of carry are 2^tile_exponent texels a
  // side.
  PlaneCascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs, const PlaneMeaning& planes,
               const HalvingKernel& kernel, int tile_exponent);

  [[nodiscard]] channels::PlaneRow begin_row() override { return rows_[0].begin_row(); }
  void end_row(bool opaque, RowSink& sink) override;
  // Not for layers of planes.
  void put_area_row(std::span<const channels::ClassAreaBlock* const> areas, std::int64_t row, RowSink& sink) override;
  [[nodiscard]] Result<void> feed_carry(const CarryTiles& carry, RowSink& sink) override;
  void carry_bytes(std::vector<std::byte>& out) const override;

 private:
  [[nodiscard]] PlaneRows& rows(int k) { return rows_[static_cast<std::size_t>(k)]; }
  void row_is_written(int k, RowSink& sink);
  void emit_rows(int k, RowSink& sink);
  void keep_carry_row(std::int64_t y, const channels::ConstPlaneRow& row);

  LayerShape layer_;
  std::vector<channels::PlaneRule> rules_;
  int weight_plane_;
  std::optional<EdgeCentres> centres_;
  int tile_exponent_;
  std::vector<PlaneRows> rows_;             // by level
  std::vector<std::int64_t> next_emitted_;  // by level: the row that is passed on next
  std::optional<PlaneHalver> halver_;
  std::vector<float> at_centres_;  // a row of one plane
  std::vector<float> carry_;       // the tile that is left, plane after plane
  std::vector<float> carry_read_;  // tiles that are fed
};

}  // namespace vt::pyramid
