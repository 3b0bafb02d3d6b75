// How a layer was asked for: the subcommand and its arguments, kept in the layer's metadata so that `vtbuild update STORE` can ask again.
// Options that do not change what is built (threads, memory, progress) are left out.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "store/result.h"

namespace vt::tools {

struct Recipe {
  // The subcommand, then options as --name=value and inputs: "layer", "imagery.tif", "--channel=color". Inputs that would be taken for
  // options or commands come last, after "--". Without the store.
  std::vector<std::string> arguments;
  std::filesystem::path folder;  // that paths in the arguments are relative to
  bool operator==(const Recipe&) const = default;
};

// Of a subcommand that has been parsed. `folder` is the current one, relative to the store's where that can be said, so that store and
// sources may move together.
[[nodiscard]] nlohmann::ordered_json recipe_of(const CLI::App& command, const std::filesystem::path& store);

// kUsage: an argument, or the folder, is not UTF-8, and metadata are.
[[nodiscard]] Result<void> check_recipe(const nlohmann::ordered_json& recipe);

// The recipe in a layer's metadata; its folder made absolute. kInvalidData when there is none, or not one of ours.
[[nodiscard]] Result<Recipe> read_recipe(const std::string& metadata_json, const std::filesystem::path& store);

}  // namespace vt::tools
