// The subcommands of vtbench. Each adds itself to the program and returns what to run: its exit code, or -1
// when another was chosen.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "store/result.h"
#include "tools/vtbench/report/table.h"

namespace vt::bench {

[[nodiscard]] std::function<Result<int>()> add_build_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_sources_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_sizes_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_mosaic_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_accuracy_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_lookup_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_frame_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_scoreboard_command(CLI::App& app);
[[nodiscard]] std::function<Result<int>()> add_channels_command(CLI::App& app);

// Where results go, the same for every subcommand.
struct ResultFlags {
  std::string csv;
  std::string svg;
  std::string markdown;
  bool json = false;

  void add_to(CLI::App& command, bool has_chart);
  // The table on standard output (as text between `heading` and `remarks`, or as JSON with the machine); the
  // CSV, the Markdown and the chart into their files.
  [[nodiscard]] Result<void> deliver(const std::string& heading, const Table& table, const std::string& svg_text,
                                     const std::string& remarks = "") const;
};

}  // namespace vt::bench
