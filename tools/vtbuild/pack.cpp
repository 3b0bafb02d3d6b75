// vtbuild pack: a store in streaming order and without garbage.

#include "store/pack.h"

#include <fmt/format.h>

#include <memory>

#include "tools/cli/open_store.h"
#include "tools/vtbuild/build_flags.h"

namespace vt::tools {
namespace {

struct PackFlags {
  std::string store;
  std::string output;
  bool keep_carry = false;
  std::string cold_start = "1M";
  std::string progress = "auto";
};

std::string bytes_saved(const store::PackReport& report) {
  if (report.packed_bytes > report.source_bytes)
    return fmt::format("{} longer", cli::format_bytes(report.packed_bytes - report.source_bytes));
  return fmt::format("{} saved", cli::format_bytes(report.source_bytes - report.packed_bytes));
}

void print_report(const PackFlags& flags, const store::PackReport& report) {
  const std::string where = flags.output.empty() ? flags.store : flags.store + " -> " + flags.output;
  cli::print(fmt::format("{}: {} tiles, {} (before: {}, {})\n", where, report.tiles, cli::format_bytes(report.packed_bytes),
                         cli::format_bytes(report.source_bytes), bytes_saved(report)));
  cli::print(fmt::format("  cold start   {} at the front of the file\n", cli::format_bytes(report.cold_start_bytes)));
  for (const auto& layer : report.layers)
    cli::print(layer.cold_levels == 0 ? fmt::format("    {}: no level fits\n", layer.name)
                                      : fmt::format("    {}: levels 0 to {}\n", layer.name, layer.cold_levels - 1));
  for (const std::string& name : report.dropped_layers)
    cli::print(fmt::format("  left out     {} (a builder's working state; --keep-carry takes it along)\n", name));
}

Result<int> run(const PackFlags& flags) {
  VT_ASSIGN(const cli::ProgressMode mode, cli::progress_mode_from_name(flags.progress));
  cli::Progress progress({.mode = mode, .title = "packing", .unit = "tiles"});
  store::PackOptions options;
  options.keep_carry = flags.keep_carry;
  VT_ASSIGN(options.cold_start_bytes, parse_bytes(flags.cold_start));
  options.cancel = &cli::interrupt_flag();
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    progress.set_total(total);
    progress.update(done);
  };
  const auto pack = [&]() -> Result<store::PackReport> {
    if (flags.output.empty()) return store::pack_in_place(flags.store, options);
    VT_ASSIGN(const store::StoreReader reader, cli::open_store("vtbuild", flags.store));
    return store::pack(reader, flags.output, options);
  };
  VT_ASSIGN(const store::PackReport report, pack());
  progress.set_total(report.tiles);
  progress.finish();
  print_leftovers(report.removed_leftovers);
  print_report(flags, report);
  return 0;
}

}  // namespace

std::function<Result<int>()> add_pack_command(CLI::App& app) {
  auto flags = std::make_shared<PackFlags>();
  CLI::App* command = app.add_subcommand(
      "pack", "write a store anew without garbage and in the order in which it is streamed; tiles keep their bytes and are checked");
  command->add_option("STORE", flags->store, "the store")->required();
  command->add_option("-o,--output", flags->output,
                      "the new store (default: a file beside STORE that takes its place when it is whole; needs room for both)");
  command->add_flag("--keep-carry", flags->keep_carry,
                    "also take along the builder's working state (NAME/carry, NAME/sources), which is needed to update a layer");
  command
      ->add_option("--cold-start", flags->cold_start,
                   "most bytes at the front of the file for what a reader needs first: upper index and coarsest tiles")
      ->capture_default_str();
  command->add_option("--progress", flags->progress, "auto, plain or none")->capture_default_str();
  cli::add_help_footer(*command,
                       "  vtbuild pack area.vts -o delivery.vts          a store to hand out; area.vts stays as it is\n"
                       "  vtbuild pack area.vts --keep-carry             frees the garbage, can still be updated\n"
                       "  vtbuild pack area.vts -o web.vts --cold-start 256K\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::tools
