// Opens or makes the store that layers go into, and keeps the dataset's frame (coordinate reference system,
// area) in its metadata.
#pragma once

#include <filesystem>
#include <optional>

#include "builder/pipeline/plan/layer_plan.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// The frame of an existing store; nullopt when there is no file. Reads only.
[[nodiscard]] Result<std::optional<DatasetFrame>> existing_frame(const std::filesystem::path& path);

// Opens the store for writing, or creates it for `area` in `crs`.
[[nodiscard]] Result<store::StoreWriter> open_or_create(const std::filesystem::path& path, const geo::Crs& crs, const Area& area);

// The smallest rectangle around both.
[[nodiscard]] Area united(const Area& a, const Area& b);

}  // namespace vt::pipeline
