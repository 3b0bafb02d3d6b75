// What kernels make of the edges of the data, of holes in them and of the seam of a closed layer, held to
// independent definitions in double precision.
#include "builder/pyramid/halve_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/pyramid/cascade_fixture.h"

namespace vt::pyramid {
namespace {

constexpr int kHalvedPlanes = 2;  // a value and the weight
constexpr int kWeight = 1;

const test::PlaneRules& halved_rules() {
  static const test::PlaneRules made = test::PlaneRules::linear(kHalvedPlanes);
  return made;
}

// `value` and `weight` of texels.
test::WholeImage image_of(const LayerShape& layer, const std::function<double(std::int64_t, std::int64_t)>& value,
                          const std::function<double(std::int64_t, std::int64_t)>& weight) {
  test::WholeImage image(layer, 0, kHalvedPlanes);
  for (std::int64_t y = image.data.y; y < image.data.bottom(); ++y)
    for (std::int64_t x = image.data.x; x < image.data.right(); ++x) {
      image.at(x, y, kWeight) = static_cast<float>(weight(x, y));
      image.at(x, y, 0) = image.at(x, y, kWeight) * static_cast<float>(value(x, y));
    }
  return image;
}

double opaque(std::int64_t, std::int64_t) { return 1.0; }

std::function<double(std::int64_t, std::int64_t)> noise(unsigned seed) {
  return [seed](std::int64_t x, std::int64_t y) {
    std::mt19937 random(static_cast<unsigned>(x * 7919 + y * 104729) + seed);
    return std::uniform_real_distribution<double>(0.1, 1.0)(random);
  };
}

// Round and ragged areas with data, and edges that cover a texel partly where `soft`.
std::function<double(std::int64_t, std::int64_t)> blobs(unsigned seed, std::int64_t size, bool soft) {
  struct Blob {
    double x, y, radius;
  };
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.0, static_cast<double>(size));
  std::vector<Blob> made;
  for (int i = 0; i < 12; ++i) made.push_back({place(random), place(random), 1.0 + place(random) / 7.0});
  return [made, soft](std::int64_t x, std::int64_t y) {
    double inside = -1e9;
    for (const Blob& blob : made)
      inside = std::max(inside, blob.radius - std::hypot(static_cast<double>(x) - blob.x, static_cast<double>(y) - blob.y));
    return soft ? std::clamp(inside + 0.5, 0.0, 1.0) : inside > 0.0 ? 1.0 : 0.0;
  };
}

double sum_of(const test::WholeImage& image, int plane) {
  double sum = 0.0;
  for (std::int64_t y = image.data.y; y < image.data.bottom(); ++y)
    for (std::int64_t x = image.data.x; x < image.data.right(); ++x) sum += static_cast<double>(image.get(x, y, plane));
  return sum;
}

std::vector<HalvingKernel> means() {
  std::vector<HalvingKernel> kernels;
  for (const HalvingKernel& kernel : all_kernels())
    if (!kernel.is_point) kernels.push_back(kernel);
  return kernels;
}

// Coverage and light of all levels are those of the finest: of opaque images, of holes of every shape, of odd
// sizes, with all light in a frame at the edge and with light that changes from texel to texel.
TEST(HalvePlanes, NoLevelGainsOrLosesCoverageOrLight) {
  const auto frame = [](const TexelRect& data) {
    return [data](std::int64_t x, std::int64_t y) {
      const std::int64_t edge = std::min({x - data.x, y - data.y, data.right() - 1 - x, data.bottom() - 1 - y});
      return edge < 3 ? 1.0 : 0.01;
    };
  };
  for (const HalvingKernel& kernel : means())
    for (const TexelRect data : {TexelRect{0, 0, 64, 64}, TexelRect{0, 0, 97, 61}, TexelRect{5, 11, 50, 33}, TexelRect{0, 0, 1, 45}}) {
      const std::int64_t size = std::max(data.right(), data.bottom());
      for (const auto& weight : {std::function(opaque), blobs(1, size, false), blobs(2, size, true), noise(3)})
        for (const auto& value : {noise(4), std::function<double(std::int64_t, std::int64_t)>(frame(data))}) {
          const test::WholeImage base = image_of({.data = data}, value, weight);
          const Levels levels = levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()});
          for (std::size_t k = 1; k < levels.size(); ++k)
            for (int p = 0; p < kHalvedPlanes; ++p) {
              const double wanted = sum_of(base, p);
              // Two passes a level round by 2^-24 of what they hold, at random.
              ASSERT_NEAR(sum_of(levels[k], p) * std::exp2(2.0 * static_cast<double>(k)), wanted, 1e-5 * wanted)
                  << kernel.name << ", " << data.width << " x " << data.height << ", level " << k << ", plane " << p;
            }
        }
    }
}

