#include "builder/pipeline/passes/surface_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/pipeline/parallel/parallel.h"
#include "builder/pipeline/passes/tile_pass.h"

namespace vt::pipeline {
namespace {

// One tile of the finest level is compared at a time; a row of tiles looks into two of a coarser level, and
// steps from one column to the next.
std::size_t tiles_kept(const LayerInfo& layer, Level level) {
  constexpr std::int64_t kOfCoarserLevel = 4;
  const TexelRect tiles = layer.tile_rect(level);
  return level == layer.finest ? 1 : static_cast<std::size_t>(std::min(kOfCoarserLevel, tiles.width * tiles.height));
}

// Heights of a few tiles of one level at a time, as somebody sees them who walks along a row of tiles.
class HeightRows {
 public:
  HeightRows(const store::StoreWriter& writer, const LayerInfo& layer, LayerId id, Level level)
      : writer_(writer), layer_(layer), id_(id), level_(level), most_kept_(tiles_kept(layer, level)) {}

  // Heights x0 to x1 (inclusive) of row y; NaN where there are none. Inside the data, but x may count on past
  // the edges of a closed layer.
  [[nodiscard]] Result<void> read(std::int64_t y, std::int64_t x0, std::int64_t x1, std::vector<double>& out) {
    const std::int64_t edge = layer_.tile_texels();
    const ComponentRange& range = layer_.components[0];
    out.clear();
    for (const pyramid::WrappedPart& part : pyramid::wrapped_parts({x0, y, x1 - x0 + 1, 1}, layer_.data_rect(level_)))
      for (std::int64_t x = part.rect.x; x < part.rect.right();) {
        const std::int64_t column = x >> layer_.tile_exponent;
        const std::int64_t end = std::min(part.rect.right(), (column + 1) * edge);
        VT_ASSIGN(const std::vector<float>* samples,
                  tile({level_, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(y >> layer_.tile_exponent)}));
        for (; x < end; ++x) {
          const float sample = samples->empty() ? kVoid : (*samples)[static_cast<std::size_t>((y & (edge - 1)) * edge + (x & (edge - 1)))];
          const bool is_void = samples->empty() || (layer_.zero_is_nodata && sample == 0.0F);
          out.push_back(is_void ? std::numeric_limits<double>::quiet_NaN() : range.offset + range.scale * static_cast<double>(sample));
        }
      }
    return {};
  }

 private:
  static constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

  struct Kept {
    TileId tile;
    std::vector<float> samples;
  };

  [[nodiscard]] Result<const std::vector<float>*> tile(const TileId& wanted) {
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.tile == wanted; });
    if (found != kept_.end()) {
      std::rotate(kept_.begin(), found, found + 1);  // the last used comes first
    } else {
      Kept kept{.tile = wanted, .samples = {}};
      if (kept_.size() == most_kept_) {
        kept.samples = std::move(kept_.back().samples);
        kept_.pop_back();
      }
      VT_ASSIGN([[maybe_unused]] const bool is_there, read_samples(writer_, layer_, id_, wanted, kept.samples));
      kept_.insert(kept_.begin(), std::move(kept));
    }
    return &kept_.front().samples;
  }

  const store::StoreWriter& writer_;
  const LayerInfo& layer_;
  LayerId id_;
  Level level_;
  std::size_t most_kept_;
  std::vector<Kept> kept_;
};

// Where a finest texel lies among a level's heights, along one axis.
struct Place {
  std::int64_t lower;
  std::int64_t upper;
  double fraction;  // of the way from lower to upper
};

double texels_at(std::int64_t texel, int steps, bool is_point) {
  const double scale = std::ldexp(1.0, -steps);
  return is_point ? static_cast<double>(texel) * scale : (static_cast<double>(texel) + 0.5) * scale - 0.5;
}

Place place_of(std::int64_t texel, int steps, bool is_point, std::int64_t first, std::int64_t last) {
  const double at = texels_at(texel, steps, is_point);
  const double inside = std::clamp(at, static_cast<double>(first), static_cast<double>(last));
  const auto lower = static_cast<std::int64_t>(std::floor(inside));
  return {lower, std::min(lower + 1, last), inside - static_cast<double>(lower)};
}

// The same among the columns of a closed layer, of which there are `count`, the finest level's `width` texels
// around the globe. Columns count on past the edges; from the last to the first it may be less than a texel.
Place place_on_circle(std::int64_t texel, int steps, bool is_point, std::int64_t count, std::int64_t width) {
  const double at = texels_at(texel, steps, is_point);
  const auto last = static_cast<double>(count - 1);
  const double gap = std::ldexp(static_cast<double>(width), -steps) - last;
  if (at > last) return {count - 1, count, (at - last) / gap};
  if (at >= 0.0) return {static_cast<std::int64_t>(at), static_cast<std::int64_t>(at) + 1, at - std::floor(at)};
  if (at >= -gap) return {-1, 0, 1.0 + at / gap};
  return {-2, -1, 1.0 + at + gap};
}

double between(double a, double b, double fraction) { return fraction == 0.0 ? a : a + fraction * (b - a); }

