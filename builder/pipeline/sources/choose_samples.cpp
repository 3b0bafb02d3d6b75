#include "builder/pipeline/sources/choose_samples.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "builder/channels/all_channels.h"

namespace vt::pipeline {
namespace {

using source::BandMeaning;
using source::BandRole;
using source::RasterInfo;

constexpr int kNoBand = -1;

const BandMeaning& meaning_of(const RasterInfo& info, int band) { return info.meaning[static_cast<std::size_t>(band)]; }

Result<int> checked_band(const OpenSource& source, int number) {
  const RasterInfo& info = source.raster->info();
  if (number >= 1 && number <= info.bands) return number - 1;
  return fail(ErrorCode::kUsage, source.request.path.string() + ": band " + std::to_string(number) + " asked for, the file has 1 to " +
                                     std::to_string(info.bands));
}

// The bands that could be values when the user names none: all but coverage.
std::vector<int> value_candidates(const RasterInfo& info, int coverage) {
  std::vector<int> bands;
  for (int band = 0; band < info.bands; ++band)
    if (band != coverage && meaning_of(info, band).role != BandRole::kCoverage) bands.push_back(band);
  return bands;
}

// Red, green and blue where the file says which they are; otherwise the first ones.
std::vector<int> first_bands(const RasterInfo& info, const std::vector<int>& candidates, int wanted) {
  if (wanted == 3) {
    std::vector<int> colors;
    for (const BandRole role : {BandRole::kRed, BandRole::kGreen, BandRole::kBlue}) {
      const auto has_role = [&](int band) { return meaning_of(info, band).role == role; };
      if (std::ranges::count_if(candidates, has_role) == 1) colors.push_back(*std::ranges::find_if(candidates, has_role));
    }
    if (colors.size() == 3) return colors;
  }
  const auto count = std::min(candidates.size(), static_cast<std::size_t>(std::max(wanted, 0)));
  return {candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count)};
}

struct Bands {
  std::vector<int> values;
  int coverage = kNoBand;
};

Result<Bands> choose_bands(const LayerRequest& request, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const CoverageChoice& choice = source.request.coverage;
  Bands bands;
  for (const int number : source.request.bands) {
    VT_ASSIGN(const int band, checked_band(source, number));
    bands.values.push_back(band);
  }
  const bool is_chosen = !bands.values.empty();
  const bool is_named = std::ranges::find(bands.values, info.alpha_band) != bands.values.end();
  switch (choice.kind) {
    case CoverageChoice::Kind::kNone:
      break;
    case CoverageChoice::Kind::kBand: {
      VT_ASSIGN(bands.coverage, checked_band(source, choice.band));
      break;
    }
    case CoverageChoice::Kind::kAuto:
      // Bands that are named are the bands that are read. A mask is no band.
      if (!is_chosen || is_named || info.alpha_is_mask) bands.coverage = info.alpha_band;
  }
  const std::vector<int> candidates = value_candidates(info, bands.coverage);
  // A mask layer can be of the coverage itself.
  const channels::ChannelKind& kind = channels::kind_of(request.channel);
  const bool is_value = kind.may_be_coverage && choice.kind == CoverageChoice::Kind::kAuto && bands.coverage != kNoBand &&
                        (is_chosen ? is_named : candidates.size() > 1);
  if (is_value) {
    if (!is_chosen) bands.values = {bands.coverage};
    bands.coverage = kNoBand;
    return bands;
  }
  if (!is_chosen) {
    const int wanted = kind.bands_wanted(static_cast<int>(candidates.size()));
    // Several bands of equal right, as the three of a picture, are no height, class or radiance: one of them
    // has to be chosen.
    if (kind.has_one_value && static_cast<int>(candidates.size()) > wanted)
      return fail(ErrorCode::kInvalidData, source.request.path.string() + ": has " + std::to_string(candidates.size()) +
                                               " bands of values, and " + channels::channel_name(request.channel) +
                                               " takes one; say which with `bands`, for example `bands` 1");
    bands.values = first_bands(info, candidates, wanted);
  }
  // The mask of each band counts for all: that of a band that is not wanted would hide data.
  const auto value_count = static_cast<std::ptrdiff_t>(bands.values.size()) - std::ranges::count(bands.values, bands.coverage);
  if (bands.coverage == info.alpha_band && info.alpha_is_mask && info.mask_bands > 1 && value_count < info.mask_bands)
    return fail(ErrorCode::kUnsupported,
                source.request.path.string() + ": has a mask for each of " + std::to_string(info.mask_bands) +
                    " bands, of which the layer takes " + std::to_string(value_count) +
                    "; write those with their own mask into a new file, for example with gdal_translate -b 1 -mask 1, or say `alpha` none");
  std::erase(bands.values, bands.coverage);  // a coverage band that was named among the others is not taken twice
  return bands;
}

// What the user says for each value band, else what the file declares of all of them.
Result<std::optional<channels::NodataKey>> choose_nodata(const OpenSource& source, const std::vector<int>& values) {
  const std::vector<double>& given = source.request.nodata;
  if (given.size() > 1 && given.size() != values.size())
    return fail(ErrorCode::kUsage, source.request.path.string() + ": " + std::to_string(given.size()) + " no-data values are given for " +
                                       std::to_string(values.size()) + " bands; give one for all, or one for each");
  if (given.size() > 1) return std::optional(channels::NodataKey(given));
  std::vector<double> declared;  // a single value that is given comes through the file, which knows of palettes and inverted codes
  for (const int band : values) {
    const std::optional<double>& nodata = meaning_of(source.raster->info(), band).nodata;
    if (!nodata) return std::optional<channels::NodataKey>{};
    declared.push_back(*nodata);
  }
  const bool is_one =
      declared.size() < 2 || channels::NodataKey(std::vector<double>(declared.size(), declared[0])) == channels::NodataKey(declared);
  if (declared.empty()) return std::optional<channels::NodataKey>{};
  return std::optional(is_one ? channels::NodataKey(declared[0]) : channels::NodataKey(declared));
}

// Full scales that are the type's own are left unsaid.
std::optional<double> other_full_scale(const RasterInfo& info, int band) {
  const double full = meaning_of(info, band).full_scale;
  return full == full_scale(info.sample_type) ? std::nullopt : std::optional(full);
}

// What the file declares of the numbers in `bands`, which have to agree: a layer has one scale, offset and
// unit.
Result<void> choose_numbers(const OpenSource& source, const std::vector<int>& bands, channels::SampleLayout& layout) {
  const RasterInfo& info = source.raster->info();
  const BandMeaning& first = meaning_of(info, bands.front());
  const auto is_same = [&](int band) {
    const BandMeaning& other = meaning_of(info, band);
    return other.scale.value_or(1.0) == first.scale.value_or(1.0) && other.offset.value_or(0.0) == first.offset.value_or(0.0) &&
           other.unit == first.unit;
  };
  if (const auto other = std::ranges::find_if_not(bands, is_same); other != bands.end())
    return fail(ErrorCode::kInvalidData, source.request.path.string() + ": bands " + std::to_string(bands.front() + 1) + " and " +
                                             std::to_string(*other + 1) +
                                             " declare different scales, offsets or units, and a layer has one for all; write the "
                                             "values themselves into the file first, for example with gdal_translate -unscale -ot Float32");
  layout.scale = first.scale;
  layout.offset = first.offset;
  layout.unit = first.unit;
  return {};
}

// What the file says of heights, where the band does not say it itself.
void take_heights(const source::HeightMeaning& heights, channels::SampleLayout& layout) {
  if (layout.unit.empty()) layout.unit = heights.unit;
  layout.counts_down = heights.counts_down;
  if (!layout.scale && !layout.offset) {
    layout.scale = heights.scale;
    layout.offset = heights.offset;
  }
}

}  // namespace

