// Normals. A number is a component of a unit vector in a declared frame; what averages is the vector. The
// mean of unit vectors is shorter than one where they differ: its direction is stored, and beside it its
// length, which tells shading how rough the surface under the texel is (Toksvig 2004). Planes: x, y, z times
// weight, the weight (1 data, 0 none), then the moments of slopes when they are wanted.
//
// Frames. `enu`: x to the east, y to the north, z up, at the texel's own place. `scene`: whatever one frame
// the scene declares. Vectors are passed on as they are given; nothing is turned from one frame into another.
//
// Codes. A component c is code 128 + 127 c, in 16 bits 32768 + 32767 c, rounded: 0 and the ends are exact.
// Formats with two components leave z to the reader: sqrt(max(0, 1 - x^2 - y^2)). They cannot hold a
// direction that looks down; such a mean is put on the rim, at z = 0, which the reported angle shows. The
// length is code 1 to 255 (1 to 65535) for 0 to 1; code 0 is no data. In a bc4 there is no code to spare: no
// data has length 0.

#include "builder/channels/normal/normal.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/normal/normal_input.h"
#include "builder/channels/normal/normal_moments.h"
#include "builder/channels/normal/normal_rows.h"
#include "builder/channels/shared/angle.h"
#include "builder/channels/shared/format_of_channels.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/unblocked_format.h"
#include "builder/channels/shared/unorm_code.h"
#include "builder/channels/shared/unorm_rows.h"

namespace vt::channels {
namespace {

enum class Frame : std::uint8_t { kEnu, kScene };

struct NormalStyle {
  TexelFormat format = TexelFormat::kRgb8;
  Frame frame = Frame::kEnu;
  bool has_length = true;
  bool has_moments = false;
};

struct Vector {
  float x = 0.0F;
  float y = 0.0F;
  float z = 1.0F;
};

constexpr std::size_t kFirstMoment = 4;  // of the planes
constexpr std::int64_t kAtOnce = 256;    // texels between the SIMD loop and the codes, on the stack

// Room for what direction_and_length() gives.
struct DirectionRow {
  std::array<float, kAtOnce> x, y, z, length;

  void fill(const ConstPlaneRow& planes, std::int64_t first, std::int64_t count) {
    direction_and_length(static_cast<std::size_t>(count), planes[0] + first, planes[1] + first, planes[2] + first, planes[3] + first,
                         {x.data(), y.data(), z.data(), length.data()});
  }
  void set(std::size_t i, const Vector& direction) {
    x[i] = direction.x;
    y[i] = direction.y;
    z[i] = direction.z;
  }
};

template <class Work>
void in_pieces(std::int64_t count, const Work& work) {
  for (std::int64_t first = 0; first < count; first += kAtOnce) work(first, std::min(kAtOnce, count - first));
}

class NormalCodec final : public ChannelCodec {
 public:
  NormalCodec(const NormalInput& input, const NormalStyle& style)
      : input_(input), components_(format_info(style.format).channels), direction_(unorm_code(style.format, -1.0, 1.0, 1)) {
    input_.layout = weighed_by_coverage(input.layout);
    source_planes_ = 4;
    rules_.assign(4, PlaneRule::kLinear);
    if (style.has_moments) {
      for (std::size_t moment = 0; moment < kMomentCount; ++moment)
        rules_.insert(rules_.end(), {PlaneRule::kLinear, PlaneRule::kRemainder});
      rules_version_ = 2;  // moments were halves
    }
    measures_.push_back({.name = "direction", .unit = "deg"});
    measures_.push_back({.name = "length", .unit = ""});
    const bool is_one_texture = components_ == 4;  // x, y, z and the length
    marks_no_data_ = !style.has_length && !is_one_texture && style.format != TexelFormat::kBc5;
    add_direction(style);
    if (style.has_length && !is_one_texture) add_length(format_of_channels(style.format, 1));
    if (is_one_texture) length_ = unorm_code(style.format, 0.0, 1.0, 1);
    if (style.has_moments) add_moments();
    describe_losses(style);
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    return input_.decode_row(samples, count, out);
  }