// How much of a texel's area has data does not depend on the kernel, and is never more than 1.
TEST(HalvePlanes, CoverageIsTheAreaWithData) {
  for (const HalvingKernel& kernel : means())
    for (const TexelRect data : {TexelRect{0, 0, 64, 48}, TexelRect{0, 0, 51, 61}}) {
      const test::WholeImage base = image_of({.data = data}, noise(1), blobs(7, 60, true));
      const Levels levels = levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()});
      for (int k = 1; k < static_cast<int>(levels.size()); ++k) {
        const test::WholeImage& level = levels[static_cast<std::size_t>(k)];
        for (std::int64_t y = 0; y < level.data.height; ++y)
          for (std::int64_t x = 0; x < level.data.width; ++x) {
            double area = 0.0;
            for (std::int64_t v = y << k; v < (y + 1) << k; ++v)
              for (std::int64_t u = x << k; u < (x + 1) << k; ++u) area += static_cast<double>(base.get(u, v, kWeight));
            ASSERT_NEAR(level.get(x, y, kWeight), area * std::exp2(-2 * k), 1e-6) << kernel.name << " level " << k;
            ASSERT_LE(level.get(x, y, kWeight), 1.0F);
          }
      }
    }
}

// Opaque data of even size stay opaque to the last texel, and a constant stays a constant whatever is
// missing.
TEST(HalvePlanes, AConstantStaysConstantWhateverIsMissing) {
  for (const HalvingKernel& kernel : means())
    for (const auto& weight : {std::function(opaque), blobs(3, 80, false), blobs(4, 80, true), noise(9)}) {
      const test::WholeImage base = image_of(
          {.data = {0, 0, 80, 61}}, [](std::int64_t, std::int64_t) { return 0.3; }, weight);
      for (const test::WholeImage& level : levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()}))
        for (std::int64_t y = 0; y < level.data.height; ++y)
          for (std::int64_t x = 0; x < level.data.width; ++x) {
            const float w = level.get(x, y, kWeight);
            if (w > 0.0F) {
              ASSERT_NEAR(level.get(x, y, 0) / w, 0.3F, 2e-5F) << kernel.name;
            } else {
              ASSERT_EQ(level.get(x, y, 0), 0.0F) << kernel.name;
            }
          }
    }
  const test::WholeImage base = image_of({.data = {0, 0, 64, 32}}, noise(2), opaque);
  for (const HalvingKernel& kernel : means()) {
    const Levels levels = levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()});
    for (std::size_t k = 0; k <= 5; ++k)
      for (std::size_t i = kWeight; i < levels[k].floats.size(); i += kHalvedPlanes) ASSERT_EQ(levels[k].floats[i], 1.0F) << kernel.name;
  }
}

// A veil of one strength over everything changes no colour.
TEST(HalvePlanes, EvenlyTranslucentDataHaveTheColoursOfOpaqueOnes) {
  for (const HalvingKernel& kernel : means()) {
    const LayerShape layer{.data = {0, 0, 61, 40}};
    const Levels full = levels_by_cascade({.base = image_of(layer, noise(5), opaque), .kernel = kernel, .rules = halved_rules()});
    const auto veil = [](std::int64_t, std::int64_t) { return 0.3; };
    const Levels thin = levels_by_cascade({.base = image_of(layer, noise(5), veil), .kernel = kernel, .rules = halved_rules()});
    for (std::size_t k = 0; k < full.size(); ++k)
      for (std::size_t i = 0; i < full[k].floats.size(); i += kHalvedPlanes)
        ASSERT_NEAR(thin[k].floats[i] / thin[k].floats[i + 1], full[k].floats[i] / full[k].floats[i + 1], 3e-6) << kernel.name << " " << k;
  }
}

// ---- Against double precision ----

using Plane = std::vector<std::vector<double>>;  // rows of texels

