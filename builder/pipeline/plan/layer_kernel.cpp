#include "builder/pipeline/plan/layer_kernel.h"

#include <string>

#include "builder/channels/all_channels.h"
#include "builder/text/names_text.h"

namespace vt::pipeline {
Result<pyramid::HalvingKernel> choose_kernel(const LayerRequest& request) {
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  const std::string channel = channels::channel_name(request.channel);
  const std::string name = !request.kernel.empty() ? request.kernel : std::string(kind.usual_kernel);
  auto kernel = pyramid::kernel_from_name(name);
  if (!kernel)
    return fail(ErrorCode::kUsage,
                "unknown kernel '" + name + "'; known are " + text::names_text(pyramid::all_kernels(), &pyramid::HalvingKernel::name));
  if (kernel->is_point && !kind.may_be_picked)
    return fail(ErrorCode::kUsage,
                "kernel point takes one texel of four, which is for heights that displace a surface; " + channel + " layers would alias");
  if (!kernel->is_point && !kind.why_only_box.empty() && name != pyramid::box_kernel().name)
    return fail(ErrorCode::kUsage,
                "kernel " + name + " does not suit " + channel + " layers: " + std::string(kind.why_only_box) + "; they use box");
  if (kind.find_option("anti-ringing") != nullptr) {
    VT_ASSIGN(const bool limits, channels::flag_of(request.options, "anti-ringing", false));
    kernel->limits_ringing = limits && kernel->has_negative_lobes();
  }
  return *kernel;
}

Result<resample::Method> choose_resampling(const LayerRequest& request) {
  const std::string counted(channels::kind_of(request.channel).counted(request.options));
  const resample::Method preset = counted.empty() ? resample::Method::kBilinear : resample::Method::kNearest;
  const resample::Method method = request.resample.value_or(preset);
  if (!counted.empty() && method != resample::Method::kNearest)
    return fail(ErrorCode::kUsage, counted + " cannot be resampled " + std::string(resample::method_name(method)) +
                                       ": between class 2 and class 4 there is no class 3; they use nearest");
  return method;
}

}  // namespace vt::pipeline
