// Layers of classes whose finest texels lie over many samples: their areas become counts, and the counts go
// on exactly.
#include "builder/channels/codec/class_areas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "builder/channels/codec/class_planes.h"
#include "builder/pyramid/class_cascade.h"

namespace vt::pyramid {
namespace {

using channels::ClassArea;
using channels::ClassAreaBlock;
using channels::ClassCounting;

constexpr int kTileExponent = 4;
constexpr int kAreaExponent = 16;
constexpr std::uint64_t kFull = std::uint64_t{1} << kAreaExponent;

using Histogram = std::map<int, std::uint64_t>;

// The definition, in long double: round down, then one more for the largest remainders.
Histogram rounded(const std::vector<ClassArea>& classes, std::uint64_t full) {
  struct Entry {
    long double lost;
    std::size_t order;
    std::uint64_t whole;
  };
  std::vector<Entry> entries;
  long double rest = full;
  std::uint64_t left = full;
  for (std::size_t i = 0; i <= classes.size(); ++i) {
    const long double exact = i < classes.size() ? static_cast<long double>(classes[i].area) * static_cast<long double>(full) : rest;
    const auto whole = static_cast<std::uint64_t>(exact);
    rest -= i < classes.size() ? exact : 0;
    left -= whole;
    entries.push_back({exact - static_cast<long double>(whole), i, whole});
  }
  std::vector<Entry> by_loss = entries;
  std::stable_sort(by_loss.begin(), by_loss.end(), [](const Entry& a, const Entry& b) { return a.lost > b.lost; });
  for (std::size_t i = 0; i < left; ++i) ++entries[by_loss[i].order].whole;
  Histogram histogram;
  for (std::size_t i = 0; i < classes.size(); ++i)
    if (entries[i].whole > 0) histogram[static_cast<int>(classes[i].id)] = entries[i].whole;
  return histogram;
}

TEST(CountAreas, AreWholeAndSumToTheTexel) {
  std::mt19937 random(11);
  std::vector<ClassCount> counts;
  for (int i = 0; i < 20000; ++i) {
    // Eighths of quarters, so that equal remainders are frequent and every sum is exact.
    std::vector<ClassArea> classes;
    double sum = 0.0;
    for (int id = 0; id < 12; ++id) {
      if (random() % 2 == 0) continue;
      const double area = std::ldexp(static_cast<double>(1 + random() % 40), -10 - static_cast<int>(random() % 10));
      if (sum + area > 1.0) break;
      sum += area;
      classes.push_back({static_cast<float>(id), area});
    }
    const std::uint64_t full = i % 2 == 0 ? 256 : kFull;
    counts.clear();
    count_areas(classes, full, counts);
    Histogram found;
    std::uint64_t all = 0;
    for (const ClassCount count : counts) {
      found[static_cast<int>(class_of(count))] = area_of(count);
      all += area_of(count);
    }
    ASSERT_EQ(found, rounded(classes, full));
    ASSERT_LE(all, full);
    ASSERT_TRUE(std::ranges::is_sorted(counts));
    // Without voids nothing is lost.
    if (!classes.empty()) {
      for (ClassArea& one : classes) one.area /= sum;
      counts.clear();
      count_areas(classes, full, counts);
      all = 0;
      for (const ClassCount count : counts) all += area_of(count);
      ASSERT_EQ(all, full);
    }
  }
}

// A finest level of mixed texels, a void here and there.
struct AreaImage {
  TexelRect data;
  std::vector<std::vector<ClassArea>> texels;