Plane values_of(const test::WholeImage& image, int plane) {
  Plane rows;
  for (std::int64_t y = image.data.y; y < image.data.bottom(); ++y) {
    rows.emplace_back();
    for (std::int64_t x = image.data.x; x < image.data.right(); ++x) rows.back().push_back(static_cast<double>(image.get(x, y, plane)));
  }
  return rows;
}

Plane transposed(const Plane& plane) {
  Plane columns(plane.front().size(), std::vector<double>(plane.size()));
  for (std::size_t y = 0; y < plane.size(); ++y)
    for (std::size_t x = 0; x < columns.size(); ++x) columns[x][y] = plane[y][x];
  return columns;
}

// Along rows: a plain convolution of the row and its mirror images.
Plane convolved(const Plane& plane, const HalvingKernel& kernel) {
  Plane result;
  for (const std::vector<double>& row : plane) {
    const auto count = static_cast<std::int64_t>(row.size());
    result.emplace_back();
    for (std::int64_t i = 0; i < (count + 1) / 2; ++i) {
      double sum = 0.0;
      for (int t = 0; t < kernel.taps; ++t)
        sum += static_cast<double>(kernel.weight[static_cast<std::size_t>(t)]) *
               row[static_cast<std::size_t>(test::mirrored(2 * i - kernel.reach() + t, 0, count))];
      result.back().push_back(sum);
    }
  }
  return result;
}

TEST(HalvePlanes, OpaqueDataAreConvolvedWithTheirMirrorImages) {
  for (const HalvingKernel& kernel : means()) {
    const Levels levels = levels_by_cascade(
        {.base = image_of({.data = {0, 0, 96, 64}}, noise(6), opaque), .kernel = kernel, .rules = halved_rules(), .levels_at_once = 2});
    Plane truth = values_of(levels[0], 0);
    for (std::size_t k = 1; k <= 5; ++k) {  // to 3 x 2 texels
      truth = transposed(convolved(transposed(convolved(truth, kernel)), kernel));
      const Plane found = values_of(levels[k], 0);
      for (std::size_t y = 0; y < truth.size(); ++y)
        for (std::size_t x = 0; x < truth[y].size(); ++x)
          ASSERT_NEAR(found[y][x], truth[y][x], 1e-5) << kernel.name << " level " << k << ": " << x << ", " << y;
    }
  }
}

// The first odd size: the cut column is a whole one of the mirrored row, and weighs half.
TEST(HalvePlanes, ACutTexelHasTheColourOfItsMirroredSelf) {
  const test::WholeImage base = image_of({.data = {0, 0, 41, 28}}, noise(8), opaque);
  for (const HalvingKernel& kernel : means()) {
    const Levels levels = levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()});
    const Plane truth = transposed(convolved(transposed(convolved(values_of(base, 0), kernel)), kernel));
    for (std::int64_t y = 0; y < 14; ++y)
      for (std::int64_t x = 0; x < 21; ++x) {
        const float weight = levels[1].get(x, y, kWeight);
        ASSERT_EQ(weight, x == 20 ? 0.5F : 1.0F);
        ASSERT_NEAR(levels[1].get(x, y, 0) / weight, truth[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)], 3e-6) << kernel.name;
      }
  }
}

// One pass over rows of texels that are not all there, by what it means: every coarse texel begins with the
// mean of its two, then all pairs of fine texels that lie mirrored about an edge between coarse ones
// exchange.
void exchange(std::vector<double>& values, std::vector<double>& weights, const HalvingKernel& kernel) {
  const auto count = static_cast<std::int64_t>(values.size());
  const auto value = [&](const std::vector<double>& row, std::int64_t x) {
    return row[static_cast<std::size_t>(test::mirrored(x, 0, count))];
  };
  const std::int64_t margin = kernel.reach() + 2;
  std::vector<double> sums(static_cast<std::size_t>(count / 2 + 2 * margin));
  const auto sum = [&](std::int64_t i) -> double& { return sums[static_cast<std::size_t>(i + margin)]; };
  for (std::int64_t i = -margin; i < count / 2 + margin; ++i) sum(i) = (value(values, 2 * i) + value(values, 2 * i + 1)) / 2.0;
  for (std::int64_t i = -margin; i < count / 2 + margin; ++i)
    for (std::int64_t j = i + 1; j < count / 2 + margin; ++j)
      for (int side = 0; side < 2; ++side) {
        const std::int64_t here = 2 * i + 1 - side;
        const std::int64_t there = 2 * j + side;
        const std::int64_t tap = there - 2 * i + kernel.reach();
        if (tap >= kernel.taps) continue;
        const double both = std::min(value(weights, here), value(weights, there));
        if (both == 0.0) continue;
        const double given = static_cast<double>(kernel.weight[static_cast<std::size_t>(tap)]) * both *
                             (value(values, there) / value(weights, there) - value(values, here) / value(weights, here));
        sum(i) += given;
        sum(j) -= given;
      }
  std::vector<double> coarse_weights;
  for (std::int64_t i = 0; i < count / 2; ++i) coarse_weights.push_back((value(weights, 2 * i) + value(weights, 2 * i + 1)) / 2.0);
  values.assign(sums.begin() + margin, sums.begin() + margin + count / 2);
  weights = coarse_weights;
}