  void derive_row(std::int64_t count, const PlaneRow& planes) const override {
    if (planes_with_moments()) moments_from_normals(count, planes, kFirstMoment);
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    switch (part_kinds_[part]) {
      case PartKind::kDirection:
        if (parts_[part].texel_format == TexelFormat::kRgb8) {
          encode_directions<std::uint8_t, 3>(rows, count, out);
        } else if (components_ == 4) {
          encode_directions<std::uint16_t, 4>(rows, count, out);
        } else {
          encode_directions<std::uint16_t, 2>(rows, count, out);
        }
        break;
      case PartKind::kLength:
        if (parts_[part].texel_format == TexelFormat::kR8) {
          encode_lengths<std::uint8_t>(rows, count, out);
        } else {
          encode_lengths<std::uint16_t>(rows, count, out);
        }
        break;
      case PartKind::kMoments:
        encode_moments(rows.here, kFirstMoment, count, out);
        break;
      case PartKind::kCrossMoment:
        encode_cross_moment(rows.here, kFirstMoment, count, out);
        break;
    }
    return {};
  }

  // A direction keeps the neighbour's, for the bilinear lookup; that there are no data is said where code 0
  // says so.
  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    const std::size_t texel_bytes = format_info(parts_[part].texel_format).block_bytes;
    for (std::int64_t i = 0; i < count; ++i, texels += texel_bytes) mark_no_data(part, texels, texel_bytes);
  }

  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    switch (part_kinds_[part]) {
      case PartKind::kDirection:
        return add_direction_errors(reference, stored, count, errors);
      case PartKind::kLength:
        return for_each_mean(reference, count, [&](std::int64_t i, const std::array<double, 3>&, double length) {
          errors[1].add(length_.value(stored[i]) - length);
        });
      case PartKind::kMoments:
        return add_moment_errors(reference, stored, count, errors[2]);
      case PartKind::kCrossMoment:
        return;  // of the variance along axes, which is measured, it has no part
    }
  }

  void count_losses(const ConstPlaneRow& row, bool, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    for (std::int64_t i = 0; i < count; ++i) {
      if (!(row[3][i] > 0.0F)) {
        if (void_loss_) counts[*void_loss_].add(x + i, y);
      } else if (down_loss_ && row[2][i] < 0.0F) {
        counts[*down_loss_].add(x + i, y);
      }
    }
  }

 private:
  enum class PartKind : std::uint8_t { kDirection, kLength, kMoments, kCrossMoment };

  [[nodiscard]] bool planes_with_moments() const { return rules_.size() > kFirstMoment; }

  void describe_losses(const NormalStyle& style) {
    const std::string name(format_info(style.format).name);
    const auto add = [&](std::string what) {
      losses_.push_back({std::move(what)});
      return losses_.size() - 1;
    };
    if (components_ == 2)
      down_loss_ =
          add("the normal looks down, which " + name + " cannot say, and the nearest one that is level is stored; use rgb8 or rgba16");
    if (style.format == TexelFormat::kBc5 && !style.has_length)
      void_loss_ =
          add("there are no data, which bc5 cannot say: it shows the neighbours' direction, or straight up where they have none; "
              "leave `length` no out, or use rg16");
  }

  void add_direction(const NormalStyle& style) {
    const bool is_enu = style.frame == Frame::kEnu;
    Part part{.format = style.format, .texel_format = unblocked_format(style.format), .zero_is_nodata = marks_no_data_};
    part.components = is_enu ? std::vector<std::string>{"east", "north", "up"} : std::vector<std::string>{"x", "y", "z"};
    part.components.resize(std::min<std::size_t>(components_, 3));
    part.metadata_json = std::string("{\"frame\":\"") + (is_enu ? "enu" : "scene") + "\"" +
                         (components_ == 2 ? ",\"up\":\"sqrt(max(0, 1 - east^2 - north^2))\"}" : "}");
    part.ranges.fill(direction_.range);
    for (std::size_t c = components_; c < 4; ++c) part.ranges[c] = {};
    if (components_ == 4) {
      part.components.emplace_back("length");
      part.ranges[3] = unorm_code(style.format, 0.0, 1.0, 1).range;
    }
    add_part(PartKind::kDirection, std::move(part));
  }

