#include "builder/source/metadata/color_remarks.h"

#include <fmt/format.h>
#include <tiff.h>

#include <algorithm>
#include <cmath>

#include "builder/source/metadata/color_profile.h"

namespace vt::source {
namespace {

constexpr std::size_t kMostProfileBytes = std::size_t{16} << 20;

// A damaged tag that would not be used anyway is no reason to refuse the file; a read error is.
template <class T>
Result<T> if_usable(Result<T> value) {
  if (value || value.error().code == ErrorCode::kIo) return value;
  return T{};
}

}  // namespace

UnusedFact unused_color(const std::string& what) {
  return {.what = what, .concern = Concern::kColor, .instead = "colours are taken for sRGB; convert them to sRGB first where that matters"};
}

UnusedFact unused_inks() {
  return {.what = "a separation into inks (CMYK)",
          .concern = Concern::kColor,
          .instead = "they are turned into red, green and blue without a profile, so that colours are near but not exact"};
}

void note_profile(std::span<const std::byte> bytes, std::vector<UnusedFact>& unused) {
  const ColorProfile profile = read_color_profile(bytes);
  if (profile.is_srgb) return;
  unused.push_back(
      unused_color(profile.description.empty() ? "an ICC profile" : fmt::format("an ICC profile \"{}\"", profile.description)));
}

void note_primaries(const std::array<double, 8>& xy, const std::string& name, std::vector<UnusedFact>& unused) {
  constexpr std::array<double, 8> kSrgb = {0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06};  // IEC 61966-2-1
  constexpr double kTolerance = 0.001;                                                           // files have three or four digits
  const auto is_near = [](double a, double b) { return std::abs(a - b) <= kTolerance; };
  if (!std::ranges::equal(xy, kSrgb, is_near))
    unused.push_back(unused_color(fmt::format("primaries of its own ({}; red at {:.4g}, {:.4g})", name, xy[2], xy[3])));
}

Result<void> note_tiff_colors(const TiffTags& tags, std::vector<UnusedFact>& unused) {
  VT_ASSIGN(std::string profile, if_usable(tags.text(TIFFTAG_ICCPROFILE)));
  if (profile.size() >= 4) {
    // Zeros at its end are not part of a text, but of a profile.
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < 4; ++i) bytes = bytes << 8 | static_cast<unsigned char>(profile[i]);
    if (bytes > profile.size() && bytes <= kMostProfileBytes) profile.resize(bytes, '\0');
  }
  if (tags.has(TIFFTAG_ICCPROFILE)) {
    note_profile(std::as_bytes(std::span(profile)), unused);
  } else if (tags.has(TIFFTAG_PRIMARYCHROMATICITIES)) {
    VT_ASSIGN(std::vector<double> white, if_usable(tags.numbers(TIFFTAG_WHITEPOINT)));
    VT_ASSIGN(std::vector<double> primaries, if_usable(tags.numbers(TIFFTAG_PRIMARYCHROMATICITIES)));
    if (white.empty()) white = {0.3127, 0.3290};
    white.resize(2);
    primaries.resize(6);
    note_primaries({white[0], white[1], primaries[0], primaries[1], primaries[2], primaries[3], primaries[4], primaries[5]}, "tag 319",
                   unused);
  } else if (tags.has(TIFFTAG_WHITEPOINT)) {
    unused.push_back(unused_color("a white point (tag 318)"));
  }
  if (tags.has(TIFFTAG_TRANSFERFUNCTION)) unused.push_back(unused_color("a transfer function (tag 301)"));
  VT_ASSIGN(const std::vector<double> photometric, tags.numbers(TIFFTAG_PHOTOMETRIC));
  if (!photometric.empty() && photometric[0] == PHOTOMETRIC_SEPARATED) unused.push_back(unused_inks());
  return {};
}

}  // namespace vt::source
