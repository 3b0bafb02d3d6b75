// Material. A number is the name of a class: between class 2 and class 4 there is no class 3, so classes are
// never averaged but counted, and a texel of a coarser level is the class that holds most of its area, the
// lowest of several that hold as much. Planes: class, weight (1 data, 0 no data), then what class_planes.h
// says. One code is kept for no data. The parts NAME/classes and NAME/weights, when asked for, hold the most
// frequent classes and their shares of the area with data in 1/255; what is missing from 255 is other
// classes'.

#include "builder/channels/material/material.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/material/class_table.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/shared/format_of_channels.h"
#include "builder/text/json_text.h"

namespace vt::channels {
namespace {

using Json = nlohmann::ordered_json;

enum PartNumber : std::size_t { kMajority, kClasses, kWeights };

// Shares in 1/255, such that they and the rest, which no rank holds, sum to 255: each rounded down, then one
// more for those that lost most (the method of largest remainders; of equal remainders the higher rank first,
// the rest last).
void quantise_shares(const std::array<float, kMostRankedClasses>& shares, int ranked, std::array<int, kMostRankedClasses>& codes) {
  std::array<float, kMostRankedClasses + 1> remainder{};
  float rest = 1.0F;
  int left = 255;
  for (std::size_t r = 0; r < static_cast<std::size_t>(ranked); ++r) {
    const float exact = shares[r] * 255.0F;
    codes[r] = static_cast<int>(exact);
    remainder[r] = exact - static_cast<float>(codes[r]);
    left -= codes[r];
    rest -= shares[r];
  }
  const auto last = static_cast<std::size_t>(ranked);
  const float exact_rest = std::max(rest, 0.0F) * 255.0F;
  left -= static_cast<int>(exact_rest);
  remainder[last] = exact_rest - std::floor(exact_rest);
  for (; left > 0; --left) {
    const auto most = static_cast<std::size_t>(std::max_element(remainder.begin(), remainder.begin() + ranked + 1) - remainder.begin());
    if (most != last) ++codes[most];
    remainder[most] = -1.0F;
  }
}

class MaterialCodec final : public ChannelCodec {
 public:
  MaterialCodec(const SampleLayout& layout, TexelFormat format, const ClassCounting& counting, bool has_mixture, const Json& table)
      : layout_(weighed_by_coverage(layout, CoverageUse::kHalf)), counting_(counting), codes_(format_info(format).samples) {
    source_planes_ = 2;
    class_counting_ = counting;
    rules_.assign(static_cast<std::size_t>(class_planes(counting.ranked)), PlaneRule::kLinear);
    Json metadata{{"no_data_class", counting.no_data}};
    if (!table.is_null()) metadata["classes"] = table;
    const bool zero_is_nodata = counting.no_data == 0;
    parts_.push_back({.format = format,
                      .texel_format = format,
                      .components = {"class"},
                      .zero_is_nodata = zero_is_nodata,
                      .metadata_json = metadata.dump()});
    measures_.push_back({.name = "class area", .unit = "pp"});
    const NodataRange nodata = nodata_range(layout);
    const bool same_no_data = nodata.empty() || (nodata.low == counting.no_data && nodata.high == counting.no_data);
    samples_are_texels_ = same_no_data && !layout.has_alpha && sample_bytes(layout.type) == vt::sample_bytes(codes_);
    if (has_mixture) add_mixture();
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    return visit_sample_type(layout_.type, [&]<class T>(std::type_identity<T>) { return decode<T>(samples, count, out); });
  }

  // A texel of the finest level is all of one class.
  void derive_row(std::int64_t count, const PlaneRow& planes) const override {
    const auto plane = [&](int p) { return planes[static_cast<std::size_t>(p)]; };
    std::copy_n(plane(kClassWeightPlane), count, plane(share_plane(0)));
    for (int rank = 1; rank < counting_.ranked; ++rank) {
      std::fill_n(plane(class_plane(rank)), count, 0.0F);
      std::fill_n(plane(share_plane(rank)), count, 0.0F);
    }
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    if (part == kWeights) {
      encode_weights(rows.here, count, reinterpret_cast<std::uint8_t*>(out));
    } else {
      visit_codes([&]<class Code>(std::type_identity<Code>) { encode_classes<Code>(part, rows.here, count, out); });
    }
    return {};
  }

  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    const std::int64_t codes = count * format_info(parts_[part].texel_format).channels;
    if (part == kWeights) {
      std::memset(texels, 0, static_cast<std::size_t>(codes));
      return;
    }
    visit_codes([&]<class Code>(std::type_identity<Code>) {
      const auto code = static_cast<Code>(counting_.no_data);
      for (std::int64_t i = 0; i < codes; ++i) std::memcpy(texels + i * static_cast<std::int64_t>(sizeof code), &code, sizeof code);
    });
  }

