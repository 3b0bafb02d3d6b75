// The cascade of layers of classes: every level keeps how much of each texel's area each class of the finest
// level holds, and what is stored of a level is derived from these counts alone. The majority of majorities
// would be another class, and would make frequent classes more frequent from level to level. Counts go on
// from tier to tier in full.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "builder/pyramid/cascade.h"
#include "builder/pyramid/class_counts.h"

namespace vt::pyramid {

class ClassCascade final : public Cascade {
 public:
  // levels[0].active is not empty; they are levels of `layer`. Tiles of carry are 2^tile_exponent texels a
  // side. The planes are those of channels/class_planes.h. Areas are counted in parts of 1 / 2^area_exponent
  // of a texel of the finest level: 0 where each of these is of one class.
  ClassCascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs, const channels::ClassCounting& classes,
               int tile_exponent, int area_exponent = 0);

  [[nodiscard]] channels::PlaneRow begin_row() override;
  void end_row(bool opaque, RowSink& sink) override;
  void put_area_row(std::span<const channels::ClassAreaBlock* const> areas, std::int64_t row, RowSink& sink) override;
  // kInvalidData: a row held a class that the layer does not have; the message says which, where, and what
  // helps. Its data are not counted.
  [[nodiscard]] Result<void> status() const override { return status_; }
  [[nodiscard]] Result<void> feed_carry(const CarryTiles& carry, RowSink& sink) override;
  void carry_bytes(std::vector<std::byte>& out) const override;

 private:
  static constexpr std::int64_t kPad = 1;       // a texel without data on either side of a row
  static constexpr std::int64_t kRingRows = 4;  // a row, its neighbours, and the one that is being written

  struct LevelState {
    BlockLevel plan;
    std::uint64_t texel_area = 1;  // of a texel, in the parts that are counted
    std::int64_t stride = 0;
    std::int64_t next_row = 0;      // the row that is written next
    std::int64_t next_emitted = 0;  // the row that is passed on next
    std::vector<float> ring;        // none of the level that is carry
    std::array<bool, kRingRows> opaque{};
    // Counts of the last even and the last odd row; none for a base whose texels are of one class.
    std::array<CountRow, 2> counts;
    std::array<CountRow, 2> beyond;  // likewise of the columns beyond the seam
  };

  [[nodiscard]] channels::PlaneRow row_at(LevelState& level, std::int64_t y);
  [[nodiscard]] channels::ConstPlaneRow row_or_nothing(LevelState& level, std::int64_t y, std::int64_t x);
  [[nodiscard]] static bool has_row(const LevelState& level, std::int64_t y) {
    return y >= level.plan.active.y && y < level.plan.active.bottom();
  }
  void count_columns(int k, std::int64_t y, const TexelRect& columns, bool is_beyond, CountRow& out);
  void close_row(LevelState& level, std::int64_t y);
  void check_classes(const channels::PlaneRow& row, std::int64_t y, bool& opaque);
  [[nodiscard]] bool is_class(float id) const;
  void refuse(float id, std::int64_t x, std::int64_t y);
  void row_is_written(int k, bool opaque, RowSink& sink);
  void emit_rows(int k, RowSink& sink);
  void make_coarser_rows(int k, RowSink& sink);
  void keep_carry_row(std::int64_t y, const CountRow& row);

  LayerShape layer_;
  channels::ClassCounting classes_;
  int planes_;
  int tile_exponent_;
  bool base_has_counts_ = false;  // it came as carry, or its texels may be of several classes
  std::vector<LevelState> state_;
  std::vector<float> nothing_;  // a row without data, for any plane
  CountRow no_counts_;
  std::vector<std::byte> carry_;  // the rows that are finished, packed
  Result<void> status_;
};

}  // namespace vt::pyramid
