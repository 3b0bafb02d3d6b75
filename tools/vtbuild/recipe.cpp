#include "tools/vtbuild/recipe.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "builder/pipeline/request/request_json.h"
#include "builder/text/json_text.h"
#include "store/format/text.h"
#include "tools/vtbuild/layer_flags.h"

namespace vt::tools {
namespace {

using Json = nlohmann::ordered_json;

// Metadata are written with every checkpoint.
constexpr std::size_t kMostSceneRequestBytes = std::size_t{256} << 10;
constexpr std::size_t kMostSceneSources = kMostSceneRequestBytes / 4;  // the shortest takes four bytes

Result<void> check_text(const Json& json) {
  if (json.is_string() && !store::is_utf8(json.get_ref<const std::string&>()))
    return fail(ErrorCode::kUsage, "\"" + json.get<std::string>() +
                                       "\" is not UTF-8, and a store keeps as text how it was built; rename what is called so, or give "
                                       "another name");
  if (json.is_structured())
    for (const Json& part : json) VT_CHECK(check_text(part));
  return {};
}

// The absolute path of a folder, without a trailing slash.
std::filesystem::path whole_path(const std::filesystem::path& folder) {
  const std::filesystem::path path = std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

std::string folder_text(const std::filesystem::path& folder, const std::filesystem::path& store) {
  const std::filesystem::path whole = whole_path(folder);
  const std::filesystem::path relative = whole.lexically_relative(whole_path(store.parent_path()));
  return (relative.empty() ? whole : relative).generic_string();
}

// ---- Command lines: what older stores hold ----

// CLI11 takes arguments from the back.
Result<void> parse(CLI::App& command, std::vector<std::string> arguments) {
  std::ranges::reverse(arguments);
  try {
    command.parse(arguments);
  } catch (const CLI::ParseError& problem) {
    return fail(ErrorCode::kInvalidData, std::string("the command that it was built by is not understood: ") + problem.what());
  }
  return {};
}

// The arguments are the subcommand, then options as --name=value and inputs, which come behind "--" when they
// might be taken for something else.
Result<Recipe> recipe_of_arguments(std::vector<std::string> arguments) {
  const std::string subcommand = arguments.front();
  arguments.erase(arguments.begin());
  Recipe recipe;
  CLI::App command;
  if (subcommand == "layer") {
    LayerFlags flags;
    flags.add_to(command);
    VT_CHECK(parse(command, std::move(arguments)));
    VT_ASSIGN(recipe.asked, asked_request(flags));
  } else {
    std::string scene;
    command.add_option("SCENE", scene)->required();
    VT_CHECK(parse(command, std::move(arguments)));
    recipe.scene = scene;
  }
  return recipe;
}

Result<Recipe> recipe_of_request(const Json& json) {
  Recipe recipe;
  if (json.contains("scene") && json["scene"].is_string()) recipe.scene = json["scene"].get<std::string>();
  if (json.contains("request")) {
    auto asked = pipeline::request_from_json(json["request"], "the request that it was built by");
    // A scene is read again in any case.
    if (!asked && !recipe.scene) return tl::unexpected(std::move(asked).error());
    if (asked) recipe.asked = *std::move(asked);
  }
  return recipe;
}

bool are_arguments(const Json& json) {
  return json.is_array() && !json.empty() && std::ranges::all_of(json, [](const Json& argument) { return argument.is_string(); }) &&
         (json.front() == "layer" || json.front() == "dataset");
}

}  // namespace

Result<Json> recipe_json(const pipeline::LayerRequest& asked, const std::filesystem::path& folder, const std::filesystem::path& store) {
  Json recipe;
  VT_ASSIGN(recipe["request"], pipeline::request_json(asked));
  recipe["folder"] = folder_text(folder, store);
  VT_CHECK(check_text(recipe));
  return recipe;
}

Result<Json> scene_recipe_json(const std::filesystem::path& scene, const pipeline::LayerRequest& asked, const std::filesystem::path& folder,
                               const std::filesystem::path& store) {
  Json recipe = {{"scene", scene.generic_string()}};
  VT_CHECK(check_text(recipe));
  if (asked.sources.size() <= kMostSceneSources) {
    VT_ASSIGN(Json request, pipeline::request_json(asked, scene.parent_path()));
    VT_CHECK(check_text(request));
    if (request.dump().size() <= kMostSceneRequestBytes) recipe["request"] = std::move(request);
  }
  recipe["folder"] = folder_text(folder, store);
  VT_CHECK(check_text(recipe["folder"]));
  return recipe;
}

Result<Recipe> read_recipe(const std::string& metadata_json, const std::filesystem::path& store) {
  const auto metadata = text::json_or_null(metadata_json);
  const Json json = metadata.is_object() && metadata.contains("recipe") ? metadata["recipe"] : Json();
  const auto is_text = [&](const char* name) { return json.contains(name) && json[name].is_string(); };
  const bool is_request = json.is_object() && (is_text("scene") || json.contains("request"));
  const bool is_command = json.is_object() && json.contains("arguments") && are_arguments(json["arguments"]);
  if (!json.is_object() || !is_text("folder") || (!is_request && !is_command))
    return fail(ErrorCode::kInvalidData,
                store.string() + ": does not say how its layers were built; run the command that built them again, with --update");
  auto recipe = is_request ? recipe_of_request(json) : recipe_of_arguments(json["arguments"].get<std::vector<std::string>>());
  if (!recipe) return fail(recipe.error().code, store.string() + ": " + recipe.error().message);
  recipe->folder = (store.parent_path() / json["folder"].get<std::string>()).lexically_normal();
  if (recipe->folder == ".") recipe->folder.clear();
  return recipe;
}

}  // namespace vt::tools
