// The folder that a file lies in. Any thread.
#pragma once

#include <filesystem>

#include "store/result.h"

namespace vt::store {

// "." of a name without one.
[[nodiscard]] inline std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

// Makes a name durable that `path` was given or has lost. kIo when the folder cannot be synced, except on
// network file systems that make renames durable themselves.
[[nodiscard]] Result<void> sync_folder_of(const std::filesystem::path& path);

}  // namespace vt::store
