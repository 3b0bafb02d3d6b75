#include "builder/pipeline/open_sources.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "builder/channels/channel_codec.h"
#include "builder/pipeline/parallel.h"
#include "store/content_hash.h"
#include "store/text.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// Parts of a file are enough to tell it from another, or from itself before an edit that moved anything: a file is read whole only to be
// built.
constexpr std::uintmax_t kFingerprintPieces = 16;
constexpr std::size_t kFingerprintPieceBytes = std::size_t{4} << 10;

constexpr std::size_t kMostListedSources = 64;

// Hash of the file's length and of evenly spaced pieces, the first and the last bytes among them; of all of it when it is small. Content,
// not clocks: a copied file is the same source.
Result<std::string> content_fingerprint(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff length = file.tellg();
  if (!file || length < 0) return fail(ErrorCode::kIo, path.string() + ": cannot be read");
  const auto file_bytes = static_cast<std::uintmax_t>(length);
  std::string pieces = std::to_string(file_bytes) + '\n';
  std::string piece(kFingerprintPieceBytes, '\0');
  const std::uintmax_t spread = file_bytes > kFingerprintPieceBytes ? file_bytes - kFingerprintPieceBytes : 0;
  const std::uintmax_t count = std::min(kFingerprintPieces, (file_bytes + kFingerprintPieceBytes - 1) / kFingerprintPieceBytes);
  for (std::uintmax_t i = 0; i < count; ++i) {
    // In this order no product overflows for any file length.
    const std::uintmax_t from = count < 2 ? 0 : spread / (count - 1) * i + spread % (count - 1) * i / (count - 1);
    file.seekg(static_cast<std::streamoff>(from));
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    if (file.bad()) return fail(ErrorCode::kIo, path.string() + ": cannot be read at byte " + std::to_string(from));
    pieces.append(piece, 0, static_cast<std::size_t>(file.gcount()));
    file.clear();
  }
  return store::content_hash(std::as_bytes(std::span(pieces)));
}

// Pictures without any place on the ground lie with their lower left corner at (0, 0), one unit a sample.
geo::GeoTransform transform_of(const RasterInfo& info) {
  if (info.has_transform) return info.transform;
  return {0.0, 1.0, 0.0, static_cast<double>(info.height), 0.0, -1.0};
}

Result<OpenSource> open_source(const SourceRequest& request, ChannelType channel, const SharedReading& shared) {
  if (!store::is_utf8(request.path.string()))
    return fail(ErrorCode::kUsage,
                request.path.string() + ": this name is not UTF-8, and a store keeps the names of its sources as text; rename the file");
  source::OpenOptions options;
  options.crs = request.crs;
  options.extent = request.extent;
  // Several values are a colour, which is compared with what is read.
  if (request.nodata.size() == 1) options.nodata = request.nodata.front();
  options.as_numbers = !channels::reads_colors(channel);
  options.cache = shared.cache;
  options.files = shared.files;
  options.scratch = shared.scratch;
  VT_ASSIGN(std::unique_ptr<source::RasterSource> raster, source::open_raster(request.path, options));
  const RasterInfo& info = raster->info();
  geo::Crs crs;
  if (info.crs) {
    crs = *info.crs;
  } else if (request.fallback_crs) {
    crs = *request.fallback_crs;
  } else {
    const std::string why = info.crs_problem.empty() ? "no coordinate reference system in the file" : info.crs_problem;
    return fail(ErrorCode::kInvalidData, request.path.string() + ": " + why + "; give one, for example --crs EPSG:4326" +
                                             (info.has_transform ? "" : " --extent WEST,SOUTH,EAST,NORTH") +
                                             ", or --crs pixel for a picture without a place on the ground");
  }
  const bool is_pixel = crs.definition().projection == geo::Projection::kPixel;
  if (!info.has_transform && !is_pixel)
    return fail(
        ErrorCode::kInvalidData,
        request.path.string() + ": the file does not say where it lies; give --extent WEST,SOUTH,EAST,NORTH in units of " + crs.text());
  VT_ASSIGN(std::string fingerprint, content_fingerprint(request.path));
  for (const std::filesystem::path& companion : info.companions) {
    VT_ASSIGN(const std::string beside, content_fingerprint(companion));
    fingerprint += "+" + beside;
  }
  const geo::GeoTransform transform = transform_of(info);
  return OpenSource{request, std::move(raster), std::move(crs), transform, std::move(fingerprint)};
}

nlohmann::ordered_json facts_of_one(const OpenSource& source) {
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

Result<std::vector<OpenSource>> open_sources(const LayerRequest& layer, const SharedReading& shared, int threads) {
  const std::vector<SourceRequest>& requests = layer.sources;
  std::vector<std::optional<OpenSource>> opened(requests.size());
  VT_CHECK(for_each_index(requests.size(), threads, [&](std::size_t i) -> Result<void> {
    VT_ASSIGN(opened[i], open_source(requests[i], layer.channel, shared));
    return {};
  }));
  std::vector<OpenSource> sources;
  sources.reserve(opened.size());
  for (std::optional<OpenSource>& source : opened) sources.push_back(std::move(*source));
  return sources;
}

nlohmann::ordered_json facts_of(const std::vector<OpenSource>& sources) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (sources.size() <= kMostListedSources) {
    for (const OpenSource& source : sources) list.push_back(facts_of_one(source));
    return list;
  }
  store::ContentHasher hasher;
  for (const OpenSource& source : sources) {
    const std::string facts = facts_of_one(source).dump() + '\n';
    hasher.add(std::as_bytes(std::span(facts)));
  }
  const store::ContentHash digest = hasher.digest();
  return {{"count", sources.size()}, {"content", store::content_hash(digest.bytes)}};
}

}  // namespace vt::pipeline
