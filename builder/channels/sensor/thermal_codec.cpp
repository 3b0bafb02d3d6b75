// A raster of classes becomes the coefficients of their thermal curves (thermal_basis.h), which average like
// radiance: filtering what is stored is storing what was filtered, but for quantisation. Planes: each
// coefficient times weight, weight. A class that the library does not have is no data, for nothing is known
// of it. Formats of four channels hold the first four coefficients (of three, and coverage), a fifth lies
// beside them; formats of one channel hold one each. Codes reach exactly over what mixtures of the library
// can be.

#include "builder/channels/sensor/thermal_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/sensor/spectral_response.h"
#include "builder/channels/sensor/thermal_basis.h"
#include "builder/channels/shared/format_of_channels.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/number_code.h"
#include "builder/channels/shared/unblocked_format.h"

namespace vt::channels {
namespace {

constexpr std::uint16_t kNoClass = 0xFFFF;
constexpr std::size_t kMostComponents = 5;

struct Thermal {
  ThermalLibrary library;
  ThermalBasis basis;
  std::shared_ptr<const BandRadiance> band;  // may be none
  std::string metadata_json;
};

// What mixtures reach: nothing else can be a weighted mean of the classes.
std::array<double, 2> span_of(const ThermalBasis& basis, std::size_t component) {
  std::array<double, 2> span{basis.coefficients[0][component], basis.coefficients[0][component]};
  for (const std::vector<double>& c : basis.coefficients) {
    span[0] = std::min(span[0], c[component]);
    span[1] = std::max(span[1], c[component]);
  }
  // A library of one class: any width will do.
  return span[1] - span[0] > 1e-9 ? span : std::array<double, 2>{span[0], span[0] + 1.0};
}

// Temperatures of radiances around those of a library, many times faster than BandRadiance: linear between
// 1024 places an octave, so that a small difference of temperatures is right to 0.1 %. Beyond two octaves
// from the library, BandRadiance's own.
class Thermometer {
 public:
  Thermometer() = default;
  Thermometer(std::shared_ptr<const BandRadiance> band, const ThermalLibrary& library) : band_(std::move(band)) {
    double least = library.classes.front().radiance.front();
    double greatest = least;
    for (const ThermalClass& one : library.classes)
      for (const double radiance : one.radiance) {
        least = std::min(least, radiance);
        greatest = std::max(greatest, radiance);
      }
    // Where BandRadiance has to search a temperature is slow. Thirty octaves below the hottest class nothing
    // matters.
    const double last = std::min(4.0 * greatest, band_->radiance(BandRadiance::kHighest));
    first_ = place(std::max({0.25 * least, band_->radiance(BandRadiance::kLowest), last * 0x1p-30})) + 1;
    for (std::uint64_t at = first_; at < place(last); ++at) kelvins_.push_back(band_->temperature(std::bit_cast<double>(at << kShift)));
  }

  // `radiance` > 0.
  [[nodiscard]] double temperature(double radiance) const {
    const std::uint64_t at = place(radiance) - first_;  // wraps to a large number below the first
    if (at + 1 >= kelvins_.size()) return band_->temperature(radiance);
    constexpr std::uint64_t kFraction = (std::uint64_t{1} << kShift) - 1;
    const double share = static_cast<double>(std::bit_cast<std::uint64_t>(radiance) & kFraction) * kPerFraction;
    return kelvins_[at] + share * (kelvins_[at + 1] - kelvins_[at]);
  }

 private:
  static constexpr int kShift = 52 - 10;
  static constexpr double kPerFraction = 1.0 / static_cast<double>(std::uint64_t{1} << kShift);
  // Positive doubles are in the order of their bits: exponent and the first ten bits of the fraction.
  static std::uint64_t place(double radiance) { return std::bit_cast<std::uint64_t>(radiance) >> kShift; }

