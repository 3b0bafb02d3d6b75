#include "builder/pipeline/sources/source_facts.h"

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "store/io/content_hash.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

constexpr std::size_t kMostListedSources = 64;

nlohmann::ordered_json facts_of_one(const OpenSource& source, const SourcePlaces& places) {
  const RasterInfo& info = source.raster->info();
  nlohmann::ordered_json json;
  json["path"] = source.request.path.filename().string();
  json["content"] = source.fingerprint;
  json["width"] = info.width;
  json["height"] = info.height;
  json["bands"] = source.request.bands;
  json["sample_type"] = sample_name(info.sample_type);
  json["compression"] = info.compression;
  json["crs"] = source.crs.text();
  const geo::GeoTransform& t = source.transform;
  json["transform"] = {t.x0, t.x_column, t.x_row, t.y0, t.y_column, t.y_row};
  // Sources that lie where they say have always been remembered without this.
  if (places.turns != std::vector{0}) json["turns"] = places.turns;
  if (places.comes_again != 0) json["comes_again"] = places.comes_again;
  if (const auto& nodata = info.meaning.front().nodata)
    json["nodata"] = std::isfinite(*nodata) ? nlohmann::ordered_json(*nodata) : nlohmann::ordered_json(std::to_string(*nodata));
  // How samples are read that the file alone does not say: equal contents are then the same texels.
  const SourceRequest& request = source.request;
  if (request.nodata.size() > 1) json["nodata"] = request.nodata;
  if (request.coverage.kind == CoverageChoice::Kind::kNone) json["coverage"] = "none";
  if (request.coverage.kind == CoverageChoice::Kind::kBand) json["coverage"] = request.coverage.band;
  return json;
}

}  // namespace

nlohmann::ordered_json facts_of(const std::vector<OpenSource>& sources, const std::vector<SourcePlaces>& places) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (sources.size() <= kMostListedSources) {
    for (std::size_t i = 0; i < sources.size(); ++i) list.push_back(facts_of_one(sources[i], places[i]));
    return list;
  }
  store::ContentHasher hasher;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const std::string facts = facts_of_one(sources[i], places[i]).dump() + '\n';
    hasher.add(std::as_bytes(std::span(facts)));
  }
  const store::ContentHash digest = hasher.digest();
  return {{"count", sources.size()}, {"content", store::content_hash(digest.bytes)}};
}

}  // namespace vt::pipeline
