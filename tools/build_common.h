// What the subcommands of vtbuild share: options that mean the same everywhere, building one planned layer with progress, printing plans and reports.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "builder/pipeline/layer_build.h"
#include "builder/pipeline/layer_plan.h"
#include "tools/cli_support.h"

namespace vt::tools {

struct BuildFlags {
  int threads = 0;
  std::string memory = "512M";
  std::string progress = "auto";
  double checkpoint_seconds = 10.0;
  int block_levels = 0;
  bool dry_run = false;

  void add_to(CLI::App& command);
  // Parsed forms; kUsage when a text makes no sense.
  [[nodiscard]] Result<std::size_t> memory_bytes() const;
  [[nodiscard]] Result<cli::ProgressMode> progress_mode() const;
};

// "512M", "2G", "800000000".
[[nodiscard]] Result<std::size_t> parse_bytes(const std::string& text);
// "a,b,c" into exactly `count` numbers.
[[nodiscard]] Result<std::vector<double>> parse_numbers(const std::string& text, std::size_t count, const std::string& option);

void print_plan(const pipeline::LayerPlan& plan, int threads, std::size_t memory_bytes, int block_levels);

// Builds the layers in order into the store at `path`, made for `area` in the plans' CRS when it does not exist.
[[nodiscard]] Result<int> build_layers(const std::filesystem::path& path, const std::vector<pipeline::LayerPlan>& plans, const Area& area,
                                       const BuildFlags& flags);

// Half of the memory that is left for the sources is what they may keep decoded.
[[nodiscard]] std::size_t source_cache_bytes(std::size_t memory_bytes);

// Each adds its subcommand to the program and returns what to run when it was chosen.
[[nodiscard]] std::function<Result<int>()> add_layer_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_dataset_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_sample_command(CLI::App& app);

}  // namespace vt::tools
