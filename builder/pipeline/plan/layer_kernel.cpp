#include "builder/pipeline/plan/layer_kernel.h"

#include <string>

#include "builder/channels/codec/channel_options.h"

namespace vt::pipeline {
namespace {

// Why a channel takes no kernel but the box. nullptr: it takes any that is a mean.
const char* why_only_box(ChannelType channel) {
  switch (channel) {
    case ChannelType::kColor:
      return nullptr;
    case ChannelType::kNormal:
      return "the mean of unit vectors has a length only if no direction is subtracted";
    case ChannelType::kHorizon:
      return "what is averaged are moments of a distribution of angles, and a negative share of a distribution does not exist";
    case ChannelType::kElevation:
      return "negative lobes would put heights outside the range of the terrain";
    case ChannelType::kMaterial:
      return "classes are counted, and a count has no negative share";
    case ChannelType::kSensor:
      return "radiance has to be conserved and cannot be negative";
    case ChannelType::kIllumination:
      return "light has to be conserved and cannot be negative";
    case ChannelType::kMask:
      return "coverage has to be conserved and cannot be negative";
  }
  return nullptr;
}

std::string kernel_names() {
  std::string names;
  for (const pyramid::HalvingKernel& kernel : pyramid::all_kernels()) names += (names.empty() ? "" : ", ") + std::string(kernel.name);
  return names;
}

}  // namespace

Result<pyramid::HalvingKernel> choose_kernel(const LayerRequest& request) {
  const bool is_color = request.channel == ChannelType::kColor;
  const std::string channel(channel_info(request.channel).name);
  const std::string name = !request.kernel.empty() ? request.kernel : is_color ? "kaiser3" : "box";
  auto kernel = pyramid::kernel_from_name(name);
  if (!kernel) return fail(ErrorCode::kUsage, "unknown kernel '" + name + "'; known are " + kernel_names());
  if (kernel->is_point && request.channel != ChannelType::kElevation)
    return fail(ErrorCode::kUsage,
                "kernel point takes one texel of four, which is for heights that displace a surface; " + channel + " layers would alias");
  const char* reason = why_only_box(request.channel);
  if (!kernel->is_point && reason != nullptr && name != pyramid::box_kernel().name)
    return fail(ErrorCode::kUsage, "kernel " + name + " does not suit " + channel + " layers: " + reason + "; they use box");
  if (is_color) {
    VT_ASSIGN(const bool limits, channels::flag_of(request.options, "anti-ringing", false));
    kernel->limits_ringing = limits && kernel->has_negative_lobes();
  }
  return *kernel;
}

Result<resample::Method> choose_resampling(const LayerRequest& request) {
  const bool is_basis = request.channel == ChannelType::kSensor && request.options.contains("basis");
  const bool is_classes = request.channel == ChannelType::kMaterial || is_basis;
  const resample::Method preset = is_classes ? resample::Method::kNearest : resample::Method::kBilinear;
  const resample::Method method = request.resample.value_or(preset);
  if (is_classes && method != resample::Method::kNearest)
    return fail(ErrorCode::kUsage, std::string(is_basis ? "sensor layers with a thermal basis" : "material layers") +
                                       " cannot be resampled " + std::string(resample::method_name(method)) +
                                       ": between class 2 and class 4 there is no class 3; they use nearest");
  return method;
}

}  // namespace vt::pipeline
