// vtbench: every figure that this project publishes comes out of this program.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "store/io/output_file.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/machine.h"

namespace vt::bench {

void ResultFlags::add_to(CLI::App& command, bool has_chart) {
  command.add_option("--csv", csv, "write the results as CSV into this file");
  if (has_chart) command.add_option("--svg", svg, "write a chart into this file");
  command.add_option("--markdown", markdown, "write the results as a Markdown table into this file");
  command.add_flag("--json", json, "print the results as JSON");
}

Result<void> ResultFlags::deliver(const std::string& heading, const Table& table, const std::string& svg_text,
                                  const std::string& remarks) const {
  const Machine machine = this_machine();
  if (json) {
    nlohmann::ordered_json document;
    document["machine"] = {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory_bytes", machine.memory_bytes}};
    document["subject"] = heading;
    if (!remarks.empty()) document["remarks"] = remarks;
    document["results"] = table.json();
    cli::print_json(document);
  } else {
    cli::print(fmt::format("{}\n{}\n\n{}", heading, machine.text(), table.text()));
    if (!remarks.empty()) cli::print("\n" + remarks);
  }
  if (!markdown.empty())
    VT_CHECK(store::write_whole_file(
        markdown, fmt::format("{}\n\n{}\n\n{}{}{}", heading, machine.text(), table.markdown(), remarks.empty() ? "" : "\n", remarks)));
  if (!csv.empty()) VT_CHECK(store::write_whole_file(csv, table.csv()));
  if (!svg.empty()) VT_CHECK(store::write_whole_file(svg, svg_text));
  return {};
}

}  // namespace vt::bench

int main(int argc, char** argv) {
  CLI::App app("Measures the builder, the store and the renderer on this machine, beside other tools where they are installed.", "vtbench");
  app.set_version_flag("--version", "vtbench " VT_VERSION);
  app.require_subcommand(1);
  const std::vector<std::function<vt::Result<int>()>> commands = {
      vt::bench::add_build_command(app),  vt::bench::add_sources_command(app),    vt::bench::add_sizes_command(app),
      vt::bench::add_mosaic_command(app), vt::bench::add_accuracy_command(app),   vt::bench::add_lookup_command(app),
      vt::bench::add_frame_command(app),  vt::bench::add_scoreboard_command(app), vt::bench::add_channels_command(app),
  };
  vt::cli::add_help_footer(
      app,
      "  vtbench build ortho.tif --csv build.csv --svg build.svg    our builder beside vips, GDAL and maketx\n"
      "  vtbench sources ortho.tif                                  the same samples as TIFFs of all kinds and as PNG\n"
      "  vtbench sizes ortho.tif                                    memory and rate from 0.25 to 16 gigapixels\n"
      "  vtbench scoreboard                                         the cases that pyramid builders get wrong\n"
      "  vtbench mosaic ortho.tif                                   ten thousand files beside one\n"
      "  vtbench accuracy --svg accuracy.svg                        speed against error, every kernel and codec\n"
      "  vtbench lookup                                             nanoseconds to find and to read a tile\n"
      "  vtbench frame area.vts --path glsl                         frame times of a flight\n");
  return vt::cli::run_main(app, argc, argv, [&]() -> vt::Result<int> {
    static_cast<void>(vt::cli::interrupt_flag());  // from here on Ctrl-C lets us clean up
    for (const auto& command : commands) {
      auto code = command();
      if (!code || *code >= 0) return code;
    }
    return vt::fail(vt::ErrorCode::kInternal, "no subcommand ran");
  });
}
