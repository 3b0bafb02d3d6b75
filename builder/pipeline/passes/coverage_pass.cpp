#include "builder/pipeline/passes/coverage_pass.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "builder/encode/tile_band.h"
#include "builder/pipeline/blocks/put_tile.h"
#include "builder/pipeline/passes/tile_pass.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kMeanCodes = 65536;
constexpr double kFullMean = 65535.0;
constexpr std::size_t kMeanPart = 1;

// The least of the codes 0 to `full` that exceeds the reference.
double first_code_above(double reference, int full) { return std::floor(reference * full) + 1.0; }

class CoveragePass {
 public:
  CoveragePass(store::StoreWriter& writer, const LayerPlan& plan, const BuiltLayer& layer, int threads, const std::atomic<bool>* cancel,
               TileCounts& counts)
      : writer_(writer),
        plan_(plan),
        ids_(layer.ids),
        threads_(threads),
        cancel_(cancel),
        counts_(counts),
        reference_(*plan.codec->kept_above()) {}

  [[nodiscard]] Result<nlohmann::ordered_json> run() {
    VT_ASSIGN(const std::uint64_t base_texels, texels_above(plan_.info.finest));
    const double share = static_cast<double>(base_texels) / texels_of(plan_.info.finest);
    nlohmann::ordered_json chosen;
    chosen["above"] = reference_;
    chosen["share"] = share;
    for (int value = plan_.info.finest.value - 1; value >= 0; --value) {
      const Level level{static_cast<std::uint8_t>(value)};
      VT_ASSIGN(const std::vector<std::uint64_t> histogram, histogram_of(level));
      // What blocks are made of has 16 bits, what they decode to is worth 8.
      const CoverageScale scale =
          choose_coverage_scale(histogram, share * texels_of(level), reference_, greatest_code(format_info(plan_.info.format).samples));
      VT_CHECK(write_level(level, scale.scale));
      // What blocks make of the texels beside the reference cannot be foreseen.
      VT_ASSIGN(const std::uint64_t texels, texels_above(level));
      nlohmann::ordered_json row;
      row["level"] = value;
      row["scale"] = scale.scale;
      row["share"] = static_cast<double>(texels) / texels_of(level);
      chosen["levels"].push_back(std::move(row));
    }
    return chosen;
  }

 private:
  [[nodiscard]] double texels_of(Level level) const {
    const TexelRect data = plan_.info.data_rect(level);
    return static_cast<double>(data.width) * static_cast<double>(data.height);
  }

  // As a program that tests the stored texels sees it.
  [[nodiscard]] Result<std::uint64_t> texels_above(Level level) const {
    std::atomic<std::uint64_t> above{0};
    const double scale = plan_.info.components[0].scale;
    const auto count = [&](std::size_t, const TileId& tile) -> Result<void> {
      std::vector<float> samples;
      VT_ASSIGN(const bool is_there, read_samples(writer_, plan_.info, ids_.texture(), tile, samples));
      if (!is_there) return {};
      std::uint64_t found = 0;
      for_data_texels(tile, [&](std::size_t at) { found += scale * static_cast<double>(samples[at]) > reference_ ? 1 : 0; });
      above += found;
      return {};
    };
    VT_CHECK(for_each_tile(plan_.info, level, threads_, cancel_, count));
    return above.load();
  }

  [[nodiscard]] Result<std::vector<std::uint64_t>> histogram_of(Level level) const {
    std::vector<std::uint64_t> histogram(kMeanCodes, 0);
    std::mutex mutex;  // guards histogram
    const auto count = [&](std::size_t, const TileId& tile) -> Result<void> {
      std::vector<std::uint16_t> means;
      VT_ASSIGN(const bool is_there, read_means(tile, means));
      if (!is_there) return {};
      const std::lock_guard lock(mutex);
      for_data_texels(tile, [&](std::size_t at) { ++histogram[means[at]]; });
      return {};
    };
    VT_CHECK(for_each_tile(plan_.info, level, threads_, cancel_, count));
    return histogram;
  }

  [[nodiscard]] Result<void> write_level(Level level, double scale) {
    std::mutex mutex;  // guards counts_
    return for_each_tile(plan_.info, level, threads_, cancel_, [&](std::size_t, const TileId& tile) -> Result<void> {
      TileCounts counts;
      VT_CHECK(write_tile(tile, scale, counts));
      const std::lock_guard lock(mutex);
      counts_ += counts;
      return {};
    });
  }

