// One small raster for each kind of layer that takes a path of its own through the builder.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/channels/thermal_fixture.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {

struct Case {
  std::string name;
  RasterSpec raster;
  ChannelType channel = ChannelType::kColor;
  std::string kernel;
  std::optional<TexelFormat> format;
  std::function<double(std::int64_t, std::int64_t, int)> value;
  channels::Options options = {};
  std::optional<double> gsd_m = {};  // of a layer on another grid than its source's, which has 2 m
  std::optional<int> epsg = {};
};

inline double noisy_code(std::int64_t x, std::int64_t y, int band) {
  return (x / 3 + y / 5 + band * 40) % 200 + hash_noise(x, y, band) % 56;
}

// Once around the globe. 330 columns can be halved once, so the finer levels wrap at the seam and the coarser
// ones do not.
inline RasterSpec around_the_globe(std::int64_t width, std::int64_t height, int bands = 3, SampleType type = SampleType::kUint8,
                                   std::optional<double> nodata = std::nullopt) {
  const double step = 360.0 / static_cast<double>(width);
  const double step_down = std::min(step, 140.0 / static_cast<double>(height));  // no further south than 85 degrees
  return {.width = width,
          .height = height,
          .bands = bands,
          .type = type,
          .nodata = nodata,
          .transform = {-180.0, step, 0.0, 55.0, 0.0, -step_down},
          .epsg = 4326};
}

