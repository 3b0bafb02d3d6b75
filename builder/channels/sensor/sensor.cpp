// What a sensor sees in its band. Radiance adds up, so it is what averages: temperatures become in-band
// radiance of a black body (planck.h) sample by sample, and only what is stored may be turned back into
// kelvin. Reflectance and emissivity average as they are: each is a ratio of radiances, and what it is a
// ratio to (the light that falls on the place, a black body's radiance there) is common to the samples of one
// texel, so the mean ratio gives the mean radiance. Planes: value times weight; where samples are wide what
// its floats miss (wide_value.h); weight (1 data, 0 none). The mean is over samples that exist; a temperature
// of 0 K and less, and what is not finite, is none. Values beyond what a format holds become its ends, which
// is counted.

#include "builder/channels/sensor/sensor.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/samples/nodata.h"
#include "builder/channels/samples/read_samples.h"
#include "builder/channels/samples/wide_value.h"
#include "builder/channels/sensor/sensor_quantity.h"
#include "builder/channels/sensor/thermal_codec.h"
#include "builder/channels/shared/finite_rows.h"
#include "builder/channels/shared/neighbours.h"
#include "builder/channels/shared/number_code.h"
#include "builder/channels/shared/radiance_unit.h"
#include "builder/channels/shared/unblocked_format.h"
#include "builder/text/number_text.h"

namespace vt::channels {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class SensorCodec final : public ChannelCodec {
 public:
  SensorCodec(const SampleLayout& layout, SensorQuantity quantity, TexelFormat format, bool is_wide)
      : layout_(weighed_by_coverage(layout)),
        nodata_(nodata_range(layout)),
        quantity_(std::move(quantity)),
        number_(format, quantity_.span.value_or(std::array<double, 2>{}), format == TexelFormat::kR16),
        is_float_(format == TexelFormat::kR32Float),
        has_nodata_(format != TexelFormat::kBc4),
        is_wide_(is_wide) {
    rules_ = {PlaneRule::kLinear, PlaneRule::kLinear};
    if (is_wide) {
      rules_.insert(rules_.begin() + kRemainder, PlaneRule::kRemainder);
      rules_version_ = 2;  // values were floats before they were means
    }
    source_planes_ = static_cast<int>(rules_.size());
    weight_ = rules_.size() - 1;
    const std::string stored(stored_name(quantity_));
    parts_.push_back({.format = format,
                      .texel_format = unblocked_format(format),
                      .components = {stored},
                      .unit = quantity_.unit,
                      .ranges = {number_.range()},
                      .zero_is_nodata = format == TexelFormat::kR16,
                      .metadata_json = quantity_.metadata_json});
    measures_ = {{.name = stored, .unit = quantity_.unit}, {.name = "clipped " + stored, .unit = quantity_.unit}};
    measures_equivalent_ = quantity_.band != nullptr && !quantity_.stores_temperature;
    if (measures_equivalent_) measures_.push_back({.name = "equivalent temperature", .unit = "K"});
    keeps_numbers_ = quantity_.scale == 1.0 && quantity_.offset == 0.0;
    make_table();
    describe_losses(format);
  }

  bool decode_values(const std::byte* samples, std::int64_t count, const PlaneRow& out) const override {
    switch (layout_.type) {
      case SampleType::kUint8:
      case SampleType::kInt8:
        return decode_codes<std::uint8_t>(samples, count, out);
      case SampleType::kUint16:
      case SampleType::kInt16:
        return decode_codes<std::uint16_t>(samples, count, out);
      case SampleType::kUint32:
      case SampleType::kInt32:
      case SampleType::kFloat32:
      case SampleType::kFloat64:
        break;
    }
    return decode_numbers(samples, count, out);
  }

  Result<void> encode_row(std::size_t, const RowNeighbourhood& rows, std::int64_t count, std::byte* out) const override {
    const float* value = rows.here[0];
    const float* weight = rows.here[weight_];
    // Sums of huge samples overflow; what is left has no mean.
    if (!all_finite(value, count)) return overflow();
    if (rows.opaque && is_float_ && !is_wide_ && !quantity_.stores_temperature) {
      std::memcpy(out, value, static_cast<std::size_t>(count) * sizeof(float));
      return {};
    }
    for (std::int64_t i = 0; i < count; ++i, out += number_.bytes()) {
      const double wanted = weight[i] > 0.0F ? stored_value(mean_at(rows.here, i)) : kNaN;
      if (std::isfinite(wanted))
        number_.write(wanted, out);
      else if (has_nodata_)
        number_.write_nodata(out);
      else
        write_neighbours(rows, i, out);
    }
    return {};
  }

