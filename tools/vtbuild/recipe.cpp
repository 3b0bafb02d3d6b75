#include "tools/vtbuild/recipe.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "builder/text/json_text.h"
#include "store/format/text.h"

namespace vt::tools {
namespace {

constexpr std::string_view kStoreOption = "--output";
constexpr std::array<std::string_view, 11> kWithoutEffect = {"--threads", "--memory", "--progress", "--checkpoint", "--block", "--stats",
                                                             "--json",    "--update", "--dry-run",  "--help",       "--rate"};

bool is_left_out(const std::string& name) {
  return name == kStoreOption || std::ranges::find(kWithoutEffect, name) != kWithoutEffect.end();
}

// Among options it would be taken for one, or for a command.
bool is_taken_for_something_else(const CLI::App& command, const std::string& value) {
  const CLI::App& program = *command.get_parent();
  return value.starts_with('-') || !program.get_subcommands([&](const CLI::App* one) { return one->get_name() == value; }).empty();
}

}  // namespace

nlohmann::ordered_json recipe_of(const CLI::App& command, const std::filesystem::path& store) {
  std::vector<std::string> arguments = {command.get_name()};
  std::vector<std::string> inputs;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_lnames().empty() ? std::string() : "--" + option->get_lnames().front();
    if (is_left_out(name)) continue;
    for (const std::string& value : option->results()) {
      if (name.empty()) {
        inputs.push_back(value);
      } else {
        arguments.push_back(name + "=" + value);
      }
    }
  }
  const bool has_odd_input =
      std::ranges::any_of(inputs, [&](const std::string& input) { return is_taken_for_something_else(command, input); });
  if (has_odd_input) inputs.insert(inputs.begin(), "--");
  arguments.insert(has_odd_input ? arguments.end() : arguments.begin() + 1, inputs.begin(), inputs.end());
  const std::filesystem::path here = std::filesystem::current_path();
  const std::filesystem::path store_folder = std::filesystem::absolute(store).lexically_normal().parent_path();
  const std::filesystem::path folder = here.lexically_relative(store_folder);
  return {{"arguments", arguments}, {"folder", (folder.empty() ? here : folder).generic_string()}};
}

Result<void> check_recipe(const nlohmann::ordered_json& recipe) {
  const auto check = [](const nlohmann::ordered_json& text) -> Result<void> {
    if (store::is_utf8(text.get_ref<const std::string&>())) return {};
    return fail(ErrorCode::kUsage, "\"" + text.get<std::string>() +
                                       "\" is not UTF-8, and a store keeps as text how it was built; rename what is called so, or give "
                                       "another name");
  };
  for (const auto& argument : recipe["arguments"]) VT_CHECK(check(argument));
  return check(recipe["folder"]);
}

Result<Recipe> read_recipe(const std::string& metadata_json, const std::filesystem::path& store) {
  const auto metadata = text::json_or_null(metadata_json);
  const auto invalid = [&] {
    return fail(ErrorCode::kInvalidData,
                store.string() + ": does not say how its layers were built; run the command that built them again, with --update");
  };
  if (!metadata.is_object() || !metadata.contains("recipe")) return invalid();
  const auto& json = metadata["recipe"];
  if (!json.is_object() || !json.contains("arguments") || !json["arguments"].is_array() || !json.contains("folder") ||
      !json["folder"].is_string())
    return invalid();
  Recipe recipe;
  for (const auto& argument : json["arguments"]) {
    if (!argument.is_string()) return invalid();
    recipe.arguments.push_back(argument.get<std::string>());
  }
  // Nothing but the two commands that build layers is ever run from a store.
  if (recipe.arguments.empty() || (recipe.arguments.front() != "layer" && recipe.arguments.front() != "dataset")) return invalid();
  recipe.folder = (std::filesystem::absolute(store).parent_path() / json["folder"].get<std::string>()).lexically_normal();
  return recipe;
}

}  // namespace vt::tools
