// How the values of one layer enter and leave filter space.
//
// Filter space is where averaging is right: for every channel a few planes of floats, each already multiplied
// by its texel's weight, and the weight itself. Resampling and overviews are then plain weighted sums of
// planes, and a texel without data (all planes zero) contributes nothing by itself. A channel's file says
// what its planes are; nothing else about a channel is known outside it.
//
// A value walks: samples -> decode_row -> source planes -> derive_row -> all planes -> (mosaics, overviews)
// -> encode_row, once for each part. Resampling to a grid that is as fine as the source's comes before
// derive_row, to a coarser one after it. A codec is immutable: const functions are safe from any thread. Work
// is done by rows, never by a call per texel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/channels/codec/channel_settings.h"
#include "builder/channels/codec/class_planes.h"
#include "builder/channels/codec/error_sum.h"
#include "builder/channels/samples/sample_layout.h"
#include "builder/source/sample_type.h"
#include "store/channel.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/texel_format.h"

namespace vt::channels {

inline constexpr int kMaxPlanes = 52;  // 24 directions of a horizon with two moments each, the weight, and room

using PlaneRow = std::array<float*, kMaxPlanes>;
using ConstPlaneRow = std::array<const float*, kMaxPlanes>;

// A row with its neighbours to the north and south; every pointer may be read from index -1 to count (one
// past the last texel).
struct RowNeighbourhood {
  ConstPlaneRow above;
  ConstPlaneRow here;
  ConstPlaneRow below;
  bool opaque = false;  // every weight of `here` is exactly 1
};

// How a plane of a coarser level comes from the finer one.
enum class PlaneRule : std::uint8_t {
  kLinear,    // weighted sum by the layer's kernel
  kLeast,     // least of the four texels under it; +infinity where there is none
  kGreatest,  // greatest of the four; -infinity where there is none
  // What the floats of the linear plane before it miss: the two together are that plane's sums in double
  // precision, see wide_value.h. For the kernels box and point.
  kRemainder,
};
// A plane of sums, not of least or greatest values.
[[nodiscard]] constexpr bool is_sum(PlaneRule rule) { return rule == PlaneRule::kLinear || rule == PlaneRule::kRemainder; }
// Whether plane `p` is continued by the next one, which holds what its floats miss.
[[nodiscard]] inline bool has_remainder(std::span<const PlaneRule> rules, std::size_t p) {
  return p + 1 < rules.size() && rules[p + 1] == PlaneRule::kRemainder;
}

// One texture layer that a channel writes. The first part is the layer itself, the others lie beside it as
// NAME/suffix on the same grid.
struct Part {
  std::string suffix;                             // "" for the first
  TexelFormat format = TexelFormat::kRgb8;        // as stored
  TexelFormat texel_format = TexelFormat::kRgb8;  // what encode_row writes: `format`, or what its block encoder takes
  std::vector<std::string> components;            // what the texel's numbers are, for people and metadata: {"east mean", ...}
  std::string unit;                               // of value = offset + scale * sample; "" when it has none
  std::array<ComponentRange, 4> ranges = {};      // likewise
  bool zero_is_nodata = false;                    // code 0 of the first component means no data
  bool starts_above_base = false;                 // nothing is stored at the finest level; readers fall back to the next coarser one
  bool ends_at_base = false;                      // blocks write the finest level only; a pass after them makes the others
  // What else a reader has to know (a table of classes, a frame, a spectral band): a JSON object, whose
  // members become members of the part's metadata. None of them is called as the builder's own, see
  // kOwnMembers in builder/pipeline/blocks/built_layer.cpp.
  std::string metadata_json = "{}";
};

// A texel that the edge of the data rectangle cuts has its data on one side of its centre, up to half a texel
// away. A channel with such a range stores there the value at the centre, continued in a straight line from
// the next texel, instead of the mean over the part that has data; what goes on to coarser levels stays the
// mean. It concerns the first plane and its remainder, of which planes of least and greatest values are
// bounds.
struct CentreRange {
  double least = 0.0;  // what the format can hold; values are not continued past it
  double greatest = 0.0;
  double bounds_origin = 0.0;  // planes of bounds are values less this
};

// Something that texels of the finest level cannot say as it is (values cut off at the end of what a format
// holds, texels without data where a format has no way to say so), or that can hardly be meant. Counted while
// a layer is built, so that it is never silent.
struct Loss {
  std::string what;  // completes "in 12 texels of the finest level ..."; says what is stored, and what to do about it
};

struct LossCount {
  std::uint64_t texels = 0;
  std::int64_t x = 0;  // of the first in reading order
  std::int64_t y = 0;

  // `x` and `y` of a texel that comes after those that were added, or before them.
  void add(std::int64_t texel_x, std::int64_t texel_y) { *this += {1, texel_x, texel_y}; }
  LossCount& operator+=(const LossCount& other) {
    if (other.texels == 0) return *this;
    if (texels == 0 || other.y < y || (other.y == y && other.x < x)) {
      x = other.x;
      y = other.y;
    }
    texels += other.texels;
    return *this;
  }
};

// One number that is reported of every level: how far what is stored lies from the unquantised planes, in the
// channel's own unit.
struct Measure {
  std::string name;       // "error of light"
  std::string unit;       // "deg"; "" for ratios
  std::size_t part = 0;   // whose texels are measured
  bool is_light = false;  // the total has to be kept; where a format does not, whoever builds the layer is told
};

class ChannelCodec {
 public:
  virtual ~ChannelCodec() = default;