TEST(HalvePlanes, TexelsThatAreNotAllThereExchangeAsMuchAsBothHave) {
  for (const HalvingKernel& kernel : means())
    for (const auto& weight : {blobs(5, 60, false), blobs(6, 60, true), noise(12)}) {
      const Levels levels =
          levels_by_cascade({.base = image_of({.data = {0, 0, 64, 48}}, noise(10), weight), .kernel = kernel, .rules = halved_rules()});
      Plane values = values_of(levels[0], 0);
      Plane weights = values_of(levels[0], kWeight);
      for (std::size_t k = 1; k <= 4; ++k) {
        for (int pass = 0; pass < 2; ++pass) {  // down the columns, then along the rows
          values = transposed(values);
          weights = transposed(weights);
          for (std::size_t row = 0; row < values.size(); ++row) exchange(values[row], weights[row], kernel);
        }
        const Plane found = values_of(levels[k], 0);
        for (std::size_t y = 0; y < values.size(); ++y)
          for (std::size_t x = 0; x < values[y].size(); ++x)
            ASSERT_NEAR(found[y][x], values[y][x], 3e-6) << kernel.name << " level " << k << ": " << x << ", " << y;
      }
    }
}

// ---- Closed layers ----

// A row of a closed layer goes on for ever, and so do its levels: the value of column x, of any whole number.
class EndlessRow {
 public:
  EndlessRow(std::vector<double> base, const HalvingKernel& kernel) : base_(std::move(base)), kernel_(kernel) {}

  [[nodiscard]] double at(int level, std::int64_t x) {
    const auto width = static_cast<std::int64_t>(base_.size());
    if (level == 0) return base_[static_cast<std::size_t>(((x % width) + width) % width)];
    const auto known = values_.find({level, x});
    if (known != values_.end()) return known->second;
    double sum = 0.0;
    for (int t = 0; t < kernel_.taps; ++t)
      sum += static_cast<double>(kernel_.weight[static_cast<std::size_t>(t)]) * at(level - 1, 2 * x - kernel_.reach() + t);
    return values_[{level, x}] = sum;
  }

 private:
  std::vector<double> base_;
  HalvingKernel kernel_;
  std::map<std::pair<int, std::int64_t>, double> values_;
};

// A row with amplitudes in inverse proportion to the frequency, mean 0 and standard deviation 1.
std::vector<double> natural_row(std::int64_t width, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::acos(-1.0));
  std::vector<double> row(static_cast<std::size_t>(width));
  for (std::int64_t f = 1; f <= width / 2; ++f) {
    const double phase = angle(random);
    for (std::int64_t x = 0; x < width; ++x)
      row[static_cast<std::size_t>(x)] +=
          std::cos(phase + 2.0 * std::acos(-1.0) * static_cast<double>(f * x) / static_cast<double>(width)) / static_cast<double>(f);
  }
  double squares = 0.0;
  for (const double v : row) squares += v * v / static_cast<double>(width);
  for (double& v : row) v /= std::sqrt(squares);
  return row;
}

Levels levels_of_rows(const std::vector<double>& row, const HalvingKernel& kernel, bool is_closed) {
  const LayerShape layer{.data = {0, 0, static_cast<std::int64_t>(row.size()), 1}, .is_closed = is_closed};
  const auto value = [&](std::int64_t x, std::int64_t) { return row[static_cast<std::size_t>(x)]; };
  return levels_by_cascade({.base = image_of(layer, value, opaque), .kernel = kernel, .rules = halved_rules(), .levels_at_once = 2});
}

