// One kind of numbers: everything that the builder and the tools know of a channel, in one value. Each
// channel defines its own beside its codec; builder/channels/all_channels.cpp has one row a channel. Nothing
// outside a channel's folder asks which channel it has before it: it asks what the channel's kind says.
// Constant data, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "builder/channels/codec/channel_codec.h"
#include "builder/channels/codec/channel_options.h"
#include "builder/channels/codec/channel_settings.h"
#include "builder/channels/samples/sample_layout.h"
#include "builder/source/raster_source.h"
#include "store/channel.h"
#include "store/result.h"
#include "store/texel_format.h"

namespace vt::channels {

using MadeCodec = Result<std::unique_ptr<const ChannelCodec>>;

// For ChannelKind::formats: the same list whatever the options are.
template <const auto& kFormats>
std::span<const TexelFormat> always_formats(const Options&) {
  return kFormats;
}

// How texels of the layer itself (not of its parts) are shown to people.
enum class Shown : std::uint8_t {
  kValues,      // as numbers from the least to the greatest, or as codes
  kDirections,  // unit vectors: components from -1 to 1; of two the third follows
  kLight,       // light of any size, of which the brightest lamps are left out
  kClasses,     // numbers that name something, by the layer's table of classes
};

// What a texel without a tile, or without data in a format that cannot say so, is worth.
enum class Absent : std::uint8_t {
  kUnknown,  // nothing
  kZero,     // 0, as what has no light or lies outside
  kClass,    // the class that the layer keeps for "no data"
  kFill,     // what voids were filled with, if they were; else nothing
};

// Stored to raw bytes, of formats that were never measured: the most that it can be.
inline constexpr double kUnmeasuredRatio = 1.0;

struct ChannelKind {
  ChannelType type{};          // its number on disk
  std::string_view name;       // on the command line, in scenes and in messages
  std::string_view unit = "";  // of its values, where a layer does not say another
  std::span<const OptionInfo> options = {};

  // ---- What is read of a raster ----

  // How many of so many bands that may be values are read when nobody names them.
  int (*bands_wanted)(int candidates) = [](int) { return 1; };
  bool has_one_value = false;        // bands of equal right exclude each other: of several one has to be named
  bool may_be_coverage = false;      // the coverage band of a file that has values beside it is the channel's value
  bool reads_colors = false;         // samples are colours: palettes are expanded and MinIsWhite is inverted; otherwise they are numbers
  bool has_black_and_white = false;  // a range names the samples that are black and white
  bool uses_declared_scale = false;  // the scale, offset and unit that a file declares for a band count
  bool holds_heights = false;        // what a file says of its heights counts (feet, depths), and its no-data value is given back
  source::Concern concern = source::Concern::kAll;  // the special facts of a file that make a difference; kAll: none
  // Refuses what the samples of a window cannot be. Null: nothing is looked at.
  Result<void> (*check_samples)(const Options& options, const SampleLayout& layout, std::span<const std::byte> samples) = nullptr;

  // ---- How it is filtered ----

  std::string_view usual_kernel = "box";
  std::string_view why_only_box = "";  // completes "does not suit ... layers: "; empty where every kernel that is a mean will do
  bool may_be_picked = false;          // takes the kernel point, which picks one texel of four
  // What is counted and never interpolated, for messages: "material layers". Empty: values are averaged.
  std::string_view (*counted)(const Options& options) = [](const Options&) { return std::string_view(); };

  // ---- How it is stored ----

  // The formats that a layer may be stored as, in the order in which messages name them; make() is given no
  // other. always_formats<kFormats> where options do not matter. Empty: make() looks at the format itself.
  std::span<const TexelFormat> (*formats)(const Options& options) = [](const Options&) { return std::span<const TexelFormat>(); };
  // Why another format will not do, for messages: completes "mask layers cannot be stored as rgb8". May be
  // empty.
  std::string_view (*why_not_format)(TexelFormat format, const Options& options) = [](TexelFormat, const Options&) {
    return std::string_view();
  };
  // The format of a layer for which nobody names one.
  TexelFormat (*usual_format)(SampleType samples, bool may_be_empty) = nullptr;
  Transfer transfer = Transfer::kLinear;
  bool fourth_is_coverage = false;  // in formats of four components
  // The light of the stored number 1 in layers of such a format is chosen by a look at the sources, see
  // stored_light.h.
  bool (*chooses_stored_light)(TexelFormat format, const Options& options) = [](TexelFormat, const Options&) { return false; };
  // Stored to raw bytes at zstd:3, the upper end of what was measured.
  double (*stored_ratio)(TexelFormat format) = [](TexelFormat) { return kUnmeasuredRatio; };
  double carry_ratio = 0.55;  // likewise of filter state at zstd:1

  // ---- How it is shown ----

  Shown shown = Shown::kValues;
  Absent absent = Absent::kUnknown;

  // The codec of such samples and settings. Its options belong to the channel. Errors as of make_codec().
  MadeCodec (*make)(const ChannelSettings& settings, const SampleLayout& layout) = nullptr;

  // Null: the channel has no such option.
  [[nodiscard]] const OptionInfo* find_option(std::string_view option) const;
};

}  // namespace vt::channels
