// From what was asked for to what is built: the inputs of a request become files, and its options that name
// files what the files hold. A request is kept and written as it was asked for, so that a folder that has
// more rasters tomorrow is read anew.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"

namespace vt::pipeline {

// The sources that one of `asked` stands for, all read in the same way: see input_list.h. Paths are relative
// to `folder`.
[[nodiscard]] Result<std::vector<SourceRequest>> files_of(const SourceRequest& asked, const std::filesystem::path& folder);

// A request that can be planned. `where` is the place of the request in a document that messages name, or
// empty. kIo, kInvalidData.
[[nodiscard]] Result<LayerRequest> expand_request(LayerRequest asked, const std::filesystem::path& folder, const std::string& where = {});

}  // namespace vt::pipeline