// Every level that wraps, and the one above it, is that of a row without an end, to the last column.
TEST(HalvePlanes, AcrossTheSeamOfAClosedLayerKernelsSeeTheOtherSide) {
  for (const HalvingKernel& kernel : means())
    for (const std::int64_t width : {180, 96, 64, 45, 7}) {
      const std::vector<double> row = natural_row(width, 1);
      EndlessRow truth(row, kernel);
      const Levels levels = levels_of_rows(row, kernel, true);
      for (int k = 1; k < static_cast<int>(levels.size()) && (width & ((std::int64_t{1} << (k - 1)) - 1)) == 0; ++k) {
        const test::WholeImage& level = levels[static_cast<std::size_t>(k)];
        const float rows = level.get(0, 0, kWeight);  // how much of the texel the one row fills
        for (std::int64_t x = 0; x < level.data.width; ++x) {
          ASSERT_EQ(level.get(x, 0, kWeight), rows) << "all columns are whole";
          ASSERT_NEAR(level.get(x, 0, 0) / rows, truth.at(k, x), 1e-5)
              << kernel.name << ", " << width << " columns, level " << k << ": " << x;
        }
      }
    }
}

// Where the period is no whole number of texels, a column past the edge is taken between two. How far the
// levels of an endless row are off beside the seam, against those of rows that end in a mirror: the figures
// of layer_shape.h.
TEST(HalvePlanes, BesideTheSeamOfAnOddWidthErrorsAreAFractionOfThoseOfMirrors) {
  for (const std::int64_t width : {180, 675})
    for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()}) {
      constexpr int kRows = 20;
      std::map<int, std::array<double, 2>> squares;  // by level, of both ways
      for (unsigned seed = 0; seed < kRows; ++seed) {
        const std::vector<double> row = natural_row(width, seed);
        EndlessRow truth(row, kernel);
        for (const bool is_closed : {true, false}) {
          const Levels levels = levels_of_rows(row, kernel, is_closed);
          for (int k = 1; k < static_cast<int>(levels.size()); ++k) {
            const test::WholeImage& level = levels[static_cast<std::size_t>(k)];
            if (level.data.width < 6 || (width & ((std::int64_t{1} << (k - 1)) - 1)) == 0) continue;
            for (const std::int64_t x : {std::int64_t{0}, std::int64_t{1}, level.data.width - 2, level.data.width - 1})
              squares[k][is_closed ? 0 : 1] += std::pow(level.get(x, 0, 0) / level.get(x, 0, kWeight) - truth.at(k, x), 2);
          }
        }
      }
      ASSERT_FALSE(squares.empty());
      for (const auto& [level, sums] : squares) {
        const double closed = std::sqrt(sums[0] / (4 * kRows));
        const double mirror = std::sqrt(sums[1] / (4 * kRows));
        if (mirror < 1e-6) continue;  // the box, where no texel lies over the seam
        EXPECT_LT(closed, 0.6 * mirror) << kernel.name << ", " << width << " columns, level " << level;
        EXPECT_LT(closed, 0.08) << kernel.name << ", " << width << " columns, level " << level;
      }
    }
}

// A closed layer loses nothing at its seam as long as it wraps.
TEST(HalvePlanes, LevelsThatWrapKeepTheirSums) {
  for (const HalvingKernel& kernel : means()) {
    const LayerShape layer{.data = {0, 0, 96, 40}, .is_closed = true};
    const auto at_the_seam = [](std::int64_t x, std::int64_t) { return x == 95 ? 1.0 : 0.0; };
    for (const auto& weight : {std::function(opaque), blobs(8, 96, true)}) {
      const test::WholeImage base = image_of(layer, at_the_seam, weight);
      const Levels levels = levels_by_cascade({.base = base, .kernel = kernel, .rules = halved_rules()});
      for (std::size_t k = 1; k <= 5; ++k)
        for (int p = 0; p < kHalvedPlanes; ++p)
          EXPECT_NEAR(sum_of(levels[k], p) * std::exp2(2.0 * static_cast<double>(k)), sum_of(base, p), 1e-5 * sum_of(base, p))
              << kernel.name;
    }
  }
}

}  // namespace
}  // namespace vt::pyramid