  std::shared_ptr<const BandRadiance> band_;
  std::uint64_t first_ = 0;
  std::vector<double> kelvins_;
};

class ThermalCodec final : public ChannelCodec {
 public:
  ThermalCodec(const SampleLayout& layout, Thermal thermal, TexelFormat format)
      : layout_(weighed_by_coverage(layout)), nodata_(nodata_range(layout)), thermal_(std::move(thermal)) {
    components_ = thermal_.basis.curves.size();
    source_planes_ = static_cast<int>(components_) + 1;
    rules_.assign(components_ + 1, PlaneRule::kLinear);
    has_nodata_ = format != TexelFormat::kBc4;
    const std::size_t channels = format_info(format).channels;
    for (std::size_t first = 0; first < components_; first += channels)
      add_part(first == 0 ? format : format_of_channels(format, 1), first);
    if (!has_nodata_)
      losses_.push_back({"there are no data, which bc4 cannot say: it shows the neighbours' mean; to keep them apart use r16"});
    prepare_errors();
    make_table();
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    const std::size_t bytes = sample_bytes(layout_.type);
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i, samples += bytes) {
      const std::uint16_t row = bytes == 1   ? class_of_code_[std::to_integer<std::size_t>(*samples)]
                                : bytes == 2 ? class_of_code_[read_code(samples)]
                                             : class_of(read_sample(layout_.type, samples));
      const bool is_data = row != kNoClass;
      for (std::size_t k = 0; k < components_; ++k) out[k][i] = is_data ? values_[row * components_ + k] : 0.0F;
      out[components_][i] = is_data ? 1.0F : 0.0F;
      opaque = opaque && is_data;
    }
    return opaque;
  }

  Result<void> encode_row(std::size_t part, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    const PartCodes& codes = codes_[part];
    const float* weight = rows.here[components_];
    for (std::int64_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < codes.numbers.size(); ++c, out += codes.numbers.front().bytes()) {
        const NumberCode& number = codes.numbers[c];
        const std::size_t plane = codes.first + c;
        if (plane >= components_)
          number.write(weight[i], out);  // coverage
        else if (weight[i] > 0.0F)
          number.write(static_cast<double>(rows.here[plane][i]) / weight[i], out);
        else if (has_nodata_)
          number.write_nodata(out);
        else
          number.write(mean_around(rows, plane, i), out);
      }
    return {};
  }

  void mark_outside(std::size_t part, std::byte* texels, std::int64_t count) const override {
    if (!has_nodata_) return;  // blocks have nothing but the neighbour's value to show there
    const PartCodes& codes = codes_[part];
    for (std::int64_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < codes.numbers.size(); ++c, texels += codes.numbers.front().bytes()) {
        if (codes.first + c >= components_)
          codes.numbers[c].write(0.0, texels);
        else
          codes.numbers[c].write_nodata(texels);
      }
  }

  // The root mean square over the library's hours of what the part's quantisation does to the temperature
  // (with a band) or the radiance.
  void add_errors(std::size_t part, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    const PartCodes& codes = codes_[part];
    const std::size_t used = std::min(codes.numbers.size(), components_ - codes.first);
    const std::size_t hours = thermal_.basis.hours.size();
    std::array<double, kMostComponents> wanted{};
    std::array<double, kMostComponents> off{};
    for (std::int64_t i = 0; i < count; ++i, stored += codes.numbers.size()) {
      const float weight = reference[components_][i];
      if (!(weight > 0.0F)) continue;
      for (std::size_t k = 0; k < components_; ++k) wanted[k] = static_cast<double>(reference[k][i]) / weight;
      for (std::size_t c = 0; c < used; ++c) {
        const ComponentRange& range = codes.numbers[c].range();
        off[c] = range.offset + range.scale * static_cast<double>(stored[c]) - wanted[codes.first + c];
      }
      double squares = 0.0;
      double total = 0.0;
      double difference = 0.0;
      for (std::size_t t = 0; t < hours; ++t) {
        double radiance = thermal_.basis.mean[t];
        for (std::size_t k = 0; k < components_; ++k) radiance += wanted[k] * thermal_.basis.curves[k][t];
        double change = 0.0;
        for (std::size_t c = 0; c < used; ++c) change += off[c] * thermal_.basis.curves[codes.first + c][t];
        total += radiance;
        difference += change;
        const double error = change == 0.0 ? 0.0 : error_at(t, radiance, change);
        squares += error * error;
      }
      errors[part].add(std::sqrt(squares / static_cast<double>(hours)));
      errors[part].add_total(total, total + difference);
    }
  }

