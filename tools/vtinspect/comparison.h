// What vtinspect compare finds, whatever it compares. One thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/channels/codec/error_sum.h"
#include "store/layer.h"
#include "store/result.h"
#include "tools/vtinspect/compare.h"
#include "tools/vtinspect/layer_values.h"

namespace vt::inspect {

// Decibels below `peak`; nothing when there is no error at all.
[[nodiscard]] inline std::optional<double> psnr_of(const channels::ErrorSum& errors, double peak) {
  const double rms = errors.root_mean_square();
  if (rms == 0.0) return std::nullopt;
  return 20.0 * std::log10(peak / rms);
}

// How far what is stored lies from a raster, in the channel's own terms; what the format loses is part of it.
struct MeasuredError {
  std::string name;  // "height"
  std::string unit;  // "m"; "" for ratios
  channels::ErrorSum error;
};

struct LevelDifference {
  int level = 0;
  std::uint64_t tiles = 0;            // present on either side
  std::uint64_t differing_tiles = 0;  // in bytes; against a raster, with a texel that differs
  std::uint64_t only_in_first = 0;
  std::uint64_t only_in_second = 0;
  std::uint64_t texels = 0;  // of the data in those tiles
  // Those of them that differ: in any value, or against a raster by more than the layer's format loses; with
  // or without data on one side only as well.
  std::uint64_t differing_texels = 0;
  std::uint64_t data_only_in_first = 0;
  std::uint64_t data_only_in_second = 0;
  std::uint64_t misfits = 0;  // values of a raster that the layer's format cannot hold
  channels::ErrorSum values;  // codes, or the layer's unit; of classes 1 where they differ
  channels::ErrorSum linear;  // linear light, for sRGB layers
  std::vector<MeasuredError> measured;

  [[nodiscard]] std::uint64_t hole_mismatches() const { return data_only_in_first + data_only_in_second; }
};

struct LayerDifference {
  std::string name;
  bool is_byte_format = false;
  bool is_srgb = false;
  bool is_blob = false;
  bool is_class = false;  // names, which are the same or not: no tolerance applies
  std::vector<LevelDifference> levels;

  [[nodiscard]] bool is_within(const LevelDifference& level, double tolerance) const {
    if (level.only_in_first > 0 || level.only_in_second > 0 || level.hole_mismatches() > 0 || level.misfits > 0) return false;
    if (is_blob) return level.differing_tiles == 0;
    return level.differing_texels == 0 || (!is_class && level.values.largest <= tolerance);
  }
};

// What is known of a raster: how its samples were understood, and how much of the layer it covers.
struct RasterReading {
  bool as_source = false;  // as the builder read the layer's sources; otherwise its samples are the layer's values
  TexelRect compared;      // texels from the data rectangle's corner
};

struct Comparison {
  std::vector<std::string> mismatches;  // what makes tiles incomparable, or is not in both
  std::vector<std::string> remarks;     // what to know about the figures
  std::optional<RasterReading> raster;
  std::vector<LayerDifference> layers;

  // Not one tile differs in its bytes, or, of a raster, not one texel.
  [[nodiscard]] bool is_equal() const {
    return mismatches.empty() && std::ranges::all_of(layers, [&](const LayerDifference& layer) {
             return std::ranges::all_of(layer.levels, [&](const LevelDifference& level) {
               return level.differing_tiles == 0 && level.only_in_first == 0 && level.only_in_second == 0;
             });
           });
  }
  [[nodiscard]] bool is_within(double tolerance) const {
    return mismatches.empty() && std::ranges::all_of(layers, [&](const LayerDifference& layer) {
             return std::ranges::all_of(layer.levels, [&](const LevelDifference& level) { return layer.is_within(level, tolerance); });
           });
  }
};

[[nodiscard]] inline LayerDifference empty_difference(const LayerInfo& layer) {
  const bool is_byte_format = !layout_of(layer).is_float;
  // The part NAME/weights holds shares, which are numbers.
  const bool is_class =
      channels::kind_of(layer.channel).shown == channels::Shown::kClasses && absent_texels(layer, layer.finest).code_of_none.has_value();
  return {layer.name, is_byte_format, is_byte_format && layer.transfer == Transfer::kSrgb, layer.holds_blobs(), is_class, {}};
}

// One sample of both sides, which are numbers.
inline void add_pair(LevelDifference& difference, double a, double b, bool is_class, bool is_srgb_code) {
  // Equal infinities have no difference, and their subtraction is no number.
  if (a == b) {
    ++difference.values.count;
  } else if (is_class) {
    difference.values.add(1.0);
  } else {
    difference.values.add(a - b);
  }
  if (is_srgb_code) {
    const auto& light = linear_from_srgb();
    difference.linear.add(light[static_cast<std::size_t>(a)] - light[static_cast<std::size_t>(b)]);
  }
}

// A sample of decoded texels, as TexelLayout says.
[[nodiscard]] inline double sample_at(std::span<const std::byte> texels, std::size_t index, bool is_float) {
  if (!is_float) return std::to_integer<int>(texels[index]);
  float value = 0.0F;
  std::memcpy(&value, &texels[index * sizeof value], sizeof value);
  return double{value};
}

[[nodiscard]] Result<Comparison> compare_stores(const CompareOptions& options);
[[nodiscard]] Result<Comparison> compare_with_raster(const CompareOptions& options);

}  // namespace vt::inspect
