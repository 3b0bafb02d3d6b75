#include "builder/resample/base_sampler.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "builder/channels/all_channels.h"
#include "tests/resample/memory_source.h"

namespace vt::resample {
namespace {

using channels::SampleLayout;

constexpr TexelRect kLayer{0, 0, 90, 70};

std::uint32_t noise(std::uint32_t seed) {
  seed ^= seed >> 16;
  seed *= 0x7FEB352DU;
  seed ^= seed >> 15;
  seed *= 0x846CA68BU;
  return seed ^ seed >> 16;
}

PlacedSource color_source(const TexelRect& place, const SampleLayout& layout, std::uint32_t seed, TexelFormat format = TexelFormat::kRgb8) {
  const int bands = layout.value_bands + (layout.has_alpha ? 1 : 0);
  std::vector<std::byte> samples(static_cast<std::size_t>(place.width * place.height * bands));
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::byte>(noise(seed * 7919U + static_cast<std::uint32_t>(i)));
  // Holes and half-transparent places, where the layout can express them.
  for (std::size_t texel = 0; texel < samples.size() / static_cast<std::size_t>(bands); ++texel) {
    std::byte* at = samples.data() + texel * static_cast<std::size_t>(bands);
    const bool hole = noise(seed + static_cast<std::uint32_t>(texel / 5)) % 4 == 0;
    if (layout.has_alpha) at[bands - 1] = hole ? std::byte{0} : (texel % 3 == 0 ? at[bands - 1] : std::byte{255});
    if (layout.nodata && hole) std::memset(at, static_cast<int>(layout.nodata->of(0)), static_cast<std::size_t>(layout.value_bands));
  }
  PlacedSource source;
  source.raster = std::make_shared<MemorySource>(place.width, place.height, bands, SampleType::kUint8, std::move(samples));
  for (int b = 0; b < bands; ++b) source.bands.push_back(b);
  source.layout = layout;
  source.codec = channels::make_codec({.format = format, .transfer = Transfer::kSrgb}, layout).value();
  source.is_aligned = true;
  source.offset_x = place.x;
  source.offset_y = place.y;
  source.covered = intersect(place, kLayer);
  return source;
}

// A source of the same kind on a grid turned by half a radian.
PlacedSource turned_source(const SampleLayout& layout, std::uint32_t seed) {
  PlacedSource source = color_source({0, 0, 60, 60}, layout, seed);
  source.is_aligned = false;
  const geo::GeoTransform turned{-5.0, 0.9, -0.5, 10.0, -0.5, -0.9};
  source.warp = std::make_shared<const GridWarp>(GridPlacement{}, geo::Crs(), turned, geo::Crs());
  source.covered = kLayer;
  return source;
}

const SampleLayout kOpaque{};
const SampleLayout kWithNodata{.nodata = 9.0};
const SampleLayout kGrey{.value_bands = 1};
const SampleLayout kWithAlpha{.has_alpha = true};

// Definition: planes of one texel from all sources under it, one after the other.
std::array<float, 4> defined_texel(const std::vector<PlacedSource>& sources, std::int64_t x, std::int64_t y) {
  std::array<float, 4> below{};
  for (const PlacedSource& source : sources) {
    if (!source.covered.contains(x, y)) continue;
    std::vector<std::byte> sample(source.layout.texel_bytes());
    EXPECT_TRUE(source.read({x - source.offset_x, y - source.offset_y, 1, 1}, sample, sample.size(), nullptr).has_value());
    std::array<float, 4> above{};
    source.codec->decode_row(sample.data(), 1, {&above[0], &above[1], &above[2], &above[3]});
    for (std::size_t p = 0; p < 4; ++p) below[p] = above[3] == 1.0F ? above[p] : above[p] + (1.0F - above[3]) * below[p];
  }
  return below;
}

// Loads `rect` and compares planes and, where they are passed on, texels with the definition.
void expect_defined(const BaseSampler& sampler, const std::vector<PlacedSource>& sources, const TexelRect& rect, int& passed) {
  BaseChunk chunk;
  ASSERT_TRUE(sampler.load(rect, chunk).has_value());
  std::vector<float> planes(static_cast<std::size_t>(rect.width * 4));
  const std::int64_t w = rect.width;
  for (std::int64_t row = 0; row < rect.height; ++row) {
    const bool opaque = chunk.decode_row(row, {planes.data(), planes.data() + w, planes.data() + 2 * w, planes.data() + 3 * w});
    const std::byte* texels = chunk.texel_row(row);
    passed += texels != nullptr ? 1 : 0;
    bool all_opaque = true;
    for (std::int64_t i = 0; i < w; ++i) {
      const std::array<float, 4> wanted = defined_texel(sources, rect.x + i, rect.y + row);
      for (std::size_t p = 0; p < 4; ++p)
        ASSERT_EQ(planes[p * static_cast<std::size_t>(w) + static_cast<std::size_t>(i)], wanted[p]) << rect.x + i << "," << rect.y + row;
      all_opaque = all_opaque && wanted[3] == 1.0F;
      if (texels == nullptr) continue;
      // What is passed on is what encoding the planes would give.
      const channels::ConstPlaneRow here{&wanted[0], &wanted[1], &wanted[2], &wanted[3]};
      std::array<std::byte, 3> encoded{};
      ASSERT_TRUE(sampler.codec().encode_row(0, {here, here, here, true}, 1, encoded.data()).has_value());
      ASSERT_EQ(std::memcmp(encoded.data(), texels + i * 3, 3), 0) << rect.x + i << "," << rect.y + row;
    }
    EXPECT_EQ(opaque, all_opaque);
  }
}

TEST(BaseSampler, AnyMixtureOfSourcesIsTheirDefinitionInAnyRectangle) {
  std::mt19937 random(3);
  const auto below = [&](std::int64_t limit) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(limit)); };
  int passed = 0;
  for (int round = 0; round < 60; ++round) {
    // Rounds of one layout reach the path for samples, mixed ones that for planes.
    const std::array<SampleLayout, 4> layouts{kOpaque, kWithNodata, kGrey, kWithAlpha};
    std::vector<PlacedSource> sources;
    const bool grid = round % 3 == 0;
    for (std::int64_t i = 0; i < 12; ++i) {
      const SampleLayout& layout = layouts[round % 2 == 0 ? static_cast<std::size_t>(round / 2 % 4) : random() % 4];
      const TexelRect place = grid ? TexelRect{i % 4 * 23, i / 4 * 24, 23 + below(9), 24}
                                   : TexelRect{below(90) - 20, below(70) - 20, 1 + below(70), 1 + below(70)};
      sources.push_back(color_source(place, layout, static_cast<std::uint32_t>(round * 100 + i)));
    }
    const BaseSampler sampler(sources, kLayer.width, kLayer.height);
    for (int i = 0; i < 6; ++i) {
      const TexelRect rect = intersect(i == 0 ? kLayer : TexelRect{below(80), below(60), 1 + below(50), 1 + below(32)}, kLayer);
      expect_defined(sampler, sources, rect, passed);
    }
  }
  EXPECT_GT(passed, 100) << "the path that copies texels has to be met";
}

