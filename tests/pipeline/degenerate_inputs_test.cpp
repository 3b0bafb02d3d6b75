// Rasters at the edges of what a raster can be, for every kind of layer: nothing but nodata, one texel of
// data, numbers that are no numbers, huge and tiny ones, lines of one texel, sizes around powers of two. A
// layer builds, its store is sound, texels without data say so, and values lie where the input's lie; or it
// is refused with a message, where the kind of layer cannot hold such numbers. A channel joins with one row
// in kinds().
#include <gtest/gtest.h>

#include "builder/channels/all_channels.h"
#include "store/validate.h"
#include "tests/pipeline/level_values.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// One way to build a layer, and what its texels may be.
struct Kind {
  std::string name;
  ChannelType channel = ChannelType::kColor;
  int bands = 3;
  SampleType type = SampleType::kUint8;
  std::optional<double> nodata;
  std::optional<TexelFormat> format;
  channels::Options options = {};
  std::optional<std::array<double, 2>> range = {};
  double low = 0.0;  // ordinary samples
  double high = 255.0;
  bool shows_coverage = false;  // a texel that is half covered has half the value
  bool has_zero = true;         // 0 is a value: not the length of a direction, nor a temperature
  bool holds_anything = true;   // every finite sample can be stored; if not, some inputs are refused
};

std::vector<Kind> kinds() {
  constexpr double kVoid = -32768.0;
  return {
      {.name = "color", .nodata = 0.0},
      {.name = "color_opaque_blocks", .nodata = 0.0, .format = TexelFormat::kBc1},
      {.name = "color_of_floats",
       .type = SampleType::kFloat32,
       .nodata = -1.0,
       .format = TexelFormat::kRgba8,
       .range = std::array<double, 2>{0.0, 1000.0},
       .low = 0.0,
       .high = 1000.0},
      {.name = "color_bc7_anti_ringing", .nodata = 0.0, .format = TexelFormat::kBc7, .options = {{"anti-ringing", "yes"}}},
      {.name = "elevation",
       .channel = ChannelType::kElevation,
       .bands = 1,
       .type = SampleType::kFloat32,
       .nodata = kVoid,
       .format = TexelFormat::kR32Float,
       .options = {{"bounds", "yes"}},
       .low = -400.0,
       .high = 8800.0},
      {.name = "elevation_halves",
       .channel = ChannelType::kElevation,
       .bands = 1,
       .type = SampleType::kFloat32,
       .nodata = kVoid,
       .format = TexelFormat::kR16Float,
       .options = {{"bounds", "yes"}},
       .low = -400.0,
       .high = 8800.0,
       .holds_anything = false},
      {.name = "elevation_codes",
       .channel = ChannelType::kElevation,
       .bands = 1,
       .type = SampleType::kInt16,
       .nodata = kVoid,
       .format = TexelFormat::kR16,
       .options = {{"bounds", "yes"}},
       .low = -400.0,
       .high = 8800.0},
      {.name = "mask", .channel = ChannelType::kMask, .bands = 1, .nodata = 0.0, .format = TexelFormat::kR8},
      {.name = "mask_of_floats",
       .channel = ChannelType::kMask,
       .bands = 1,
       .type = SampleType::kFloat32,
       .nodata = -1.0,
       .format = TexelFormat::kR16,
       .high = 1.0},
      {.name = "mask_alpha_test",
       .channel = ChannelType::kMask,
       .bands = 1,
       .nodata = 0.0,
       .format = TexelFormat::kBc4,
       .options = {{"alpha-coverage", "0.5"}}},
      {.name = "material",
       .channel = ChannelType::kMaterial,
       .bands = 1,
       .nodata = 0.0,
       .format = TexelFormat::kR8,
       .options = {{"mixture", "4"}}},
      {.name = "normal_of_floats",
       .channel = ChannelType::kNormal,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kRgba16,
       .low = 0.5,
       .high = 1.0,
       .has_zero = false},
      {.name = "horizon_of_floats",
       .channel = ChannelType::kHorizon,
       .bands = 2,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kRgba16,
       .low = -0.1,
       .high = 0.7},
      {.name = "sensor",
       .channel = ChannelType::kSensor,
       .bands = 1,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kR32Float,
       .low = 1.0,
       .high = 40.0},
      {.name = "sensor_codes_of_temperatures",
       .channel = ChannelType::kSensor,
       .bands = 1,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kR16,
       .options = {{"quantity", "temperature"}, {"band", "8,12"}, {"store", "temperature"}, {"span", "200,400"}},
       .low = 250.0,
       .high = 320.0,
       .has_zero = false},
      {.name = "illumination",
       .channel = ChannelType::kIllumination,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kRgba16Float,
       .high = 1000.0},
      {.name = "illumination_blocks",
       .channel = ChannelType::kIllumination,
       .type = SampleType::kFloat32,
       .nodata = -9.0,
       .format = TexelFormat::kBc6h,
       .high = 1000.0,
       .shows_coverage = true},
  };
}