  [[nodiscard]] const std::vector<ClassArea>& at(std::int64_t x, std::int64_t y) const {
    return texels[static_cast<std::size_t>((y - data.y) * data.width + (x - data.x))];
  }
};

AreaImage mixed_image(const TexelRect& data) {
  std::mt19937 random(4);
  AreaImage image{data, {}};
  for (std::int64_t y = data.y; y < data.bottom(); ++y)
    for (std::int64_t x = data.x; x < data.right(); ++x) {
      std::vector<ClassArea> classes;
      const int kind = static_cast<int>((x / 5 + y / 3) % 4);
      if (kind == 1) classes = {{7.0F, 1.0}};
      if (kind >= 2) {
        double left = kind == 2 ? 1.0 : 0.8;
        for (int id = 3; id < 9; ++id) {
          const double area = id == 8 ? left : left * (random() % 1000) / 1500.0;
          if (area > 0.0) classes.push_back({static_cast<float>(id), area});
          left -= area;
        }
      }
      image.texels.push_back(std::move(classes));
    }
  return image;
}

Histogram histogram_under(const AreaImage& base, int level, std::int64_t x, std::int64_t y) {
  Histogram histogram;
  const TexelRect rect = intersect(finer({x, y, 1, 1}, level), base.data);
  for (std::int64_t v = rect.y; v < rect.bottom(); ++v)
    for (std::int64_t u = rect.x; u < rect.right(); ++u)
      for (const auto& [id, area] : rounded(base.at(u, v), kFull)) histogram[id] += area;
  return histogram;
}

class Judge final : public RowSink {
 public:
  Judge(const AreaImage& base, const Cascade& cascade, int depth, int ranked)
      : base_(base), cascade_(cascade), depth_(depth), ranked_(ranked) {}

  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    const TexelRect& core = cascade_.level(k).core;
    const int level = depth_ + k;
    for (std::int64_t i = 0; i < core.width; ++i) {
      const Histogram truth = histogram_under(base_, level, core.x + i, y);
      std::vector<std::pair<int, std::uint64_t>> order(truth.begin(), truth.end());
      std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
      std::uint64_t total = 0;
      for (const auto& [id, area] : order) total += area;
      const double full = std::ldexp(static_cast<double>(kFull), 2 * level);
      ASSERT_EQ(rows.here[channels::kClassWeightPlane][i], static_cast<float>(static_cast<double>(total) / full));
      for (int rank = 0; rank < ranked_; ++rank) {
        const auto at = static_cast<std::size_t>(rank);
        const bool is_there = at < order.size();
        ASSERT_EQ(rows.here[static_cast<std::size_t>(channels::class_plane(rank))][i],
                  is_there ? static_cast<float>(order[at].first) : 0.0F);
        const double share = is_there ? static_cast<double>(order[at].second) / static_cast<double>(total) : 0.0;
        ASSERT_EQ(rows.here[static_cast<std::size_t>(channels::share_plane(rank))][i], static_cast<float>(share));
      }
      if (rows.opaque) {
        ASSERT_EQ(static_cast<double>(total), full);
      }
    }
    ++rows_seen[k];
  }

  std::map<int, std::int64_t> rows_seen;

 private:
  const AreaImage& base_;
  const Cascade& cascade_;
  int depth_;
  int ranked_;
};

using CarryMap = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::byte>>;

// Rows come as areas or, where all texels of one are of one class or of none, as planes.
void feed_base(ClassCascade& cascade, const AreaImage& base, int ranked, RowSink& sink) {
  const TexelRect active = cascade.level(0).active;
  // In two parts, as where columns go on past the seam of a closed layer.
  const std::int64_t middle = active.x + active.width / 3;
  const std::array<TexelRect, 2> rects{TexelRect{active.x, active.y, middle - active.x, active.height},
                                       TexelRect{middle, active.y, active.right() - middle, active.height}};
  std::array<ClassAreaBlock, 2> areas;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    areas[i].reset(rects[i]);
    for (std::int64_t y = active.y; y < active.bottom(); ++y)
      for (std::int64_t x = rects[i].x; x < rects[i].right(); ++x) areas[i].set(x, y, base.at(x, y));
  }
  const std::array<const ClassAreaBlock*, 2> parts{&areas[0], &areas[1]};
  for (std::int64_t y = active.y; y < active.bottom(); ++y) {
    bool is_simple = true;
    for (std::int64_t x = active.x; x < active.right(); ++x)
      is_simple = is_simple && (base.at(x, y).empty() || (base.at(x, y).size() == 1 && base.at(x, y)[0].area == 1.0));
    if (!is_simple) {
      cascade.put_area_row(parts, y - active.y, sink);
      continue;
    }
    const channels::PlaneRow row = cascade.begin_row();
    bool opaque = true;
    for (std::int64_t i = 0; i < active.width; ++i) {
      const std::vector<ClassArea>& classes = base.at(active.x + i, y);
      row[0][i] = classes.empty() ? 0.0F : classes[0].id;
      row[1][i] = row[2][i] = classes.empty() ? 0.0F : 1.0F;
      for (int p = 3; p < channels::class_planes(ranked); ++p) row[static_cast<std::size_t>(p)][i] = 0.0F;
      opaque = opaque && !classes.empty();
    }
    cascade.end_row(opaque, sink);
  }
}