  // What decode_row makes; the last of them is the weight.
  [[nodiscard]] int source_planes() const { return source_planes_; }
  [[nodiscard]] int weight_plane() const { return source_planes_ - 1; }
  // The source planes, then those that derive_row makes.
  [[nodiscard]] int planes() const { return static_cast<int>(rules_.size()); }
  [[nodiscard]] std::span<const PlaneRule> rules() const { return rules_; }
  [[nodiscard]] std::span<const Part> parts() const { return parts_; }
  [[nodiscard]] std::span<const Measure> measures() const { return measures_; }
  [[nodiscard]] std::span<const Loss> losses() const { return losses_; }
  // Greater than 1 where the rules by which samples become the texels of such a layer are not the first ones:
  // tiles made by other rules are not to be mixed with these.
  [[nodiscard]] int rules_version() const { return rules_version_; }
  // The coarser levels keep the share of the area whose value exceeds this, see
  // builder/pipeline/passes/coverage_pass.h.
  [[nodiscard]] std::optional<double> kept_above() const { return kept_above_; }
  // The surfaces through coarser levels are compared with the finest level, see
  // builder/pipeline/passes/surface_pass.h.
  [[nodiscard]] bool measures_surface() const { return measures_surface_; }
  [[nodiscard]] const std::optional<CentreRange>& centre_range() const { return centre_range_; }
  // Values are those of a surface at places: resampling keeps them where they are, at the price that samples
  // may count a little more or less than their area. Otherwise areas count, and sums are kept.
  [[nodiscard]] bool is_surface() const { return is_surface_; }
  // A row of samples already is a row of texels of the first part, byte for byte: encode(decode(samples))
  // would give the same.
  [[nodiscard]] bool samples_are_texels() const { return samples_are_texels_; }
  // What is stored are numbers of the samples' own scale and unit.
  [[nodiscard]] bool keeps_numbers() const { return keeps_numbers_; }
  // When there is one, the planes are those of class_planes.h, and overviews count classes instead of
  // following rules().
  [[nodiscard]] const std::optional<ClassCounting>& class_counting() const { return class_counting_; }

  // `count` texels of samples into source planes. Returns whether all weights are exactly 1.
  bool decode_row(const std::byte* samples, std::int64_t count, const PlaneRow& out) const;
  // The remaining planes of `count` samples or texels of the finest level, from their source planes.
  virtual void derive_row(std::int64_t count, const PlaneRow& planes) const;
  // One quantisation: planes to texels of a part, the first of which lies in an even column (a tile's first,
  // or the data's). The neighbours lend their values to texels that have none, so that a bilinear lookup at
  // the edge does not bleed. kInvalidData: a value that the part's format and ranges cannot hold, which is
  // never clamped silently; the message names the value and says what to set. Then `out` holds nothing of
  // use.
  [[nodiscard]] virtual Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count,
                                                std::byte* out) const = 0;
  // Whether any of `count` texels has something to store in a part; tiles without are left out. Here: any
  // weight above 0.
  [[nodiscard]] virtual bool has_data(std::size_t part, const ConstPlaneRow& planes, std::int64_t count) const;
  // Texels outside the data rectangle, in a tile that also has data: turns a copy of the nearest data texel
  // into what lies outside. `count` texels of part(part).texel_format.
  virtual void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const = 0;
  // Adds the errors of `count` texels to `errors`, one for each of measures(). `stored` holds the part's
  // samples as decode_texels() (store/texel/texel_decoder.h) reads them back from what is stored; `reference`
  // the planes that they came from.
  virtual void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                          std::span<ErrorSum> errors) const = 0;
  // Adds what losses() are found in `count` texels of the finest level, the first of which is texel `x`, `y`,
  // to `counts`, one for each of losses(). `opaque`: all weights are exactly 1. Here: there are none.
  virtual void count_losses(const ConstPlaneRow& row, bool opaque, std::int64_t count, std::int64_t x, std::int64_t y,
                            std::span<LossCount> counts) const;

 protected:
  // What decode_row does of samples in the layout that the channel keeps: coverage is among them only for
  // channels that weigh with it themselves.
  virtual bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const = 0;

  // How a coverage between none and all counts.
  enum class CoverageUse : std::uint8_t {
    kWeight,  // as a weight
    kHalf,    // from one half on as all: of values that have no fraction of a texel
  };
  // For channels whose values know nothing of coverage: decode_row weighs their planes by it. Gives back the
  // layout without it.
  [[nodiscard]] SampleLayout weighed_by_coverage(const SampleLayout& layout, CoverageUse use = CoverageUse::kWeight);

  int source_planes_ = 0;
  std::vector<PlaneRule> rules_;
  std::vector<Part> parts_;
  std::vector<Measure> measures_;
  std::vector<Loss> losses_;
  int rules_version_ = 1;
  bool samples_are_texels_ = false;
  std::optional<double> kept_above_;
  bool measures_surface_ = false;
  bool keeps_numbers_ = true;
  std::optional<CentreRange> centre_range_;
  bool is_surface_ = false;
  std::optional<ClassCounting> class_counting_;

 private:
  bool decode_covered(const std::byte* samples, std::int64_t count, const PlaneRow& out) const;

  std::optional<SampleLayout> covered_layout_;  // with the coverage that decode_row takes off
  CoverageUse coverage_use_ = CoverageUse::kWeight;
};

}  // namespace vt::channels
