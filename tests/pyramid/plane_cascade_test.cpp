#include "builder/pyramid/plane_cascade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "builder/pyramid/plane_carry.h"
#include "tests/support/whole_image.h"

namespace vt::pyramid {
namespace {

using channels::ConstPlaneRow;
using channels::PlaneRow;

constexpr int kPlanes = 5;  // two values, the weight, and the least and the greatest of the first value
constexpr int kWeight = 2;

const test::PlaneRules& rules() {
  using channels::PlaneRule;
  static const test::PlaneRules made{{PlaneRule::kLinear, PlaneRule::kLinear, PlaneRule::kLinear, PlaneRule::kLeast, PlaneRule::kGreatest},
                                     kWeight};
  return made;
}

struct Image : test::WholeImage {
  explicit Image(const TexelRect& rect) : WholeImage(rect, kPlanes) {}
  explicit Image(test::WholeImage&& whole) : WholeImage(std::move(whole)) {}
  // As a block sees it, outside the data too.
  [[nodiscard]] float seen(std::int64_t x, std::int64_t y, int p) const { return data.contains(x, y) ? get(x, y, p) : rules().nothing(p); }
};

Image halve_whole(const Image& fine, const HalvingKernel& kernel) { return Image(test::halve_whole(fine, kernel, rules())); }

// Collects what a block gives out, and checks that every texel comes once.
class Collector final : public RowSink {
 public:
  Collector(std::vector<Image>& levels, const PlaneCascade& cascade) : levels_(levels), cascade_(cascade) {}
  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    const BlockLevel& level = cascade_.level(k);
    ASSERT_TRUE(y >= level.core.y && y < level.core.bottom());
    Image& image = levels_[static_cast<std::size_t>(k)];
    for (std::int64_t i = 0; i < level.core.width; ++i)
      for (int p = 0; p < kPlanes; ++p) {
        const auto plane = static_cast<std::size_t>(p);
        float& texel = image.at(level.core.x + i, y, p);
        ASSERT_TRUE(std::isnan(texel)) << "given twice";
        texel = rows.here[plane][i];
        if (rows.opaque && p == kWeight) {
          ASSERT_EQ(texel, 1.0F);
        }
      }
    seen.push_back({k, y, rows, level.core});
    check_neighbours(k, y, rows, level);
  }

  struct Seen {
    int k;
    std::int64_t y;
    channels::RowNeighbourhood rows;
    TexelRect core;
  };
  std::vector<Seen> seen;
  const std::vector<Image>* truth = nullptr;

 private:
  // Rows above and below, and one texel to either side, must be those of the whole image.
  void check_neighbours(int k, std::int64_t y, const channels::RowNeighbourhood& rows, const BlockLevel& level) {
    if (truth == nullptr) return;
    const Image& whole = (*truth)[static_cast<std::size_t>(k)];
    for (std::int64_t i = -1; i <= level.core.width; ++i)
      for (int p = 0; p < kPlanes; ++p) {
        const auto plane = static_cast<std::size_t>(p);
        ASSERT_EQ(rows.above[plane][i], whole.seen(level.core.x + i, y - 1, p));
        ASSERT_EQ(rows.here[plane][i], whole.seen(level.core.x + i, y, p));
        ASSERT_EQ(rows.below[plane][i], whole.seen(level.core.x + i, y + 1, p));
      }
  }