TEST(BaseSampler, ASourceWithCoveragePassesItsTexelsOnOnlyWhenItIsAllThereIs) {
  const PlacedSource whole = color_source(kLayer, kWithAlpha, 1, TexelFormat::kRgba8);
  EXPECT_TRUE(BaseSampler({whole}, kLayer.width, kLayer.height).passes_texels());
  // In a larger layer its edge has neighbours without data.
  const BaseSampler part({whole}, kLayer.width + 1, kLayer.height);
  EXPECT_FALSE(part.passes_texels());
  BaseChunk chunk;
  ASSERT_TRUE(part.load({0, 0, 8, 8}, chunk).has_value());
  EXPECT_EQ(chunk.texel_row(0), nullptr);
}

store::ContentHash loaded_content(const BaseSampler& sampler, const TexelRect& rect) {
  BaseChunk chunk;
  store::ContentHasher hasher;
  EXPECT_TRUE(sampler.load(rect, chunk, &hasher).has_value());
  return hasher.digest();
}

store::ContentHash hashed_content(const BaseSampler& sampler, const TexelRect& rect) {
  BaseChunk chunk;
  store::ContentHasher hasher;
  EXPECT_TRUE(sampler.hash(rect, chunk, hasher).has_value());
  return hasher.digest();
}

