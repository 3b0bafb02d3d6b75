#include "builder/pyramid/class_cascade.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <string>

#include "builder/pyramid/class_carry.h"

namespace vt::pyramid {

using channels::ConstPlaneRow;
using channels::PlaneRow;

ClassCascade::ClassCascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs, const channels::ClassCounting& classes,
                           int tile_exponent, int area_exponent)
    : Cascade(std::move(levels), outputs),
      layer_(layer),
      classes_(classes),
      planes_(channels::class_planes(classes.ranked)),
      tile_exponent_(tile_exponent),
      base_has_counts_(area_exponent > 0) {
  assert(level_count() > 0 && !level(0).active.empty());
  std::int64_t widest = 0;
  for (int k = 0; k < level_count(); ++k) {
    LevelState state;
    state.plan = level(k);
    state.texel_area = std::uint64_t{1} << (2 * state.plan.depth + area_exponent);
    state.stride = state.plan.active.width + 2 * kPad;
    state.next_row = state.plan.active.y;
    state.next_emitted = state.plan.core.y;
    if (k < outputs) state.ring.assign(static_cast<std::size_t>(kRingRows * planes_ * state.stride), 0.0F);
    widest = std::max({widest, state.stride, state.plan.beyond.width});
    state_.push_back(std::move(state));
  }
  nothing_.assign(static_cast<std::size_t>(widest), 0.0F);
  no_counts_ = CountRow::nothing(widest);
  if (has_carry()) {
    // A texel without classes is one byte of 0.
    const std::int64_t edge = std::int64_t{1} << tile_exponent;
    carry_.assign(static_cast<std::size_t>((level(outputs).core.y & (edge - 1)) * edge), std::byte{0});
  }
}

PlaneRow ClassCascade::row_at(LevelState& level, std::int64_t y) {
  const std::int64_t slot = (y - level.plan.active.y) % kRingRows;
  PlaneRow row{};
  for (int p = 0; p < planes_; ++p) row[static_cast<std::size_t>(p)] = level.ring.data() + (slot * planes_ + p) * level.stride + kPad;
  return row;
}

ConstPlaneRow ClassCascade::row_or_nothing(LevelState& level, std::int64_t y, std::int64_t x) {
  const TexelRect& active = level.plan.active;
  const bool is_there = has_row(level, y);
  const PlaneRow there = is_there ? row_at(level, y) : PlaneRow{};
  ConstPlaneRow row{};
  for (std::size_t p = 0; p < static_cast<std::size_t>(planes_); ++p)
    row[p] = (is_there ? there[p] : nothing_.data() + kPad) + (x - active.x);
  return row;
}

PlaneRow ClassCascade::begin_row() {
  assert(state_[0].next_row < level(0).active.bottom());
  return row_at(state_[0], state_[0].next_row);
}

void ClassCascade::end_row(bool opaque, RowSink& sink) {
  const std::int64_t y = state_[0].next_row;
  const PlaneRow row = row_at(state_[0], y);
  check_classes(row, y, opaque);
  if (base_has_counts_) {
    CountRow& counts = state_[0].counts[static_cast<std::size_t>(y & 1)];
    const std::int64_t width = level(0).active.width;
    counts.begin(static_cast<std::size_t>(width));
    for (std::int64_t i = 0; i < width; ++i) {
      if (row[channels::kClassWeightPlane][i] > 0.0F) counts.add(class_count(static_cast<std::uint32_t>(row[0][i]), state_[0].texel_area));
      counts.end_texel();
    }
    counts.finish();
  }
  row_is_written(0, opaque, sink);
}