  void mark_outside(std::size_t, std::byte* texels, std::int64_t count) const override {
    if (!has_nodata_) return;  // blocks have nothing but the neighbour's value to show there
    for (std::int64_t i = 0; i < count; ++i, texels += number_.bytes()) number_.write_nodata(texels);
  }

  void add_errors(std::size_t, const ConstPlaneRow& reference, const float* stored, std::int64_t count,
                  std::span<ErrorSum> errors) const override {
    for (std::int64_t i = 0; i < count; ++i) {
      if (!(reference[weight_][i] > 0.0F)) continue;
      const double mean = mean_at(reference, i);
      const double wanted = stored_value(mean);
      if (!std::isfinite(wanted)) continue;
      const double is = number_.range().offset + number_.range().scale * static_cast<double>(stored[i]);
      errors[0].add(is - wanted);
      errors[1].add(std::max({0.0, wanted - number_.greatest(), number_.least() - wanted}));
      errors[0].add_total(mean, averaged_of_stored(is, mean, wanted));
      if (!measures_equivalent_ || mean <= 0.0) continue;
      // As much as the radiance's error would be of temperature; there is none where no temperature has such
      // a radiance.
      const double kelvins = is == mean ? 0.0 : quantity_.band->temperature(std::max(is, mean * 1e-6)) - quantity_.band->temperature(mean);
      if (std::isfinite(kelvins)) errors[2].add(kelvins);
    }
  }

  void count_losses(const ConstPlaneRow& row, bool, std::int64_t count, std::int64_t x, std::int64_t y,
                    std::span<LossCount> counts) const override {
    for (std::int64_t i = 0; i < count; ++i) {
      const bool has_data = row[weight_][i] > 0.0F;
      if (!has_data) {
        if (void_loss_) counts[*void_loss_].add(x + i, y);
        continue;
      }
      const double mean = mean_at(row, i);
      const bool is_temperature = !quantity_.stores_temperature || (mean > 0.0 && mean <= most_radiance_);
      if (temperature_loss_ && !is_temperature) counts[*temperature_loss_].add(x + i, y);
      if (end_loss_ && is_temperature && (mean < least_mean_ || mean > greatest_mean_)) counts[*end_loss_].add(x + i, y);
    }
  }

 private:
  static constexpr std::size_t kRemainder = 1;  // the plane beside the values, when they are wide
  static constexpr double kHottest = 1e7;       // K: BandRadiance::temperature() knows no more

  // The texel's weight is not 0.
  [[nodiscard]] double mean_at(const ConstPlaneRow& row, std::int64_t i) const {
    const double weight = row[weight_][i];
    const double sum = is_wide_ ? static_cast<double>(row[0][i]) + static_cast<double>(row[kRemainder][i]) : static_cast<double>(row[0][i]);
    return weight == 1.0 ? sum : sum / weight;
  }

  [[nodiscard]] Result<void> overflow() const {
    return fail(ErrorCode::kInvalidData,
                "the mean " + std::string(quantity_.kind == SensorQuantity::Kind::kTemperature ? "radiance" : stored_name(quantity_)) +
                    " is that of samples too large to add; if they are none, say with `nodata` which sample value means no data");
  }

  // What texels of the finest level may lose, and from which means on.
  void describe_losses(TexelFormat format) {
    const std::string name(format_info(format).name);
    const std::string unit = quantity_.unit.empty() ? "" : " " + quantity_.unit;
    const auto add = [&](std::string what) {
      losses_.push_back({std::move(what)});
      return losses_.size() - 1;
    };
    if (quantity_.stores_temperature) {
      temperature_loss_ = add("the radiance is none that a temperature has, and what is stored is no data");
      most_radiance_ = quantity_.band->radiance(kHottest);
    }
    if (!has_nodata_)
      void_loss_ = add("there are no data, which " + name + " cannot say: it shows the neighbours' mean, or " +
                       text::number_text(number_.least()) + unit + " where they have none; to keep them apart use r16");
    if (is_float_) return;
    const bool is_half = format == TexelFormat::kR16Float;
    // What rounds to the end lies on it.
    const double margin = is_half ? 15.9 : 0.5 * number_.range().scale;
    const std::string ends = text::number_text(number_.least()) + " to " + text::number_text(number_.greatest()) + unit;
    end_loss_ = add("the value lies outside " + ends + (is_half ? ", what r16f holds," : ", what `span` gives " + name + ",") +
                    " and the nearer end is stored; " + (is_half ? "use r32f" : "give a wider `span`, or use r32f"));
    const auto mean_of_stored = [&](double stored) {
      return !quantity_.stores_temperature ? stored : stored > 0.0 ? quantity_.band->radiance(stored) : 0.0;
    };
    least_mean_ = mean_of_stored(number_.least() - margin);
    greatest_mean_ = mean_of_stored(number_.greatest() + margin);
  }

