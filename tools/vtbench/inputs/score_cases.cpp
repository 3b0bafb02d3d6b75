#include "tools/vtbench/inputs/score_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "builder/channels/shared/srgb.h"

namespace vt::bench {
namespace {

source::GeoTiffSpec raster(std::int64_t width, std::int64_t height, int bands, SampleType type) {
  source::GeoTiffSpec spec;
  spec.width = width;
  spec.height = height;
  spec.bands = bands;
  spec.sample_type = type;
  spec.tile = 16;
  return spec;
}

// A hash that looks like noise: the finaliser of MurmurHash3 (Austin Appleby, public domain).
std::uint32_t noise(std::int64_t x, std::int64_t y) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
  h = (h ^ h >> 16U) * 0x85EBCA6BU;
  h = (h ^ h >> 13U) * 0xC2B2AE35U;
  return h ^ h >> 16U;
}

std::vector<PeerRun> gdal_kernels(const std::vector<std::string>& kernels) {
  std::vector<PeerRun> runs;
  for (const std::string& kernel : kernels) runs.push_back({kernel, {"-r", kernel}});
  return runs;
}
const std::vector<PeerRun> kPlain = {{"", {}}};

ScoreCase checker() {
  ScoreCase c;
  c.test = "sRGB checker of 0 and 255, level 1";
  c.truth = "188";
  c.raster = raster(64, 64, 3, SampleType::kUint8);
  c.value = [](std::int64_t x, std::int64_t y, int) { return (x + y) % 2 == 0 ? 0.0 : 255.0; };
  c.ours = {{"", {"--channel", "color"}}};
  c.gdal = gdal_kernels({"average", "cubic", "lanczos"});
  c.vips = c.maketx = kPlain;
  c.judge = [](const Pyramid& p) { return fmt::format("{:.0f}", p[1].at(15, 15)); };
  return c;
}

ScoreCase clear_texels() {
  ScoreCase c;
  c.test = "opaque red beside clear black, odd border, level 1";
  c.truth = "255,0,0 alpha 128";
  c.raster = raster(63, 64, 4, SampleType::kUint8);
  c.raster.last_band_is_alpha = true;
  c.value = [](std::int64_t x, std::int64_t, int band) { return x % 2 == 0 && (band == 0 || band == 3) ? 255.0 : 0.0; };
  c.ours = {{"", {"--channel", "color", "--kernel", "box"}}};
  c.gdal = gdal_kernels({"average"});
  c.vips = c.maketx = kPlain;
  c.judge = [](const Pyramid& p) {
    const LevelValues& level = p[1];
    const auto text = [&](std::int64_t x) {
      return fmt::format("{:.0f},{:.0f},{:.0f} alpha {:.0f}", level.at(x, 9, 0), level.at(x, 9, 1), level.at(x, 9, 2), level.at(x, 9, 3));
    };
    const std::string inside = text(9);
    const std::string border = text(level.width - 1);
    return inside == border ? inside : inside + "; border " + border;
  };
  return c;
}

ScoreCase void_column() {
  ScoreCase c;
  c.test = "heights of 100 and a column of voids, nodata declared, level 1";
  c.truth = "100";
  c.raster = raster(64, 64, 1, SampleType::kInt16);
  c.raster.nodata = -32768.0;
  c.value = [](std::int64_t x, std::int64_t, int) { return x == 20 ? -32768.0 : 100.0; };
  c.ours = {{"", {"--channel", "elevation"}}};
  c.gdal = gdal_kernels({"average", "cubic"});
  c.vips = c.maketx = kPlain;
  c.judge = [](const Pyramid& p) { return fmt::format("{:.0f}", p[1].at(10, 9)); };
  return c;
}

// Overshoot in percent of the step, away from the image's own edges.
std::string overshoot(const Pyramid& p, double low, double high) {
  double least = low;
  double greatest = high;
  const LevelValues& level = p[1];
  for (std::int64_t x = 8; x < level.width - 8; ++x) {
    least = std::min(least, level.at(x, level.height / 2));
    greatest = std::max(greatest, level.at(x, level.height / 2));
  }
  return fmt::format("{:.1f} %", 100.0 * std::max(greatest - high, low - least) / (high - low));
}

ScoreCase step() {
  ScoreCase c;
  c.test = "a bar of 1000 on 0, edges at odd and even columns: overshoot at level 1";
  c.truth = "0 %";
  c.raster = raster(128, 64, 1, SampleType::kFloat32);
  c.value = [](std::int64_t x, std::int64_t, int) { return x >= 43 && x < 86 ? 1000.0 : 0.0; };
  // As light from -1000 to 2000, so that nothing is cut off; codes are 16 to 22 apart there, 2 % of the step.
  const std::vector<std::string> light = {"--channel", "color", "--range", "-1000,2000", "--transfer", "linear"};
  for (const char* kernel : {"box", "mitchell", "kaiser3"}) {
    std::vector<std::string> arguments = light;
    arguments.insert(arguments.end(), {"--kernel", kernel});
    c.ours.emplace_back(kernel, arguments);
  }
  std::vector<std::string> limited = light;
  limited.insert(limited.end(), {"--kernel", "kaiser3", "--anti-ringing", "yes"});
  c.ours.emplace_back("kaiser3 anti-ringing", limited);
  c.gdal = gdal_kernels({"average", "cubic", "lanczos"});
  c.vips = kPlain;
  c.maketx = {{"box", {}}, {"lanczos3", {"--filter", "lanczos3"}}, {"lanczos3 hicomp", {"--filter", "lanczos3", "--hicomp"}}};
  c.judge = [](const Pyramid& p) { return overshoot(p, 0.0, 1000.0); };
  c.judge_ours = [](const Pyramids& layers) {
    Pyramid codes = layers.at("color");
    for (double& code : codes[1].values) code = channels::linear_from_srgb(code / 255.0) * 3000.0 - 1000.0;
    return overshoot(codes, 0.0, 1000.0);
  };
  return c;
}

ScoreCase stripes_of_normals() {
  ScoreCase c;
  c.test = "normals tilted by +60 and -60 degrees in stripes, level 1: length of the direction";
  c.truth = "1 (spread kept: 0.5)";
  c.raster = raster(64, 64, 3, SampleType::kUint8);
  c.value = [](std::int64_t x, std::int64_t, int band) {
    const double tilt = (x % 2 == 0 ? 60.0 : -60.0) * std::numbers::pi / 180.0;
    const double component = band == 0 ? std::sin(tilt) : band == 1 ? 0.0 : std::cos(tilt);
    return std::round(128.0 + 127.0 * component);
  };
  c.ours = {{"", {"--channel", "normal"}}};
  c.gdal = gdal_kernels({"average"});
  c.vips = c.maketx = kPlain;
  const auto length = [](const LevelValues& level, const auto& component) {
    double sum = 0.0;
    for (int band = 0; band < 3; ++band) sum += std::pow(component(level.at(9, 9, band)), 2.0);
    return std::sqrt(sum);
  };
  c.judge = [length](const Pyramid& p) { return fmt::format("{:.2f}", length(p[1], [](double code) { return (code - 128.0) / 127.0; })); };
  c.judge_ours = [length](const Pyramids& layers) {
    return fmt::format("{:.2f} (spread kept: {:.2f})", length(layers.at("normal")[1], [](double value) { return value; }),
                       layers.at("normal/length")[1].at(9, 9));
  };
  return c;
}

// The values of a ramp are places: how far each lies from the centre of its texel, in texels of its level.
ScoreCase odd_ramp(bool along_rows) {
  constexpr std::int64_t kWidth = 257;
  constexpr std::int64_t kHeight = 65;
  constexpr std::size_t kOverviews = 4;
  const std::int64_t length = along_rows ? kWidth : kHeight;
  ScoreCase c;
  c.test =
      fmt::format("ramp over {} {}, levels 1 to {}: size of level 1, farthest from its texel's centre inside and at the edge, in texels",
                  length, along_rows ? "columns" : "rows", kOverviews);
  c.truth = fmt::format("{}, 0, 0", (length + 1) / 2);
  c.raster = raster(kWidth, kHeight, 1, SampleType::kFloat32);
  c.value = [along_rows](std::int64_t x, std::int64_t y, int) { return static_cast<double>(along_rows ? x : y) + 0.5; };
  c.ours = {{"", {"--channel", "elevation"}}};
  c.gdal = gdal_kernels({"average", "bilinear"});
  c.vips = c.maketx = kPlain;
  c.overviews = kOverviews;
  c.judge = [along_rows, length](const Pyramid& p) {
    const auto texels = [&](const LevelValues& level) { return along_rows ? level.width : level.height; };
    // Texels may be 2^level fine ones wide, the last cut off, or stretched over the whole ramp; what fits
    // better is taken to be meant.
    const auto errors = [&](bool stretched) {
      std::array<double, 2> worst{};
      for (std::size_t k = 1; k <= kOverviews; ++k) {
        const std::int64_t count = texels(p[k]);
        const double width = stretched ? static_cast<double>(length) / static_cast<double>(count) : std::exp2(static_cast<double>(k));
        for (std::int64_t i = 0; i < count; ++i) {
          const double value = along_rows ? p[k].at(i, p[k].height / 2) : p[k].at(p[k].width / 2, i);
          double& error = worst[i + 1 == count ? 1 : 0];
          error = std::max(error, std::abs(value / width - (static_cast<double>(i) + 0.5)));
        }
      }
      return worst;
    };
    const auto by_worst = [](const auto& a, const auto& b) { return std::ranges::max(a) < std::ranges::max(b); };
    const auto [inside, edge] = std::min(errors(false), errors(true), by_worst);
    return fmt::format("{}, {:.3f}, {:.3f}", texels(p[1]), inside, edge);
  };
  return c;
}

ScoreCase one_nan() {
  ScoreCase c;
  c.test = "one NaN: texels without a value at levels 1 to 4";
  c.truth = "0 or 1 each";
  c.raster = raster(512, 512, 1, SampleType::kFloat32);
  c.value = [](std::int64_t x, std::int64_t y, int) { return x == 201 && y == 77 ? std::numeric_limits<double>::quiet_NaN() : 50.0; };
  c.ours = {{"", {"--channel", "elevation"}}};
  c.gdal = gdal_kernels({"average", "cubic", "lanczos"});
  c.vips = c.maketx = kPlain;
  c.overviews = 4;
  c.judge = [](const Pyramid& p) {
    std::string text;
    for (std::size_t k = 1; k <= 4; ++k)
      text += fmt::format("{}{}", k > 1 ? "," : "", std::ranges::count_if(p[k].values, [](double v) { return std::isnan(v); }));
    return text;
  };
  return c;
}

ScoreCase bias() {
  ScoreCase c;
  c.test = "random bytes, mean of level 4 less mean of the input";
  c.truth = "0";
  c.raster = raster(1024, 1024, 1, SampleType::kUint8);
  c.value = [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(noise(x, y) & 0xFFU); };
  // Codes that mean light in proportion, so that the mean of codes that the peers make is right.
  c.ours = {{"", {"--channel", "color", "--transfer", "linear", "--kernel", "box"}}};
  c.gdal = gdal_kernels({"average", "bilinear", "cubic"});
  c.vips = c.maketx = kPlain;
  c.overviews = 4;
  double input = 0.0;
  for (std::int64_t y = 0; y < c.raster.height; ++y)
    for (std::int64_t x = 0; x < c.raster.width; ++x) input += c.value(x, y, 0) / static_cast<double>(c.raster.width * c.raster.height);
  const auto drift = [input](const Pyramid& p, const auto& code) {
    double sum = 0.0;
    for (const double value : p[4].values) sum += code(value);
    return fmt::format("{:+.3f}", sum / static_cast<double>(p[4].values.size()) - input);
  };
  c.judge = [drift](const Pyramid& p) { return drift(p, [](double value) { return value; }); };
  c.judge_ours = [drift](const Pyramids& layers) {
    return drift(layers.at("color"), [](double code) { return 255.0 * channels::linear_from_srgb(code / 255.0); });
  };
  return c;
}

ScoreCase classes() {
  ScoreCase c;
  c.test = "random classes, 40, 30 and 30 % of the area: shares at level 5";
  c.truth = "40/30/30";
  c.raster = raster(1024, 1024, 1, SampleType::kUint8);
  c.value = [](std::int64_t x, std::int64_t y, int) {
    const std::uint32_t share = noise(x, y) % 100;
    return share < 40 ? 1.0 : share < 70 ? 2.0 : 3.0;
  };
  c.ours = {{"", {"--channel", "material", "--mixture", "3"}}};
  c.gdal = gdal_kernels({"mode"});
  c.vips = {{"mode", {"--region-shrink", "mode"}}};
  c.overviews = 5;
  c.judge = [](const Pyramid& p) {
    std::array<double, 4> counts{};
    for (const double id : p[5].values)
      counts[static_cast<std::size_t>(std::clamp(id, 0.0, 3.0))] += 100.0 / static_cast<double>(p[5].values.size());
    return fmt::format("{:.0f}/{:.0f}/{:.0f}", counts[1], counts[2], counts[3]);
  };
  c.judge_ours = [](const Pyramids& layers) {
    const LevelValues& ids = layers.at("material/classes")[5];
    const LevelValues& weights = layers.at("material/weights")[5];
    std::array<double, 4> shares{};
    for (std::size_t i = 0; i < ids.values.size(); ++i)
      shares[static_cast<std::size_t>(std::clamp(ids.values[i], 0.0, 3.0))] +=
          100.0 * weights.values[i] / static_cast<double>(weights.width * weights.height);
    return fmt::format("{:.0f}/{:.0f}/{:.0f}", shares[1], shares[2], shares[3]);
  };
  return c;
}

}  // namespace

std::vector<ScoreCase> score_cases() {
  return {checker(),      clear_texels(),  void_column(), step(), stripes_of_normals(),
          odd_ramp(true), odd_ramp(false), one_nan(),     bias(), classes()};
}

}  // namespace vt::bench
