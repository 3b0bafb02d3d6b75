// Channel options that name files: what a layer is built from, and what decides its bytes, is their content.
#pragma once

#include <filesystem>

#include "builder/channels/all_channels.h"
#include "store/result.h"

namespace vt::pipeline {

// Replaces the paths in `options`, relative to `folder`, by what the files hold. kIo: a file cannot be read,
// or has more than 1 MiB.
[[nodiscard]] Result<void> load_option_files(ChannelType channel, const std::filesystem::path& folder, channels::Options& options);

}  // namespace vt::pipeline