  // What is averaged, of what is stored in place of `wanted`, which stands for `mean`.
  [[nodiscard]] double averaged_of_stored(double is, double mean, double wanted) const {
    if (!quantity_.stores_temperature) return is;
    return is == wanted ? mean : is > 0.0 ? quantity_.band->radiance(is) : 0.0;
  }

  // What is stored, of what is averaged. NaN: no temperature has such a radiance.
  [[nodiscard]] double stored_value(double mean) const { return quantity_.stores_temperature ? quantity_.band->temperature(mean) : mean; }

  // What is averaged, of a sample. NaN when it is no data.
  [[nodiscard]] double averaged_value(double sample) const {
    if (!std::isfinite(sample) || nodata_.contains(sample)) return kNaN;
    const double value = quantity_.offset + quantity_.scale * sample;
    const double averaged = quantity_.kind == SensorQuantity::Kind::kTemperature ? quantity_.band->radiance(value) : value;
    return std::isfinite(static_cast<float>(averaged)) ? averaged : kNaN;
  }

  // For each sample of 8 or 16 bits, by its bits as an unsigned number.
  void make_table() {
    const std::size_t bytes = sample_bytes(layout_.type);
    if (bytes > 2) return;
    value_of_code_.resize(std::size_t{1} << (8 * bytes));
    for (std::size_t code = 0; code < value_of_code_.size(); ++code) {
      std::array<std::byte, sizeof(double)> sample{};  // as long as read_sample() can want it
      sample[0] = static_cast<std::byte>(code & 0xFFU);
      sample[1] = static_cast<std::byte>(code >> 8U);
      value_of_code_[code] = static_cast<float>(averaged_value(read_sample(layout_.type, sample.data())));
    }
  }

  template <class T>
  bool decode_codes(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i) {
      T code;
      std::memcpy(&code, samples + i * static_cast<std::int64_t>(sizeof code), sizeof code);
      opaque = set(static_cast<double>(value_of_code_[code]), i, out) && opaque;
    }
    return opaque;
  }

  bool decode_numbers(const std::byte* samples, std::int64_t count, const PlaneRow& out) const {
    const std::size_t bytes = sample_bytes(layout_.type);
    bool opaque = true;
    for (std::int64_t i = 0; i < count; ++i, samples += bytes)
      opaque = set(averaged_value(read_sample(layout_.type, samples)), i, out) && opaque;
    return opaque;
  }

  bool set(double value, std::int64_t i, const PlaneRow& out) const {
    const bool is_data = !std::isnan(value);
    const auto nearest = static_cast<float>(value);
    out[0][i] = is_data ? nearest : 0.0F;
    if (is_wide_) out[kRemainder][i] = is_data ? remainder_of(value, nearest) : 0.0F;
    out[weight_][i] = is_data ? 1.0F : 0.0F;
    return is_data;
  }

  // What a texel without data holds in a format that cannot say so: the neighbours' mean, or the least that
  // there is.
  void write_neighbours(const RowNeighbourhood& rows, std::int64_t i, std::byte* out) const {
    const auto [sum, weight] = sum_around<double>(rows, std::array<std::size_t, 2>{0, weight_}, i);
    const double value = weight > 0.0 ? stored_value(sum / weight) : number_.least();
    number_.write(std::isfinite(value) ? value : number_.least(), out);
  }

  SampleLayout layout_;
  NodataRange nodata_;
  SensorQuantity quantity_;
  NumberCode number_;
  bool is_float_;
  bool has_nodata_;
  bool is_wide_;
  std::size_t weight_ = 1;  // the plane
  // Among losses(), where there are such.
  std::optional<std::size_t> temperature_loss_;
  std::optional<std::size_t> void_loss_;
  std::optional<std::size_t> end_loss_;
  double most_radiance_ = kInfinity;
  double least_mean_ = -kInfinity;
  double greatest_mean_ = kInfinity;
  bool measures_equivalent_ = false;
  std::vector<float> value_of_code_;
};

