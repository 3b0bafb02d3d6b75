// The cases that pyramid builders get wrong: for each a small raster, the answer by analysis, and how the
// answer is read from a pyramid. Knows nothing of how pyramids are built.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "builder/source/tiff/geotiff_writer.h"

namespace vt::bench {

// One level as numbers: values of our layers, samples of files; NaN where there are no data.
struct LevelValues {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int bands = 0;
  SampleType type = SampleType::kFloat64;  // in the file
  std::vector<double> values;              // bands interleaved

  [[nodiscard]] double at(std::int64_t x, std::int64_t y, int band = 0) const {
    return values[static_cast<std::size_t>((y * width + x) * bands + band)];
  }
};
// Finest first.
using Pyramid = std::vector<LevelValues>;
// The answers of one store, by layer.
using Pyramids = std::map<std::string, Pyramid>;

// How another tool is to be run: `kernel` for gdaladdo -r, arguments for the others; in the words of the
// table.
struct PeerRun {
  std::string label;
  std::vector<std::string> arguments;
};

struct ScoreCase {
  std::string test;
  std::string truth;
  source::GeoTiffSpec raster;
  std::function<double(std::int64_t x, std::int64_t y, int band)> value;
  std::vector<std::pair<std::string, std::vector<std::string>>> ours;  // label, arguments of vtbuild layer
  std::vector<PeerRun> gdal;                                           // of gdaladdo
  std::vector<PeerRun> vips;                                           // of vips tiffsave --pyramid
  std::vector<PeerRun> maketx;
  std::function<std::string(const Pyramid& pyramid)> judge;  // of a peer, and of ours unless judge_ours is there
  std::function<std::string(const Pyramids& layers)> judge_ours;
  std::size_t overviews = 1;  // that the judges look at
};

[[nodiscard]] std::vector<ScoreCase> score_cases();

}  // namespace vt::bench