// One row of finest tiles against one coarser level.
class LevelSurface {
 public:
  LevelSurface(const store::StoreWriter& writer, const LayerPlan& plan, LayerId id, int steps)
      : steps_(steps),
        is_point_(plan.kernel.is_point),
        is_closed_(plan.is_closed),
        width_(plan.info.data.width),
        data_(plan.info.data_rect(Level{static_cast<std::uint8_t>(plan.info.finest.value - steps)})),
        rows_(writer, plan.info, id, Level{static_cast<std::uint8_t>(plan.info.finest.value - steps)}) {}

  // `heights` of finest row y from column x on.
  [[nodiscard]] Result<void> compare(std::int64_t y, std::int64_t x, std::span<const double> heights, channels::ErrorSum& error) {
    const auto column = [&](std::size_t i) {
      const std::int64_t texel = x + static_cast<std::int64_t>(i);
      return is_closed_ ? place_on_circle(texel, steps_, is_point_, data_.width, width_)
                        : place_of(texel, steps_, is_point_, data_.x, data_.right() - 1);
    };
    const Place row = place_of(y, steps_, is_point_, data_.y, data_.bottom() - 1);
    const std::int64_t first = column(0).lower;
    const std::int64_t last = column(heights.size() - 1).upper;
    VT_CHECK(rows_.read(row.lower, first, last, lower_));
    VT_CHECK(rows_.read(row.upper, first, last, upper_));
    for (std::size_t i = 0; i < lower_.size(); ++i) lower_[i] = between(lower_[i], upper_[i], row.fraction);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const Place at = column(i);
      const double surface =
          between(lower_[static_cast<std::size_t>(at.lower - first)], lower_[static_cast<std::size_t>(at.upper - first)], at.fraction);
      const double difference = heights[i] - surface;
      if (!std::isnan(difference)) error.add(difference);
    }
    return {};
  }

 private:
  int steps_;
  bool is_point_;
  bool is_closed_;
  std::int64_t width_;
  TexelRect data_;
  HeightRows rows_;
  std::vector<double> lower_;
  std::vector<double> upper_;
};

}  // namespace

std::size_t surface_thread_bytes(const LayerPlan& plan) {
  if (!plan.codec->measures_surface()) return 0;
  const std::size_t edge = plan.info.tile_texels();
  std::size_t tiles = 0;
  for (int level = 0; level <= plan.info.finest.value; ++level) tiles += tiles_kept(plan.info, Level{static_cast<std::uint8_t>(level)});
  const std::size_t rows = 2 * (static_cast<std::size_t>(plan.info.finest.value) + 1) * edge * sizeof(double);
  return tiles * edge * edge * sizeof(float) + rows + 2 * plan.info.tile_payload_bytes();  // as stored and decompressed
}

Result<std::vector<LevelQuality>> measure_surface(const store::StoreWriter& writer, const LayerPlan& plan, const BuiltLayer& layer,
                                                  int threads, const std::atomic<bool>* cancel) {
  std::vector<LevelQuality> quality;
  if (!plan.codec->measures_surface()) return quality;
  const LayerInfo& info = plan.info;
  const LayerId id = layer.ids.texture();
  const auto levels = static_cast<std::size_t>(info.finest.value);
  const TexelRect data = info.data_rect(info.finest);
  const auto tile_rows = static_cast<std::size_t>(info.tile_rect(info.finest).height);
  std::vector<LevelErrors> of_rows(tile_rows, LevelErrors(levels));
  const auto measure_row = [&](std::size_t tile_row) -> Result<void> {
    HeightRows finest(writer, info, id, info.finest);
    std::vector<LevelSurface> surfaces;
    for (std::size_t steps = 1; steps <= levels; ++steps) surfaces.emplace_back(writer, plan, id, static_cast<int>(steps));
    std::vector<double> heights;
    const TexelRect tiles = info.tile_rect(info.finest);
    for (std::int64_t column = tiles.x; column < tiles.right(); ++column) {
      if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return fail(ErrorCode::kCancelled, "stopped");
      const TileId tile{info.finest, static_cast<std::uint32_t>(column),
                        static_cast<std::uint32_t>(tiles.y + static_cast<std::int64_t>(tile_row))};
      if (!writer.contains(id, tile)) continue;
      const TexelRect rect = intersect(rect_of(tile, info.tile_exponent), data);
      for (std::int64_t y = rect.y; y < rect.bottom(); ++y) {
        VT_CHECK(finest.read(y, rect.x, rect.right() - 1, heights));
        for (std::size_t k = 0; k < levels; ++k) VT_CHECK(surfaces[k].compare(y, rect.x, heights, of_rows[tile_row][k]));
      }
    }
    return {};
  };
  VT_CHECK(for_each_index(tile_rows, threads, measure_row));
  for (std::size_t k = 0; k < levels; ++k) {
    LevelQuality level{.level = Level{static_cast<std::uint8_t>(info.finest.value - 1 - static_cast<int>(k))}, .errors = LevelErrors(1)};
    for (const LevelErrors& row : of_rows) level.errors[0] += row[k];
    quality.push_back(std::move(level));
  }
  return quality;
}

}  // namespace vt::pipeline