  void count_losses(const ConstPlaneRow& row, bool opaque, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    if (opaque || losses_.empty()) return;
    for (std::int64_t i = 0; i < count; ++i)
      if (!(row[components_][i] > 0.0F)) counts[0].add(x + i, y);
  }

 private:
  // How one part is stored: its first coefficient, and how each of its texel's numbers is written.
  struct PartCodes {
    std::size_t first = 0;
    std::vector<NumberCode> numbers;
  };

  void add_part(TexelFormat format, std::size_t first) {
    const FormatInfo& info = format_info(format);
    const bool zero_is_nodata = info.samples == SampleKind::kUnorm16;
    Part part{.suffix = first == 0 ? "" : "c" + std::to_string(first + 1), .format = format, .texel_format = unblocked_format(format)};
    part.zero_is_nodata = zero_is_nodata;
    part.metadata_json = thermal_.metadata_json;
    PartCodes codes{.first = first};
    for (std::size_t c = 0; c < info.channels; ++c) {
      const std::size_t k = first + c;
      const bool is_coefficient = k < components_;
      part.components.push_back(is_coefficient ? "c" + std::to_string(k + 1) : "coverage");
      codes.numbers.emplace_back(format, is_coefficient ? span_of(thermal_.basis, k) : std::array<double, 2>{0.0, 1.0},
                                 zero_is_nodata && c == 0);
      part.ranges[c] = codes.numbers.back().range();
    }
    const bool in_kelvins = thermal_.band != nullptr;
    measures_.push_back({.name = std::string(in_kelvins ? "temperature" : "radiance") + " by quantisation of " + part.components.front() +
                                 (info.channels > 1 ? " and on" : ""),
                         .unit = in_kelvins ? "K" : "W/(m2 sr)"});
    parts_.push_back(std::move(part));
    codes_.push_back(std::move(codes));
  }

  // What a change of the radiance at an hour of the library does to the temperature, or the change itself
  // without a band. A radiance of less than nothing has no temperature: a basis of few components may come to
  // it, and there the slope at the mean curve has to do; what is stored counts as a millionth of what should
  // be.
  [[nodiscard]] double error_at(std::size_t hour, double radiance, double change) const {
    if (!thermal_.band) return change;
    if (!(radiance > 0.0)) return change * kelvins_of_mean_[hour];
    return thermometer_.temperature(std::max(radiance + change, 1e-6 * radiance)) - thermometer_.temperature(radiance);
  }

  void prepare_errors() {
    if (!thermal_.band) return;
    thermometer_ = Thermometer(thermal_.band, thermal_.library);
    for (const double radiance : thermal_.basis.mean) kelvins_of_mean_.push_back(kelvins_per_radiance(thermal_.band.get(), radiance));
  }

  void make_table() {
    for (const std::vector<double>& c : thermal_.basis.coefficients)
      for (const double value : c) values_.push_back(static_cast<float>(value));
    const std::size_t bytes = sample_bytes(layout_.type);
    if (bytes > 2) return;
    class_of_code_.resize(std::size_t{1} << (8 * bytes));
    for (std::size_t code = 0; code < class_of_code_.size(); ++code) {
      std::array<std::byte, sizeof(double)> sample{};  // as long as read_sample() can want it
      sample[0] = static_cast<std::byte>(code & 0xFFU);
      sample[1] = static_cast<std::byte>(code >> 8U);
      class_of_code_[code] = class_of(read_sample(layout_.type, sample.data()));
    }
  }