void ClassCascade::put_area_row(std::span<const channels::ClassAreaBlock* const> areas, std::int64_t row, RowSink& sink) {
  assert(base_has_counts_);
  LevelState& base = state_[0];
  const std::int64_t y = base.next_row;
  std::int64_t x = level(0).active.x;
  CountRow& counts = base.counts[static_cast<std::size_t>(y & 1)];
  counts.begin(0);
  std::vector<ClassCount> texel;
  bool all_are_classes = true;
  for (const channels::ClassAreaBlock* const block : areas)
    for (std::int64_t i = 0; i < block->rect().width; ++i, ++x) {
      const std::span<const channels::ClassArea> classes = block->at(block->rect().x + i, block->rect().y + row);
      for (const channels::ClassArea& one : classes) {
        if (is_class(one.id)) continue;
        refuse(one.id, x, y);
        all_are_classes = false;
      }
      texel.clear();
      if (all_are_classes) count_areas(classes, base.texel_area, texel);
      counts.append(texel);
      counts.end_texel();
    }
  assert(x == level(0).active.right());
  counts.finish();
  row_is_written(0, rank_classes(counts, base.texel_area, classes_.ranked, row_at(base, y)), sink);
}

bool ClassCascade::is_class(float id) const {
  return id >= 0.0F && id <= static_cast<float>(classes_.greatest) && id == std::trunc(id) && id != static_cast<float>(classes_.no_data);
}

void ClassCascade::check_classes(const PlaneRow& row, std::int64_t y, bool& opaque) {
  const std::int64_t width = level(0).active.width;
  const float* const classes = row[0];
  const float* const weights = row[channels::kClassWeightPlane];
  const auto greatest = static_cast<float>(classes_.greatest);
  const auto no_data = static_cast<float>(classes_.no_data);
  constexpr auto beyond = static_cast<float>(channels::kGreatestClass + 1);
  const auto is_wrong = [&](std::int64_t i) {
    return (static_cast<int>(!(classes[i] >= 0.0F)) | static_cast<int>(!(classes[i] <= greatest)) |
            static_cast<int>(classes[i] != static_cast<float>(static_cast<std::int32_t>(std::clamp(classes[i], -1.0F, beyond)))) |
            (static_cast<int>(classes[i] == no_data) & static_cast<int>(weights[i] > 0.0F))) != 0;
  };
  int wrong = 0;
  for (std::int64_t i = 0; i < width; ++i) wrong |= static_cast<int>(is_wrong(i));
  if (wrong == 0) return;
  std::int64_t at = 0;
  while (!is_wrong(at)) ++at;
  refuse(classes[at], level(0).active.x + at, y);
  for (int p = 0; p < planes_; ++p) std::fill_n(row[static_cast<std::size_t>(p)], width, 0.0F);
  opaque = false;
}

void ClassCascade::refuse(float id, std::int64_t x, std::int64_t y) {
  if (!status_) return;  // the first is the one to tell
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.9g", static_cast<double>(id));
  std::string message = "texel " + std::to_string(x) + ", " + std::to_string(y) + " of the finest level is class " + number.data();
  if (id != std::trunc(id)) {
    message += ", but classes are whole numbers; is this a raster of classes, and has it been resampled by its nearest samples?";
  } else if (id == static_cast<float>(classes_.no_data)) {
    message += ", which stands for no data in this layer; give it as the source's no-data value, or choose another with no-data-class";
  } else {
    message += "; this layer holds classes 0 to " + std::to_string(classes_.greatest);
    if (id > static_cast<float>(classes_.greatest) && classes_.greatest < 65535) message += ", as r16 it would hold all to 65535";
  }
  status_ = fail(ErrorCode::kInvalidData, message);
}

void ClassCascade::row_is_written(int k, bool opaque, RowSink& sink) {
  LevelState& level = state_[static_cast<std::size_t>(k)];
  level.opaque[static_cast<std::size_t>((level.next_row - level.plan.active.y) % kRingRows)] = opaque;
  ++level.next_row;
  emit_rows(k, sink);
  make_coarser_rows(k, sink);
}

