#include "builder/pipeline/blocks/dataset_store.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "builder/text/json_text.h"
#include "store/store_reader.h"

namespace vt::pipeline {

Result<std::optional<DatasetFrame>> existing_frame(const std::filesystem::path& path) {
  for (const char* suffix : {".tif", ".tiff", ".png", ".jpg", ".jpeg", ".exr", ".jp2", ".json"})
    if (path.extension() == suffix)
      return fail(ErrorCode::kUsage,
                  path.string() + ": a store is wanted here, with the suffix .vts; " + suffix + " is the suffix of something else");
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
