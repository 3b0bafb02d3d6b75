// What the samples of a sensor layer are, what they average as, and what is stored, from the layer's options.
// Plain values; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "builder/channels/codec/channel_settings.h"
#include "builder/channels/samples/sample_layout.h"
#include "builder/channels/sensor/planck.h"
#include "store/result.h"

namespace vt::channels {

struct SensorQuantity {
  enum class Kind : std::uint8_t { kRadiance, kReflectance, kEmissivity, kTemperature };

  Kind kind = Kind::kRadiance;
  double scale = 1.0;  // value = offset + scale * sample
  double offset = 0.0;
  bool stores_temperature = false;
  std::string unit;                           // of what is stored
  std::optional<std::array<double, 2>> span;  // of what is stored, least and greatest
  std::string metadata_json = "{}";           // what readers have to know beside that
  std::shared_ptr<const BandRadiance> band;   // where temperature and radiance turn into each other; otherwise none
};

// Scale, offset and unit of the input are the options', else what the file declares in `layout`. kUsage:
// options that do not fit together; the message says how they would. kInvalidData: a table of response that
// is none; a declared unit that is not the quantity's.
[[nodiscard]] Result<SensorQuantity> sensor_quantity(const Options& options, const SampleLayout& layout);

// "radiance", "reflectance", "emissivity" or "temperature".
[[nodiscard]] std::string_view stored_name(const SensorQuantity& quantity);

}  // namespace vt::channels
