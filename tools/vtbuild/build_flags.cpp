#include "tools/vtbuild/build_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "builder/pipeline/blocks/built_layer.h"
#include "builder/pipeline/blocks/dataset_store.h"
#include "builder/pipeline/build/build_memory.h"
#include "builder/pipeline/parallel/parallel.h"
#include "builder/pipeline/plan/build_state.h"
#include "builder/pipeline/plan/settings_difference.h"
#include "tools/cli/setting_names.h"
#include "tools/vtbuild/print_plan.h"
#include "tools/vtbuild/print_report.h"

namespace vt::tools {

void BuildFlags::add_to(CLI::App& app) {
  command = &app;
  app.add_option("--threads", threads, "worker threads (default: one per processor)")->check(CLI::Range(1, 1024));
  app.add_option("--memory", memory, "most memory to use, for example 512M or 2G")->capture_default_str();
  app.add_option("--progress", progress, "auto (a bar on a terminal, lines elsewhere), plain or none")->capture_default_str();
  app.add_option("--checkpoint", checkpoint_seconds,
                 "seconds between checkpoints; at most this much work is lost when the program is killed")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 86400.0));
  app.add_option("--block", block_levels,
                 "a block of work spans 2^N tiles along an edge (default: from --memory); never changes the result")
      ->check(CLI::Range(1, 10));
  app.add_flag("--update", update, "compare layers that are there with their sources (all of them are read) and build again what changed");
  app.add_flag("--stats", stats, "say where the time went");
  app.add_flag("--json", json, "print what was done (or, with --dry-run, what would be) as JSON");
  app.add_flag("--dry-run", dry_run, "print levels, tiles, bytes, memory and time; build nothing");
  app.add_option("--rate", megatexels_per_second, "million texels a second that --dry-run reckons with (default: 10 a thread)")
      ->check(CLI::Range(1e-3, 1e6));
}

std::string BuildFlags::in_flags(std::string_view message) const {
  return command == nullptr ? std::string(message) : cli::with_flags(message, *command);
}

void BuildFlags::put_document(nlohmann::ordered_json document) const {
  if (documents) {
    documents->push_back(std::move(document));
  } else {
    cli::print_json(document);
  }
}

Result<std::size_t> parse_bytes(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string suffix(end, static_cast<const char*>(text.data() + text.size()));
  double scale = 0.0;
  if (suffix.empty() || suffix == "B") scale = 1.0;
  if (suffix == "K" || suffix == "KiB") scale = 1024.0;
  if (suffix == "M" || suffix == "MiB") scale = 1024.0 * 1024.0;
  if (suffix == "G" || suffix == "GiB") scale = 1024.0 * 1024.0 * 1024.0;
  const double bytes = value * scale;
  if (error != std::errc{} || !(bytes >= 1.0) || bytes > 9e18)
    return fail(ErrorCode::kUsage, "'" + text + "' is not an amount of memory; write for example 512M or 2G");
  return static_cast<std::size_t>(bytes);
}

void print_leftovers(const std::vector<std::filesystem::path>& removed) {
  for (const std::filesystem::path& path : removed)
    cli::print_note("vtbuild", "removed " + path.string() + ", which a program that was stopped had left");
}

Result<std::size_t> BuildFlags::memory_bytes() const { return parse_bytes(memory); }

Result<cli::ProgressMode> BuildFlags::progress_mode() const { return cli::progress_mode_from_name(progress); }

pipeline::PlanOptions BuildFlags::plan_options(std::size_t memory_bytes, const std::filesystem::path& store) const {
  return {.may_lack_sources = dry_run,
          .source_cache_bytes = pipeline::source_cache_bytes(memory_bytes),
          .threads = threads,
          .scratch_folder = store.has_parent_path() ? store.parent_path() : "."};
}

namespace {

// One layer with its progress bars. Messages say how to go on after a stop.
Result<pipeline::BuildReport> build_one(store::StoreWriter& writer, const std::filesystem::path& path, const pipeline::LayerPlan& plan,
                                        const BuildFlags& flags, cli::ProgressMode mode, pipeline::BuildOptions options) {
  cli::Progress check({.mode = mode, .title = "comparing " + plan.info.name, .unit = "blocks"});
  cli::Progress build({.mode = mode, .title = "building " + plan.info.name, .unit = "texels"});
  options.check_progress = [&](std::uint64_t done, std::uint64_t total) {
    check.set_total(total);
    check.update(done);
  };
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    build.set_total(total);
    build.update(done);
  };
  options.cancel = &cli::interrupt_flag();
  options.remark = [&](const std::string& remark) { cli::print_note("vtbuild", flags.in_flags(remark)); };
  auto report = pipeline::build_layer(writer, plan, options);
  if (!report && report.error().code == ErrorCode::kCancelled)
    return fail(ErrorCode::kCancelled, "stopped; what is done is kept in " + path.string() + ", run the same command again to go on");
  if (!report && report.error().code == ErrorCode::kIo)
    return fail(ErrorCode::kIo,
                report.error().message + "; the store is whole up to its last checkpoint, run the same command again to go on");
  if (report && !report->was_complete) build.finish();
  return report;
}