  [[nodiscard]] Result<void> write_tile(const TileId& tile, double scale, TileCounts& counts) const {
    std::vector<std::uint16_t> means;
    VT_ASSIGN(const bool is_there, read_means(tile, means));
    if (!is_there) return put_tile(writer_, ids_.texture(), {.tile = tile, .is_empty = true, .constant_block = {}, .payload = {}}, counts);

    const auto edge = static_cast<std::int64_t>(plan_.info.tile_texels());
    const TexelRect rect = rect_of(tile, plan_.info.tile_exponent);
    const TexelRect data = intersect(rect, plan_.info.data_rect(tile.level));
    encode::TileBand band(plan_.parts[0], *plan_.codec, 0, plan_.compression, plan_.request.quality, tile.level, data, nullptr);
    // One texel of room at either end, as RowNeighbourhood promises.
    // In 255ths, as the codec's planes have them.
    std::vector<float> shares(static_cast<std::size_t>(data.width) + 2, 0.0F);
    const std::vector<float> weights(shares.size(), 1.0F);
    channels::ConstPlaneRow planes{};
    planes[0] = shares.data() + 1;
    planes[1] = weights.data() + 1;
    for (std::int64_t y = data.y; y < data.bottom(); ++y) {
      const std::uint16_t* const row = means.data() + (y - rect.y) * edge + (data.x - rect.x);
      for (std::int64_t x = 0; x < data.width; ++x)
        shares[static_cast<std::size_t>(x) + 1] = static_cast<float>(255.0 * std::min(1.0, scale * (row[x] / kFullMean)));
      VT_CHECK(band.add_row(y, {planes, planes, planes, true}));
      VT_CHECK(band.take_finished([&](const encode::EncodedTile& encoded) { return put_tile(writer_, ids_.texture(), encoded, counts); }));
    }
    return {};
  }

  // false: there is no such tile.
  [[nodiscard]] Result<bool> read_means(const TileId& tile, std::vector<std::uint16_t>& means) const {
    std::vector<float> samples;
    VT_ASSIGN(const bool is_there, read_samples(writer_, plan_.parts[kMeanPart], ids_.parts[kMeanPart], tile, samples));
    means.assign(samples.begin(), samples.end());
    return is_there;
  }

  // Calls use(index in the tile) for the texels of a tile that lie inside the data.
  template <class Use>
  void for_data_texels(const TileId& tile, const Use& use) const {
    const TexelRect rect = rect_of(tile, plan_.info.tile_exponent);
    const TexelRect data = intersect(rect, plan_.info.data_rect(tile.level));
    for (std::int64_t y = data.y; y < data.bottom(); ++y)
      for (std::int64_t x = data.x; x < data.right(); ++x)
        use(static_cast<std::size_t>((y - rect.y) * static_cast<std::int64_t>(plan_.info.tile_texels()) + (x - rect.x)));
  }

  store::StoreWriter& writer_;
  const LayerPlan& plan_;
  const LayerIds& ids_;
  int threads_;
  const std::atomic<bool>* cancel_;
  TileCounts& counts_;
  double reference_;
};

}  // namespace

CoverageScale choose_coverage_scale(std::span<const std::uint64_t> histogram, double wanted_texels, double reference, int full) {
  // A mean m, as a share, becomes a code above the reference when scale * m * full rounds to `first` at
  // least.
  const double needed = (first_code_above(reference, full) - 0.5) / full;
  const auto first_mean_above = [&](double scale) { return std::ceil(needed / scale * kFullMean); };

  // What the plain means give, then every other threshold: all means from `threshold` on are above.
  const double plain_threshold = first_mean_above(1.0);
  CoverageScale best;
  for (std::size_t mean = histogram.size() - 1; static_cast<double>(mean) >= plain_threshold; --mean)
    best.reached_texels += histogram[mean];
  double best_miss = std::abs(static_cast<double>(best.reached_texels) - wanted_texels);
  std::uint64_t above = 0;
  for (std::size_t threshold = histogram.size() - 1; threshold >= 1; --threshold) {
    above += histogram[threshold];
    const double miss = std::abs(static_cast<double>(above) - wanted_texels);
    if (!(miss < best_miss)) continue;
    best_miss = miss;
    // The threshold's mean is above and the next lower one is not: the scale that puts the reference half way
    // between them.
    best = {.scale = needed * kFullMean / (static_cast<double>(threshold) - 0.5), .reached_texels = above};
  }
  return best;
}

Result<nlohmann::ordered_json> keep_coverage(store::StoreWriter& writer, const LayerPlan& plan, const BuiltLayer& layer, int threads,
                                             const std::atomic<bool>* cancel, TileCounts& counts) {
  if (!plan.codec->kept_above()) return nlohmann::ordered_json{};
  return CoveragePass(writer, plan, layer, threads, cancel, counts).run();
}

}  // namespace vt::pipeline
