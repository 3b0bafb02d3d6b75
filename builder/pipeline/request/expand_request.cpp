#include "builder/pipeline/request/expand_request.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "builder/pipeline/request/input_list.h"
#include "builder/pipeline/request/option_files.h"

namespace vt::pipeline {
namespace {

tl::unexpected<Error> at(const std::string& where, const std::string& place, const Error& error) {
  return fail(error.code, where.empty() ? error.message : where + place + ": " + error.message);
}

}  // namespace

Result<std::vector<SourceRequest>> files_of(const SourceRequest& asked, const std::filesystem::path& folder) {
  VT_ASSIGN(std::vector<std::filesystem::path> files, expand_input(asked.path, folder));
  std::vector<SourceRequest> sources(files.size(), asked);
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i].path = std::move(files[i]);
  return sources;
}

Result<LayerRequest> expand_request(LayerRequest asked, const std::filesystem::path& folder, const std::string& where) {
  std::vector<SourceRequest> sources;
  for (std::size_t i = 0; i < asked.sources.size(); ++i) {
    auto files = files_of(asked.sources[i], folder);
    if (!files) return at(where, "/sources/" + std::to_string(i), files.error());
    std::ranges::move(*files, std::back_inserter(sources));
  }
  asked.sources = std::move(sources);
  const auto loaded = load_option_files(asked.channel, folder, asked.options);
  if (!loaded) return at(where, "/options", loaded.error());
  return asked;
}

}  // namespace vt::pipeline
