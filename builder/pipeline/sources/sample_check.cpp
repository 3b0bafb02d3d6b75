#include "builder/pipeline/sources/sample_check.h"

#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/sources/sample_windows.h"

namespace vt::pipeline {

Result<void> check_samples(const LayerRequest& request, std::span<const SourcePlaces> sources) {
  const auto check = channels::kind_of(request.channel).check_samples;
  if (check == nullptr) return {};
  return look_at_windows(sources, [&](const resample::PlacedSource& source, const source::Window& window) -> Result<void> {
    const std::size_t pitch = static_cast<std::size_t>(window.width) * source.layout.texel_bytes();
    std::vector<std::byte> samples(pitch * static_cast<std::size_t>(window.height));
    VT_CHECK(source.read(window, samples, pitch, nullptr));
    const auto checked = check(request.options, source.layout, samples);
    return checked ? checked : fail(checked.error().code, source.raster->info().path.string() + ": " + checked.error().message);
  });
}

}  // namespace vt::pipeline
