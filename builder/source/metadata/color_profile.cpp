#include "builder/source/metadata/color_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "store/format/text.h"

namespace vt::source {
namespace {

using namespace std::string_view_literals;

// ICC.1:2022, all numbers big-endian.
class Profile {
 public:
  explicit Profile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t count = 4) const {
    if (at > bytes_.size() || count > bytes_.size() - at) return 0;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i) value = value << 8 | std::to_integer<std::uint32_t>(bytes_[at + i]);
    return value;
  }
  [[nodiscard]] double fixed(std::size_t at) const { return static_cast<std::int32_t>(number(at)) / 65536.0; }  // s15Fixed16Number
  [[nodiscard]] std::string text(std::size_t at, std::size_t count) const {
    std::string result;
    for (std::size_t i = 0; i < count && at + i < bytes_.size(); ++i) result += static_cast<char>(bytes_[at + i]);
    return result;
  }
  // The offset of a tag's data; nullopt when there is none, or not all of it.
  struct Tag {
    std::size_t at = 0;
    std::size_t bytes = 0;
    std::string type;
  };
  [[nodiscard]] std::optional<Tag> tag(std::string_view signature) const {
    const std::uint32_t count = std::min<std::uint32_t>(number(128), 256);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::size_t entry = 132 + std::size_t{12} * i;
      if (text(entry, 4) != signature) continue;
      const std::size_t at = number(entry + 4);
      const std::size_t bytes = number(entry + 8);
      if (at > bytes_.size() || bytes > bytes_.size() - at || bytes < 8) return std::nullopt;
      return Tag{.at = at, .bytes = bytes, .type = text(at, 4)};
    }
    return std::nullopt;
  }

 private:
  std::span<const std::byte> bytes_;
};

std::string name_in(const std::string& text) { return store::printable(text.substr(0, std::min(text.find('\0'), std::size_t{80}))); }

std::string description_of(const Profile& profile) {
  const auto tag = profile.tag("desc");
  if (!tag) return {};
  if (tag->type == "desc") return name_in(profile.text(tag->at + 12, std::min<std::size_t>(profile.number(tag->at + 8), tag->bytes)));
  if (tag->type != "mluc" || profile.number(tag->at + 8) == 0) return {};
  // The first language's text, two bytes a character.
  const std::size_t bytes = std::min<std::size_t>(profile.number(tag->at + 20), 256);
  const std::string wide = profile.text(tag->at + profile.number(tag->at + 24), bytes);
  std::string text;
  for (std::size_t i = 1; i < wide.size(); i += 2) text += wide[i];
  return name_in(text);
}

double srgb_light(double code) { return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4); }

// Light of a code from 0 to 1 by a curve tag; nullopt when it is of a kind that nobody uses for this.
std::optional<double> curve(const Profile& profile, const Profile::Tag& tag, double code) {
  if (tag.type == "curv") {
    const std::uint32_t count = profile.number(tag.at + 8);
    if (count == 0) return code;
    if (count == 1) return std::pow(code, profile.number(tag.at + 12, 2) / 256.0);
    if (tag.bytes < 12 + std::size_t{2} * count) return std::nullopt;
    const double place = code * (count - 1);
    const auto lower = static_cast<std::size_t>(place);
    const std::size_t upper = std::min<std::size_t>(lower + 1, count - 1);
    const auto entry = [&](std::size_t i) { return profile.number(tag.at + 12 + 2 * i, 2) / 65535.0; };
    return entry(lower) + (place - static_cast<double>(lower)) * (entry(upper) - entry(lower));
  }
  if (tag.type != "para") return std::nullopt;
  const std::uint32_t kind = profile.number(tag.at + 8, 2);
  const auto parameter = [&](std::size_t i) { return profile.fixed(tag.at + 12 + 4 * i); };
  const double g = parameter(0);
  const double a = parameter(1);
  const double b = parameter(2);
  switch (kind) {  // table 68
    case 0:
      return std::pow(code, g);
    case 1:
      return code >= -b / a ? std::pow(a * code + b, g) : 0.0;
    case 2:
      return code >= -b / a ? std::pow(a * code + b, g) + parameter(3) : parameter(3);
    case 3:
      return code >= parameter(4) ? std::pow(a * code + b, g) : parameter(3) * code;
    case 4:
      return code >= parameter(4) ? std::pow(a * code + b, g) + parameter(5) : parameter(3) * code + parameter(6);
    default:
      return std::nullopt;
  }
}

bool is_srgb_curve(const Profile& profile, std::string_view signature) {
  constexpr double kTolerance =
      0.002;  // of light: tables of 1024 entries and parameters of 16 bits stay below, a pure power of 2.2 does not
  const auto tag = profile.tag(signature);
  if (!tag) return false;
  for (int i = 0; i <= 64; ++i) {
    const double code = i / 64.0;
    const auto light = curve(profile, *tag, code);
    if (!light || !(std::abs(*light - srgb_light(code)) <= kTolerance)) return false;
  }
  return true;
}

// The primaries of sRGB, adapted to D50 (IEC 61966-2-1 with the Bradford matrix), as profiles hold them.
bool has_srgb_colorants(const Profile& profile) {
  constexpr double kTolerance = 0.002;
  constexpr std::array<std::pair<std::string_view, std::array<double, 3>>, 3> kColorants = {
      {{"rXYZ", {0.4360, 0.2225, 0.0139}}, {"gXYZ", {0.3851, 0.7169, 0.0971}}, {"bXYZ", {0.1431, 0.0606, 0.7139}}}};
  for (const auto& [signature, wanted] : kColorants) {
    const auto tag = profile.tag(signature);
    if (!tag || tag->bytes < 20) return false;
    for (std::size_t i = 0; i < 3; ++i)
      if (!(std::abs(profile.fixed(tag->at + 8 + 4 * i) - wanted[i]) <= kTolerance)) return false;
  }
  return true;
}

}  // namespace

ColorProfile read_color_profile(std::span<const std::byte> bytes) {
  const Profile profile(bytes);
  ColorProfile result{.description = description_of(profile), .is_srgb = false};
  const std::string space = profile.text(16, 4);
  if (space == "GRAY") result.is_srgb = is_srgb_curve(profile, "kTRC");
  if (space == "RGB ")
    result.is_srgb =
        has_srgb_colorants(profile) && is_srgb_curve(profile, "rTRC") && is_srgb_curve(profile, "gTRC") && is_srgb_curve(profile, "bTRC");
  return result;
}

}  // namespace vt::source
