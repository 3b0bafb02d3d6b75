// vtinspect info: what a store holds, as a table for people or as JSON (schemas/vtinspect-info.schema.json).
#pragma once

#include <filesystem>

#include "store/result.h"

namespace vt::inspect {

struct InfoOptions {
  std::filesystem::path store;
  bool json = false;
  bool names_only = false;  // the texture layers' names, one a line, for scripts
};

[[nodiscard]] Result<int> run_info(const InfoOptions& options);

}  // namespace vt::inspect