  void add_length(TexelFormat format) {
    const bool is_block = format == TexelFormat::kBc4;
    length_ = unorm_code(format, 0.0, 1.0, is_block ? 0 : 1);
    Part part{.suffix = "length", .format = format, .texel_format = unblocked_format(format), .zero_is_nodata = !is_block};
    part.components = {"length"};
    part.ranges[0] = length_.range;
    add_part(PartKind::kLength, std::move(part));
  }

  void add_moments() {
    measures_.push_back({.name = "slope variance", .unit = ""});
    Part moments{.suffix = "moments", .format = TexelFormat::kRgba32Float, .texel_format = TexelFormat::kRgba32Float};
    moments.components = {"mean x/z", "mean y/z", "mean (x/z)^2", "mean (y/z)^2"};
    moments.metadata_json = R"json({"moments": {"variance": ["mean (x/z)^2 - (mean x/z)^2", "mean (y/z)^2 - (mean y/z)^2"]}})json";
    add_part(PartKind::kMoments, std::move(moments));
    Part cross{.suffix = "cross_moment", .format = TexelFormat::kR32Float, .texel_format = TexelFormat::kR32Float};
    cross.components = {"mean (x/z)(y/z)"};
    cross.metadata_json = R"json({"moments": {"covariance": "mean (x/z)(y/z) - (mean x/z) (mean y/z)"}})json";
    add_part(PartKind::kCrossMoment, std::move(cross));
  }

  void add_part(PartKind kind, Part part) {
    parts_.push_back(std::move(part));
    part_kinds_.push_back(kind);
  }

  // Where a texel has no direction of its own: that of its neighbours together, or straight up.
  static Vector borrowed_direction(const RowNeighbourhood& rows, std::int64_t i) {
    const std::array<float, 4> sum = sum_around<float>(rows, kThreeAndWeight, i);
    Vector direction;
    float length = 0.0F;
    direction_and_length(1, sum.data(), &sum[1], &sum[2], &sum[3], {&direction.x, &direction.y, &direction.z, &length});
    return length >= kLeastLength ? direction : Vector{};
  }