BaseSampler sampler_of(std::vector<PlacedSource> sources) { return {std::move(sources), kLayer.width, kLayer.height}; }

TEST(BaseSampler, HashAndLoadAddTheSame) {
  const std::vector<PlacedSource> sources{color_source({0, 0, 40, 40}, kOpaque, 1), color_source({30, 10, 40, 40}, kWithNodata, 2),
                                          turned_source(kWithAlpha, 3)};
  const BaseSampler sampler = sampler_of(sources);
  for (const TexelRect& rect : {kLayer, TexelRect{0, 0, 8, 8}, TexelRect{35, 20, 20, 20}, TexelRect{88, 68, 2, 2}})
    EXPECT_EQ(hashed_content(sampler, rect), loaded_content(sampler, rect));
}

TEST(BaseSampler, ContentKnowsWhatIsSeenAndNothingElse) {
  const TexelRect rect{10, 10, 20, 20};
  const PlacedSource base = color_source({0, 0, 60, 60}, kOpaque, 1);
  const PlacedSource holed = color_source({5, 5, 30, 30}, kWithNodata, 2);
  const store::ContentHash content = hashed_content(sampler_of({base, holed}), rect);

  // A source elsewhere, before or after in the list.
  const PlacedSource elsewhere = color_source({40, 40, 20, 20}, kOpaque, 3);
  EXPECT_EQ(hashed_content(sampler_of({elsewhere, base, holed}), rect), content);
  EXPECT_EQ(hashed_content(sampler_of({base, holed, elsewhere}), rect), content);
  // One that lies here, but wholly under another.
  EXPECT_EQ(hashed_content(sampler_of({color_source({0, 0, 40, 40}, kOpaque, 4), base, holed}), rect), content);

  EXPECT_NE(hashed_content(sampler_of({base}), rect), content) << "a source less";
  EXPECT_NE(hashed_content(sampler_of({base, color_source({5, 5, 30, 30}, kWithNodata, 4)}), rect), content) << "other samples";
  PlacedSource other_nodata = holed;
  other_nodata.layout.nodata = 10.0;
  EXPECT_NE(hashed_content(sampler_of({base, other_nodata}), rect), content) << "other settings";
  PlacedSource other_bands = base;
  other_bands.bands = {2, 1, 0};
  EXPECT_NE(hashed_content(sampler_of({other_bands, holed}), rect), content) << "other bands";
  PlacedSource shifted = holed;
  shifted.offset_x += 1;
  EXPECT_NE(hashed_content(sampler_of({base, shifted}), rect), content) << "another place";
  EXPECT_NE(hashed_content(sampler_of({base, color_source({30, 5, 30, 30}, kWithNodata, 2)}), rect), content)
      << "only the edge of the rectangle";

  const PlacedSource turned = turned_source(kOpaque, 5);
  const store::ContentHash turned_content = hashed_content(sampler_of({turned}), rect);
  PlacedSource moved = turned;
  moved.warp = std::make_shared<const GridWarp>(GridPlacement{}, geo::Crs(), geo::GeoTransform{-5.0, 0.9, -0.5, 10.0 + 1e-9, -0.5, -0.9},
                                                geo::Crs());
  EXPECT_NE(hashed_content(sampler_of({moved}), rect), turned_content) << "other weights from the same samples";
}

