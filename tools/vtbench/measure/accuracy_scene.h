// The scene on which speed is set against error: its file, its exact pyramids, and how far the levels of a
// store or of another tool's file are from them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "store/result.h"
#include "tools/vtbench/measure/ideal_pyramid.h"

namespace vt::bench {

inline constexpr std::int64_t kSmallestLevel = 256;  // texels along an edge: the root tile

using Codes = std::vector<std::uint8_t>;  // RGB, tightly packed

// sRGB codes of the built-in scene, `size` texels along an edge.
[[nodiscard]] Codes paint_scene(std::int64_t size);
[[nodiscard]] Result<void> write_scene(const std::filesystem::path& path, const Codes& rgb, std::int64_t size);

// Overviews of the scene; index 0 is half its size, the last one is kSmallestLevel.
struct Truth {
  Codes base;
  std::vector<LightImage> ideal;                             // by a brick wall
  std::map<std::string, std::vector<LightImage>> by_kernel;  // by each kernel's definition
  std::vector<Codes> codes_averaged;                         // the pyramid that most tools make
};
[[nodiscard]] Truth make_truth(Codes base, std::int64_t size, const std::vector<std::string>& kernels);

// The base first, then `overviews` levels. kUnsupported when the layer is neither RGB8 nor BC1.
[[nodiscard]] Result<std::vector<Codes>> levels_of_store(const std::filesystem::path& path, std::size_t overviews);
// The same of a TIFF with overviews, through the `gdal_translate` at `gdal`; `scratch` takes one level at a
// time.
[[nodiscard]] Result<std::vector<Codes>> levels_of_tiff(const std::filesystem::path& path, std::size_t overviews,
                                                        const std::filesystem::path& gdal, const std::filesystem::path& scratch);

struct Errors {
  double base_psnr_code_db = 0.0;
  PyramidError from_ideal;
  std::optional<PyramidError> from_kernel;  // when `kernel` has a pyramid in the truth
};
// `levels` as above, with or without a base (`first_overview` is 1 or 0).
[[nodiscard]] Errors errors_of(const std::vector<Codes>& levels, const Truth& truth, const std::string& kernel,
                               std::size_t first_overview = 1);

}  // namespace vt::bench