  std::vector<Image>& levels_;
  const PlaneCascade& cascade_;
};

constexpr int kTileExponent = 5;

// The block's carry tile into the level above its outputs.
void keep_carry(const PlaneCascade& cascade, Image& level) {
  constexpr std::int64_t kEdge = std::int64_t{1} << kTileExponent;
  std::vector<std::byte> bytes;
  cascade.carry_bytes(bytes);
  std::vector<float> floats(static_cast<std::size_t>(kPlanes * kEdge * kEdge));
  ASSERT_TRUE(unpack_carry(bytes, kPlanes, kEdge, floats).has_value());
  const TexelRect& core = cascade.level(cascade.outputs()).core;
  for (std::int64_t y = core.y; y < core.bottom(); ++y)
    for (std::int64_t x = core.x; x < core.right(); ++x)
      for (int p = 0; p < kPlanes; ++p)
        level.at(x, y, p) = floats[static_cast<std::size_t>((p * kEdge + (y & (kEdge - 1))) * kEdge + (x & (kEdge - 1)))];
}

// Blocks whose carry is one tile: 2^outputs tiles a side.
void run_blocks(const Image& base, int outputs, const HalvingKernel& kernel, const std::vector<Image>& truth, std::vector<Image>& result) {
  const std::int64_t block = std::int64_t{1} << (kTileExponent + outputs);
  for (std::int64_t by = base.data.y / block; by * block < base.data.bottom(); ++by)
    for (std::int64_t bx = base.data.x / block; bx * block < base.data.right(); ++bx) {
      PlaneCascade cascade(plan_block({bx * block, by * block, block, block}, base.data, outputs, true, kernel), outputs, rules().rules,
                           kWeight, kernel, kTileExponent);
      Collector collector(result, cascade);
      collector.truth = &truth;
      const TexelRect active = cascade.level(0).active;
      for (std::int64_t y = active.y; y < active.bottom(); ++y) {
        const PlaneRow row = cascade.begin_row();
        bool opaque = true;
        for (std::int64_t x = active.x; x < active.right(); ++x) {
          for (int p = 0; p < kPlanes; ++p) row[static_cast<std::size_t>(p)][x - active.x] = base.get(x, y, p);
          opaque = opaque && base.get(x, y, kWeight) == 1.0F;
        }
        cascade.end_row(opaque, collector);
      }
      keep_carry(cascade, result.back());
    }
}

enum class Content { kOpaque, kHoles, kTranslucent };

Image make_image(const TexelRect& data, Content content) {
  Image image(data);
  std::mt19937 random(static_cast<unsigned>(data.width * 31 + data.height));
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  for (std::int64_t y = data.y; y < data.bottom(); ++y)
    for (std::int64_t x = data.x; x < data.right(); ++x) {
      float weight = 1.0F;
      if (content == Content::kHoles && (((x / 9) % 5 == 1 && (y / 7) % 4 == 2) || uniform(random) < 0.05F)) weight = 0.0F;
      if (content == Content::kTranslucent) weight = uniform(random);
      for (int p = 0; p < kWeight; ++p) image.at(x, y, p) = weight * uniform(random);
      image.at(x, y, kWeight) = weight;
      for (const int p : {3, 4}) image.at(x, y, p) = weight > 0.0F ? image.at(x, y, 0) : rules().nothing(p);
    }
  return image;
}

std::vector<HalvingKernel> every_kernel() {
  std::vector<HalvingKernel> kernels(all_kernels().begin(), all_kernels().end());
  for (const HalvingKernel& kernel : all_kernels())
    if (kernel.has_negative_lobes()) {
      kernels.push_back(kernel);
      kernels.back().limits_ringing = true;
    }
  return kernels;
}

TEST(PlaneCascade, BlocksEqualTheWholeImageBitForBit) {
  for (const HalvingKernel& kernel : every_kernel())
    for (const Content content : {Content::kOpaque, Content::kHoles, Content::kTranslucent})
      for (const TexelRect data : {TexelRect{0, 0, 257, 131}, TexelRect{0, 0, 1, 77}, TexelRect{37, 51, 200, 95}})
        for (const int outputs : {1, 2, 4}) {
          std::vector<Image> truth{make_image(data, content)};
          for (int k = 0; k < outputs; ++k) truth.push_back(halve_whole(truth.back(), kernel));
          std::vector<Image> result;
          for (const Image& level : truth) {
            result.emplace_back(level.data);
            std::fill(result.back().floats.begin(), result.back().floats.end(), std::numeric_limits<float>::quiet_NaN());
          }
          run_blocks(truth[0], outputs, kernel, truth, result);
          for (std::size_t k = 0; k < truth.size(); ++k)
            ASSERT_EQ(result[k].floats, truth[k].floats) << kernel.name << (kernel.limits_ringing ? " limited, " : ", ") << data.width
                                                         << " x " << data.height << ", " << outputs << " levels, level " << k;
        }
}

// Going on from carry gives the rows that going on in one sweep gives.
TEST(PlaneCascade, CarryIsFedBackBitForBit) {
  for (const HalvingKernel& kernel : every_kernel()) {
    const Image base = make_image({37, 51, 200, 95}, Content::kHoles);
    const Image halved = halve_whole(base, kernel);
    constexpr std::int64_t kEdge = std::int64_t{1} << kTileExponent;
    std::vector<Image> result;
    for (int k = 0; k < 2; ++k) result.emplace_back(coarser(halved.data, k));
    for (Image& level : result) std::fill(level.floats.begin(), level.floats.end(), std::numeric_limits<float>::quiet_NaN());
    PlaneCascade cascade(plan_block({0, 0, 256, 256}, halved.data, 2, false, kernel), 2, rules().rules, kWeight, kernel, kTileExponent);
    Collector collector(result, cascade);
    const TexelRect tiles = coarser(halved.data, kTileExponent);
    for (std::int64_t row = tiles.y; row < tiles.bottom(); ++row) {
      std::vector<std::vector<std::byte>> carry;
      for (std::int64_t column = tiles.x; column < tiles.right(); ++column) {
        std::vector<float> floats;
        for (int p = 0; p < kPlanes; ++p)
          for (std::int64_t y = 0; y < kEdge; ++y)
            for (std::int64_t x = 0; x < kEdge; ++x) floats.push_back(halved.seen(column * kEdge + x, row * kEdge + y, p));
        pack_carry(floats, kPlanes, kEdge, carry.emplace_back());
      }
      ASSERT_TRUE(cascade.feed_carry({.first_column = tiles.x, .row = row, .tiles = carry}, collector).has_value());
    }
    EXPECT_EQ(result[0].floats, halved.floats) << kernel.name;
    EXPECT_EQ(result[1].floats, halve_whole(halved, kernel).floats) << kernel.name;
  }
}

TEST(PlaneCascade, BytesThatAreNoCarryAreRefused) {
  const TexelRect data{0, 0, 32, 32};
  PlaneCascade cascade(plan_block(data, data, 1, false, box_kernel()), 1, rules().rules, kWeight, box_kernel(), kTileExponent);
  std::vector<Image> result(1, Image(data));
  Collector collector(result, cascade);
  const std::vector<std::vector<std::byte>> carry{std::vector<std::byte>(17)};
  const auto fed = cascade.feed_carry({.first_column = 0, .row = 0, .tiles = carry}, collector);
  ASSERT_FALSE(fed.has_value());
  EXPECT_EQ(fed.error().code, ErrorCode::kCorrupt);
}

// The registration contract: a texel's value stands for its centre, at every level and up to the edges that data reach.
TEST(PlaneCascade, ARampStaysARamp) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()}) {
    Image level({0, 0, 257, 64});
    for (std::int64_t y = 0; y < 64; ++y)
      for (std::int64_t x = 0; x < 257; ++x) {
        level.at(x, y, 0) = static_cast<float>(x) + 0.5F;
        level.at(x, y, kWeight) = 1.0F;
      }
    for (int k = 1; k <= 4; ++k) {
      level = halve_whole(level, kernel);
      const double scale = 1 << k;
      const std::int64_t margin = 2 * kernel.reach() + 1;  // texels that the edge of the data can touch, over all levels
      for (std::int64_t x = margin; x < level.data.right() - margin; ++x) {
        const double position = level.get(x, level.data.height / 2, 0) / scale;
        EXPECT_NEAR(position, static_cast<double>(x) + 0.5, 0.01) << kernel.name << " level " << k;
      }
    }
  }
}

