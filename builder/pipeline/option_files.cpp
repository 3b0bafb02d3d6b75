#include "builder/pipeline/option_files.h"

#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace vt::pipeline {
namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 20;

Result<std::string> read_text(const std::filesystem::path& path, const std::string& option) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error) return fail(ErrorCode::kIo, path.string() + ": " + error.message() + "; option " + option + " names it");
  if (bytes > kMostBytes)
    return fail(ErrorCode::kIo, path.string() + ": has " + std::to_string(bytes) + " bytes, option " + option + " takes at most 1 MiB");
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return fail(ErrorCode::kIo, path.string() + ": cannot be read; option " + option + " names it");
  return text;
}

}  // namespace

Result<void> load_option_files(ChannelType channel, const std::filesystem::path& folder, channels::Options& options) {
  for (const channels::OptionInfo& info : channels::all_options()) {
    const auto given = options.find(std::string(info.name));
    if (info.channel != channel || !info.is_file || given == options.end()) continue;
    VT_ASSIGN(given->second, read_text(folder / given->second, given->first));
  }
  return {};
}

}  // namespace vt::pipeline
