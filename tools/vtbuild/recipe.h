// How a layer was asked for, kept in its metadata (schemas/store-metadata.schema.json) so that `vtbuild
// update STORE` can ask again and `vtinspect compare STORE RASTER` knows how the raster was read. Options
// that do not change what is built are no part of it. Any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"

namespace vt::tools {

struct Recipe {
  // The file that the layer is from. An update reads it again, as it is by then.
  std::optional<std::filesystem::path> scene;
  // The layer as it was asked for (builder/pipeline/request/expand_request.h). Older stores name only the
  // scene.
  std::optional<pipeline::LayerRequest> asked;
  // The folder that paths in both are relative to. It may be relative to the current one.
  std::filesystem::path folder;
};

// The recipe of a layer in `store`, for its metadata. Paths of `asked` are relative to `folder`, which is
// kept relative to the store's folder where that can be said, so that store and sources may move together.
// kUsage: a text is not UTF-8, and metadata are.
[[nodiscard]] Result<nlohmann::ordered_json> recipe_json(const pipeline::LayerRequest& asked, const std::filesystem::path& folder,
                                                         const std::filesystem::path& store);
// The recipe of a layer of a scene. Paths of `asked` are relative to the scene file, the scene's to `folder`.
// A request that is too long is left out, since the scene has it.
[[nodiscard]] Result<nlohmann::ordered_json> scene_recipe_json(const std::filesystem::path& scene, const pipeline::LayerRequest& asked,
                                                               const std::filesystem::path& folder, const std::filesystem::path& store);

// The recipe in a layer's metadata, which may be the command line that older programs kept. kInvalidData when
// there is none, or none that is understood.
[[nodiscard]] Result<Recipe> read_recipe(const std::string& metadata_json, const std::filesystem::path& store);

}  // namespace vt::tools
