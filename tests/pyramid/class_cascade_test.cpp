#include "builder/pyramid/class_cascade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "builder/channels/codec/class_planes.h"
#include "builder/pyramid/class_carry.h"

namespace vt::pyramid {
namespace {

using channels::ClassCounting;

constexpr int kClassTile = 4;
constexpr int kVoid = -1;

// The finest level, class by class; kVoid where there are no data.
struct ClassImage {
  LayerShape layer;
  std::vector<int> classes;

  [[nodiscard]] int at(std::int64_t x, std::int64_t y) const {
    const TexelRect& data = layer.data;
    if (layer.is_closed) x = ((x % data.width) + data.width) % data.width;
    return data.contains(x, y) ? classes[static_cast<std::size_t>((y - data.y) * data.width + (x - data.x))] : kVoid;
  }
};

template <class Make>
ClassImage image_of(const LayerShape& layer, const Make& make) {
  const TexelRect& data = layer.data;
  ClassImage image{layer, {}};
  for (std::int64_t y = data.y; y < data.bottom(); ++y)
    for (std::int64_t x = data.x; x < data.right(); ++x) image.classes.push_back(make(x, y));
  return image;
}

using Histogram = std::map<int, std::uint64_t>;

// The definition: all texels of the finest level under a texel, counted one by one. A column past the edge of
// a closed level that does not wrap is the nearer of the two that it lies between; so are all columns finer
// ones are under.
Histogram histogram_under(const ClassImage& base, int level, std::int64_t x, std::int64_t y) {
  Histogram histogram;
  const TexelRect data = base.layer.data_at(level);
  if (!base.layer.is_closed || level == 0) {
    for (std::int64_t v = y << level; v < (y + 1) << level; ++v)
      for (std::int64_t u = x << level; u < (x + 1) << level; ++u)
        if (const int id = base.at(u, v); id != kVoid) ++histogram[id];
    return histogram;
  }
  if (x < 0 || x >= data.width) {
    const SeamColumn column = base.layer.column_past_edge(level, x);
    x = column.share <= 0.5F ? column.first : column.second;
  }
  for (std::int64_t v = 2 * y; v < 2 * y + 2; ++v)
    for (std::int64_t u = 2 * x; u < 2 * x + 2; ++u)
      for (const auto& [id, area] : histogram_under(base, level - 1, u, v)) histogram[id] += area;
  return histogram;
}

void expect_planes(const channels::ConstPlaneRow& planes, std::int64_t i, const Histogram& truth, int level, int ranked) {
  std::vector<std::pair<int, std::uint64_t>> order(truth.begin(), truth.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::uint64_t total = 0;
  for (const auto& [id, area] : order) total += area;
  ASSERT_EQ(planes[channels::kClassWeightPlane][i], static_cast<float>(std::ldexp(static_cast<double>(total), -2 * level)));
  for (int rank = 0; rank < ranked; ++rank) {
    const bool is_there = static_cast<std::size_t>(rank) < order.size();
    const auto at = static_cast<std::size_t>(rank);
    const int id = is_there ? order[at].first : 0;
    const double share = is_there ? static_cast<double>(order[at].second) / static_cast<double>(total) : 0.0;
    ASSERT_EQ(planes[static_cast<std::size_t>(channels::class_plane(rank))][i], static_cast<float>(id));
    ASSERT_EQ(planes[static_cast<std::size_t>(channels::share_plane(rank))][i], static_cast<float>(share));
  }
}

// Holds every row that comes, and its neighbours, to the definition.
class ClassJudge final : public RowSink {
 public:
  ClassJudge(const ClassImage& base, const Cascade& cascade, int depth, int ranked)
      : base_(base), cascade_(cascade), depth_(depth), ranked_(ranked) {}

  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    const TexelRect& core = cascade_.level(k).core;
    const int level = depth_ + k;
    bool opaque = true;
    // Past the edges of a closed level that does not wrap nobody asks for classes: texels without data have
    // none to borrow.
    const bool has_sides = !base_.layer.is_closed || base_.layer.wraps_at(level);
    for (std::int64_t i = has_sides ? -1 : 0; i < core.width + (has_sides ? 1 : 0); ++i) {
      expect_planes(rows.above, i, histogram_under(base_, level, core.x + i, y - 1), level, ranked_);
      expect_planes(rows.here, i, histogram_under(base_, level, core.x + i, y), level, ranked_);
      expect_planes(rows.below, i, histogram_under(base_, level, core.x + i, y + 1), level, ranked_);
      if (i >= 0 && i < core.width) opaque = opaque && rows.here[channels::kClassWeightPlane][i] == 1.0F;
    }
    if (rows.opaque) {
      EXPECT_TRUE(opaque);
    }
    ++rows_seen[k];
  }

  std::map<int, std::int64_t> rows_seen;

 private:
  const ClassImage& base_;
  const Cascade& cascade_;
  int depth_;
  int ranked_;
};

using CarryMap = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::byte>>;

void feed_base(ClassCascade& cascade, const ClassImage& base, int ranked, RowSink& sink) {
  const TexelRect active = cascade.level(0).active;
  for (std::int64_t y = active.y; y < active.bottom(); ++y) {
    const channels::PlaneRow row = cascade.begin_row();
    bool opaque = true;
    for (std::int64_t i = 0; i < active.width; ++i) {
      const int id = base.at(active.x + i, y);
      row[0][i] = static_cast<float>(std::max(id, 0));
      row[1][i] = row[2][i] = id == kVoid ? 0.0F : 1.0F;
      for (int p = 3; p < channels::class_planes(ranked); ++p) row[static_cast<std::size_t>(p)][i] = 0.0F;
      opaque = opaque && id != kVoid;
    }
    cascade.end_row(opaque, sink);
  }
}

// All blocks of one tier; `carry` is what the tier before left, and then what this one leaves.
void run_tier(const ClassImage& base, const ClassCounting& classes, int depth, int outputs, bool with_carry, CarryMap& carry) {
  const TexelRect data = base.layer.data_at(depth);
  const std::int64_t block = std::int64_t{1} << (kClassTile + outputs);
  CarryMap left;
  for (std::int64_t by = data.y / block; by * block < data.bottom(); ++by)
    for (std::int64_t bx = data.x / block; bx * block < data.right(); ++bx) {
      ClassCascade cascade(plan_block({bx * block, by * block, block, block}, base.layer, depth, outputs, with_carry, box_kernel()),
                           base.layer, outputs, classes, kClassTile);
      ClassJudge judge(base, cascade, depth, classes.ranked);
      if (depth == 0) {
        feed_base(cascade, base, classes.ranked, judge);
      } else {
        const TexelRect active = cascade.level(0).active;
        for (std::int64_t row = active.y >> kClassTile; row <= (active.bottom() - 1) >> kClassTile; ++row) {
          std::vector<std::vector<std::byte>> tiles;
          const std::vector<std::int64_t> columns = carry_columns(cascade.level(0), kClassTile);
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

void run_all(const ClassImage& base, const ClassCounting& classes) {
  CarryMap carry;
  run_tier(base, classes, 0, 2, true, carry);
  run_tier(base, classes, 2, 1, true, carry);
  run_tier(base, classes, 3, 3, false, carry);
}

TEST(ClassCascade, EveryLevelCountsTheFinestWhateverTheBlocks) {
  std::mt19937 random(5);
  for (const LayerShape& layer :
       {LayerShape{{0, 0, 200, 130}}, LayerShape{{37, 21, 129, 63}}, LayerShape{{64, 128, 64, 64}}, LayerShape{{3, 5, 1, 90}},
        LayerShape{{7, 9, 150, 1}}, LayerShape{{11, 13, 1, 1}}, LayerShape{{0, 0, 192, 40}, true}, LayerShape{{0, 0, 150, 70}, true},
        LayerShape{{0, 0, 301, 33}, true}, LayerShape{{0, 0, 9, 20}, true}, LayerShape{{0, 0, 1, 3}, true}})
    for (const int ranked : {1, 3, 4}) {
      const ClassImage base = image_of(layer, [&](std::int64_t x, std::int64_t y) {
        if ((x / 13 + y / 7) % 5 == 0) return kVoid;
        return (x / 9 + y / 11) % 3 == 0 ? static_cast<int>(random() % 5) : static_cast<int>((x / 9 * y / 11) % 250);
      });
      run_all(base, {.ranked = ranked, .greatest = 254, .no_data = 255});
    }
}

// The coarsest level of 180 columns of a closed layer whose own columns are whole: 45 of 4, and of the next
// one the last stands for columns 176 to 179 and, past the seam, 0 to 3.
TEST(ClassCascade, ATexelOverTheSeamCountsBothSides) {
  const LayerShape layer{{0, 0, 180, 8}, true};
  const ClassImage base = image_of(layer, [](std::int64_t x, std::int64_t y) { return static_cast<int>((x * 7 + y * 3) % 5); });
  Histogram truth;
  for (std::int64_t y = 0; y < 8; ++y)
    for (std::int64_t x = 176; x < 184; ++x) ++truth[static_cast<int>((x % 180 * 7 + y * 3) % 5)];
  EXPECT_EQ(histogram_under(base, 3, 22, 0), truth) << "what EveryLevelCountsTheFinestWhateverTheBlocks holds levels to";
  run_all(base, {.ranked = 4});
}

TEST(ClassCascade, CountsSixteenBitsOfClasses) {
  std::mt19937 random(6);
  const ClassImage base = image_of({{1, 2, 140, 70}}, [&](std::int64_t, std::int64_t) { return static_cast<int>(random() % 65535); });
  run_all(base, {.ranked = 4, .greatest = 65535, .no_data = 65535});
}

TEST(ClassCascade, OneClassAndNoneAreThemselves) {
  run_all(image_of({{5, 0, 100, 100}}, [](std::int64_t, std::int64_t) { return 7; }), {.ranked = 2});
  run_all(image_of({{5, 0, 100, 100}}, [](std::int64_t, std::int64_t) { return kVoid; }), {.ranked = 2});
  run_all(image_of({{0, 0, 100, 70}}, [](std::int64_t x, std::int64_t y) { return x == 51 && y == 33 ? 9 : kVoid; }), {.ranked = 2});
}

// Two classes share every texel of every level equally.
TEST(ClassCascade, OfEqualAreasTheLowestClassIsFirst) {
  run_all(image_of({{0, 0, 128, 128}}, [](std::int64_t x, std::int64_t y) { return (x + y) % 2 == 0 ? 200 : 13; }), {.ranked = 2});
}

TEST(ClassCascade, AClassThatTheLayerHasNotIsSaid) {
  struct NoSink final : RowSink {
    void row(int, std::int64_t, const channels::RowNeighbourhood&) override {}
  };
  const auto message_of = [](float id, const ClassCounting& classes) {
    const TexelRect data{0, 0, 20, 8};
    ClassCascade cascade(plan_block({0, 0, 32, 32}, data, 1, true, box_kernel()), {data}, 1, classes, kClassTile);
    NoSink sink;
    for (int y = 0; y < 8; ++y) {
      const channels::PlaneRow row = cascade.begin_row();
      for (int p = 0; p < 3; ++p) std::fill_n(row[static_cast<std::size_t>(p)], 20, 1.0F);
      if (y == 3) row[0][11] = id;
      cascade.end_row(true, sink);
    }
    return cascade.status() ? std::string() : cascade.status().error().message;
  };
  EXPECT_EQ(message_of(254.0F, {}), "");
  EXPECT_NE(message_of(256.0F, {}).find("texel 11, 3 of the finest level is class 256; this layer holds classes 0 to 255, as r16"),
            std::string::npos);
  EXPECT_NE(message_of(-5.0F, {}).find("is class -5"), std::string::npos);
  EXPECT_NE(message_of(255.0F, {}).find("stands for no data"), std::string::npos);
  EXPECT_NE(message_of(0.0F, {.no_data = 0}).find("stands for no data"), std::string::npos);
  EXPECT_EQ(message_of(65534.0F, {.greatest = 65535, .no_data = 65535}), "");
  EXPECT_NE(message_of(70000.0F, {.greatest = 65535, .no_data = 65535}), "");
}

TEST(ClassCarry, ComesBackAndIsChecked) {
  const ClassCounting classes{.greatest = 1000, .no_data = 17};
  const std::vector<ClassCount> texel{class_count(0, 1), class_count(16, 200), class_count(18, 70000), class_count(1000, 5)};
  const std::uint64_t area = std::uint64_t{1} << 18;
  std::vector<std::byte> bytes;
  pack_texel(texel, bytes);
  pack_texel({}, bytes);
  CountReader reader(bytes, classes, area);
  std::vector<ClassCount> back;
  ASSERT_TRUE(reader.read(back).has_value());
  EXPECT_EQ(back, texel);
  ASSERT_TRUE(reader.read(back).has_value());
  EXPECT_TRUE(back.empty());
  EXPECT_TRUE(reader.at_end());
  EXPECT_FALSE(reader.read(back).has_value()) << "beyond the end";

  for (std::size_t length = 0; length + 1 < bytes.size(); ++length) {
    const std::vector<std::byte> prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    CountReader cut(prefix, classes, area);
    const auto read = cut.read(back);
    ASSERT_FALSE(read.has_value()) << length;
    EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
  }
  const auto is_read = [&](const std::vector<ClassCount>& written, std::uint64_t full_area) {
    std::vector<std::byte> packed;
    pack_texel(written, packed);
    CountReader other(packed, classes, full_area);
    return other.read(back).has_value();
  };
  EXPECT_TRUE(is_read({class_count(1, 2), class_count(2, 2)}, 4));
  EXPECT_FALSE(is_read({class_count(1, 2), class_count(2, 3)}, 4)) << "more area than there is";
  EXPECT_FALSE(is_read({class_count(17, 1)}, 4)) << "the code of no data";
  EXPECT_FALSE(is_read({class_count(1001, 1)}, 4)) << "beyond the greatest class";
  EXPECT_FALSE(is_read({class_count(1, 0)}, 4)) << "no area";
  EXPECT_FALSE(is_read({class_count(1, kAreaMask), class_count(2, kAreaMask)}, 4));

  // Any bytes are read or refused, within bounds.
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> noise(random() % 24);
    for (std::byte& b : noise) b = static_cast<std::byte>(random() % (i % 2 == 0 ? 256 : 6));
    CountReader other(noise, classes, 4096);
    while (!other.at_end() && other.read(back)) {
      std::uint64_t sum = 0;
      for (std::size_t c = 0; c < back.size(); ++c) {
        sum += area_of(back[c]);
        ASSERT_LE(class_of(back[c]), 1000U);
        if (c > 0) {
          ASSERT_LT(class_of(back[c - 1]), class_of(back[c]));
        }
      }
      ASSERT_LE(sum, 4096U);
    }
  }
}

TEST(ClassCarry, TilesWithTooFewOrTooManyBytesAreCorrupt) {
  struct NoSink final : RowSink {
    void row(int, std::int64_t, const channels::RowNeighbourhood&) override {}
  };
  const auto feed = [](std::vector<std::byte> tile) {
    const LayerShape layer{{0, 0, 64, 64}};
    ClassCascade cascade(plan_block({0, 0, 16, 16}, layer, 2, 1, false, box_kernel()), layer, 1, {}, kClassTile);
    NoSink sink;
    const std::vector<std::vector<std::byte>> tiles{std::move(tile)};
    const std::vector<std::int64_t> columns{0};
    return cascade.feed_carry({.row = 0, .columns = columns, .tiles = tiles}, sink);
  };
  std::vector<std::byte> tile(256, std::byte{0});
  EXPECT_TRUE(feed(tile).has_value());
  tile.pop_back();
  EXPECT_EQ(feed(tile).error().code, ErrorCode::kCorrupt);
  tile.resize(257);
  EXPECT_EQ(feed(tile).error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace vt::pyramid