void run_tier(const AreaImage& base, const ClassCounting& classes, int depth, int outputs, bool with_carry, CarryMap& carry) {
  const LayerShape layer{base.data};
  const TexelRect data = layer.data_at(depth);
  const std::int64_t block = std::int64_t{1} << (kTileExponent + outputs);
  CarryMap left;
  for (std::int64_t by = data.y / block; by * block < data.bottom(); ++by)
    for (std::int64_t bx = data.x / block; bx * block < data.right(); ++bx) {
      ClassCascade cascade(plan_block({bx * block, by * block, block, block}, layer, depth, outputs, with_carry, box_kernel()), layer,
                           outputs, classes, kTileExponent, kAreaExponent);
      Judge judge(base, cascade, depth, classes.ranked);
      if (depth == 0) {
        feed_base(cascade, base, classes.ranked, judge);
      } else {
        const TexelRect active = cascade.level(0).active;
        for (std::int64_t row = active.y >> kTileExponent; row <= (active.bottom() - 1) >> kTileExponent; ++row) {
          std::vector<std::vector<std::byte>> tiles;
          const std::vector<std::int64_t> columns = carry_columns(cascade.level(0), kTileExponent);
          for (const std::int64_t column : columns) tiles.push_back(carry.at({column, row}));
          const auto fed = cascade.feed_carry({.row = row, .columns = columns, .tiles = tiles}, judge);
          ASSERT_TRUE(fed.has_value()) << fed.error().message;
        }
      }
      ASSERT_TRUE(cascade.status().has_value());
      for (int k = 0; k < outputs; ++k) ASSERT_EQ(judge.rows_seen[k], cascade.level(k).core.height) << "level " << k;
      if (with_carry) cascade.carry_bytes(left[{bx, by}]);
    }
  carry = std::move(left);
}

TEST(ClassCascade, EveryLevelSumsTheAreasOfTheFinestWhateverTheBlocks) {
  for (const TexelRect& data : {TexelRect{0, 0, 150, 90}, TexelRect{37, 21, 60, 63}, TexelRect{7, 9, 1, 40}})
    for (const int ranked : {1, 4}) {
      const AreaImage base = mixed_image(data);
      const ClassCounting classes{.ranked = ranked, .greatest = 254, .no_data = 255};
      CarryMap carry;
      run_tier(base, classes, 0, 2, true, carry);
      run_tier(base, classes, 2, 1, true, carry);
      run_tier(base, classes, 3, 3, false, carry);
    }
}

TEST(ClassCascade, AnAreaOfAClassThatTheLayerHasNotIsSaid) {
  struct NoSink final : RowSink {
    void row(int, std::int64_t, const channels::RowNeighbourhood&) override {}
  };
  const auto message_of = [](float id) {
    const LayerShape layer{{0, 0, 20, 2}};
    ClassCascade cascade(plan_block({0, 0, 32, 32}, layer, 0, 1, true, box_kernel()), layer, 1, {}, kTileExponent, kAreaExponent);
    NoSink sink;
    ClassAreaBlock areas;
    areas.reset({0, 0, 20, 2});
    const std::vector<ClassArea> texel{{id < 3.0F ? id : 3.0F, 0.5}, {std::max(id, 4.0F), 0.5}};
    areas.set(11, 1, texel);
    const ClassAreaBlock* const all = &areas;
    for (int row = 0; row < 2; ++row) cascade.put_area_row({&all, 1}, row, sink);
    return cascade.status() ? std::string() : cascade.status().error().message;
  };
  EXPECT_EQ(message_of(4.0F), "");
  EXPECT_NE(message_of(256.0F).find("texel 11, 1 of the finest level is class 256; this layer holds classes 0 to 255, as r16"),
            std::string::npos);
  EXPECT_NE(message_of(-5.0F).find("is class -5"), std::string::npos);
  EXPECT_NE(message_of(255.0F).find("stands for no data"), std::string::npos);
}

}  // namespace
}  // namespace vt::pyramid