  // The row of the library, or kNoClass.
  [[nodiscard]] std::uint16_t class_of(double id) const {
    if (!std::isfinite(id) || nodata_.contains(id)) return kNoClass;
    const std::vector<ThermalClass>& classes = thermal_.library.classes;
    const auto found = std::lower_bound(classes.begin(), classes.end(), id,
                                        [](const ThermalClass& one, double wanted) { return static_cast<double>(one.id) < wanted; });
    return found != classes.end() && static_cast<double>(found->id) == id ? static_cast<std::uint16_t>(found - classes.begin()) : kNoClass;
  }

  static std::uint16_t read_code(const std::byte* sample) {
    std::uint16_t code;
    std::memcpy(&code, sample, sizeof code);
    return code;
  }

  // What a texel without data holds in a format that cannot say so: the neighbours' mean, or that of the
  // library.
  [[nodiscard]] double mean_around(const RowNeighbourhood& rows, std::size_t plane, std::int64_t i) const {
    const auto [sum, weight] = sum_around<double>(rows, std::array{plane, components_}, i);
    return weight > 0.0 ? sum / weight : 0.0;
  }

  SampleLayout layout_;
  NodataRange nodata_;
  Thermal thermal_;
  std::size_t components_ = 0;
  bool has_nodata_ = true;
  std::vector<PartCodes> codes_;
  std::vector<float> values_;                 // of the library's classes, the coefficients of each
  std::vector<std::uint16_t> class_of_code_;  // for each sample of 8 or 16 bits, by its bits as an unsigned number
  Thermometer thermometer_;                   // with a band
  std::vector<double> kelvins_of_mean_;       // likewise: of one more W/(m2 sr) beside the mean curve, at every hour
};

std::string metadata_of(const Thermal& thermal, const std::vector<ResponsePoint>& response) {
  const BasisError error = basis_error(thermal.library, thermal.basis, thermal.band.get());
  nlohmann::ordered_json metadata;
  metadata["quantity"] = "thermal basis";
  if (!response.empty()) metadata["band_um"] = {response.front().wavelength_um, response.back().wavelength_um};
  metadata["basis"]["hours"] = thermal.basis.hours;
  metadata["basis"]["mean"] = thermal.basis.mean;
  metadata["basis"]["curves"] = thermal.basis.curves;
  metadata["basis"]["unit"] = "W/(m2 sr)";
  metadata["basis"]["error"] = {{"unit", thermal.band ? "K" : "W/(m2 sr)"}, {"rms", error.root_mean_square}, {"max", error.largest}};
  return metadata.dump();
}

Result<void> check_fit(const ChannelSettings& settings) {
  for (const char* name : {"quantity", "store", "input-scale", "input-offset", "input-unit", "span", "unit"})
    if (settings.options.contains(name))
      return fail(ErrorCode::kUsage,
                  std::string("option ") + name + " has no meaning with a basis: input is classes, and the library says the rest");
  return {};
}

}  // namespace

MadeCodec make_thermal_codec(const ChannelSettings& settings, const SampleLayout& layout) {
  VT_CHECK(check_fit(settings));
  VT_ASSIGN(const auto components, number_of(settings.options, "components", 3, 5));
  VT_ASSIGN(const std::vector<ResponsePoint> response, response_of(settings.options));
  Thermal thermal;
  if (!response.empty()) thermal.band = std::make_shared<const BandRadiance>(response);
  VT_ASSIGN(thermal.library, parse_thermal_library(settings.options.at("basis"), thermal.band.get()));
  const auto count = static_cast<int>(components.value_or(4.0));
  if (components && *components != count)
    return fail(ErrorCode::kUsage, "option components: " + settings.options.at("components") + " is not whole");
  if (thermal.library.hours.size() < static_cast<std::size_t>(count))
    return fail(ErrorCode::kUsage, "thermal library: " + std::to_string(thermal.library.hours.size()) + " hours are fewer than the " +
                                       std::to_string(count) + " components that are wanted");
  thermal.basis = make_thermal_basis(thermal.library, count, thermal.band.get());
  thermal.metadata_json = metadata_of(thermal, response);
  return std::make_unique<const ThermalCodec>(layout, std::move(thermal), settings.format);
}

}  // namespace vt::channels