// On the grids of their sources.
inline std::vector<Case> aligned_cases() {
  const auto holes = [](std::int64_t x, std::int64_t y) { return (x / 17) % 4 == 1 && (y / 23) % 3 == 1; };
  const auto translucent = [](std::int64_t x, std::int64_t y, int band) {
    return band < 3                     ? noisy_code(x, y, band)
           : (x / 20 + y / 30) % 3 == 0 ? 0.0
           : (x / 20) % 2 == 0          ? 255.0
                                        : static_cast<double>(hash_noise(x, y, 3) % 256);
  };
  const auto height = [holes](std::int64_t x, std::int64_t y, int) {
    return holes(x, y) ? -32768.0 : static_cast<double>((x * 7 + y * 3) % 4000) - 200;
  };
  // Vectors of any length, and none in the holes.
  const auto slopes = [holes](std::int64_t x, std::int64_t y, int band) {
    return holes(x, y) ? 0.0 : band == 2 ? 1.0 : (hash_noise(x, y, band) % 200) / 100.0 - 1.0;
  };
  const auto land_cover = [holes](std::int64_t x, std::int64_t y, int) {
    return holes(x, y) ? 0.0 : static_cast<double>(1 + (x / 7 + y / 9) % 5 + hash_noise(x, y, 0) % 3);
  };
  const auto angle = [holes](std::int64_t x, std::int64_t y, int band) {
    return holes(x, y) ? -32768.0 : static_cast<double>((x + y) % 20 + hash_noise(x, y, band) % 30) - 5.0;
  };
  return {
      {"opaque_kaiser", {.width = 301, .height = 203}, ChannelType::kColor, "kaiser3", TexelFormat::kRgb8, noisy_code},
      {"opaque_box", {.width = 256, .height = 256}, ChannelType::kColor, "box", TexelFormat::kRgb8, noisy_code},
      {"translucent_kaiser",
       {.width = 301, .height = 203, .bands = 4, .alpha = true},
       ChannelType::kColor,
       "kaiser3",
       TexelFormat::kRgba8,
       translucent},
      {"nodata_kaiser",
       {.width = 301, .height = 203, .nodata = 0.0},
       ChannelType::kColor,
       "kaiser3",
       TexelFormat::kRgb8,
       [holes](std::int64_t x, std::int64_t y, int band) { return holes(x, y) ? 0.0 : noisy_code(x, y, band); }},
      {"bc1", {.width = 301, .height = 203}, ChannelType::kColor, "kaiser3", TexelFormat::kBc1, noisy_code},
      {"grey16",
       {.width = 97, .height = 310, .bands = 1, .type = SampleType::kUint16},
       ChannelType::kColor,
       "kaiser3",
       TexelFormat::kRgb8,
       [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(hash_noise(x, y, 0) % 65536); }},
      {"elevation",
       {.width = 301, .height = 203, .bands = 1, .type = SampleType::kInt16, .nodata = -32768.0},
       ChannelType::kElevation,
       "box",
       TexelFormat::kR32Float,
       height},
      {"elevation_codes_bounds",
       {.width = 301, .height = 203, .bands = 1, .type = SampleType::kInt16, .nodata = -32768.0},
       ChannelType::kElevation,
       "point",
       TexelFormat::kR16,
       height,
       {{"bounds", "yes"}, {"surface-error", "yes"}}},
      {"elevation_wide_bounds",
       {.width = 301, .height = 203, .bands = 1, .type = SampleType::kFloat64, .nodata = -1.0},
       ChannelType::kElevation,
       "box",
       TexelFormat::kR32Float,
       [holes](std::int64_t x, std::int64_t y, int) { return holes(x, y) ? -1.0 : 1e6 + hash_noise(x, y, 0) % 10000 * 1e-6; },
       {{"bounds", "yes"}}},
      {"elevation_wide_point",
       {.width = 130, .height = 203, .bands = 1, .type = SampleType::kInt32},
       ChannelType::kElevation,
       "point",
       TexelFormat::kR32Float,
       [](std::int64_t x, std::int64_t y, int) { return 2147483000.0 - hash_noise(x, y, 0) % 1000; }},
      {"radiance_wide",
       {.width = 301, .height = 130, .bands = 1, .type = SampleType::kFloat64},
       ChannelType::kSensor,
       "box",
       TexelFormat::kR16,
       [holes](std::int64_t x, std::int64_t y, int) { return holes(x, y) ? std::nan("") : 1e6 + hash_noise(x, y, 0) % 10000 * 1e-6; },
       {{"span", "1000000,1000000.01"}}},
      {"mask", {.width = 301, .height = 203, .bands = 1}, ChannelType::kMask, "box", TexelFormat::kR8, noisy_code},
      {"mask_alpha_test_bc4",
       {.width = 301, .height = 203, .bands = 1},
       ChannelType::kMask,
       "box",
       TexelFormat::kBc4,
       noisy_code,
       {{"alpha-coverage", "0.5"}}},
      {"color_associated_linear",
       {.width = 301, .height = 203, .bands = 4, .alpha = true},
       ChannelType::kColor,
       "kaiser5",
       TexelFormat::kRgba8,
       translucent,
       {{"alpha", "associated"}, {"transfer", "linear"}, {"anti-ringing", "yes"}}},
      {"normal", {.width = 301, .height = 203}, ChannelType::kNormal, "box", TexelFormat::kRgb8, noisy_code},
      {"normal_rgba16_moments",
       {.width = 301, .height = 203, .type = SampleType::kFloat32},
       ChannelType::kNormal,
       "box",
       TexelFormat::kRgba16,
       slopes,
       {{"moments", "lean"}}},
      {"normal_bc5", {.width = 130, .height = 203, .bands = 2}, ChannelType::kNormal, "box", TexelFormat::kBc5, noisy_code},
      {"horizon",
       {.width = 301, .height = 203, .bands = 2, .type = SampleType::kInt16, .nodata = -32768.0},
       ChannelType::kHorizon,
       "box",
       TexelFormat::kRgba16,
       angle,
       {{"angles", "deg"}}},
      {"horizon_bc5",
       {.width = 130, .height = 203, .bands = 5, .type = SampleType::kInt16, .nodata = -32768.0},
       ChannelType::kHorizon,
       "box",
       TexelFormat::kBc5,
       angle,
       {{"angles", "deg"}, {"span", "-10,60"}}},
      {"kelvins",
       {.width = 203, .height = 97, .bands = 1, .type = SampleType::kFloat32},
       ChannelType::kSensor,
       "box",
       TexelFormat::kR16,
       [holes](std::int64_t x, std::int64_t y, int) { return holes(x, y) ? std::nan("") : 250.0 + hash_noise(x, y, 0) % 9000 * 0.01; },
       {{"quantity", "temperature"}, {"band", "3,5"}, {"store", "temperature"}, {"span", "200,400"}}},
      {"radiance_bc4",
       {.width = 301, .height = 203, .bands = 1, .type = SampleType::kUint16, .nodata = 0.0},
       ChannelType::kSensor,
       "box",
       TexelFormat::kBc4,
       [holes](std::int64_t x, std::int64_t y, int) { return holes(x, y) ? 0.0 : 20000.0 + hash_noise(x, y, 0) % 9000; },
       {{"span", "0,65535"}}},
      {"thermal_basis",
       {.width = 301, .height = 203, .bands = 1, .nodata = 0.0},
       ChannelType::kSensor,
       "box",
       TexelFormat::kRgba16,
       [holes](std::int64_t x, std::int64_t y, int) {
         return holes(x, y) ? 0.0 : static_cast<double>(1 + hash_noise(x / 5, y / 5, 0) % 66);
       },
       {{"basis", test::thermal_library_json()}, {"band", "8,12"}, {"components", "5"}}},
      {"light_halves",
       {.width = 301, .height = 203, .bands = 4, .alpha = true},
       ChannelType::kIllumination,
       "box",
       TexelFormat::kRgba16Float,
       translucent},
      {"light_rgb9e5",
       {.width = 203, .height = 97, .type = SampleType::kFloat32},
       ChannelType::kIllumination,
       "box",
       TexelFormat::kRgb9e5,
       [holes](std::int64_t x, std::int64_t y, int band) {
         return holes(x, y) ? std::nan("") : std::exp2(static_cast<double>(hash_noise(x, y, band) % 20000) / 1000.0 - 5.0);
       }},
      {"light_in_small_units_bc6h",
       {.width = 203, .height = 97, .bands = 1, .type = SampleType::kFloat32},
       ChannelType::kIllumination,
       "box",
       TexelFormat::kBc6h,
       [](std::int64_t x, std::int64_t y, int band) {
         return std::exp2(static_cast<double>(hash_noise(x, y, band) % 6000) / 1000.0 - 25.0);
       }},
      {"land_cover", {.width = 301, .height = 203, .bands = 1, .nodata = 0.0}, ChannelType::kMaterial, "box", TexelFormat::kR8, land_cover},
      {"land_cover_mixture",
       {.width = 203, .height = 301, .bands = 1, .type = SampleType::kUint16},
       ChannelType::kMaterial,
       "box",
       TexelFormat::kR16,
       [](std::int64_t x, std::int64_t y, int) { return static_cast<double>((x / 17 + y / 13) % 3 == 0 ? hash_noise(x, y, 0) % 3000 : 7); },
       {{"mixture", "4"}}},
      {"globe_kaiser", around_the_globe(330, 110), ChannelType::kColor, "kaiser3", TexelFormat::kRgb8, noisy_code},
      {"globe_translucent",
       [] {
         RasterSpec spec = around_the_globe(330, 71, 4);
         spec.alpha = true;
         return spec;
       }(),
       ChannelType::kColor,
       "kaiser5",
       TexelFormat::kRgba8,
       translucent,
       {{"anti-ringing", "yes"}}},
      {"globe_bc1", around_the_globe(256, 90), ChannelType::kColor, "mitchell", TexelFormat::kBc1, noisy_code},
      {"globe_normal", around_the_globe(330, 71), ChannelType::kNormal, "box", TexelFormat::kRgb8, noisy_code},
      {"globe_horizon",
       around_the_globe(330, 71, 2, SampleType::kInt16, -32768.0),
       ChannelType::kHorizon,
       "box",
       TexelFormat::kRgba16,
       angle,
       {{"angles", "deg"}}},
      {"globe_heights",
       around_the_globe(330, 71, 1, SampleType::kInt16, -32768.0),
       ChannelType::kElevation,
       "box",
       TexelFormat::kR32Float,
       height,
       {{"bounds", "yes"}, {"surface-error", "yes"}}},
      {"globe_points",
       around_the_globe(315, 71, 1, SampleType::kInt16, -32768.0),
       ChannelType::kElevation,
       "point",
       TexelFormat::kR16,
       height,
       {{"bounds", "yes"}, {"surface-error", "yes"}}},
      {"globe_land_cover", around_the_globe(330, 71, 1), ChannelType::kMaterial, "box", TexelFormat::kR8, land_cover, {{"mixture", "3"}}},
      {"globe_radiance",
       around_the_globe(330, 71, 1, SampleType::kUint16),
       ChannelType::kSensor,
       "box",
       TexelFormat::kR16,
       [](std::int64_t x, std::int64_t y, int) { return 20000.0 + hash_noise(x, y, 0) % 9000; },
       {{"span", "0,65535"}}},
      {"globe_light", around_the_globe(330, 71, 3, SampleType::kFloat32), ChannelType::kIllumination, "box", TexelFormat::kRgba16Float,
       [](std::int64_t x, std::int64_t y, int band) { return static_cast<double>(hash_noise(x, y, band) % 1000) / 100.0; }},
      {"globe_mask", around_the_globe(330, 71, 1), ChannelType::kMask, "box", TexelFormat::kR8, noisy_code},
  };
}