  template <class Code, std::size_t components>
  void encode_directions(const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const {
    DirectionRow row;
    std::array<std::array<std::uint16_t, kAtOnce>, 4> codes;
    std::array<Code, kAtOnce * components> texels;
    in_pieces(count, [&](std::int64_t first, std::int64_t piece) {
      const auto texels_here = static_cast<std::size_t>(piece);
      row.fill(rows.here, first, piece);
      for (std::size_t i = 0; i < texels_here; ++i) {
        if (row.length[i] < kLeastLength) row.set(i, borrowed_direction(rows, first + static_cast<std::int64_t>(i)));
        if (components == 2 && row.z[i] < 0.0F) row.set(i, on_rim({row.x[i], row.y[i], row.z[i]}));
      }
      unorm_codes(direction_, texels_here, row.x.data(), codes[0].data());
      unorm_codes(direction_, texels_here, row.y.data(), codes[1].data());
      if (components > 2) unorm_codes(direction_, texels_here, row.z.data(), codes[2].data());
      if (components > 3) length_codes(row, texels_here, codes[3].data());
      for (std::size_t i = 0; i < texels_here; ++i)
        for (std::size_t c = 0; c < components; ++c) texels[i * components + c] = static_cast<Code>(codes[c][i]);
      if (marks_no_data_)
        for (std::size_t i = 0; i < texels_here; ++i)
          if (row.length[i] < 0.0F) texels[i * components] = 0;
      std::memcpy(out, texels.data(), texels_here * components * sizeof(Code));
      out += texels_here * components * sizeof(Code);
    });
  }

  // Code 0 where there are no data.
  void length_codes(const DirectionRow& row, std::size_t count, std::uint16_t* codes) const {
    unorm_codes(length_, count, row.length.data(), codes);
    for (std::size_t i = 0; i < count; ++i)
      if (row.length[i] < 0.0F) codes[i] = 0;
  }

  static Vector on_rim(const Vector& direction) {
    const float across = std::sqrt(direction.x * direction.x + direction.y * direction.y);
    if (across == 0.0F) return {1.0F, 0.0F, 0.0F};  // straight down: the whole rim is equally near
    return {direction.x / across, direction.y / across, 0.0F};
  }

  template <class Code>
  void encode_lengths(const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const {
    DirectionRow row;
    std::array<std::uint16_t, kAtOnce> codes;
    std::array<Code, kAtOnce> texels;
    in_pieces(count, [&](std::int64_t first, std::int64_t piece) {
      row.fill(rows.here, first, piece);
      length_codes(row, static_cast<std::size_t>(piece), codes.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(piece); ++i) texels[i] = static_cast<Code>(codes[i]);
      std::memcpy(out, texels.data(), static_cast<std::size_t>(piece) * sizeof(Code));
      out += static_cast<std::size_t>(piece) * sizeof(Code);
    });
  }

  void mark_no_data(std::size_t part, std::byte* texel, std::size_t texel_bytes) const {
    switch (part_kinds_[part]) {
      case PartKind::kDirection:
        if (marks_no_data_) std::memset(texel, 0, texel_bytes / components_);
        if (components_ == 4) std::memset(texel + texel_bytes / 4 * 3, 0, texel_bytes / 4);
        return;
      case PartKind::kLength:
        std::memset(texel, 0, texel_bytes);
        return;
      case PartKind::kMoments:
      case PartKind::kCrossMoment:
        for (std::size_t at = 0; at < texel_bytes; at += sizeof kNoMoment) std::memcpy(texel + at, &kNoMoment, sizeof kNoMoment);
        return;
    }
  }

  // `visit(texel, direction, length)` for each texel with data; the direction is 0, 0, 0 where the normals
  // cancel.
  template <class Visit>
  static void for_each_mean(const ConstPlaneRow& reference, std::int64_t count, const Visit& visit) {
    for (std::int64_t i = 0; i < count; ++i) {
      const double weight = reference[3][i];
      if (!(weight > 0.0)) continue;
      const std::array<double, 3> sum{reference[0][i], reference[1][i], reference[2][i]};
      const double magnitude = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
      const double length = std::min(magnitude / weight, 1.0);
      std::array<double, 3> direction{};
      const double scale = 1.0 / magnitude;
      if (length >= kLeastLength) direction = {scale * sum[0], scale * sum[1], scale * sum[2]};
      visit(i, direction, length);
    }
  }

  void add_direction_errors(const ConstPlaneRow& reference, const float* stored, std::int64_t count, std::span<ErrorSum> errors) const {
    for_each_mean(reference, count, [&](std::int64_t i, const std::array<double, 3>& wanted, double length) {
      const float* texel = stored + i * static_cast<std::int64_t>(components_);
      if (components_ == 4) errors[1].add(length_.value(texel[3]) - length);
      if (length < kLeastLength) return;  // no direction to be wrong about
      const double x = direction_.value(texel[0]);
      const double y = direction_.value(texel[1]);
      const double z = components_ == 2 ? std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) : direction_.value(texel[2]);
      const double scale = 1.0 / std::sqrt(x * x + y * y + z * z);
      errors[0].add(angle_between({scale * x, scale * y, scale * z}, wanted) / kRadiansPerDegree);
    });
  }

  static void add_moment_errors(const ConstPlaneRow& reference, const float* stored, std::int64_t count, ErrorSum& error) {
    for (std::int64_t i = 0; i < count; ++i, stored += 4) {
      if (!(reference[3][i] > 0.0F)) continue;
      const SlopeMoments wanted = moments_at(reference, kFirstMoment, i);
      error.add(slope_variance({stored[0], stored[1], stored[2], stored[3]}) - slope_variance({wanted.x, wanted.y, wanted.xx, wanted.yy}));
    }
  }

  NormalInput input_;
  std::size_t components_;
  bool marks_no_data_ = false;  // in the direction, because nothing else can
  // Among losses(), where there are such.
  std::optional<std::size_t> down_loss_;
  std::optional<std::size_t> void_loss_;
  UnormCode direction_;
  UnormCode length_;
  std::vector<PartKind> part_kinds_;
};

constexpr std::array<std::string_view, 2> kFrames{"enu", "scene"};

constexpr std::array kFormats{TexelFormat::kRgb8, TexelFormat::kRg16, TexelFormat::kRgba16, TexelFormat::kBc5};
// Those of two components leave z to be computed as positive.
constexpr std::array kFormatsWithZ{TexelFormat::kRgb8, TexelFormat::kRgba16};

bool is_of_scene(const Options& options) {
  const auto frame = options.find("frame");
  return frame != options.end() && frame->second == kFrames[1];
}

std::span<const TexelFormat> formats(const Options& options) {
  return is_of_scene(options) ? std::span<const TexelFormat>(kFormatsWithZ) : std::span<const TexelFormat>(kFormats);
}

std::string_view why_not_format(TexelFormat format, const Options& options) {
  if (is_of_scene(options) && std::ranges::find(kFormats, format) != kFormats.end())
    return " in the scene's frame: it leaves z to be computed as positive, and there z may be negative";
  return is_color_block(format_info(format)) ? ": its blocks tie x, y and z together, which turns directions by degrees" : "";
}

MadeCodec make_normal(const ChannelSettings& settings, const SampleLayout& layout) {
  constexpr std::array<std::string_view, 2> kMoments{"none", "lean"};
  VT_ASSIGN(const std::string frame, choice_of(settings.options, "frame", kFrames[0], kFrames));
  VT_ASSIGN(const std::string moments, choice_of(settings.options, "moments", kMoments[0], kMoments));
  NormalStyle style{.format = settings.format, .frame = frame == kFrames[0] ? Frame::kEnu : Frame::kScene};
  VT_ASSIGN(style.has_length, flag_of(settings.options, "length", true));
  style.has_moments = moments == kMoments[1];
  if (style.has_moments && style.frame == Frame::kScene)
    return fail(ErrorCode::kUnsupported,
                "moments of slopes need a vertical, which only frame enu has; use `frame` enu or leave `moments` out");
  VT_ASSIGN(const NormalInput input, choose_normal_input(settings.options, layout));
  return std::make_unique<const NormalCodec>(input, style);
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"frame", "enu|scene", "what x, y, z are: east, north, up at each place, or one frame for the whole scene (default: enu)"},
    {"zero", "128|127.5", "the code that is 0 in unsigned 8-bit input; in 16-bit input 32768 or 32767.5 (default: 128)"},
    {"y", "up|down", "whether y grows to the top or to the bottom of the picture in the input (default: up)"},
    {"length", "yes|no", "store the length of the mean normal, which tells roughness, beside rgb8, rg16 and bc5 (default: yes)"},
    {"moments", "none|lean", "store means and mean squares of the slopes as well (default: none)"},
});

}  // namespace

constinit const ChannelKind kNormalKind{
    .type = ChannelType::kNormal,
    .name = "normal",
    .options = kOptions,
    .bands_wanted = [](int candidates) { return candidates >= 3 ? 3 : 2; },
    .reads_colors = true,
    .why_only_box = "the mean of unit vectors has a length only if no direction is subtracted",
    .formats = formats,
    .why_not_format = why_not_format,
    .usual_format = [](SampleType, bool) { return TexelFormat::kRgb8; },
    .shown = Shown::kDirections,
    .make = make_normal,
};

}  // namespace vt::channels
