#include "builder/source/metadata/world_file.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

namespace vt::source {
namespace {

// a.tif: a.tfw, a.tifw, a.wld, in either case.
std::vector<std::filesystem::path> candidates(const std::filesystem::path& raster) {
  const std::string extension = raster.extension().string();  // with its dot
  std::vector<std::string> suffixes;
  if (extension.size() >= 4) suffixes.push_back({'.', extension[1], extension.back(), 'w'});
  if (extension.size() >= 2) suffixes.push_back(extension + 'w');
  suffixes.emplace_back(".wld");
  std::vector<std::filesystem::path> paths;
  for (std::string suffix : suffixes) {
    paths.push_back(std::filesystem::path(raster).replace_extension(suffix));
    for (char& c : suffix) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    paths.push_back(std::filesystem::path(raster).replace_extension(suffix));
  }
  return paths;
}

}  // namespace

Result<std::optional<geo::GeoTransform>> read_world_file(const std::filesystem::path& raster) {
  for (const std::filesystem::path& path : candidates(raster)) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) continue;
    std::ifstream file(path);
    std::array<double, 6> numbers{};
    for (double& number : numbers) {
      std::string word;
      file >> word;
      for (char& c : word) c = c == ',' ? '.' : c;  // decimal commas happen
      const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
      const auto [end, status] = std::from_chars(begin, word.data() + word.size(), number);
      if (word.empty() || status != std::errc{} || end != word.data() + word.size() || !std::isfinite(number)) {
        return fail(ErrorCode::kInvalidData,
                    fmt::format("{}: a world file holds six numbers; found \"{}\"", path.string(), word.substr(0, 40)));
      }
    }
    // The file counts from the centre of the first sample: x step, y per column, x per row, y step, centre x,
    // centre y.
    const auto [x_column, y_column, x_row, y_row, centre_x, centre_y] = numbers;
    geo::GeoTransform transform{.x0 = centre_x - 0.5 * (x_column + x_row),
                                .x_column = x_column,
                                .x_row = x_row,
                                .y0 = centre_y - 0.5 * (y_column + y_row),
                                .y_column = y_column,
                                .y_row = y_row};
    if (!transform.inverse()) return fail(ErrorCode::kInvalidData, fmt::format("{}: all samples fall on one line", path.string()));
    return transform;
  }
  return std::nullopt;
}

}  // namespace vt::source
