#include "builder/pipeline/request/option_files.h"

#include <string>

#include "builder/text/text_file.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

Result<std::string> read_option(const std::filesystem::path& path, const std::string& option) {
  auto content = text::read_text_file(path, kMostBytes);
  if (!content) return fail(content.error().code, content.error().message + "; option " + option + " names it");
  return content;
}

}  // namespace

Result<void> load_option_files(ChannelType channel, const std::filesystem::path& folder, channels::Options& options) {
  for (const channels::OptionInfo& info : channels::kind_of(channel).options) {
    const auto given = options.find(std::string(info.name));
    if (!info.is_file || given == options.end()) continue;
    VT_ASSIGN(given->second, read_option(folder / given->second, given->first));
  }
  return {};
}

}  // namespace vt::pipeline
