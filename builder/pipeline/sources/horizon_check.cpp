#include "builder/pipeline/sources/horizon_check.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "builder/channels/samples/nodata.h"
#include "builder/pipeline/sources/sample_windows.h"
#include "builder/text/number_text.h"

namespace vt::pipeline {
namespace {

// The largest size of a number that is beyond a right angle in radians, and none in degrees; 0: there is none.
template <class T>
double largest_degrees(const channels::SampleLayout& layout, const std::vector<std::byte>& samples) {
  constexpr double kMostRadians = std::numbers::pi / 2.0 * 1.001;
  constexpr double kMostDegrees = 90.001;
  const auto bands = static_cast<std::size_t>(layout.value_bands);
  double largest = 0.0;
  for (std::size_t band = 0; band < bands; ++band) {
    const auto nodata = channels::typed_nodata_range<T>(layout, band);
    for (std::size_t at = band * sizeof(T); at + sizeof(T) <= samples.size(); at += layout.texel_bytes()) {
      T number;
      std::memcpy(&number, samples.data() + at, sizeof number);
      const double size = std::abs(layout.offset.value_or(0.0) + layout.scale.value_or(1.0) * static_cast<double>(number));
      if (size > kMostRadians && size <= kMostDegrees && !nodata.contains(number)) largest = std::max(largest, size);
    }
  }
  return largest;
}

}  // namespace

Result<void> check_horizon_unit(const LayerRequest& request, std::span<const SourcePlaces> sources) {
  if (request.channel != ChannelType::kHorizon || request.options.contains("angles")) return {};
  return look_at_windows(sources, [](const resample::PlacedSource& source, const source::Window& window) -> Result<void> {
    const channels::SampleLayout& layout = source.layout;
    const bool is_float = layout.type == SampleType::kFloat32 || layout.type == SampleType::kFloat64;
    if (!layout.unit.empty() || !is_float) return {};
    const std::size_t pitch = static_cast<std::size_t>(window.width) * layout.texel_bytes();
    std::vector<std::byte> samples(pitch * static_cast<std::size_t>(window.height));
    VT_CHECK(source.read(window, samples, pitch, nullptr));
    const double largest =
        layout.type == SampleType::kFloat32 ? largest_degrees<float>(layout, samples) : largest_degrees<double>(layout, samples);
    if (largest == 0.0) return {};
    return fail(ErrorCode::kInvalidData, source.raster->info().path.string() + ": holds angles up to " + text::number_text(largest) +
                                             ", more than any horizon has in radians; say --angles deg, or --angles rad if what is beyond "
                                             "a right angle means no data");
  });
}

}  // namespace vt::pipeline