TEST(BaseSampler, NearestTakesTheSampleUnderTheCentre) {
  for (const SampleLayout& layout : {kOpaque, kWithAlpha, kWithNodata}) {
    PlacedSource source = turned_source(layout, 6);
    source.method = Method::kNearest;
    const BaseSampler sampler = sampler_of({source});
    const TexelRect rect{3, 5, 50, 33};
    BaseChunk chunk;
    ASSERT_TRUE(sampler.load(rect, chunk).has_value());
    std::vector<float> planes(static_cast<std::size_t>(rect.width * 4));
    const std::int64_t w = rect.width;
    int inside = 0;
    for (std::int64_t row = 0; row < rect.height; ++row) {
      chunk.decode_row(row, {planes.data(), planes.data() + w, planes.data() + 2 * w, planes.data() + 3 * w});
      for (std::int64_t i = 0; i < w; ++i) {
        const Point2 place = source.warp->exact({static_cast<double>(rect.x + i) + 0.5, static_cast<double>(rect.y + row) + 0.5});
        std::array<float, 4> wanted{};
        if (place.x >= 0 && place.y >= 0 && place.x < 60 && place.y < 60) {
          std::vector<std::byte> sample(layout.texel_bytes());
          const source::Window one{static_cast<std::int64_t>(place.x), static_cast<std::int64_t>(place.y), 1, 1};
          ASSERT_TRUE(source.read(one, sample, sample.size(), nullptr).has_value());
          source.codec->decode_row(sample.data(), 1, {&wanted[0], &wanted[1], &wanted[2], &wanted[3]});
          ++inside;
        }
        for (std::size_t p = 0; p < 4; ++p)
          ASSERT_EQ(planes[p * static_cast<std::size_t>(w) + static_cast<std::size_t>(i)], wanted[p]) << i << "," << row;
      }
    }
    EXPECT_GT(inside, 500);
    EXPECT_EQ(hashed_content(sampler, rect), loaded_content(sampler, rect));
    EXPECT_NE(hashed_content(sampler, rect), hashed_content(sampler_of({turned_source(layout, 6)}), rect))
        << "another method, other texels";
  }
}

TEST(BaseSampler, TouchesOnlyWhatASourceCovers) {
  const BaseSampler sampler = sampler_of({color_source({10, 10, 5, 5}, kOpaque, 1), color_source({50, 40, 100, 100}, kOpaque, 2)});
  EXPECT_TRUE(sampler.touches({0, 0, 11, 11}));
  EXPECT_FALSE(sampler.touches({0, 0, 10, 70}));
  EXPECT_FALSE(sampler.touches({15, 0, 35, 70}));
  EXPECT_TRUE(sampler.touches({89, 69, 1, 1}));
}

TEST(BaseSampler, PassesHintsOnInTheSourcesOwnRows) {
  const PlacedSource north = color_source({0, 0, 90, 30}, kOpaque, 1);
  const PlacedSource south = color_source({0, 20, 90, 50}, kOpaque, 2);
  const BaseSampler sampler = sampler_of({north, south});
  for (const std::int64_t row : {10, 25, 20, 40, 70}) sampler.release_rows_before(row);
  const auto released = [](const PlacedSource& source) { return static_cast<const MemorySource&>(*source.raster).released; };
  EXPECT_EQ(released(north), (std::vector<std::int64_t>{10, 25, 30}));
  EXPECT_EQ(released(south), (std::vector<std::int64_t>{5, 20, 50}));
}

TEST(BaseSampler, ARectangleWithoutSourcesHasNoDataAndNoContent) {
  const BaseSampler sampler = sampler_of({color_source({10, 10, 5, 5}, kOpaque, 1)});
  BaseChunk chunk;
  ASSERT_TRUE(sampler.load({40, 40, 3, 2}, chunk).has_value());
  std::array<float, 12> planes;
  planes.fill(1.0F);
  EXPECT_FALSE(chunk.decode_row(1, {&planes[0], &planes[3], &planes[6], &planes[9]}));
  for (const float value : planes) EXPECT_EQ(value, 0.0F);
  EXPECT_EQ(hashed_content(sampler, {40, 40, 3, 2}), store::ContentHasher().digest());
}

}  // namespace
}  // namespace vt::resample