// A thermal basis has several numbers in a texel, or each of them in a layer of its own.
constexpr std::array kFormats{TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16, TexelFormat::kBc4};
constexpr std::array kThermalFormats{TexelFormat::kRgba16,   TexelFormat::kRgba16Float, TexelFormat::kRgba32Float, TexelFormat::kR16,
                                     TexelFormat::kR16Float, TexelFormat::kR32Float,    TexelFormat::kBc4};

std::span<const TexelFormat> formats(const Options& options) {
  return options.contains("basis") ? std::span<const TexelFormat>(kThermalFormats) : std::span<const TexelFormat>(kFormats);
}

bool needs_span(TexelFormat format) { return format == TexelFormat::kR16 || format == TexelFormat::kBc4; }

MadeCodec make_sensor(const ChannelSettings& settings, const SampleLayout& layout) {
  if (layout.value_bands != 1)
    return fail(ErrorCode::kUnsupported,
                "a sensor layer is of one band, found " + std::to_string(layout.value_bands) + "; choose with `bands`");
  if (layout.range)
    return fail(ErrorCode::kUnsupported,
                "a sensor layer has no black and white to be given as a range; say what samples are worth with "
                "`input-scale` and `input-offset`");
  if (settings.options.contains("basis")) return make_thermal_codec(settings, layout);
  if (settings.options.contains("components"))
    return fail(ErrorCode::kUsage, "option components: it is the number of curves of a thermal library; name that with `basis` FILE");
  VT_ASSIGN(SensorQuantity quantity, sensor_quantity(settings.options, layout));
  if (needs_span(settings.format) && !quantity.span)
    return fail(ErrorCode::kUsage, std::string("codes of ") + std::string(format_info(settings.format).name) +
                                       " need to know what they span; give `span` LOW,HIGH in " +
                                       (quantity.unit.empty() ? "the unit of what is stored" : quantity.unit) + ", or use r32f");
  return std::make_unique<const SensorCodec>(layout, std::move(quantity), settings.format, settings.samples_are_wide);
}

constexpr auto kOptions = std::to_array<OptionInfo>({
    {"quantity", "radiance|reflectance|emissivity|temperature", "what the input is (default: radiance)"},
    {"band", "LOW,HIGH", "edges of the sensor's band in micrometres"},
    {"response", "FILE", "the sensor's relative response over wavelength, CSV or JSON; a band cuts it", true},
    {"store", "radiance|temperature", "what is stored of a thermal input; temperatures are those of the mean radiance (default: radiance)"},
    {"input-scale", "FACTOR", "value = offset + scale * sample, in `input-unit` (default: what the file declares for the band, else 1)"},
    {"input-offset", "VALUE", "value of the sample 0, see `input-scale` (default: what the file declares, else 0)"},
    {"input-unit", "TEXT",
     "unit of the input's values: K, C or F of temperatures, 1 or % of ratios, W/(m2 sr) of radiance in a band (default: what the file "
     "declares)"},
    {"span", "LOW,HIGH", "the values that the codes of r16 and bc4 reach from and to (default: 0,1 for ratios)"},
    {"unit", "TEXT", "unit of radiance that is given without a band (default: W/(m2 sr))"},
    {"basis", "FILE", "thermal curves of the input's classes over a day, JSON; what is stored is their common curves' coefficients", true},
    {"components", "3..5", "how many coefficients (default: 4)"},
});

}  // namespace

constinit const ChannelKind kSensorKind{
    .type = ChannelType::kSensor,
    .name = "sensor",
    .unit = kRadianceUnit,
    .options = kOptions,
    .has_one_value = true,
    .uses_declared_scale = true,
    .why_only_box = "radiance has to be conserved and cannot be negative",
    .counted =
        [](const Options& options) { return std::string_view(options.contains("basis") ? "sensor layers with a thermal basis" : ""); },
    .formats = formats,
    .why_not_format = [](TexelFormat,
                         const Options& options) { return std::string_view(options.contains("basis") ? "" : ", which is for colours"); },
    .usual_format = [](SampleType, bool) { return TexelFormat::kR32Float; },
    .make = make_sensor,
};

}  // namespace vt::channels