// A store that was made for data which cannot be built would only be in the way of the next command: its area
// and its coordinates are theirs.
void remove_if_empty(const store::StoreWriter& writer, const std::filesystem::path& path) {
  const auto holds_work = pipeline::holds_built_work(writer);
  if (!holds_work || *holds_work) return;
  std::error_code problem;
  if (std::filesystem::remove(path, problem)) cli::print_note("vtbuild", path.string() + " is not kept, since nothing was built");
}

// What an update would find, as far as can be told without reading samples.
std::string update_outlook(const pipeline::LayerPlan& plan, const std::optional<pipeline::DatasetFrame>& frame) {
  const std::string layer = "layer '" + plan.info.name + "': ";
  if (!frame || !frame->layers.contains(plan.info.name)) return layer + "is not in the store; all of it would be built";
  if (plan.settings.is_null()) return layer + "its sources are not there, so nothing can be said of what has changed";
  const pipeline::BuildState state = pipeline::state_of(frame->layers.at(plan.info.name));
  if (!state.is_ours) return layer + "does not say what it was built with, and an update refuses it";
  const std::string settings = pipeline::settings_difference(state.settings, plan.settings);
  if (!settings.empty()) return layer + "was built with other settings (" + settings + "), which an update refuses";
  const std::string sources =
      pipeline::source_difference(state.settings.value("sources", nlohmann::ordered_json()), plan.settings["sources"]);
  return layer +
         (sources.empty() ? "by a look at a few pieces of each file its sources are as they were"
                          : "its sources differ from those that it was built from (" + sources + ")") +
         "; a plan reads no samples: an update compares all of them and builds again only the blocks where they have changed. What follows "
         "is "
         "the plan of all of the layer";
}

}  // namespace

Result<int> build_layers(const std::filesystem::path& path, std::vector<pipeline::LayerPlan> plans, const Area& area,
                         const BuildFlags& flags) {
  VT_ASSIGN(const std::size_t memory, flags.memory_bytes());
  VT_ASSIGN(const cli::ProgressMode mode, flags.progress_mode());
  const int threads = pipeline::thread_count(flags.threads);
  if (flags.dry_run && flags.update) {
    VT_ASSIGN(const auto frame, pipeline::existing_frame(path));
    for (pipeline::LayerPlan& plan : plans) plan.warnings.push_back(update_outlook(plan, frame));
  }
  for (pipeline::LayerPlan& plan : plans)
    for (std::string& warning : plan.warnings) {
      warning = flags.in_flags(warning);
      cli::print_note("vtbuild", warning);
    }

  // All that can be wrong with the request is found before a store is made for it.
  std::vector<int> block_levels(plans.size(), flags.block_levels);
  if (flags.block_levels == 0) {
    auto chosen = pipeline::choose_block_levels(plans, threads, memory);
    // A plan is there to show what is needed; a build that does not fit is refused.
    if (!chosen && !flags.dry_run) return tl::unexpected(chosen.error());
    for (std::size_t i = 0; i < plans.size(); ++i)
      block_levels[i] =
          chosen ? (*chosen)[i]
                 : pipeline::choose_block_levels(plans[i], threads, memory).value_or(pipeline::cheapest_block_levels(plans[i], threads));
  }
  const PlanContext context{
      .threads = threads, .memory_bytes = memory, .megatexels_per_second = flags.megatexels_per_second, .command = flags.command};
  for (const std::string& doubt : plan_doubts(plans, block_levels, context)) cli::print_note("vtbuild", doubt);
  if (flags.dry_run) {
    if (flags.json) {
      flags.put_document(plan_json(path, plans, block_levels, context));
    } else {
      for (std::size_t i = 0; i < plans.size(); ++i) print_plan(plans[i], block_levels[i], context);
    }
    return 0;
  }

  std::error_code unknown;
  const bool is_new = !std::filesystem::exists(path, unknown);
  VT_ASSIGN(store::StoreWriter writer, pipeline::open_or_create(path, plans.front().crs, area));
  print_leftovers(writer.removed_leftovers());
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < plans.size(); ++i) {
    pipeline::LayerPlan& plan = plans[i];
    const pipeline::BuildOptions options{.threads = threads,
                                         .memory_bytes = memory,
                                         .block_levels = block_levels[i],
                                         .checkpoint_seconds = flags.checkpoint_seconds,
                                         .update = flags.update,
                                         .with_stats = flags.stats};
    auto built = build_one(writer, path, plan, flags, mode, options);
    if (!built) {
      if (is_new && pipeline::is_of_the_data(built.error().code)) remove_if_empty(writer, path);
      return tl::unexpected(std::move(built).error());
    }
    pipeline::BuildReport report = *std::move(built);
    for (std::string& remark : report.remarks) {
      remark = flags.in_flags(remark);
      cli::print_note("vtbuild", remark);
    }
    plan.sampler.reset();  // closes the sources: what they keep decoded is memory that the next layer may need
    if (flags.json) {
      layers.push_back(report_json(plan, report, flags.stats));
    } else {
      print_report(plan, report, flags.stats);
    }
  }
  VT_CHECK(writer.finish());
  if (flags.json) flags.put_document(report_document(path.string(), std::move(layers)));
  return 0;
}

}  // namespace vt::tools
