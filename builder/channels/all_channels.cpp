#include "builder/channels/all_channels.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "builder/channels/color/color.h"
#include "builder/channels/elevation/elevation.h"
#include "builder/channels/horizon/horizon.h"
#include "builder/channels/illumination/illumination.h"
#include "builder/channels/mask/mask.h"
#include "builder/channels/material/material.h"
#include "builder/channels/normal/normal.h"
#include "builder/channels/sensor/sensor.h"
#include "builder/text/names_text.h"

namespace vt::channels {
namespace {

// One row a channel, in the order of their numbers. It grows before main() alone, see ExtraChannel.
std::vector<const ChannelKind*>& rows() {
  static std::vector<const ChannelKind*> kinds = {
      &kColorKind, &kNormalKind, &kHorizonKind, &kElevationKind, &kMaterialKind, &kSensorKind, &kIlluminationKind, &kMaskKind,
  };
  return kinds;
}

constexpr ChannelKind kUnknownKind{
    .name = "unknown",
    .usual_format = [](SampleType, bool) { return TexelFormat::kRgba32Float; },
    .make = [](const ChannelSettings& settings, const SampleLayout&) -> MadeCodec {
      return fail(ErrorCode::kUnsupported,
                  channel_name(settings.channel) + " is not known to this program, which can show its texels and not make them");
    }};

std::string option_names(const ChannelKind& kind) {
  return kind.options.empty() ? "none" : text::names_text(kind.options, &OptionInfo::name);
}

// "r8, r16 or bc4".
std::string choice_text(std::span<const TexelFormat> formats) {
  const auto name = [](TexelFormat format) { return format_info(format).name; };
  if (formats.size() == 1) return std::string(name(formats.front()));
  return text::names_text(formats.first(formats.size() - 1), name) + " or " + std::string(name(formats.back()));
}

Result<void> check_format(const ChannelKind& kind, const ChannelSettings& settings) {
  const std::span<const TexelFormat> formats = kind.formats(settings.options);
  if (formats.empty() || std::ranges::find(formats, settings.format) != formats.end()) return {};
  return fail(ErrorCode::kUnsupported,
              std::string(kind.name) + " layers cannot be stored as " + std::string(format_info(settings.format).name) +
                  std::string(kind.why_not_format(settings.format, settings.options)) + "; use " + choice_text(formats));
}

}  // namespace

const OptionInfo* ChannelKind::find_option(std::string_view option) const {
  const auto found = std::ranges::find(options, option, &OptionInfo::name);
  return found == options.end() ? nullptr : &*found;
}

std::span<const ChannelKind* const> all_channels() { return rows(); }

const ChannelKind& kind_of(ChannelType type) {
  const auto found = std::ranges::find(rows(), type, &ChannelKind::type);
  return found == rows().end() ? kUnknownKind : **found;
}

const ChannelKind* find_channel(std::string_view name) {
  const auto found = std::ranges::find(rows(), name, &ChannelKind::name);
  return found == rows().end() ? nullptr : *found;
}

std::string channel_name(ChannelType type) {
  const ChannelKind& kind = kind_of(type);
  return &kind == &kUnknownKind ? "channel " + std::to_string(static_cast<unsigned>(type)) : std::string(kind.name);
}

std::string channel_names() {
  return text::names_text(rows(), [](const ChannelKind* kind) { return kind->name; });
}

ExtraChannel::ExtraChannel(const ChannelKind& kind) {
  const bool is_free = is_private(kind.type) && &kind_of(kind.type) == &kUnknownKind && find_channel(kind.name) == nullptr;
  if (!is_free) {
    // Before main() nobody could be told otherwise, and a store would hold numbers of two meanings.
    std::fprintf(stderr, "channel %.*s: its number or its name is not its alone\n", static_cast<int>(kind.name.size()), kind.name.data());
    std::abort();
  }
  rows().push_back(&kind);
}

Result<void> check_options(ChannelType channel, const Options& options) {
  const ChannelKind& kind = kind_of(channel);
  for (const auto& [name, value] : options)
    if (kind.find_option(name) == nullptr)
      return fail(ErrorCode::kUsage,
                  "option " + name + " does not belong to " + channel_name(channel) + " layers; theirs: " + option_names(kind));
  return {};
}

Result<std::unique_ptr<const ChannelCodec>> make_codec(const ChannelSettings& settings, const SampleLayout& layout) {
  VT_CHECK(check_options(settings.channel, settings.options));
  const ChannelKind& kind = kind_of(settings.channel);
  VT_CHECK(check_format(kind, settings));
  return kind.make(settings, layout);
}

}  // namespace vt::channels
