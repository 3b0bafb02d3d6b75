// Opening a store on behalf of a user, who is told on standard error when what is read may not be the last
// that was written.
#pragma once

#include <filesystem>
#include <string_view>

#include "store/result.h"
#include "store/store_reader.h"

namespace vt::cli {

// `program` begins the line that is printed.
[[nodiscard]] Result<store::StoreReader> open_store(std::string_view program, const std::filesystem::path& path);

// "whole", "one superblock" or "may be older".
[[nodiscard]] std::string_view health_name(store::StoreHealth health);

}  // namespace vt::cli
