// The cascade of channels whose levels are weighted sums of planes, with planes of least and greatest values beside them.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/pyramid/cascade.h"

namespace vt::pyramid {

class PlaneCascade final : public Cascade {
 public:
  // levels[0].active is not empty. `rules` and `weight_plane` are the codec's. Tiles of carry are 2^tile_exponent texels a side.
  PlaneCascade(std::vector<BlockLevel> levels, int outputs, std::span<const channels::PlaneRule> rules, int weight_plane,
               const HalvingKernel& kernel, int tile_exponent);

  [[nodiscard]] channels::PlaneRow begin_row() override;
  void end_row(bool opaque, RowSink& sink) override;
  [[nodiscard]] Result<void> feed_carry(const CarryTiles& carry, RowSink& sink) override;
  void carry_bytes(std::vector<std::byte>& out) const override;

 private:
  static constexpr std::int64_t kPad = 32;  // texels without data on either side of a row, for taps that reach outside the data

  struct LevelState {
    BlockLevel plan;
    bool clipped_x = false;  // taps of the next level reach past the data's west or east edge
    std::int64_t stride = 0;
    std::int64_t next_row = 0;      // the row that is written next
    std::int64_t next_emitted = 0;  // the row that is passed on next
    std::vector<float> ring;
    std::vector<std::uint8_t> opaque;  // per ring row
  };

  [[nodiscard]] static float neutral(channels::PlaneRule rule);
  [[nodiscard]] float* row_at(LevelState& level, std::int64_t y, int plane);
  [[nodiscard]] const float* row_or_nothing(LevelState& level, std::int64_t y, int plane);
  [[nodiscard]] channels::ConstPlaneRow planes_at(LevelState& level, std::int64_t y, std::int64_t x);
  void emit_rows(int k, RowSink& sink);
  void keep_carry_row(std::int64_t y, const channels::ConstPlaneRow& row);
  void make_coarser_rows(int k, RowSink& sink);
  void halve_into(LevelState& fine, LevelState& coarse);
  void halve_plane(LevelState& fine, std::int64_t first, std::int64_t start, int plane, std::int64_t count, float* out);
  void limit_to_neighbours(LevelState& fine, std::int64_t y, const TexelRect& active, bool opaque, const channels::PlaneRow& out);

  HalvingKernel kernel_;
  std::vector<channels::PlaneRule> rules_;
  int planes_;
  int weight_plane_;
  int tile_exponent_;
  std::int64_t ring_rows_;
  std::vector<LevelState> state_;
  std::vector<float> nothing_;  // for each plane, a row without data
  std::int64_t widest_ = 0;
  std::vector<float> combined_;
  std::vector<float> scratch_;
  std::vector<float> carry_;       // the tile that is left, plane after plane
  std::vector<float> carry_read_;  // tiles that are fed
};

}  // namespace vt::pyramid