  // Half the sum over all classes of |stored share - true share|: the part of the texel's area, in percentage
  // points, that is taken for another class, or for none. The majority alone stands for all of the area.
  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    const float* weight = reference[kClassWeightPlane];
    if (part == kMajority) {
      const float* classes = reference[static_cast<std::size_t>(class_plane(0))];
      const float* share = reference[static_cast<std::size_t>(share_plane(0))];
      for (std::int64_t i = 0; i < count; ++i)
        if (weight[i] > 0.0F) errors[0].add(100.0 * (1.0 - (stored[i] == classes[i] ? static_cast<double>(share[i]) : 0.0)));
    }
    if (part != kWeights) return;
    const auto channels = static_cast<std::int64_t>(format_info(parts_[kWeights].format).channels);
    for (std::int64_t i = 0; i < count; ++i) {
      if (weight[i] == 0.0F) continue;
      double distance = 0.0;
      double true_rest = 1.0;
      double stored_rest = 1.0;
      for (int rank = 0; rank < counting_.ranked; ++rank) {
        const double is = static_cast<double>(stored[i * channels + rank]) / 255.0;
        const double wanted = reference[static_cast<std::size_t>(share_plane(rank))][i];
        distance += std::abs(is - wanted);
        true_rest -= wanted;
        stored_rest -= is;
      }
      errors[1].add(50.0 * (distance + std::abs(true_rest) + std::abs(stored_rest)));
      errors[1].add_total(1.0, 1.0 - stored_rest);
    }
  }

 private:
  // Calls act(std::type_identity<Code>()) with the type of a stored class.
  template <class Act>
  void visit_codes(const Act& act) const {
    switch (codes_) {
      case SampleKind::kUnorm8:
        return act(std::type_identity<std::uint8_t>());
      case SampleKind::kUnorm16:
        return act(std::type_identity<std::uint16_t>());
      case SampleKind::kHalf:
      case SampleKind::kFloat:
      case SampleKind::kSharedExponent:
      case SampleKind::kBlock:
      case SampleKind::kOpaque:
        assert(false && "a format that classes are not stored in");
    }
  }

  void add_mixture() {
    Part classes{.suffix = "classes", .format = format_of_channels(parts_[kMajority].format, counting_.ranked)};
    Part weights{.suffix = "weights", .format = format_of_channels(TexelFormat::kR8, counting_.ranked)};
    for (int rank = 1; rank <= counting_.ranked; ++rank) {
      classes.components.push_back("class " + std::to_string(rank));
      weights.components.push_back("share of class " + std::to_string(rank));
    }
    classes.texel_format = classes.format;
    classes.zero_is_nodata = counting_.no_data == 0;
    classes.metadata_json = Json{{"no_data_class", counting_.no_data}}.dump();
    weights.texel_format = weights.format;
    for (ComponentRange& range : weights.ranges) range.scale = 1.0 / 255.0;
    parts_.push_back(std::move(classes));
    parts_.push_back(std::move(weights));
    measures_.push_back({.name = "class area of the mixture", .unit = "pp", .part = kWeights});
  }

  // A class that the layer cannot hold goes on as it is; the cascade reports it.
  template <class T>
  bool decode(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    float* const classes = out[0];
    float* const weights = out[kClassWeightPlane];
    const TypedNodataRange<T> nodata = typed_nodata_range<T>(layout_);
    T sample;
    if (nodata.empty() && !std::is_floating_point_v<T>) {
      for (std::int64_t i = 0; i < count; ++i) {
        std::memcpy(&sample, samples + i * static_cast<std::int64_t>(sizeof sample), sizeof sample);
        classes[i] = static_cast<float>(sample);
      }
      std::fill_n(weights, count, 1.0F);
      return true;
    }
    int voids = 0;
    for (std::int64_t i = 0; i < count; ++i) {
      std::memcpy(&sample, samples + i * static_cast<std::int64_t>(sizeof sample), sizeof sample);
      bool is_void = nodata.contains(sample);
      if constexpr (std::is_floating_point_v<T>) is_void = is_void || !std::isfinite(sample);
      voids |= static_cast<int>(is_void);
      classes[i] = is_void ? 0.0F : static_cast<float>(sample);
      weights[i] = is_void ? 0.0F : 1.0F;
    }
    return voids == 0;
  }

  template <class Code>
  void encode_classes(std::size_t part, const ConstPlaneRow& row, std::int64_t count, std::byte* out) const {
    const auto no_data = static_cast<Code>(counting_.no_data);
    const auto channels = static_cast<std::int64_t>(format_info(parts_[part].texel_format).channels);
    for (std::int64_t channel = 0; channel < channels; ++channel) {
      const auto rank = static_cast<int>(channel);
      const float* const classes = row[static_cast<std::size_t>(class_plane(rank))];
      const float* const share = row[static_cast<std::size_t>(share_plane(rank))];
      for (std::int64_t i = 0; i < count; ++i) {
        const Code code = share[i] > 0.0F ? static_cast<Code>(static_cast<int>(classes[i])) : no_data;
        std::memcpy(out + (i * channels + channel) * static_cast<std::int64_t>(sizeof code), &code, sizeof code);
      }
    }
  }