TEST(PlaneCascade, AConstantStaysConstantAndAHoleStaysAHole) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()}) {
    Image level({0, 0, 300, 200});
    for (std::int64_t y = 0; y < 200; ++y)
      for (std::int64_t x = 0; x < 300; ++x) {
        const bool is_hole = x >= 100 && x < 164 && y >= 60 && y < 124;
        level.at(x, y, 0) = is_hole ? 0.0F : 0.25F;
        level.at(x, y, kWeight) = is_hole ? 0.0F : 1.0F;
      }
    for (int k = 1; k <= 3; ++k) {
      level = halve_whole(level, kernel);
      for (std::int64_t y = 0; y < level.data.height; ++y)
        for (std::int64_t x = 0; x < level.data.width; ++x) {
          const float weight = level.get(x, y, kWeight);
          ASSERT_GE(weight, 0.0F);
          ASSERT_LE(weight, 1.0F);
          const std::int64_t fine_x = x << k;
          const std::int64_t fine_y = y << k;
          const std::int64_t size = std::int64_t{1} << k;
          const bool under_hole = fine_x >= 100 && fine_x + size <= 164 && fine_y >= 60 && fine_y + size <= 124;
          if (under_hole) {
            ASSERT_EQ(weight, 0.0F) << "data grew into the hole at level " << k;
          }
          // Float rounding of two passes over at most 12 taps a level.
          if (weight > 0.0F) {
            ASSERT_NEAR(level.get(x, y, 0) / weight, 0.25F, 1e-5F) << "the hole leaked at level " << k;
          }
        }
    }
  }
}

}  // namespace
}  // namespace vt::pyramid
