#include "builder/pipeline/blocks/dataset_store.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "builder/source/raster_format.h"
#include "builder/text/json_text.h"
#include "store/store_reader.h"

namespace vt::pipeline {

Result<std::optional<DatasetFrame>> existing_frame(const std::filesystem::path& path) {
  const bool is_named_as_raster = std::ranges::any_of(
      source::raster_formats(), [&](const source::RasterFormat& format) { return format.open != nullptr && format.has_suffix(path); });
  if (is_named_as_raster || path.extension() == ".json")
    return fail(ErrorCode::kUsage, path.string() + ": a store is wanted here, with the suffix .vts; " + path.extension().string() +
                                       " is the suffix of something else");
  std::error_code error;
  const std::filesystem::path folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    return fail(ErrorCode::kIo, path.string() + ": the folder " + folder.string() + " does not exist; make it first");
  const bool exists = std::filesystem::exists(path, error);
  if (error) return fail(ErrorCode::kIo, path.string() + ": " + error.message());
  if (!exists) return std::optional<DatasetFrame>{};
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
  const auto metadata = text::json_or_null(reader.description().metadata_json);
  if (!metadata.is_object() || !metadata.contains("crs"))
    return fail(ErrorCode::kInvalidData,
                path.string() + ": the store's metadata name no coordinate reference system, so nothing can be placed in it");
  auto crs = geo::Crs::from_json(metadata["crs"]);
  if (!crs) return fail(crs.error().code, path.string() + ": metadata /crs: " + crs.error().message);
  DatasetFrame frame{*crs, reader.description().area};
  for (const LayerInfo& layer : reader.layers())
    if (layer.role == LayerRole::kTexture) frame.layers[layer.name] = layer;
  return frame;
}

Result<store::StoreWriter> open_or_create(const std::filesystem::path& path, const geo::Crs& crs, const Area& area) {
  std::error_code error;
  if (std::filesystem::exists(path, error)) return store::StoreWriter::open(path);
  nlohmann::ordered_json metadata;
  metadata["crs"] = crs.to_json();
  metadata["created_by"] = "vtbuild " VT_VERSION;
  auto created = store::StoreWriter::create(path, {area, metadata.dump()});
  // Somebody else made it since we looked: then it is theirs to write, and opening it says so.
  if (!created && created.error().code == ErrorCode::kExists) return store::StoreWriter::open(path);
  return created;
}

Area united(const Area& a, const Area& b) {
  return {std::min(a.west, b.west), std::min(a.south, b.south), std::max(a.east, b.east), std::max(a.north, b.north)};
}

}  // namespace vt::pipeline
