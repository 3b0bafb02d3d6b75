#include "builder/pipeline/sources/open_sources.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <span>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/parallel/error_list.h"
#include "builder/pipeline/parallel/parallel.h"
#include "builder/pipeline/sources/source_place.h"
#include "store/format/text.h"
#include "store/io/content_hash.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// Parts of a file are enough to tell it from another, or from itself before an edit that moved anything: a
// file is read whole only to be built.
constexpr std::uintmax_t kFingerprintPieces = 16;
constexpr std::size_t kFingerprintPieceBytes = std::size_t{4} << 10;

// Hash of the file's length and of evenly spaced pieces, the first and the last bytes among them; of all of
// it when it is small. Content, not clocks: a copied file is the same source.
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
  options.fallback_crs = request.stated_crs ? request.stated_crs : request.fallback_crs;
  options.extent = request.extent;
  // Several values are a colour, which is compared with what is read.
  if (request.nodata.size() == 1) options.nodata = request.nodata.front();
  options.as_numbers = !channels::kind_of(channel).reads_colors;
  options.cache = shared.cache;
  options.files = shared.files;
  options.scratch = shared.scratch;
  VT_ASSIGN(std::unique_ptr<source::RasterSource> raster, source::open_raster(request.path, options));
  const RasterInfo& info = raster->info();
  VT_ASSIGN(geo::Crs crs, crs_of_source(request, info));
  const bool is_pixel = crs.kind() == geo::CrsKind::kPixel;
  if (!info.has_transform && !is_pixel) {
    const std::string why =
        info.place_problem.empty() ? std::string("the file does not say where it lies; give") : info.place_problem + "; or give";
    return fail(ErrorCode::kInvalidData, request.path.string() + ": " + why + " `extent` WEST,SOUTH,EAST,NORTH in units of " + crs.text());
  }
  VT_ASSIGN(std::string fingerprint, content_fingerprint(request.path));
  for (const std::filesystem::path& companion : info.companions) {
    VT_ASSIGN(const std::string beside, content_fingerprint(companion));
    fingerprint += "+" + beside;
  }
  const geo::GeoTransform transform = transform_of(info);
  OpenSource source{request, std::move(raster), std::move(crs), transform, std::move(fingerprint)};
  VT_CHECK(check_place(source));
  return source;
}

}  // namespace

Result<std::vector<OpenSource>> open_sources(const LayerRequest& layer, const SharedReading& shared, int threads) {
  const std::vector<SourceRequest>& requests = layer.sources;
  std::vector<std::optional<OpenSource>> opened(requests.size());
  ErrorList errors(requests.size());
  VT_CHECK(for_each_index(requests.size(), threads, [&](std::size_t i) -> Result<void> {
    auto source = open_source(requests[i], layer.channel, shared);
    if (source) {
      opened[i] = *std::move(source);
    } else {
      errors.set(i, source.error());
    }
    return {};
  }));
  VT_CHECK(errors.result());
  std::vector<OpenSource> sources;
  sources.reserve(opened.size());
  for (std::optional<OpenSource>& source : opened) sources.push_back(std::move(*source));
  return sources;
}

}  // namespace vt::pipeline