  void encode_weights(const ConstPlaneRow& row, std::int64_t count, std::uint8_t* out) const {
    const auto ranked = static_cast<std::size_t>(counting_.ranked);
    std::array<float, kMostRankedClasses> shares{};
    std::array<int, kMostRankedClasses> codes{};
    for (std::int64_t i = 0; i < count; ++i, out += ranked) {
      for (std::size_t rank = 0; rank < ranked; ++rank)
        shares[rank] = row[static_cast<std::size_t>(share_plane(static_cast<int>(rank)))][i];
      if (shares[0] == 0.0F || shares[0] == 1.0F) {
        codes = {shares[0] == 1.0F ? 255 : 0, 0, 0, 0};
      } else {
        quantise_shares(shares, counting_.ranked, codes);
      }
      for (std::size_t rank = 0; rank < ranked; ++rank) out[rank] = static_cast<std::uint8_t>(codes[rank]);
    }
  }

  SampleLayout layout_;
  ClassCounting counting_;
  SampleKind codes_;  // of the classes
};

Result<int> choose_no_data(const ChannelSettings& settings, int greatest) {
  VT_ASSIGN(const std::optional<double> chosen, number_of(settings.options, "no-data-class", 0.0, greatest));
  if (chosen && *chosen != std::floor(*chosen))
    return fail(ErrorCode::kUsage, "option no-data-class: " + settings.options.at("no-data-class") + " is no whole number");
  if (chosen) return static_cast<int>(*chosen);
  const double declared = settings.source_nodata;
  return declared >= 0.0 && declared <= greatest && declared == std::floor(declared) ? static_cast<int>(declared) : greatest;
}

constexpr std::array kFormats{TexelFormat::kR8, TexelFormat::kR16};

std::string_view why_not_format(TexelFormat format, const Options&) {
  const bool is_block = format_info(format).samples == SampleKind::kBlock;
  return is_block ? ": a decoded block holds numbers between its classes, which are other classes" : "";
}

MadeCodec make_material(const ChannelSettings& settings, const SampleLayout& layout) {
  if (layout.value_bands != 1)
    return fail(ErrorCode::kUnsupported,
                "material needs exactly one band, found " + std::to_string(layout.value_bands) + "; choose with `bands`");

  constexpr std::array<std::string_view, 5> kMixtures{"", "1", "2", "3", "4"};
  VT_ASSIGN(const std::string mixture, choice_of(settings.options, "mixture", "", std::span(kMixtures)));
  const SampleKind codes = format_info(settings.format).samples;
  ClassCounting counting;
  counting.ranked = mixture.empty() ? 1 : std::stoi(mixture);
  counting.greatest = static_cast<int>(std::min<std::int64_t>(greatest_code(codes), kGreatestClass));
  if (!find_format_of_channels(settings.format, counting.ranked))
    return fail(ErrorCode::kUnsupported,
                "a mixture of " + mixture + " classes cannot be stored with " + std::to_string(8 * vt::sample_bytes(codes)) +
                    " bits each; " + (find_format_of_channels(settings.format, 4) ? "use mixture 4, or " : "") + "store the layer as r8");
  VT_ASSIGN(counting.no_data, choose_no_data(settings, counting.greatest));
  Json table;
  if (const auto text = settings.options.find("classes"); text != settings.options.end()) {
    VT_ASSIGN(const std::string checked, checked_class_table(text->second, counting));
    table = text::json_or_null(checked);
  }
  return std::make_unique<const MaterialCodec>(layout, settings.format, counting, !mixture.empty(), table);
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"classes", "FILE", "JSON table of the classes, [{\"id\": 1, \"name\": \"water\", \"color\": \"#265480\"}, ...]", true},
    {"mixture", "1|2|3|4",
     "also store how much of each texel its most frequent classes hold, as NAME/classes and NAME/weights (default: the majority alone)"},
    {"no-data-class", "NUMBER",
     "what is stored where there are no data (default: the first source's no-data value, or the greatest number of the format)"},
});

}  // namespace

constinit const ChannelKind kMaterialKind{
    .type = ChannelType::kMaterial,
    .name = "material",
    .options = kOptions,
    .has_one_value = true,
    .why_only_box = "classes are counted, and a count has no negative share",
    .counted = [](const Options&) { return std::string_view("material layers"); },
    .formats = always_formats<kFormats>,
    .why_not_format = why_not_format,
    .usual_format = [](SampleType samples, bool) { return sample_bytes(samples) > 1 ? TexelFormat::kR16 : TexelFormat::kR8; },
    .shown = Shown::kClasses,
    .absent = Absent::kClass,
    .make = make_material,
};

}  // namespace vt::channels