// Those of every channel again where each texel lies over several samples: in the source's own system at a
// ratio that is not whole, and turned by a projection.
inline std::vector<Case> cases() {
  std::vector<Case> all = aligned_cases();
  const std::vector<Case> aligned = all;
  for (Case c : aligned)
    for (const char* name : {"translucent_kaiser", "elevation_codes_bounds", "mask", "normal_rgba16_moments", "horizon", "kelvins",
                             "thermal_basis", "light_halves", "land_cover_mixture"}) {
      if (c.name != name) continue;
      c.raster.width = 470;
      c.raster.height = 350;
      c.gsd_m = 4.7;
      c.name = std::string(name) + "_coarser";
      all.push_back(c);
      if (c.channel != ChannelType::kColor && c.channel != ChannelType::kElevation && c.channel != ChannelType::kMaterial) continue;
      c.epsg = 4326;
      c.name = std::string(name) + "_coarser_in_degrees";
      all.push_back(c);
    }
  return all;
}

inline LayerRequest request_of(const Case& c, const std::filesystem::path& input) {
  LayerRequest request = request_for({input}, c.channel);
  request.kernel = c.kernel;
  request.format = c.format;
  request.options = c.options;
  request.gsd_m = c.gsd_m;
  if (c.epsg) request.crs = geo::Crs::from_epsg(*c.epsg).value();
  return request;
}

}  // namespace vt::pipeline