struct Size {
  std::int64_t width;
  std::int64_t height;
};

bool is_float(SampleType type) { return type == SampleType::kFloat32 || type == SampleType::kFloat64; }

// Builds a layer of one kind, or says with which error it was refused; either way the store is sound.
Result<store::StoreReader> built(const Kind& kind, const Size& size, const std::function<double(std::int64_t, std::int64_t)>& value) {
  const test::TempFolder folder;
  RasterSpec spec{.width = size.width, .height = size.height, .bands = kind.bands, .type = kind.type, .nodata = kind.nodata};
  write_raster(folder / "input.tif", spec, [&](std::int64_t x, std::int64_t y, int) { return value(x, y); });
  LayerRequest request = request_for({folder / "input.tif"}, kind.channel);
  request.format = kind.format;
  request.options = kind.options;
  request.range = kind.range;
  VT_ASSIGN(const LayerPlan plan, plan_layer(request, std::nullopt, std::size_t{1} << 20));
  {
    VT_ASSIGN(auto writer, open_or_create(folder / "a.vts", plan.crs, plan.extent()));
    const auto report = build_layer(writer, plan, {.threads = 1, .block_levels = 1});
    VT_CHECK(writer.finish());
    const auto findings = store::validate(folder / "a.vts");
    EXPECT_TRUE(findings.has_value());
    if (findings) {
      EXPECT_TRUE(findings->ok()) << kind.name << " " << size.width << "x" << size.height;
    }
    if (!report) return tl::unexpected(report.error());
  }
  return store::StoreReader::open(folder / "a.vts");
}

// All numbers that a level holds are finite or "no data".
void expect_no_infinity(const store::StoreReader& reader, const std::string& what) {
  for (const LayerInfo& layer : reader.layers()) {
    if (layer.role != LayerRole::kTexture) continue;
    for (int level = 0; level <= layer.finest.value; ++level) {
      const LevelValues values(reader, layer, Level{static_cast<std::uint8_t>(level)});
      for (std::int64_t y = 0; y < values.height(); ++y)
        for (std::int64_t x = 0; x < values.width(); ++x)
          for (std::size_t c = 0; c < format_info(layer.format).channels; ++c)
            ASSERT_FALSE(std::isinf(values.at(x, y, c))) << what << ", " << layer.name << " level " << level;
    }
  }
}

// A texel of any level with an ordinary sample under it has data; one with nothing but NaN and infinity under
// it has none, in layers whose numbers can say so.
void expect_holes_as_in(const store::StoreReader& reader, const Kind& kind,
                        const std::function<double(std::int64_t, std::int64_t)>& value) {
  const LayerInfo& layer = *reader.find_layer(channels::kind_of(kind.channel).name);
  const bool says_void = layer.zero_is_nodata || layer.format == TexelFormat::kR32Float || layer.format == TexelFormat::kR16Float;
  for (int level = 0; level <= layer.finest.value; ++level) {
    const LevelValues values(reader, layer, Level{static_cast<std::uint8_t>(level)});
    const std::int64_t scale = std::int64_t{1} << (layer.finest.value - level);
    for (std::int64_t y = 0; y < values.height(); ++y)
      for (std::int64_t x = 0; x < values.width(); ++x) {
        bool has_ordinary = false;
        bool has_number = false;
        for (std::int64_t fy = y * scale; fy < std::min((y + 1) * scale, layer.data.height); ++fy)
          for (std::int64_t fx = x * scale; fx < std::min((x + 1) * scale, layer.data.width); ++fx) {
            const double sample = value(fx, fy);
            has_ordinary = has_ordinary || (sample >= kind.low && sample <= kind.high && sample != 0.0);
            has_number = has_number || std::isfinite(sample);
          }
        if (has_ordinary) {
          ASSERT_FALSE(values.is_void(x, y)) << kind.name << " level " << level << " texel " << x << ", " << y << ": a hole spread";
        } else if (!has_number && says_void) {
          ASSERT_TRUE(values.is_void(x, y)) << kind.name << " level " << level << " texel " << x << ", " << y << ": made of nothing";
        }
      }
  }
}

constexpr std::array kSizes{Size{1, 1}, Size{1, 67}, Size{67, 1}, Size{31, 33}, Size{33, 31}, Size{64, 64}, Size{65, 63}, Size{127, 129}};

