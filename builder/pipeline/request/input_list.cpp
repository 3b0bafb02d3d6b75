#include "builder/pipeline/request/input_list.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>
#include <system_error>

#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_format.h"
#include "builder/text/text_file.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kMostListBytes = std::size_t{64} << 20;  // longer than any list of files that a machine can open

// Whether a file of a folder is meant: a raster, or one that should be one. World files, pyramids and other
// companions lie beside rasters. Rasters of formats that are not read would be holes in a mosaic if they were
// left out without a word: they are taken along where their content is what their name says, and refused by
// name when they are opened.
bool is_raster(const std::filesystem::path& path) {
  bool may_be = false;
  for (const source::RasterFormat& format : source::raster_formats()) {
    if (!format.has_suffix(path)) continue;
    if (format.open != nullptr && !format.shares_suffix) return true;
    may_be = true;
  }
  if (!may_be) return false;
  const auto file = source::FileBytes::open(path);
  if (!file) return true;  // opening it again will tell why
  const auto format = source::format_of(**file);
  if (!format) return true;
  return *format != nullptr && (*format)->is_raster() && ((*format)->open == nullptr || (*format)->has_suffix(path));
}

Result<std::vector<std::filesystem::path>> rasters_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (const std::filesystem::directory_iterator end; !error && entry != end; entry.increment(error))
    if (!entry->is_directory(error) && is_raster(entry->path())) files.push_back(entry->path());
  if (error) return fail(ErrorCode::kIo, folder.string() + ": the folder cannot be read: " + error.message());
  if (files.empty())
    return fail(ErrorCode::kInvalidData,
                folder.string() + ": no rasters in this folder (.tif, .png, .jpg, ...); folders in it are not entered");
  // The order decides who lies over whom: it must not be the file system's.
  std::ranges::sort(files, {}, [](const std::filesystem::path& path) { return path.filename().string(); });
  return files;
}

Result<std::vector<std::filesystem::path>> plain_or_folder(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return rasters_in(path);
  return std::vector{path};
}

Result<std::vector<std::filesystem::path>> files_of_list(const std::filesystem::path& list) {
  auto text = text::read_text_file(list, kMostListBytes);
  if (!text) return fail(text.error().code, text.error().message + "; @ means a list of inputs");
  std::istringstream file(*std::move(text));
  std::vector<std::filesystem::path> files;
  std::string line;
  while (std::getline(file, line)) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    VT_ASSIGN(const std::vector<std::filesystem::path> more, plain_or_folder(list.parent_path() / line));
    files.insert(files.end(), more.begin(), more.end());
  }
  if (files.empty()) return fail(ErrorCode::kInvalidData, list.string() + ": the list names no inputs; write one file or folder a line");
  return files;
}

}  // namespace

Result<std::vector<std::filesystem::path>> expand_input(const std::filesystem::path& input, const std::filesystem::path& base) {
  const std::string text = input.string();
  if (text.starts_with('@')) return files_of_list(base / text.substr(1));
  return plain_or_folder(base / input);
}

}  // namespace vt::pipeline