// A row is passed on as soon as the one below it exists.
void ClassCascade::emit_rows(int k, RowSink& sink) {
  LevelState& level = state_[static_cast<std::size_t>(k)];
  const std::int64_t ready = level.next_row == level.plan.active.bottom() ? level.next_row : level.next_row - 1;
  for (; level.next_emitted < std::min(ready, level.plan.core.bottom()); ++level.next_emitted) {
    const std::int64_t y = level.next_emitted;
    const std::int64_t x = level.plan.core.x;
    const bool opaque = level.opaque[static_cast<std::size_t>((y - level.plan.active.y) % kRingRows)];
    sink.row(k, y, {row_or_nothing(level, y - 1, x), row_or_nothing(level, y, x), row_or_nothing(level, y + 1, x), opaque});
  }
}

void ClassCascade::make_coarser_rows(int k, RowSink& sink) {
  if (k + 1 == level_count()) return;
  LevelState& fine = state_[static_cast<std::size_t>(k)];
  LevelState& coarse = state_[static_cast<std::size_t>(k) + 1];
  const BlockLevel& plan = coarse.plan;
  const bool fine_done = fine.next_row == fine.plan.active.bottom();
  while (coarse.next_row < plan.active.bottom() && (fine_done || 2 * coarse.next_row + 1 < fine.next_row)) {
    const std::int64_t y = coarse.next_row;
    CountRow& counts = coarse.counts[static_cast<std::size_t>(y & 1)];
    count_columns(k, y, plan.active, false, counts);
    if (!plan.beyond.empty()) count_columns(k, y, plan.beyond, true, coarse.beyond[static_cast<std::size_t>(y & 1)]);
    close_row(coarse, y);
    if (k + 1 == outputs()) {
      keep_carry_row(y, counts);
      ++coarse.next_row;
    } else {
      row_is_written(k + 1, rank_classes(counts, coarse.texel_area, classes_.ranked, row_at(coarse, y)), sink);
    }
  }
}

// Columns of row `y` of level k + 1; `is_beyond`: those beyond the seam.
void ClassCascade::count_columns(int k, std::int64_t y, const TexelRect& columns, bool is_beyond, CountRow& out) {
  LevelState& fine = state_[static_cast<std::size_t>(k)];
  const BlockLevel& plan = fine.plan;
  const bool from_beyond = is_beyond && !plan.beyond.empty();
  // The other end of a level that wraps follows on the active columns.
  const std::int64_t turn = is_beyond && layer_.wraps_at(plan.depth) ? plan.data.width : 0;
  const std::int64_t column = columns.x == 0 ? turn : 2 * columns.x - turn;
  const std::int64_t start = column - (from_beyond ? plan.beyond.x : plan.active.x);  // may be -1
  if (k > 0 || base_has_counts_) {
    const auto row = [&](std::int64_t v) -> const CountRow& {
      if (!has_row(fine, v)) return no_counts_;
      return (from_beyond ? fine.beyond : fine.counts)[static_cast<std::size_t>(v & 1)];
    };
    add_counts(row(2 * y), row(2 * y + 1), start, columns.width, out);
  } else {
    const ConstPlaneRow upper = row_or_nothing(fine, 2 * y, plan.active.x);
    const ConstPlaneRow lower = row_or_nothing(fine, 2 * y + 1, plan.active.x);
    count_classes({upper[0], upper[channels::kClassWeightPlane]}, {lower[0], lower[channels::kClassWeightPlane]}, start, columns.width,
                  out);
  }
}

// The columns of a closed level that does not wrap go on between two texels: classes are not mixed, so the
// nearer one follows.
void ClassCascade::close_row(LevelState& level, std::int64_t y) {
  const BlockLevel& plan = level.plan;
  if (!layer_.is_closed || layer_.wraps_at(plan.depth) || plan.active.right() != plan.data.width) return;
  CountRow& counts = level.counts[static_cast<std::size_t>(y & 1)];
  const CountRow& beyond = level.beyond[static_cast<std::size_t>(y & 1)];
  const SeamColumn seen = layer_.column_past_edge(plan.depth, plan.data.width);
  const std::int64_t column = seen.share <= 0.5F ? seen.first : seen.second;
  std::span<const ClassCount> found;
  if (column >= plan.active.x && column < plan.active.right())
    found = counts.texel(column - plan.active.x);
  else if (column >= plan.beyond.x && column < plan.beyond.right())
    found = beyond.texel(column - plan.beyond.x);
  const std::vector<ClassCount> classes(found.begin(), found.end());
  counts.put_past_end(classes);
}

