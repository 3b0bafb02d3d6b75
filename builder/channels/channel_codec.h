// How the values of one layer enter and leave filter space.
//
// Filter space is where averaging is right: for every channel a few planes of floats, each already multiplied by its texel's weight, and
// the weight itself as the last plane. Resampling and overviews are then plain weighted sums of planes, and a texel without data (all
// planes zero) contributes nothing by itself. A channel's file says what its planes are; nothing else about a channel is known outside it.
// A codec is immutable: const functions are safe from any thread. Work is done by rows, never by a call per texel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "store/channel.h"
#include "store/result.h"
#include "store/sample_type.h"
#include "store/texel_format.h"

namespace vt::channels {

inline constexpr int kMaxPlanes = 4;

using PlaneRow = std::array<float*, kMaxPlanes>;
using ConstPlaneRow = std::array<const float*, kMaxPlanes>;

// A row with its neighbours to the north and south; every pointer may be read from index -1 to count (one past the last texel).
struct RowNeighbourhood {
  ConstPlaneRow above;
  ConstPlaneRow here;
  ConstPlaneRow below;
  bool opaque = false;  // every weight of `here` is exactly 1
};

// What one row of source samples looks like: `value_bands` values, then one coverage sample when `has_alpha`, interleaved, native byte
// order.
struct SampleLayout {
  SampleType type = SampleType::kUint8;
  int value_bands = 3;
  bool has_alpha = false;
  std::optional<double> nodata;  // a texel is no data when all its values equal this (NaN and infinities always are)
  // Source values that mean black and white, for colour from samples that are not 8 or 16 bit codes.
  std::optional<std::array<double, 2>> range;

  [[nodiscard]] std::size_t texel_bytes() const { return sample_bytes(type) * static_cast<std::size_t>(value_bands + (has_alpha ? 1 : 0)); }
};

class ChannelCodec {
 public:
  virtual ~ChannelCodec() = default;

  [[nodiscard]] int planes() const { return planes_; }
  [[nodiscard]] int weight_plane() const { return planes_ - 1; }
  // What encode_row writes. A block-compressed layer is encoded as kRgb8 first; the block encoder comes after.
  [[nodiscard]] TexelFormat texel_format() const { return texel_format_; }
  // Holds the planes of one texel, interleaved.
  [[nodiscard]] TexelFormat carry_format() const { return carry_format_; }
  // A row of samples already is a row of texels, byte for byte: encode(decode(samples)) would give the same.
  [[nodiscard]] bool samples_are_texels() const { return samples_are_texels_; }

  // `count` texels of samples into planes. Returns whether all weights are exactly 1.
  virtual bool decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const = 0;
  // One quantisation: planes to texels. The neighbours lend their colour to texels that have none, so that a bilinear lookup at the edge
  // does not bleed.
  virtual void encode_row(const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const = 0;
  // Texels outside the data rectangle, in a tile that also has data: turns a copy of the nearest data texel into what lies outside. `count`
  // texels.
  virtual void mark_outside(std::byte* texels, std::int64_t count) const = 0;

 protected:
  int planes_ = 0;
  TexelFormat texel_format_ = TexelFormat::kRgb8;
  TexelFormat carry_format_ = TexelFormat::kRgba32Float;
  bool samples_are_texels_ = false;
};

// kUnsupported when the channel cannot be made from such samples or stored in such a format; the message says what can.
[[nodiscard]] Result<std::unique_ptr<const ChannelCodec>> make_color_codec(const SampleLayout& layout, Transfer transfer,
                                                                           TexelFormat format);
[[nodiscard]] Result<std::unique_ptr<const ChannelCodec>> make_elevation_codec(const SampleLayout& layout, TexelFormat format);

// Chooses by channel type. A type that has no file here yet is kUnsupported, by name.
[[nodiscard]] Result<std::unique_ptr<const ChannelCodec>> make_codec(ChannelType channel, const SampleLayout& layout, Transfer transfer,
                                                                     TexelFormat format);

}  // namespace vt::channels
