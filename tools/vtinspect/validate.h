// vtinspect validate: every finding of store::validate, for people or as JSON
// (schemas/vtinspect-validate.schema.json).
#pragma once

#include <filesystem>

#include "store/result.h"
#include "tools/cli/cli_support.h"

namespace vt::inspect {

struct ValidateCommand {
  std::filesystem::path store;
  bool json = false;
  bool quick = false;        // checksums only, tiles are not unpacked
  std::uint64_t sample = 0;  // not 0: so many tiles only
  std::uint64_t seed = 1;
  cli::ProgressMode progress = cli::ProgressMode::kAuto;
};

// 3 when the store is not valid.
[[nodiscard]] Result<int> run_validate(const ValidateCommand& options);

}  // namespace vt::inspect