void ClassCascade::keep_carry_row(std::int64_t y, const CountRow& row) {
  const TexelRect& core = level(outputs()).core;
  const TexelRect& active = level(outputs()).active;
  if (y < core.y || y >= core.bottom()) return;
  const std::int64_t edge = std::int64_t{1} << tile_exponent_;
  const std::int64_t west = core.x & (edge - 1);
  carry_.insert(carry_.end(), static_cast<std::size_t>(west), std::byte{0});
  for (std::int64_t i = 0; i < core.width; ++i) pack_texel(row.texel(core.x - active.x + i), carry_);
  carry_.insert(carry_.end(), static_cast<std::size_t>(edge - west - core.width), std::byte{0});
}

void ClassCascade::carry_bytes(std::vector<std::byte>& out) const {
  const TexelRect& core = level(outputs()).core;
  const std::int64_t edge = std::int64_t{1} << tile_exponent_;
  out = carry_;
  out.insert(out.end(), static_cast<std::size_t>((edge - (core.y & (edge - 1)) - core.height) * edge), std::byte{0});
}

Result<void> ClassCascade::feed_carry(const CarryTiles& carry, RowSink& sink) {
  base_has_counts_ = true;
  const std::int64_t edge = std::int64_t{1} << tile_exponent_;
  LevelState& base = state_[0];
  const TexelRect& active = base.plan.active;
  std::vector<CountReader> readers;
  for (const std::vector<std::byte>& tile : carry.tiles) readers.emplace_back(tile, classes_, base.texel_area);
  std::vector<CountRow> tile_rows(readers.size());
  std::vector<ClassCount> texel;
  const auto copy = [&](const TexelRect& columns, CountRow& out) {
    out.begin(0);
    for (const WrappedPart& part : wrapped_parts(columns, base.plan.data))
      for (std::int64_t x = part.rect.x; x < part.rect.right(); ++x) {
        const auto tile = std::lower_bound(carry.columns.begin(), carry.columns.end(), x >> tile_exponent_) - carry.columns.begin();
        out.append(tile_rows[static_cast<std::size_t>(tile)].texel(x & (edge - 1)));
        out.end_texel();
      }
    out.finish();
  };
  for (std::int64_t y = carry.row * edge; y < (carry.row + 1) * edge; ++y) {
    for (std::size_t i = 0; i < readers.size(); ++i) {
      tile_rows[i].begin(0);
      for (std::int64_t x = 0; x < edge; ++x) {
        if (carry.tiles[i].empty()) {
          texel.clear();
        } else {
          VT_CHECK(readers[i].read(texel));
        }
        tile_rows[i].append(texel);
        tile_rows[i].end_texel();
      }
      tile_rows[i].finish();
    }
    if (y < active.y || y >= active.bottom()) continue;
    CountRow& counts = base.counts[static_cast<std::size_t>(y & 1)];
    copy(active, counts);
    if (!base.plan.beyond.empty()) copy(base.plan.beyond, base.beyond[static_cast<std::size_t>(y & 1)]);
    close_row(base, y);
    row_is_written(0, rank_classes(counts, base.texel_area, classes_.ranked, row_at(base, y)), sink);
  }
  for (const CountReader& reader : readers)
    if (!reader.at_end()) return fail(ErrorCode::kCorrupt, "a tile of carry of classes: bytes are left after the last texel");
  return {};
}

}  // namespace vt::pyramid
