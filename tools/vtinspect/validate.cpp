#include "tools/vtinspect/validate.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "store/validate.h"

namespace vt::inspect {

Result<int> run_validate(const ValidateCommand& options) {
  cli::Progress progress({.mode = options.progress, .title = "validating", .unit = "tiles"});
  progress.update(0);
  store::ValidateOptions validate_options;
  validate_options.decode_tiles = !options.quick;
  validate_options.sample_tiles = options.sample;
  validate_options.seed = options.seed;
  validate_options.progress = [&](std::uint64_t done, std::uint64_t total) {
    progress.set_total(total);
    progress.update(done);
  };
  VT_ASSIGN(const store::ValidationReport report, store::validate(options.store, validate_options));
  progress.set_total(report.tiles_checked);
  progress.finish();

  std::uint64_t errors = 0;
  for (const store::Finding& finding : report.findings) errors += finding.is_error ? 1 : 0;
  const std::uint64_t warnings = report.findings.size() - errors;

  if (options.json) {
    nlohmann::ordered_json json = {
        {"path", options.store.string()},
        {"ok", report.ok()},
        {"tiles_decoded", !options.quick},
        {"sampled", report.is_sampled},
        {"tiles_in_store", report.tiles_in_store},
        {"tiles_checked", report.tiles_checked},
        {"bytes_checked", report.bytes_checked},
        {"garbage_bytes", report.garbage_bytes},
        {"errors", errors},
        {"warnings", warnings},
        {"findings", nlohmann::ordered_json::array()},
    };
    for (const store::Finding& finding : report.findings) {
      json["findings"].push_back({{"number", finding.number},
                                  {"severity", finding.is_error ? "error" : "warning"},
                                  {"place", finding.place},
                                  {"sentence", finding.sentence}});
    }
    cli::print_json(json);
  } else {
    for (const store::Finding& finding : report.findings) {
      cli::print(fmt::format("{} {}: {}: {}\n", finding.is_error ? "error" : "note", finding.number, finding.place, finding.sentence));
    }
    cli::print(fmt::format("{}: {}, {} tiles and {} checked, {} errors, {} notes\n", options.store.string(),
                           report.ok() ? "valid" : "NOT valid", report.tiles_checked, cli::format_bytes(report.bytes_checked), errors,
                           warnings));
    if (report.garbage_bytes > 0)
      cli::print(fmt::format("{} are garbage, left by earlier commits\n", cli::format_bytes(report.garbage_bytes)));
    if (report.is_sampled)
      cli::print(fmt::format("sampled: {} of {} tiles, seed {}; counts and garbage were not checked\n", report.tiles_checked,
                             report.tiles_in_store, options.seed));
  }
  return report.ok() ? 0 : cli::exit_code(ErrorCode::kInvalidData);
}

}  // namespace vt::inspect
