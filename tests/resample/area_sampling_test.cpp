// Layers that are coarser than their sources, and sources that continue each other, against brute force over
// every sample.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <random>

#include "builder/channels/all_channels.h"
#include "builder/resample/base_sampler.h"
#include "builder/resample/grid/footprint.h"
#include "tests/resample/memory_source.h"
#include "tests/resample/polygon_area.h"

namespace vt::resample {
namespace {

using channels::ChannelSettings;
using channels::SampleLayout;

// Bands of samples, as their layout says.
struct Raster {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 1;
  std::function<double(std::int64_t, std::int64_t, int)> value;
};

double noise(std::int64_t x, std::int64_t y, int band) {
  auto h = static_cast<std::uint32_t>(x * 7919 + y * 104729 + band * 1299709 + 12345);
  h ^= h >> 16;
  h *= 0x7FEB352DU;
  h ^= h >> 15;
  h *= 0x846CA68BU;
  h ^= h >> 16;
  return h % 10000 / 10000.0;
}

PlacedSource placed(const Raster& raster, const ChannelSettings& settings, SampleLayout layout, const geo::GeoTransform& transform,
                    const GridPlacement& grid, const TexelRect& layer, const geo::Crs& source_crs = {}, const geo::Crs& crs = {}) {
  const std::size_t bytes = sample_bytes(layout.type);
  std::vector<std::byte> samples(static_cast<std::size_t>(raster.width * raster.height * raster.bands) * bytes);
  std::byte* at = samples.data();
  for (std::int64_t y = 0; y < raster.height; ++y)
    for (std::int64_t x = 0; x < raster.width; ++x)
      for (int b = 0; b < raster.bands; ++b, at += bytes) {
        const auto put = [&](auto sample) { std::memcpy(at, &sample, sizeof sample); };
        const double v = raster.value(x, y, b);
        if (layout.type == SampleType::kFloat32)
          put(static_cast<float>(v));
        else if (layout.type == SampleType::kFloat64)
          put(v);
        else
          put(static_cast<std::uint8_t>(v));
      }
  PlacedSource source;
  source.raster = std::make_shared<MemorySource>(raster.width, raster.height, raster.bands, layout.type, std::move(samples));
  for (int b = 0; b < raster.bands; ++b) source.bands.push_back(b);
  source.layout = layout;
  source.codec = channels::make_codec(settings, layout).value();
  source.warp = std::make_shared<const GridWarp>(grid, crs, transform, source_crs);
  if (source.codec->class_counting()) source.method = Method::kNearest;
  source.covered = layer;
  return source;
}

const ChannelSettings kHeights{.channel = ChannelType::kElevation, .format = TexelFormat::kR32Float, .options = {{"bounds", "yes"}}};
const SampleLayout kOneFloat{.type = SampleType::kFloat32, .value_bands = 1};

ChannelSettings radiance() {
  ChannelSettings settings;
  settings.channel = ChannelType::kSensor;
  settings.format = TexelFormat::kR32Float;
  return settings;
}

// All texels of a layer, loaded in one piece or in pieces.
struct Texels {
  TexelRect layer;
  int planes = 0;
  std::vector<float> floats;