Result<ChosenSamples> choose_samples(const LayerRequest& request, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  VT_ASSIGN(const Bands bands, choose_bands(request, source));
  ChosenSamples chosen{.bands = bands.values, .layout = {.type = info.sample_type, .range = request.range}};
  chosen.layout.value_bands = static_cast<int>(bands.values.size());
  VT_ASSIGN(chosen.layout.nodata, choose_nodata(source, bands.values));
  if (!bands.values.empty()) {
    chosen.layout.value_full_scale = other_full_scale(info, bands.values.front());
    const channels::ChannelKind& kind = channels::kind_of(request.channel);
    if (kind.uses_declared_scale) VT_CHECK(choose_numbers(source, bands.values, chosen.layout));
    if (kind.holds_heights) take_heights(info.heights, chosen.layout);
  }
  if (bands.coverage != kNoBand) {
    chosen.bands.push_back(bands.coverage);
    chosen.layout.has_alpha = true;
    chosen.layout.alpha_full_scale = other_full_scale(info, bands.coverage);
  }
  if (info.alpha_is_straightened && request.options.contains("alpha") && request.options.at("alpha") == "associated")
    return fail(ErrorCode::kUsage,
                source.request.path.string() +
                    ": declares that its colour is multiplied by its coverage, which is undone already; do not say so again");
  return chosen;
}

}  // namespace vt::pipeline
