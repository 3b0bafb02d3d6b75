#include "builder/channels/codec/channel_options.h"

#include <array>
#include <charconv>
#include <cmath>

namespace vt::channels {
namespace {

// In the order of the channels' numbers.
constexpr auto kOptions = std::to_array<OptionInfo>({
    {ChannelType::kColor, "alpha", "straight|associated",
     "whether the input's codes are multiplied by their coverage although the file does not say so; files that declare it are understood "
     "without this (default: straight)"},
    {ChannelType::kColor, "transfer", "srgb|linear", "what the input's codes mean; the layer's are sRGB in any case (default: srgb)"},
    {ChannelType::kColor, "anti-ringing", "yes|no", "keep overshoot beside edges within the neighbouring texels (default: no)"},
    {ChannelType::kNormal, "frame", "enu|scene",
     "what x, y, z are: east, north, up at each place, or one frame for the whole scene (default: enu)"},
    {ChannelType::kNormal, "zero", "128|127.5",
     "the code that is 0 in unsigned 8-bit input; in 16-bit input 32768 or 32767.5 (default: 128)"},
    {ChannelType::kNormal, "y", "up|down", "whether y grows to the top or to the bottom of the picture in the input (default: up)"},
    {ChannelType::kNormal, "length", "yes|no",
     "store the length of the mean normal, which tells roughness, beside rgb8, rg16 and bc5 (default: yes)"},
    {ChannelType::kNormal, "moments", "none|lean", "store means and mean squares of the slopes as well (default: none)"},
    {ChannelType::kHorizon, "azimuths", "DEGREES,...",
     "direction of each band, clockwise from north (default: 90,270 of two, evenly from north of more)"},
    {ChannelType::kHorizon, "angles", "rad|deg", "unit of the input's angles (default: the one that the file declares, else rad)"},
    {ChannelType::kHorizon, "deviations", "none|given",
     "whether bands are single angles, or pairs of mean and standard deviation (default: none)"},
    {ChannelType::kHorizon, "span", "LOW,HIGH",
     "degrees that codes are spread over; fewer give low sun finer steps, horizons beyond are clamped (default: -90,90)"},
    {ChannelType::kElevation, "input-scale", "FACTOR",
     "height = offset + scale * sample, in --input-unit (default: what the file declares for the band, else 1)"},
    {ChannelType::kElevation, "input-offset", "HEIGHT",
     "height of the sample 0, see --input-scale (default: what the file declares, else 0)"},
    {ChannelType::kElevation, "input-unit", "m|ft|us-ft|cm|...",
     "unit of the input's heights; the layer's are metres. Also metres, as in \"0.3048 m\" (default: what the file declares, else m)"},
    {ChannelType::kElevation, "quantum", "METRES",
     "step of the codes of r16, which hold --range (of 8 and 16 bit integers: all that the type can say) in 65535 of them (default: the "
     "finest power of two that does)"},
    {ChannelType::kElevation, "bounds", "yes|no",
     "store the least and greatest height under every texel of coarser levels too, as NAME/bounds; twice the data of all levels but the "
     "finest, for programs that displace or cull (default: no)"},
    {ChannelType::kElevation, "surface-error", "yes|no",
     "measure how far the surface through every coarser level lies from the finest, into the layer's metadata (\"surface\"); reads all "
     "tiles again after the build (default: no)"},
    {ChannelType::kElevation, "fill", "METRES|none",
     "height that is stored where there are no data; means of coarser levels leave it out; the metadata say so: \"filled_m\" (default: "
     "none)"},
    {ChannelType::kMaterial, "classes", "FILE",
     "JSON table of the classes, [{\"id\": 1, \"name\": \"water\", \"color\": \"#265480\"}, ...]", true},
    {ChannelType::kMaterial, "mixture", "1|2|3|4",
     "also store how much of each texel its most frequent classes hold, as NAME/classes and NAME/weights (default: the majority alone)"},
    {ChannelType::kMaterial, "no-data-class", "NUMBER",
     "what is stored where there are no data (default: the first source's no-data value, or the greatest number of the format)"},
    {ChannelType::kSensor, "quantity", "radiance|reflectance|emissivity|temperature", "what the input is (default: radiance)"},
    {ChannelType::kSensor, "band", "LOW,HIGH", "edges of the sensor's band in micrometres"},
    {ChannelType::kSensor, "response", "FILE", "the sensor's relative response over wavelength, CSV or JSON; a band cuts it", true},
    {ChannelType::kSensor, "store", "radiance|temperature",
     "what is stored of a thermal input; temperatures are those of the mean radiance (default: radiance)"},
    {ChannelType::kSensor, "input-scale", "FACTOR",
     "value = offset + scale * sample, in --input-unit (default: what the file declares for the band, else 1)"},
    {ChannelType::kSensor, "input-offset", "VALUE", "value of the sample 0, see --input-scale (default: what the file declares, else 0)"},
    {ChannelType::kSensor, "input-unit", "TEXT",
     "unit of the input's values: K, C or F of temperatures, 1 or % of ratios, W/(m2 sr) of radiance in a band (default: what the file "
     "declares)"},
    {ChannelType::kSensor, "span", "LOW,HIGH", "the values that the codes of r16 and bc4 reach from and to (default: 0,1 for ratios)"},
    {ChannelType::kSensor, "unit", "TEXT", "unit of radiance that is given without a band (default: W/(m2 sr))"},
    {ChannelType::kSensor, "basis", "FILE",
     "thermal curves of the input's classes over a day, JSON; what is stored is their common curves' coefficients", true},
    {ChannelType::kSensor, "components", "3..5", "how many coefficients (default: 4)"},
    {ChannelType::kIllumination, "transfer", "linear|srgb", "what the codes of 8 and 16 bit input are proportional to (default: linear)"},
    {ChannelType::kIllumination, "scale", "LIGHT",
     "light of the full code of 8 and 16 bit input, of the number 1 of other input (default: 1)"},
    {ChannelType::kIllumination, "stored-scale", "LIGHT",
     "light of the number 1 in the store, of which readers multiply what is stored; powers of two round nothing (default: 1, or less where "
     "light of numbers as small as the first build finds them would be lost in rgba16f, rgb9e5 or bc6h)"},
    {ChannelType::kIllumination, "unit", "TEXT", "unit of the light (default: W/(m2 sr), or none for codes without a scale)"},
    {ChannelType::kMask, "inside", "VALUES",
     "sample values that are inside, with commas between them; all others are outside (default: samples are shares from 0 to 1)"},
    {ChannelType::kMask, "alpha-coverage", "REF",
     "for alpha tests: scale every coarser level so that as much of it exceeds REF (0.001 to 0.999) as of the finest; the plain means stay "
     "as NAME/mean (default: plain means only)"},
});

std::string names_of(ChannelType channel) {
  std::string names;
  for (const OptionInfo& option : kOptions)
    if (option.channel == channel) names += (names.empty() ? "" : ", ") + std::string(option.name);
  return names.empty() ? "none" : names;
}

Result<double> parse_number(const std::string& name, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return fail(ErrorCode::kUsage, "option " + name + ": '" + std::string(text) + "' is not a number");
  return value;
}

}  // namespace

std::span<const OptionInfo> all_options() { return kOptions; }

Result<void> check_options(ChannelType channel, const Options& options) {
  for (const auto& [name, value] : options) {
    bool known = false;
    for (const OptionInfo& option : kOptions) known = known || (option.channel == channel && option.name == name);
    if (!known)
      return fail(ErrorCode::kUsage, "option " + name + " does not belong to " + std::string(channel_info(channel).name) +
                                         " layers; theirs: " + names_of(channel));
  }
  return {};
}

Result<std::string> choice_of(const Options& options, const std::string& name, std::string_view preset,
                              std::span<const std::string_view> choices) {
  const auto given = options.find(name);
  if (given == options.end()) return std::string(preset);
  std::string all;
  for (const std::string_view choice : choices) {
    if (given->second == choice) return given->second;
    all += (all.empty() ? "" : ", ") + std::string(choice);
  }
  return fail(ErrorCode::kUsage, "option " + name + ": '" + given->second + "' is none of " + all);
}

Result<std::optional<double>> number_of(const Options& options, const std::string& name, double least, double greatest) {
  const auto given = options.find(name);
  if (given == options.end()) return std::optional<double>{};
  VT_ASSIGN(const double value, parse_number(name, given->second));
  if (value < least || value > greatest)
    return fail(ErrorCode::kUsage,
                "option " + name + ": " + given->second + " is not from " + std::to_string(least) + " to " + std::to_string(greatest));
  return std::optional(value);
}

Result<std::vector<double>> numbers_of(const Options& options, const std::string& name) {
  std::vector<double> numbers;
  const auto given = options.find(name);
  if (given == options.end()) return numbers;
  const std::string& text = given->second;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    VT_ASSIGN(const double value, parse_number(name, std::string_view(text).substr(at, end - at)));
    numbers.push_back(value);
    at = end + 1;
  }
  return numbers;
}

Result<bool> flag_of(const Options& options, const std::string& name, bool preset) {
  constexpr std::array<std::string_view, 2> kChoices{"yes", "no"};
  VT_ASSIGN(const std::string choice, choice_of(options, name, preset ? "yes" : "no", kChoices));
  return choice == "yes";
}

}  // namespace vt::channels