  [[nodiscard]] float at(std::int64_t x, std::int64_t y, int plane) const {
    return floats[static_cast<std::size_t>((y * layer.width + x) * planes + plane)];
  }
};

Texels texels_of(const BaseSampler& sampler, const TexelRect& layer, std::int64_t piece_width = 1 << 20,
                 std::int64_t piece_height = 1 << 20) {
  Texels texels{layer, sampler.codec().planes(), {}};
  texels.floats.resize(static_cast<std::size_t>(layer.width * layer.height * texels.planes));
  BaseChunk chunk;
  for (std::int64_t y = 0; y < layer.height; y += piece_height)
    for (std::int64_t x = 0; x < layer.width; x += piece_width) {
      const TexelRect rect = intersect(layer, {x, y, piece_width, piece_height});
      EXPECT_TRUE(sampler.load(rect, chunk).has_value());
      std::vector<float> row(static_cast<std::size_t>(rect.width * texels.planes));
      channels::PlaneRow planes{};
      for (int p = 0; p < texels.planes; ++p) planes[static_cast<std::size_t>(p)] = row.data() + p * rect.width;
      for (std::int64_t j = 0; j < rect.height; ++j) {
        chunk.decode_row(j, planes);
        for (std::int64_t i = 0; i < rect.width; ++i)
          for (int p = 0; p < texels.planes; ++p)
            texels.floats[static_cast<std::size_t>(((rect.y + j) * layer.width + rect.x + i) * texels.planes + p)] =
                planes[static_cast<std::size_t>(p)][i];
      }
    }
  return texels;
}

// The definition of a surface's weight at `centre` over `width` samples, along one axis: intervals of n and
// n + 1 samples, in long double.
long double surface_weight(long double centre, long double width, std::int64_t sample, std::int64_t end) {
  const long double to_end = std::min(centre, static_cast<long double>(end) - centre);
  width = std::max<long double>(1, std::min(width, 2 * to_end));
  const long double whole = std::floor(width + 1e-6L);
  const long double rest = whole + 1 <= 2 * to_end ? std::max<long double>(0, width - whole) : 0;
  const auto covered = [&](long double length) {
    const long double low = std::max(centre - length / 2, static_cast<long double>(sample));
    const long double high = std::min(centre + length / 2, static_cast<long double>(sample + 1));
    return std::max<long double>(0, high - low);
  };
  return (1 - rest) * covered(whole) + rest * covered(whole + 1);
}

// The definition: planes of every sample, as the codec derives them, by the area that the texel's
// quadrilateral covers of it; of a surface by its own weights.
std::vector<double> defined_texel(const PlacedSource& source, std::int64_t x, std::int64_t y) {
  const auto fx = static_cast<double>(x);
  const auto fy = static_cast<double>(y);
  const GridWarp& warp = *source.warp;
  const std::array<Point2, 4> corners{warp.exact({fx, fy}), warp.exact({fx + 1, fy}), warp.exact({fx + 1, fy + 1}),
                                      warp.exact({fx, fy + 1})};
  const auto polygon = test::polygon_of(corners);
  const channels::ChannelCodec& codec = *source.codec;
  const auto planes = static_cast<std::size_t>(codec.planes());
  std::vector<long double> sum(planes, 0);
  long double area = 0;
  for (std::size_t p = 0; p < planes; ++p) {
    if (codec.rules()[p] == channels::PlaneRule::kLeast) sum[p] = std::numeric_limits<long double>::infinity();
    if (codec.rules()[p] == channels::PlaneRule::kGreatest) sum[p] = -std::numeric_limits<long double>::infinity();
  }
  const source::RasterInfo& info = source.raster->info();
  const Point2 centre = warp.exact({fx + 0.5, fy + 0.5});
  const auto width = [&](const auto& axis) {
    const long double across = (axis(corners[1]) - axis(corners[0]) + axis(corners[2]) - axis(corners[3])) / 2;
    const long double down = (axis(corners[3]) - axis(corners[0]) + axis(corners[2]) - axis(corners[1])) / 2;
    return std::sqrt(across * across + down * down);
  };
  const long double width_x = width([](const Point2& p) { return static_cast<long double>(p.x); });
  const long double width_y = width([](const Point2& p) { return static_cast<long double>(p.y); });
  for (std::int64_t row = 0; row < info.height; ++row)
    for (std::int64_t column = 0; column < info.width; ++column) {
      const long double under = test::covered_area(polygon, column, row);
      long double covered = under;
      if (codec.is_surface())
        covered = surface_weight(centre.x, width_x, column, info.width) * surface_weight(centre.y, width_y, row, info.height);
      if (covered <= 0 && under <= 0) continue;
      area += covered;
      std::vector<std::byte> sample(source.layout.texel_bytes());
      EXPECT_TRUE(source.read({column, row, 1, 1}, sample, sample.size(), nullptr).has_value());
      std::vector<float> values(planes);
      channels::PlaneRow pointers{};
      for (std::size_t p = 0; p < planes; ++p) pointers[p] = &values[p];
      codec.decode_row(sample.data(), 1, pointers);
      codec.derive_row(1, pointers);
      for (std::size_t p = 0; p < planes; ++p) {
        if (is_sum(codec.rules()[p])) sum[p] += covered * static_cast<long double>(values[p]);
        if (std::max(covered, under) <= static_cast<long double>(kLeastTouch) ||
            values[static_cast<std::size_t>(codec.weight_plane())] == 0.0F)
          continue;
        if (codec.rules()[p] == channels::PlaneRule::kLeast) sum[p] = std::min(sum[p], static_cast<long double>(values[p]));
        if (codec.rules()[p] == channels::PlaneRule::kGreatest) sum[p] = std::max(sum[p], static_cast<long double>(values[p]));
      }
    }
  std::vector<double> result(planes, std::numeric_limits<double>::quiet_NaN());
  if (area > 0)
    for (std::size_t p = 0; p < planes; ++p) {
      result[p] = static_cast<double>(is_sum(codec.rules()[p]) ? sum[p] / area : sum[p]);
      // What a plane and its remainder hold together.
      if (codec.rules()[p] == channels::PlaneRule::kRemainder) result[p] += std::exchange(result[p - 1], 0.0);
    }
  return result;
}

geo::GeoTransform turned(double x0, double y0, double size, double angle) {
  return {x0, std::cos(angle) * size, std::sin(angle) * size, y0, std::sin(angle) * size, -std::cos(angle) * size};
}

struct Kind {
  const char* name;
  ChannelSettings settings;
  SampleLayout layout;
  Raster raster;
};

std::vector<Kind> kinds() {
  const auto holes = [](std::int64_t x, std::int64_t y) { return (x / 5 + y / 7) % 4 == 0; };
  const Raster one{.width = 61, .height = 53, .bands = 1, .value = [holes](std::int64_t x, std::int64_t y, int b) {
                     return holes(x, y) ? -9999.0 : std::floor(1000 * noise(x, y, b));
                   }};
  SampleLayout with_holes = kOneFloat;
  with_holes.nodata = -9999.0;
  std::vector<Kind> all;
  const auto add = [&](const char* name, ChannelType channel, TexelFormat format, const channels::Options& options,
                       const SampleLayout& layout, const Raster& raster) {
    ChannelSettings settings;
    settings.channel = channel;
    settings.format = format;
    settings.options = options;
    if (channel == ChannelType::kColor) settings.transfer = Transfer::kSrgb;
    all.push_back({name, settings, layout, raster});
  };
  add("heights and their bounds", ChannelType::kElevation, TexelFormat::kR32Float, {{"bounds", "yes"}}, with_holes, one);
  const Raster codes{
      .width = 61, .height = 53, .bands = 4, .value = [](auto x, auto y, int b) { return std::floor(256 * noise(x, y, b)); }};
  add("colour with coverage", ChannelType::kColor, TexelFormat::kRgba8, {}, {.value_bands = 3, .has_alpha = true}, codes);
  const Raster angles{.width = 61, .height = 53, .bands = 2, .value = [](auto x, auto y, int b) { return noise(x, y, b) - 0.2; }};
  add("horizons and their squares", ChannelType::kHorizon, TexelFormat::kRgba16, {}, {.type = SampleType::kFloat32, .value_bands = 2},
      angles);
  const Raster slopes{
      .width = 61, .height = 53, .bands = 3, .value = [](auto x, auto y, int b) { return b == 2 ? 1.0 : 2 * noise(x, y, b) - 1; }};
  add("normals and their moments", ChannelType::kNormal, TexelFormat::kRgba16, {{"moments", "lean"}},
      {.type = SampleType::kFloat32, .value_bands = 3}, slopes);
  add("radiance", ChannelType::kSensor, TexelFormat::kR32Float, {}, with_holes, one);
  return all;
}

// Whole, broken and large ratios, turned and sheared sources, grids that do not begin together.
TEST(AreaSampling, ATexelIsTheMeanOfAllThatLiesUnderIt) {
  const TexelRect layer{0, 0, 12, 11};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  const std::vector<geo::GeoTransform> places{
      {0.0, 0.25, 0.0, 0.0, 0.0, -0.25}, {-0.13, 0.4, 0.0, 0.21, 0.0, -0.37}, {0.0, 0.2, 0.0, -11.0, 0.0, 0.2},  // from south to north
      {0.2, 0.93, 0.0, -0.1, 0.0, -0.2}, turned(1.0, -4.0, 0.3, 0.5),         turned(5.0, -14.0, 0.22, 2.2),
      {2.0, 0.2, 0.1, -1.0, 0.05, -0.3},
  };
  for (const Kind& kind : kinds())
    for (const geo::GeoTransform& place : places) {
      const PlacedSource source = placed(kind.raster, kind.settings, kind.layout, place, grid, layer);
      const BaseSampler sampler({source}, layer.width, layer.height);
      const Texels texels = texels_of(sampler, layer);
      int with_data = 0;
      for (std::int64_t y = 0; y < layer.height; ++y)
        for (std::int64_t x = 0; x < layer.width; ++x) {
          const Point2 centre = source.warp->exact({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
          const bool is_in = centre.x >= 0 && centre.y >= 0 && centre.x <= 61 && centre.y <= 53;
          const std::vector<double> wanted = defined_texel(source, x, y);
          for (int p = 0; p < texels.planes; ++p) {
            const double w = wanted[static_cast<std::size_t>(p)];
            const float found = texels.at(x, y, p);
            if (!is_in) {
              if (is_sum(sampler.codec().rules()[static_cast<std::size_t>(p)])) {
                ASSERT_EQ(found, 0.0F);
              }
              continue;
            }
            if (std::isinf(w)) {
              ASSERT_EQ(found, static_cast<float>(w));
              continue;
            }
            const auto rule_of = [&](int plane) { return sampler.codec().rules()[static_cast<std::size_t>(plane)]; };
            if (p + 1 < texels.planes && rule_of(p + 1) == channels::PlaneRule::kRemainder) continue;  // looked at with its remainder
            if (rule_of(p) == channels::PlaneRule::kRemainder) {
              const double both = static_cast<double>(texels.at(x, y, p - 1)) + static_cast<double>(found);
              ASSERT_NEAR(both, w, 1e-12 * std::max(1.0, std::abs(w))) << kind.name << " of " << x << "," << y;
              continue;
            }
            // Near an edge a surface's weights are narrower than its footprint along one axis alone: samples
            // beside both may be touched.
            const channels::PlaneRule rule = sampler.codec().rules()[static_cast<std::size_t>(p)];
            const bool is_near_edge = centre.x < 6 || centre.y < 6 || centre.x > 55 || centre.y > 47;
            if (is_near_edge && !is_sum(rule)) {
              ASSERT_TRUE(rule == channels::PlaneRule::kLeast ? found <= w : found >= w) << kind.name << " of " << x << "," << y;
              continue;
            }
            // Sums are in double; what is given out is rounded to float once.
            ASSERT_NEAR(found, w, 1e-7 * std::max(1.0, std::abs(w))) << kind.name << " plane " << p << " of " << x << "," << y;
          }
          with_data += is_in ? 1 : 0;
        }
      EXPECT_GT(with_data, 20) << kind.name;
    }
}

TEST(AreaSampling, WholeRatiosKeepTheMeanOfTheSource) {
  for (const int ratio : {2, 3, 8, 50, 600}) {
    const TexelRect layer{0, 0, ratio > 100 ? 3 : 8, ratio > 100 ? 2 : 6};
    const Raster raster{.width = layer.width * ratio, .height = layer.height * ratio, .bands = 1, .value = [](auto x, auto y, int) {
                          return x % 8 == 3 && y % 8 == 5 ? 64.0 : 0.01 * noise(x, y, 0);
                        }};
    const double size = 1.0 / ratio;
    const PlacedSource source = placed(raster, kHeights, kOneFloat, {0.0, size, 0.0, 0.0, 0.0, -size}, {0.0, 0.0, 1.0, 1.0}, layer);
    const BaseSampler sampler({source}, layer.width, layer.height);
    const Texels texels = texels_of(sampler, layer);
    long double mean = 0;
    float greatest = 0.0F;
    for (std::int64_t y = 0; y < layer.height; ++y)
      for (std::int64_t x = 0; x < layer.width; ++x) {
        mean += static_cast<long double>(texels.at(x, y, 0));
        greatest = std::max(greatest, texels.at(x, y, 3));
        EXPECT_EQ(texels.at(x, y, 1), 1.0F);
      }
    mean /= static_cast<long double>(layer.width * layer.height);
    long double wanted = 0;
    for (std::int64_t y = 0; y < raster.height; ++y)
      for (std::int64_t x = 0; x < raster.width; ++x) wanted += static_cast<long double>(static_cast<float>(raster.value(x, y, 0)));
    wanted /= static_cast<long double>(raster.width * raster.height);
    EXPECT_NEAR(static_cast<double>(mean / wanted), 1.0, 1e-7) << ratio;
    EXPECT_EQ(greatest, 64.0F) << ratio;
  }
}

// What a texel is does not depend on what is read with it: in one piece, one by one, and through bands of
// rows and halves.
TEST(AreaSampling, PiecesDoNotShow) {
  const TexelRect layer{0, 0, 40, 36};
  const geo::Crs utm = geo::Crs::from_epsg(32633).value();
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  const Raster raster{.width = 700, .height = 640, .bands = 1, .value = [](auto x, auto y, int b) { return noise(x, y, b); }};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  std::vector<PlacedSource> sources{
      placed(raster, kHeights, kOneFloat, {0.0, 0.06, 0.0, 0.0, 0.0, -0.06}, grid, layer),
      placed(raster, kHeights, kOneFloat, turned(2.0, -5.0, 0.05, 0.6), grid, layer),
      placed(raster, kHeights, kOneFloat, turned(2.0, -5.0, 0.9, 0.6), grid, layer),
      // From one sample under a texel in the west to two in the east, so that both ways of making texels
      // meet.
      placed(raster, kHeights, kOneFloat, {500000.0, 110000.0 / 80, 0.0, 7000000.0, 0.0, -110000.0 / 30}, {15.0, 63.0, 0.033, 0.033}, layer,
             utm, geographic),
      placed({700, 640, 1, [](auto x, auto y, int b) { return std::floor(4 * noise(x / 3, y / 3, b)); }},
             {.channel = ChannelType::kMask, .format = TexelFormat::kR8, .options = {{"inside", "1,3"}}}, kOneFloat,
             {0.3, 0.055, 0.0, -0.2, 0.0, -0.057}, grid, layer),
  };
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const BaseSampler sampler({sources[i]}, layer.width, layer.height);
    const Texels whole = texels_of(sampler, layer);
    EXPECT_EQ(texels_of(sampler, layer, 1, 1).floats, whole.floats) << i;
    EXPECT_EQ(texels_of(sampler, layer, 7, 32).floats, whole.floats) << i;
    EXPECT_EQ(texels_of(sampler, layer, 40, 5).floats, whole.floats) << i;
    BaseChunk chunk;
    for (const TexelRect& rect : {layer, TexelRect{3, 4, 20, 9}}) {
      store::ContentHasher loaded;
      store::ContentHasher hashed;
      ASSERT_TRUE(sampler.load(rect, chunk, &loaded).has_value());
      ASSERT_TRUE(sampler.hash(rect, chunk, hashed).has_value());
      EXPECT_EQ(loaded.digest(), hashed.digest()) << i;
    }
  }
}

// A footprint of more samples than are ever decoded at once.
TEST(AreaSampling, AVastFootprintIsAddedUpByBands) {
  const TexelRect layer{0, 0, 2, 1};
  const Raster raster{.width = 1400, .height = 700, .bands = 1, .value = [](auto x, auto y, int b) { return noise(x, y, b); }};
  ASSERT_GT(700 * 700, kMostWindowSamples + kMostWindowSamples / 2);
  for (const ChannelSettings& settings : {kHeights, radiance()})
    for (const double angle : {0.0, 0.4}) {
      // About the middle of both.
      const double x0 = 1.0 - (std::cos(angle) + std::sin(angle) / 2);
      const double y0 = -0.5 - (std::sin(angle) - std::cos(angle) / 2);
      const PlacedSource source = placed(raster, settings, kOneFloat, turned(x0, y0, 1.0 / 700, angle), {0.0, 0.0, 1.0, 1.0}, layer);
      const BaseSampler sampler({source}, layer.width, layer.height);
      const Texels texels = texels_of(sampler, layer);
      const std::vector<double> wanted = defined_texel(source, 1, 0);
      for (int p = 0; p < texels.planes; ++p)
        EXPECT_NEAR(texels.at(1, 0, p), wanted[static_cast<std::size_t>(p)], 1e-7) << angle << " plane " << p;
      EXPECT_LE(static_cast<const MemorySource&>(*source.raster).largest_read, kMostWindowSamples);
    }
}

// Footprints of one sample are bilinear interpolation, as ever: a ramp is a ramp.
TEST(AreaSampling, ALayerAsFineAsItsSourceKeepsRamps) {
  const TexelRect layer{0, 0, 50, 40};
  for (const double angle : {0.0, 0.3, 0.785398, 1.9})
    for (const double size : {1.0, 1.7, 12.0}) {
      const Raster raster{
          .width = 60, .height = 60, .bands = 1, .value = [](auto x, auto y, int) { return 3.0 * (x + 0.5) - 2.0 * (y + 0.5); }};
      const PlacedSource source = placed(
          raster, kHeights, kOneFloat,
          turned(25 - 30 * size * (std::cos(angle) + std::sin(angle)), -20 - 30 * size * (std::sin(angle) - std::cos(angle)), size, angle),
          {0.0, 0.0, 1.0, 1.0}, layer);
      const BaseSampler sampler({source}, layer.width, layer.height);
      const Texels texels = texels_of(sampler, layer);
      int seen = 0;
      for (std::int64_t y = 0; y < layer.height; ++y)
        for (std::int64_t x = 0; x < layer.width; ++x) {
          const Point2 p = source.warp->exact({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
          if (!(p.x > 0.5 && p.y > 0.5 && p.x < 59.5 && p.y < 59.5)) continue;
          ASSERT_NEAR(texels.at(x, y, 0), 3.0 * p.x - 2.0 * p.y, 2e-5) << angle;  // floats of up to 180
          ++seen;
        }
      EXPECT_GT(seen, 100) << angle << " " << size;
    }
}

ChannelSettings wide_heights() {
  ChannelSettings settings = kHeights;
  settings.options = {};
  settings.samples_are_wide = true;
  return settings;
}
const SampleLayout kOneDouble{.type = SampleType::kFloat64, .value_bands = 1};

// A millimetre at 1000 km, of which floats would lose up to 31: between samples, and as the mean of many.
TEST(AreaSampling, WideHeightsKeepWhatFloatsLose) {
  const TexelRect layer{0, 0, 16, 14};
  const Raster raster{.width = 61, .height = 53, .bands = 1, .value = [](auto x, auto y, int b) {
                        return 1e6 + 40.0 * noise(x, y, b) + 0.001 * noise(y, x, b);
                      }};
  const auto sample = [&](std::int64_t x, std::int64_t y) { return static_cast<long double>(raster.value(x, y, 0)); };
  for (const double size : {1.0, 0.25}) {
    const geo::GeoTransform place{-3.375 * size, size, 0.0, 4.625 * size, 0.0, -size};  // fractions of samples that floats hold
    const PlacedSource source = placed(raster, wide_heights(), kOneDouble, place, {0.0, 0.0, 1.0, 1.0}, layer);
    ASSERT_EQ(source.codec->rules()[1], channels::PlaneRule::kRemainder);
    const Texels texels = texels_of(BaseSampler({source}, layer.width, layer.height), layer);
    int seen = 0;
    for (std::int64_t y = 0; y < layer.height; ++y)
      for (std::int64_t x = 0; x < layer.width; ++x) {
        const Point2 p = source.warp->exact({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
        if (!(p.x > 3 && p.y > 3 && p.x < 58 && p.y < 50)) continue;
        long double wanted = 0;
        if (size == 1.0) {
          const auto column = static_cast<std::int64_t>(std::floor(p.x - 0.5));
          const auto row = static_cast<std::int64_t>(std::floor(p.y - 0.5));
          const long double fx = static_cast<long double>(p.x) - 0.5L - static_cast<long double>(column);
          const long double fy = static_cast<long double>(p.y) - 0.5L - static_cast<long double>(row);
          wanted = (1 - fy) * ((1 - fx) * sample(column, row) + fx * sample(column + 1, row)) +
                   fy * ((1 - fx) * sample(column, row + 1) + fx * sample(column + 1, row + 1));
        } else {
          wanted = static_cast<long double>(defined_texel(source, x, y)[1]);  // of both planes
        }
        // Two floats hold 48 bits: 2^-29 of a metre at 1000 km.
        const long double found = static_cast<long double>(texels.at(x, y, 0)) + static_cast<long double>(texels.at(x, y, 1));
        ASSERT_NEAR(static_cast<double>(found - wanted), 0.0, 0x1p-28) << size << " " << x << "," << y;
        ++seen;
      }
    EXPECT_GT(seen, 80) << size;
  }
}

// The figure that the header gives.
TEST(AreaSampling, ABrokenRatioMovesARampByNoMoreThanItSays) {
  const TexelRect layer{0, 0, 64, 4};
  for (const double ratio : {1.04, 1.25, 4.0 / 3, 1.5, 1.9, 2.5, 3.5, 7.3}) {
    const Raster raster{.width = 500, .height = 40, .bands = 1, .value = [](auto x, auto, int) { return x + 0.5; }};
    const double size = 1.0 / ratio;
    const geo::GeoTransform place{-1.0, size, 0.0, 1.0, 0.0, -size};
    const auto worst_of = [&](const ChannelSettings& settings) {
      const BaseSampler sampler({placed(raster, settings, kOneFloat, place, {0.0, 0.0, 1.0, 1.0}, layer)}, layer.width, layer.height);
      const Texels texels = texels_of(sampler, layer);
      double worst = 0.0;
      for (std::int64_t x = 0; x < layer.width; ++x)
        worst = std::max(worst, std::abs(texels.at(x, 1, 0) - (static_cast<double>(x) + 1.5) * ratio) / ratio);
      return worst;
    };
    const double f = ratio - std::floor(ratio);
    // Floats of up to 500 are steps of 3e-5.
    EXPECT_LE(worst_of({.channel = ChannelType::kSensor, .format = TexelFormat::kR32Float}), f * (1 - f) / (2 * ratio * ratio) + 2e-5)
        << ratio;
    EXPECT_LE(worst_of(kHeights), 2e-5) << ratio << ": values of a surface do not move";
  }
}

// --- mosaics ---

// Cuts a raster into files on one grid.
std::vector<PlacedSource> files_of(const Raster& whole, const std::vector<TexelRect>& parts, const ChannelSettings& settings,
                                   const SampleLayout& layout, const geo::GeoTransform& transform, const GridPlacement& grid,
                                   const TexelRect& layer) {
  std::vector<PlacedSource> files;
  for (const TexelRect& part : parts) {
    Raster raster = whole;
    raster.width = part.width;
    raster.height = part.height;
    raster.value = [&whole, part](std::int64_t x, std::int64_t y, int b) { return whole.value(x + part.x, y + part.y, b); };
    geo::GeoTransform place = transform;
    const Point2 corner = transform.crs_from_raster({static_cast<double>(part.x), static_cast<double>(part.y)});
    place.x0 = corner.x;
    place.y0 = corner.y;
    files.push_back(placed(raster, settings, layout, place, grid, layer));
  }
  return files;
}

// Two and four files, overlapping ones, holes and coverage among them, at every offset of the grids, finer
// and coarser.
TEST(AreaSampling, FilesOfOneGridAreOneRaster) {
  const TexelRect layer{0, 0, 30, 26};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  const std::vector<std::vector<TexelRect>> cuts{
      {{0, 0, 31, 53}, {31, 0, 30, 53}},
      {{0, 0, 61, 20}, {0, 20, 61, 33}},
      {{0, 0, 30, 27}, {30, 0, 31, 27}, {0, 27, 30, 26}, {30, 27, 31, 26}},
      {{0, 0, 40, 53}, {25, 0, 36, 53}},
  };
  for (const Kind& kind : kinds())
    for (int tenth = 0; tenth < 10; ++tenth)
      for (const auto& place : {geo::GeoTransform{1.0 + tenth / 10.0, 0.4, 0.0, -1.0 - tenth / 20.0, 0.0, -0.4},
                                geo::GeoTransform{-10.0 + tenth / 10.0, 1.0, 0.0, 11.0 + tenth / 10.0, 0.0, -1.0},
                                turned(2.0 + tenth / 10.0, -9.0, 0.9, 0.4)}) {
        const Texels one =
            texels_of(BaseSampler({placed(kind.raster, kind.settings, kind.layout, place, grid, layer)}, layer.width, layer.height), layer);
        for (const std::vector<TexelRect>& cut : cuts) {
          // Where coverage overlaps it covers twice, which one file does not.
          if (kind.layout.has_alpha && cut.size() == 2 && cut[0].right() > cut[1].x && cut[0].bottom() > cut[1].y) continue;
          const BaseSampler sampler(files_of(kind.raster, cut, kind.settings, kind.layout, place, grid, layer), layer.width, layer.height);
          ASSERT_EQ(texels_of(sampler, layer).floats, one.floats) << kind.name << " " << tenth << " files " << cut.size();
          ASSERT_EQ(texels_of(sampler, layer, 9, 7).floats, one.floats) << kind.name;
        }
      }
}

// A gap between files is a gap; what lies at its edge is that edge's sample, as at the edge of one file.
TEST(AreaSampling, GapsBetweenFilesStayGaps) {
  const TexelRect layer{0, 0, 20, 20};
  const Raster raster{.width = 20, .height = 20, .bands = 1, .value = [](auto x, auto y, int) { return 1.0 + x + 100.0 * y; }};
  const std::vector<TexelRect> corners{{0, 0, 8, 8}, {12, 0, 8, 8}, {0, 8, 8, 12}};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  const BaseSampler sampler(files_of(raster, corners, kHeights, kOneFloat, {0.3, 1.0, 0.0, -0.3, 0.0, -1.0}, grid, layer), 20, 20);
  const Texels texels = texels_of(sampler, layer);
  for (std::int64_t y = 0; y < 20; ++y)
    for (std::int64_t x = 0; x < 20; ++x) {
      const double column = static_cast<double>(x) + 0.5 - 0.3;
      const double row = static_cast<double>(y) + 0.5 - 0.3;
      const auto is_in = [&](const TexelRect& r) {
        return column >= static_cast<double>(r.x) && column <= static_cast<double>(r.right()) && row >= static_cast<double>(r.y) &&
               row <= static_cast<double>(r.bottom());
      };
      const bool has_data = std::ranges::any_of(corners, is_in);
      ASSERT_EQ(texels.at(x, y, 1), has_data ? 1.0F : 0.0F) << x << "," << y;
      if (!has_data) continue;
      // Within half a sample of an edge that nothing continues the edge's sample goes on.
      double least_x = 0.5;
      double greatest_x = 19.5;
      if (row < 8 && column < 10) greatest_x = 7.5;
      if (row < 8 && column > 10) least_x = 12.5;
      if (row > 8) greatest_x = 7.5;
      const double greatest_y = column > 10 ? 7.5 : 19.5;
      const double wanted = 1.0 + (std::clamp(column, least_x, greatest_x) - 0.5) + 100.0 * (std::clamp(row, 0.5, greatest_y) - 0.5);
      ASSERT_NEAR(texels.at(x, y, 0), wanted, 1e-3) << x << "," << y;
    }
}

// A texel at a gap is made of the samples that are there, and keeps what floats of them would lose.
TEST(AreaSampling, WideHeightsKeepWhatFloatsLoseAtGaps) {
  const TexelRect layer{0, 0, 20, 20};
  // A plane, so that what is between samples is known.
  const Raster raster{.width = 20, .height = 20, .bands = 1, .value = [](auto x, auto y, int) { return 1e6 + 0.37 * x + 1.91 * y; }};
  const std::vector<TexelRect> corners{{0, 0, 8, 8}, {12, 0, 8, 8}, {0, 8, 8, 12}};
  const BaseSampler sampler(
      files_of(raster, corners, wide_heights(), kOneDouble, {0.25, 1.0, 0.0, -0.25, 0.0, -1.0}, {0.0, 0.0, 1.0, 1.0}, layer), 20, 20);
  const Texels texels = texels_of(sampler, layer);
  int at_gaps = 0;
  for (std::int64_t y = 1; y < 20; ++y)
    for (std::int64_t x = 1; x < 20; ++x) {
      const double column = static_cast<double>(x) + 0.25;
      const double row = static_cast<double>(y) + 0.25;
      const bool has_data = std::ranges::any_of(corners, [&](const TexelRect& r) {
        return column >= static_cast<double>(r.x) && column <= static_cast<double>(r.right()) && row >= static_cast<double>(r.y) &&
               row <= static_cast<double>(r.bottom());
      });
      ASSERT_EQ(texels.at(x, y, 2), has_data ? 1.0F : 0.0F) << x << "," << y;
      if (!has_data) continue;
      const bool is_north_east = column > 10;
      const double held_x = is_north_east ? std::clamp(column, 12.5, 19.5) : std::clamp(column, 0.5, 7.5);
      const double held_y = std::clamp(row, 0.5, is_north_east ? 7.5 : 19.5);
      at_gaps += held_x != column || held_y != row ? 1 : 0;
      const double wanted = 1e6 + 0.37 * (held_x - 0.5) + 1.91 * (held_y - 0.5);
      const double found = static_cast<double>(texels.at(x, y, 0)) + static_cast<double>(texels.at(x, y, 1));
      ASSERT_NEAR(found - wanted, 0.0, 0x1p-28) << x << "," << y;  // as above; floats would be up to 0.03 off
    }
  EXPECT_EQ(at_gaps, 7) << "one column, seven rows: elsewhere no centre is nearer to a gap than half a sample";
}

PlacedSource aligned(const ChannelSettings& settings, const Raster& raster, const TexelRect& layer, std::int64_t x, std::int64_t y) {
  PlacedSource source = placed(raster, settings, kOneFloat, {}, {0.0, 0.0, 1.0, 1.0}, layer);
  source.warp = nullptr;
  source.is_aligned = true;
  source.offset_x = x;
  source.offset_y = y;
  source.covered = intersect(layer, {x, y, raster.width, raster.height});
  return source;
}

// A finer source in a mosaic: inside it is the area's mean, at its border the texel is made of both by their
// areas. A height belongs to the one that has the texel's centre, its bounds to both.
TEST(AreaSampling, AnInsetIsSeenByItsArea) {
  const TexelRect layer{0, 0, 24, 20};
  const Raster base{.width = 24, .height = 20, .bands = 1, .value = [](auto, auto, int) { return 10.0; }};
  const Raster fine{.width = 80, .height = 60, .bands = 1, .value = [](auto, auto, int) { return 50.0; }};
  for (const ChannelSettings& settings : {radiance(), kHeights})
    for (const double angle : {0.0, 0.5}) {
      const PlacedSource inset = placed(fine, settings, kOneFloat, turned(6.37, -4.81, 0.1, angle), {0.0, 0.0, 1.0, 1.0}, layer);
      const BaseSampler sampler({aligned(settings, base, layer, 0, 0), inset}, layer.width, layer.height);
      const Texels texels = texels_of(sampler, layer);
      EXPECT_EQ(texels_of(sampler, layer, 5, 3).floats, texels.floats);
      int mixed = 0;
      for (std::int64_t y = 0; y < layer.height; ++y)
        for (std::int64_t x = 0; x < layer.width; ++x) {
          const auto fx = static_cast<double>(x);
          const auto fy = static_cast<double>(y);
          const auto at = [&](double u, double v) { return inset.warp->exact({fx + u, fy + v}); };
          auto polygon = test::polygon_of({at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
          const long double all = test::area_of(polygon);
          polygon = test::cut(test::cut(polygon, -1, 0, 0), 1, 0, 80);
          polygon = test::cut(test::cut(polygon, 0, -1, 0), 0, 1, 60);
          const auto share = static_cast<double>(test::area_of(polygon) / all);
          ASSERT_EQ(texels.at(x, y, 1), 1.0F);
          if (share > 0.05 && share < 0.95) ++mixed;
          if (texels.planes == 2) {
            // Edges along the texel's are met to a 64th; of turned corners 64 places see 5 % wrong at most.
            ASSERT_NEAR(texels.at(x, y, 0), 10.0 + 40.0 * share, 40.0 * (angle == 0.0 ? 1.01 / 64 : 0.05)) << x << "," << y;
            continue;
          }
          const Point2 centre = at(0.5, 0.5);
          const bool is_in = centre.x >= 0 && centre.y >= 0 && centre.x <= 80 && centre.y <= 60;
          ASSERT_EQ(texels.at(x, y, 0), is_in ? 50.0F : 10.0F) << x << "," << y;
          if (share > 0.05) {
            ASSERT_EQ(texels.at(x, y, 3), 50.0F) << x << "," << y;
          }
          if (share < 0.95) {
            ASSERT_EQ(texels.at(x, y, 2), 10.0F) << x << "," << y;
          }
        }
      EXPECT_GT(mixed, 20);
    }
}

// Two sources of different grids that end at one edge: what lies below does not shine through the upper one's
// last texels.
TEST(AreaSampling, WhatIsBelowDoesNotShineThroughAtACommonEdge) {
  const TexelRect layer{0, 0, 12, 12};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  const auto flat = [](double v, std::int64_t n) {
    return Raster{.width = n, .height = n, .bands = 1, .value = [v](auto, auto, int) { return v; }};
  };
  for (const ChannelSettings& settings : {radiance(), kHeights}) {
    // Both from 1.4 to 9.4.
    const PlacedSource lower = placed(flat(10.0, 40), settings, kOneFloat, {1.4, 0.2, 0.0, -1.4, 0.0, -0.2}, grid, layer);
    const PlacedSource upper = placed(flat(50.0, 10), settings, kOneFloat, {1.4, 0.8, 0.0, -1.4, 0.0, -0.8}, grid, layer);
    const Texels texels = texels_of(BaseSampler({lower, upper}, 12, 12), layer);
    for (std::int64_t y = 0; y < 12; ++y)
      for (std::int64_t x = 0; x < 12; ++x) {
        const bool is_in = x >= 1 && x < 9 && y >= 1 && y < 9;  // by the centre
        ASSERT_EQ(texels.at(x, y, 1), is_in ? 1.0F : 0.0F) << x << "," << y;
        ASSERT_EQ(texels.at(x, y, 0), is_in ? 50.0F : 0.0F) << x << "," << y;
      }
  }
}

// Sources of different grids that continue each other share the texels at the seam.
TEST(AreaSampling, ASeamBetweenGridsBelongsToBoth) {
  const TexelRect layer{0, 0, 20, 6};
  const GridPlacement grid{0.0, 0.0, 1.0, 1.0};
  const auto ramp = [](double x0, double size, std::int64_t n) {
    return Raster{
        .width = n, .height = 60, .bands = 1, .value = [=](auto x, auto, int) { return x0 + (static_cast<double>(x) + 0.5) * size; }};
  };
  for (const ChannelSettings& settings : {radiance(), kHeights}) {
    // The seam lies at 8.3; samples of 0.1 and of 0.25.
    const PlacedSource west = placed(ramp(0.3, 0.1, 80), settings, kOneFloat, {0.3, 0.1, 0.0, 0.0, 0.0, -0.1}, grid, layer);
    const PlacedSource east = placed(ramp(8.3, 0.25, 40), settings, kOneFloat, {8.3, 0.25, 0.0, 0.0, 0.0, -0.25}, grid, layer);
    const Texels texels = texels_of(BaseSampler({west, east}, 20, 6), layer);
    for (std::int64_t x = 1; x < 18; ++x) {
      // The texel at the seam is cut to a 64th; east of it the ratio is whole, but texels do not begin where
      // samples do.
      ASSERT_NEAR(texels.at(x, 2, 0), static_cast<double>(x) + 0.5, texels.planes == 2 ? 0.02 : 1e-5) << x;
      ASSERT_EQ(texels.at(x, 2, 1), 1.0F);
    }
  }
}

// --- classes ---

std::map<int, double> areas_at(const BaseChunk& chunk, std::int64_t x, std::int64_t y) {
  std::map<int, double> areas;
  for (const channels::ClassArea& one : chunk.class_areas().at(x, y)) areas[static_cast<int>(one.id)] = one.area;
  return areas;
}

TEST(AreaSampling, ClassesAreCountedByTheirArea) {
  const TexelRect layer{0, 0, 12, 11};
  const ChannelSettings settings{.channel = ChannelType::kMaterial, .format = TexelFormat::kR8, .options = {{"mixture", "4"}}};
  const SampleLayout layout{.type = SampleType::kUint8, .value_bands = 1, .nodata = 0.0};
  const Raster raster{
      .width = 61, .height = 53, .bands = 1, .value = [](auto x, auto y, int) { return std::floor(5 * noise(x / 2, y / 3, 0)); }};
  for (const geo::GeoTransform& place :
       {geo::GeoTransform{0.0, 0.25, 0.0, 0.0, 0.0, -0.25}, {-0.13, 0.4, 0.0, 0.21, 0.0, -0.37}, turned(1.0, -4.0, 0.3, 0.5)}) {
    const PlacedSource source = placed(raster, settings, layout, place, {0.0, 0.0, 1.0, 1.0}, layer);
    const BaseSampler sampler({source}, layer.width, layer.height);
    ASSERT_TRUE(sampler.counts_areas());
    BaseChunk whole;
    BaseChunk one;
    ASSERT_TRUE(sampler.load(layer, whole).has_value());
    ASSERT_TRUE(whole.has_class_areas());
    for (std::int64_t y = 0; y < layer.height; ++y)
      for (std::int64_t x = 0; x < layer.width; ++x) {
        ASSERT_TRUE(sampler.load({x, y, 1, 1}, one).has_value());
        ASSERT_EQ(areas_at(one, x, y), areas_at(whole, x, y)) << "pieces show";
        const Point2 centre = source.warp->exact({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
        if (!(centre.x >= 0 && centre.y >= 0 && centre.x < 61 && centre.y < 53)) {
          ASSERT_TRUE(areas_at(whole, x, y).empty());
          continue;
        }
        const auto fx = static_cast<double>(x);
        const auto fy = static_cast<double>(y);
        const auto corner = [&](double u, double v) { return source.warp->exact({fx + u, fy + v}); };
        const auto polygon = test::polygon_of({corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
        std::map<int, long double> wanted;
        long double all = 0;
        for (std::int64_t row = 0; row < 53; ++row)
          for (std::int64_t column = 0; column < 61; ++column)
            if (const long double covered = test::covered_area(polygon, column, row); covered > 0) {
              all += covered;
              wanted[static_cast<int>(raster.value(column, row, 0))] += covered;
            }
        wanted.erase(0);
        const std::map<int, double> found = areas_at(whole, x, y);
        for (const auto& [id, area] : wanted) {
          const auto entry = found.find(id);
          ASSERT_NEAR(entry == found.end() ? 0.0 : entry->second, static_cast<double>(area / all), 1e-9)
              << x << "," << y << " class " << id;
        }
        for (const auto& [id, area] : found) ASSERT_TRUE(wanted.contains(id) || area < 1e-9) << id;
      }
  }
}

TEST(AreaSampling, ClassesOfALayerAsFineAsTheirSourceArePicked) {
  const TexelRect layer{0, 0, 12, 11};
  const ChannelSettings settings{.channel = ChannelType::kMaterial, .format = TexelFormat::kR8};
  const SampleLayout layout{.type = SampleType::kUint8, .value_bands = 1};
  const Raster raster{.width = 61, .height = 53, .bands = 1, .value = [](auto x, auto y, int) { return std::floor(5 * noise(x, y, 0)); }};
  const PlacedSource source = placed(raster, settings, layout, turned(-20.0, 18.0, 0.98, 0.3), {0.0, 0.0, 1.0, 1.0}, layer);
  const BaseSampler sampler({source}, layer.width, layer.height);
  EXPECT_FALSE(sampler.counts_areas());
  BaseChunk chunk;
  ASSERT_TRUE(sampler.load(layer, chunk).has_value());
  EXPECT_FALSE(chunk.has_class_areas());
}

}  // namespace
}  // namespace vt::resample
