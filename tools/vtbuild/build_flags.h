// What the subcommands of vtbuild share: options that mean the same everywhere, building one planned layer
// with progress, printing plans and reports.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "builder/pipeline/build/layer_build.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "tools/cli/cli_support.h"

namespace vt::tools {

struct BuildFlags {
  int threads = 0;
  std::string memory = "512M";
  std::string progress = "auto";
  double checkpoint_seconds = 10.0;
  int block_levels = 0;
  bool update = false;
  bool stats = false;
  bool json = false;
  bool dry_run = false;
  double megatexels_per_second = 0.0;  // for --dry-run; 0: not given
  // With --json: what would be printed as a document of its own is added to these instead.
  std::shared_ptr<std::vector<nlohmann::ordered_json>> documents;
  const CLI::App* command = nullptr;  // whose flags these are, see add_to()

  void add_to(CLI::App& app);
  // A library's message with the settings that it names as flags of the command.
  [[nodiscard]] std::string in_flags(std::string_view message) const;
  // Prints what --json asks for, or adds it to `documents`.
  void put_document(nlohmann::ordered_json document) const;
  // Parsed forms; kUsage when a text makes no sense.
  [[nodiscard]] Result<std::size_t> memory_bytes() const;
  [[nodiscard]] Result<cli::ProgressMode> progress_mode() const;
  // The sources of a layer may keep an eighth of the memory decoded, 4 to 128 MiB; their scratch file lies
  // beside the store.
  [[nodiscard]] pipeline::PlanOptions plan_options(std::size_t memory_bytes, const std::filesystem::path& store) const;
};

// "512M", "2G", "800000000".
[[nodiscard]] Result<std::size_t> parse_bytes(const std::string& text);

// Names what a writer of the store has cleared away.
void print_leftovers(const std::vector<std::filesystem::path>& removed);

// Builds the layers in order into the store at `path`, made for `area` in the plans' CRS when it does not
// exist. A plan's sources are closed when its layer is built.
[[nodiscard]] Result<int> build_layers(const std::filesystem::path& path, std::vector<pipeline::LayerPlan> plans, const Area& area,
                                       const BuildFlags& flags);

// Each adds its subcommand to the program and returns what to run when it was chosen.
[[nodiscard]] std::function<Result<int>()> add_layer_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_dataset_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_sample_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_update_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_pack_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_remove_command(CLI::App& app);

}  // namespace vt::tools
