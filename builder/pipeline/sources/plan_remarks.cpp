#include "builder/pipeline/sources/plan_remarks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "builder/channels/all_channels.h"
#include "builder/channels/shared/declared_unit.h"
#include "builder/pipeline/sources/source_place.h"
#include "builder/resample/warped_reader.h"
#include "builder/text/number_text.h"

namespace vt::pipeline {
namespace {

// A mosaic can have a remark for each of its files; a person reads a few.
constexpr std::size_t kMostRemarks = 8;

// "0.1 * sample + 5 ft": what a file declares of the numbers that a layer reads. Empty: nothing.
std::string declared_number(const channels::SampleLayout& layout) {
  const double scale = layout.scale.value_or(1.0);
  const double offset = layout.offset.value_or(0.0);
  const std::string unit = layout.unit.empty() ? "" : " in '" + layout.unit + "'";
  if (scale == 1.0 && offset == 0.0) return unit;
  return " as " + text::number_text(scale) + " * sample" +
         (offset == 0.0 ? "" : (offset < 0.0 ? " - " : " + ") + text::number_text(std::abs(offset))) + unit;
}

// What the file declares of its numbers, and how it is taken.
void remark_on_numbers(const LayerRequest& request, const OpenSource& source, const resample::PlacedSource& placed,
                       SharedRemarks& remarks) {
  const std::string path = source.request.path.string();
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  if (kind.uses_declared_scale) {
    const bool is_plain_metre = kind.holds_heights && channels::metres_of_unit(placed.layout.unit) == 1.0;
    channels::SampleLayout declared = placed.layout;
    if (is_plain_metre) declared.unit.clear();
    const std::string text = declared_number(declared);
    if (!text.empty()) {
      std::string given;
      for (const char* option : {"input-scale", "input-offset", "input-unit", "angles"})
        if (request.options.contains(option)) given += (given.empty() ? "" : ", ") + std::string(option);
      remarks.add("its values are declared" + text + (given.empty() ? ", and taken so" : "; what " + given + " says goes before that"),
                  path);
    }
    return;
  }
  for (const int band : placed.bands) {
    const source::BandMeaning& meaning = source.raster->info().meaning[static_cast<std::size_t>(band)];
    if (meaning.scale.value_or(1.0) == 1.0 && meaning.offset.value_or(0.0) == 0.0) continue;
    remarks.add("declares a scale of " + text::number_text(meaning.scale.value_or(1.0)) + " and an offset of " +
                    text::number_text(meaning.offset.value_or(0.0)) + " for its samples, which " + channels::channel_name(request.channel) +
                    " layers do not use",
                path);
    return;
  }
}

// "bands 1, 2 and 3 of 6 are taken, ...": where nobody, neither user nor file, has said that the first bands
// are the ones that are meant.
std::string bands_taken(const OpenSource& source, const resample::PlacedSource& placed) {
  const source::RasterInfo& info = source.raster->info();
  const auto values = std::span(placed.bands).first(static_cast<std::size_t>(placed.layout.value_bands));
  const auto is_coverage = [&](const source::BandMeaning& band) { return band.role == source::BandRole::kCoverage; };
  const auto value_bands = info.bands - std::ranges::count_if(info.meaning, is_coverage);
  const auto says_color = [&](int band) {
    const source::BandRole role = info.meaning[static_cast<std::size_t>(band)].role;
    return role == source::BandRole::kRed || role == source::BandRole::kGreen || role == source::BandRole::kBlue;
  };
  if (!source.request.bands.empty() || value_bands <= placed.layout.value_bands || std::ranges::all_of(values, says_color)) return {};
  std::string names;
  for (std::size_t i = 0; i < values.size(); ++i)
    names += (i == 0 ? "" : i + 1 == values.size() ? " and " : ", ") + std::to_string(values[i] + 1);
  return (values.size() == 1 ? "band " : "bands ") + names + " of " + std::to_string(info.bands) + (values.size() == 1 ? " is" : " are") +
         " taken; `bands` names others";
}

// What the file holds that counts in another way, or not at all.
void remark_on_file(const LayerRequest& request, const OpenSource& source, SharedRemarks& remarks) {
  const source::RasterInfo& info = source.raster->info();
  const std::string path = source.request.path.string();
  const bool is_overruled = source.request.crs && !info.declared_crs_text.empty() &&
                            !(info.declared_crs && info.declared_crs->same_coordinates(*source.request.crs));
  if (is_overruled)
    remarks.add("declared in " + info.declared_crs_text + ", but taken to be in " + source.crs.text() + ", as asked for", path);
  if (looks_like_degrees(source))
    remarks.add("coordinates look like degrees, but " + source.crs.text() + " counts lengths; check the CRS", path);
  const source::Concern special = channels::kind_of(request.channel).concern;
  for (const source::UnusedFact& fact : info.unused)
    if (fact.concern == source::Concern::kAll || fact.concern == special)
      remarks.add("holds " + fact.what + ", which is not used" + (fact.instead.empty() ? "" : ": " + fact.instead), path);
}

// How a source on another grid becomes texels.
std::string method_text(const resample::PlacedSource& placed) {
  const double samples = placed.warp->most_samples_per_texel(placed.covered);
  const bool is_picked = placed.method == resample::Method::kNearest;
  if (samples <= (is_picked ? resample::kMostPicked : resample::kMostUnit)) return std::string(resample::method_name(placed.method));
  char text[64];
  std::snprintf(text, sizeof text, "by area, up to %.1f samples along a texel", samples);
  return text;
}

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

}  // namespace

void SharedRemarks::add(const std::string& text, const std::string& path) {
  auto found = std::ranges::find(remarks_, text, &Files::text);
  if (found == remarks_.end()) found = remarks_.insert(remarks_.end(), {.text = text, .first = path});
  ++found->count;
}

void SharedRemarks::append_to(std::vector<std::string>& warnings) const {
  for (const Files& files : remarks_)
    warnings.push_back(files.first + (files.count > 1 ? " and " + std::to_string(files.count - 1) + " more files" : "") + ": " +
                       files.text);
}

void Remarks::add(std::string text) {
  if (++count_ <= kMostRemarks) texts_.push_back(std::move(text));
}

void Remarks::append_to(std::vector<std::string>& warnings) const {
  warnings.insert(warnings.end(), texts_.begin(), texts_.end());
  if (count_ > kMostRemarks) warnings.push_back("and " + std::to_string(count_ - kMostRemarks) + " more files that are " + what_);
}

void remark_on(const LayerRequest& request, const geo::Crs& crs, const std::vector<OpenSource>& sources,
               const std::vector<SourcePlaces>& places, std::vector<std::string>& warnings) {
  Remarks outside("outside the layer's area");
  Remarks moved("moved onto the grid");
  Remarks resampled("resampled");
  Remarks clear("stored without their coverage");
  Remarks ranges("taken as black at 0 and white at 65535");
  SharedRemarks shared;
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const OpenSource& source = sources[i];
    const std::string path = source.request.path.string();
    remark_on_file(request, source, shared);
    if (places[i].is_empty()) {
      outside.add(path + ": lies outside the layer's area and is left out");
      continue;
    }
    const source::RasterInfo& info = source.raster->info();
    const resample::PlacedSource& placed = places[i].placed.front();  // others differ by whole turns
    remark_on_numbers(request, source, placed, shared);
    const bool leaves_alpha = source.request.coverage.kind == CoverageChoice::Kind::kAuto && info.alpha_band >= 0 &&
                              std::ranges::find(placed.bands, info.alpha_band) == placed.bands.end();
    if (leaves_alpha)
      shared.add("its coverage (band " + std::to_string(info.alpha_band + 1) + ") is not among the bands that are named, so it is not used",
                 path);
    if (const std::string taken = bands_taken(source, placed); !taken.empty()) shared.add(taken, path);
    if (!placed.is_aligned)
      resampled.add(path + ": resampled (" + method_text(placed) + "), because " +
                    (crs.same_coordinates(source.crs) ? "its grid is not the layer's"
                                                      : "it is in " + source.crs.text() + " and the layer in " + crs.text()));
    if (placed.moved.x != 0.0 || placed.moved.y != 0.0)
      moved.add(path + ": moved by " + two_digits(placed.moved.x) + " texels to the east and " + two_digits(placed.moved.y) +
                " to the south (nearest), because its grid is not the layer's; its samples stay as they are");
    const bool is_opaque = request.format == TexelFormat::kRgb8 || request.format == TexelFormat::kBc1;
    if (kind.fourth_is_coverage && is_opaque && placed.layout.has_alpha)
      clear.add(path + ": has a coverage band that " + std::string(format_info(*request.format).name) +
                " cannot store, what is clear shows its neighbours' colour; to keep it use " +
                (request.format == TexelFormat::kBc1 ? "bc3 or bc7" : "rgba8"));
    if (kind.has_black_and_white && info.sample_type == SampleType::kUint16 && !placed.layout.value_full_scale && !request.range)
      ranges.add(path + ": 0 is taken as black and 65535 as white; if the picture comes out dark, give `range` LOW,HIGH");
  }
  shared.append_to(warnings);
  for (Remarks* remarks : {&outside, &resampled, &moved, &clear, &ranges}) remarks->append_to(warnings);
}

std::string missing_text(const LayerRequest& request) {
  if (request.sources.empty()) return "it names no sources";
  std::size_t missing = 0;
  std::string names;
  std::error_code error;
  for (const SourceRequest& source : request.sources) {
    if (std::filesystem::exists(source.path, error)) continue;
    if (++missing <= kMostRemarks) names += (missing == 1 ? "" : ", ") + source.path.string();
  }
  if (missing == 0) return "";
  return std::to_string(missing) + " of " + std::to_string(request.sources.size()) + " sources are not there: " + names +
         (missing > kMostRemarks ? ", ..." : "");
}

}  // namespace vt::pipeline
