#include "builder/pipeline/plan_remarks.h"

#include <cstdio>
#include <filesystem>

namespace vt::pipeline {
namespace {

// A mosaic can have a remark for each of its files; a person reads a few.
constexpr std::size_t kMostRemarks = 8;

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

}  // namespace

void Remarks::add(std::string text) {
  if (++count_ <= kMostRemarks) texts_.push_back(std::move(text));
}

void Remarks::append_to(std::vector<std::string>& warnings) const {
  warnings.insert(warnings.end(), texts_.begin(), texts_.end());
  if (count_ > kMostRemarks) warnings.push_back("and " + std::to_string(count_ - kMostRemarks) + " more files that are " + what_);
}

void remark_on(const LayerRequest& request, resample::Method resampling, const geo::Crs& crs, const std::vector<OpenSource>& sources,
               const std::vector<resample::PlacedSource>& placed, std::vector<std::string>& warnings) {
  const std::string method(resample::method_name(resampling));
  Remarks outside("outside the layer's area");
  Remarks moved("moved onto the grid");
  Remarks resampled("resampled");
  Remarks clear("stored without their coverage");
  Remarks ranges("taken as black at 0 and white at 65535");
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const OpenSource& source = sources[i];
    const std::string path = source.request.path.string();
    if (placed[i].covered.empty()) {
      outside.add(path + ": lies outside the layer's area and is left out");
      continue;
    }
    if (!placed[i].is_aligned)
      resampled.add(path + ": resampled (" + method + "), because " +
                    (crs.same_coordinates(source.crs) ? "its grid is not the layer's"
                                                      : "it is in " + source.crs.text() + " and the layer in " + crs.text()));
    if (placed[i].moved.x != 0.0 || placed[i].moved.y != 0.0)
      moved.add(path + ": moved by " + two_digits(placed[i].moved.x) + " texels to the east and " + two_digits(placed[i].moved.y) +
                " to the south (nearest), because its grid is not the layer's; its samples stay as they are");
    const bool is_opaque = request.format == TexelFormat::kRgb8 || request.format == TexelFormat::kBc1;
    if (request.channel == ChannelType::kColor && is_opaque && source.raster->info().alpha_band >= 0)
      clear.add(path + ": has a coverage band that " + std::string(format_info(*request.format).name) +
                " cannot store, what is clear shows its neighbours' colour; to keep it use " +
                (request.format == TexelFormat::kBc1 ? "bc3 or bc7" : "rgba8"));
    if (request.channel == ChannelType::kColor && source.raster->info().sample_type == SampleType::kUint16 && !request.range)
      ranges.add(path + ": 0 is taken as black and 65535 as white; if the picture comes out dark, give --range LOW,HIGH");
  }
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