TEST(DegenerateInputs, NothingButNodataLeavesNoTile) {
  for (const Kind& kind : kinds())
    for (const Size& size : kSizes) {
      const auto reader = built(kind, size, [&](std::int64_t, std::int64_t) { return *kind.nodata; });
      ASSERT_TRUE(reader.has_value()) << kind.name << ": " << reader.error().message;
      for (const LayerInfo& layer : reader->layers())
        if (layer.role == LayerRole::kTexture) {
          EXPECT_EQ(layer.tiles, 0U) << kind.name << " " << layer.name;
        }
    }
}

TEST(DegenerateInputs, OneTexelOfDataIsSeenInEveryLevel) {
  for (const Kind& kind : kinds())
    for (const Size& size : kSizes) {
      const std::int64_t at_x = size.width / 2;
      const std::int64_t at_y = size.height / 3;
      const double value = kind.high;
      const auto reader = built(kind, size, [&](std::int64_t x, std::int64_t y) { return x == at_x && y == at_y ? value : *kind.nodata; });
      ASSERT_TRUE(reader.has_value()) << kind.name << ": " << reader.error().message;
      const LayerInfo& layer = *reader->find_layer(channels::kind_of(kind.channel).name);
      for (int level = 0; level <= layer.finest.value; ++level) {
        const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(level)});
        const int steps = layer.finest.value - level;
        EXPECT_FALSE(values.is_void(at_x >> steps, at_y >> steps)) << kind.name << " level " << level;
      }
    }
}

TEST(DegenerateInputs, AConstantStaysConstant) {
  for (const Kind& kind : kinds())
    for (const Size& size : kSizes) {
      if (kind.shows_coverage) continue;
      const double value = kind.high;
      const auto reader = built(kind, size, [&](std::int64_t, std::int64_t) { return value; });
      ASSERT_TRUE(reader.has_value()) << kind.name << ": " << reader.error().message;
      const LayerInfo& layer = *reader->find_layer(channels::kind_of(kind.channel).name);
      // A block that reaches past the data has two coverages to say besides, and may spend a code or two of
      // colour on them.
      const double slack = format_info(layer.format).block_edge == 4 ? 2.0 : 0.0;
      const double first = LevelValues(*reader, layer, layer.finest).at(0, 0);
      for (int level = 0; level <= layer.finest.value; ++level) {
        const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(level)});
        for (std::int64_t y = 0; y < values.height(); ++y)
          for (std::int64_t x = 0; x < values.width(); ++x) ASSERT_NEAR(values.at(x, y), first, slack) << kind.name << " level " << level;
      }
    }
}

// Any mixture of ordinary and impossible numbers.
TEST(DegenerateInputs, NumbersThatAreNoneNeverSpread) {
  constexpr float kHuge = 1e30F;
  const std::vector<double> odd{std::nan(""),
                                std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity(),
                                kHuge,
                                -kHuge,
                                std::numeric_limits<float>::denorm_min(),
                                -0.0,
                                0.0};
  for (const Kind& kind : kinds()) {
    if (!is_float(kind.type)) continue;
    for (const Size& size : kSizes)
      for (const std::uint32_t share : {1U, 40U, 255U}) {
        const auto value = [&](std::int64_t x, std::int64_t y) {
          const std::uint32_t noise = hash_noise(x, y, static_cast<int>(share));
          if (noise % 256 < share) return odd[noise / 256 % odd.size()];
          return kind.low + (kind.high - kind.low) * static_cast<double>(noise / 256 % 1000) / 1000.0;
        };
        const auto reader = built(kind, size, value);
        if (!reader) {
          EXPECT_FALSE(kind.holds_anything) << kind.name << ": " << reader.error().message;
          EXPECT_EQ(reader.error().code, ErrorCode::kInvalidData) << reader.error().message;
          continue;
        }
        expect_no_infinity(*reader, kind.name);
        expect_holes_as_in(*reader, kind, value);
      }
  }
}

TEST(DegenerateInputs, DenormalsAreNumbers) {
  for (const Kind& kind : kinds()) {
    if (!is_float(kind.type) || !kind.has_zero) continue;
    const auto reader =
        built(kind, {65, 63}, [](std::int64_t, std::int64_t) { return static_cast<double>(std::numeric_limits<float>::denorm_min()); });
    ASSERT_TRUE(reader.has_value()) << kind.name << ": " << reader.error().message;
    const LayerInfo& layer = *reader->find_layer(channels::kind_of(kind.channel).name);
    for (int level = 0; level <= layer.finest.value; ++level) {
      const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(level)});
      EXPECT_NEAR(values.at(values.width() / 2, values.height() / 2), 0.0, 1e-37) << kind.name;
    }
  }
}

}  // namespace
}  // namespace vt::pipeline
