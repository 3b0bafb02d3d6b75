#include "builder/pipeline/input_list.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace vt::pipeline {
namespace {

// World files, pyramids and other companions lie beside rasters: in a folder only these are meant.
constexpr std::string_view kRasterSuffixes[] = {".tif", ".tiff", ".gtiff", ".png",  ".jpg", ".jpeg", ".jp2", ".exr",
                                                ".hdr", ".bmp",  ".tga",   ".webp", ".ppm", ".pgm",  ".pnm"};

bool is_raster_name(const std::filesystem::path& path) {
  std::string suffix = path.extension().string();
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(kRasterSuffixes, suffix) != std::end(kRasterSuffixes);
}

Result<std::vector<std::filesystem::path>> rasters_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (const std::filesystem::directory_iterator end; !error && entry != end; entry.increment(error))
    if (is_raster_name(entry->path()) && !entry->is_directory(error)) files.push_back(entry->path());
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
  std::ifstream file(list);
  if (!file) return fail(ErrorCode::kIo, list.string() + ": the list of inputs cannot be opened: " + std::strerror(errno));
  std::vector<std::filesystem::path> files;
  std::string line;
  while (std::getline(file, line)) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    VT_ASSIGN(const std::vector<std::filesystem::path> more, plain_or_folder(list.parent_path() / line));
    files.insert(files.end(), more.begin(), more.end());
  }
  if (file.bad()) return fail(ErrorCode::kIo, list.string() + ": the list of inputs cannot be read");
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
