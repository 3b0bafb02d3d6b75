// All levels of a layer on one sheet, so that one look shows whether the pyramid hangs together.
#pragma once

#include <filesystem>
#include <string>

#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"

namespace vt::inspect {

// Writes a PNG with one cell a level, coarsest first. A level that fits into a cell is shown whole, enlarged
// by a whole factor; of a larger one the cell shows the texels around the middle, one to one. Returns a
// sentence that says what is on the sheet.
[[nodiscard]] Result<std::string> write_mosaic(const store::StoreReader& reader, const LayerInfo& layer,
                                               const std::filesystem::path& output);

}  // namespace vt::inspect
