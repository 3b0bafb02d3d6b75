// Writes the sample scene: imagery, elevation, materials, lights and the SCENE.json that builds a store from
// them. Everything is made up, nothing is copied, and all of it fits together on the ground. The same seed
// gives the same bytes on every machine and with any number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "store/result.h"

namespace vt::sample {

constexpr std::int64_t kMinSampleSize = 16;
constexpr std::int64_t kMaxSampleSize = 65536;

struct SampleOptions {
  std::int64_t size = 4096;  // texels along one side of the imagery, 0.5 m each: a multiple of 8 between the limits above
  std::uint64_t seed = 1;
  bool replace_anything = false;                  // also files of these names that are none of a sample scene
  std::function<bool(double fraction)> progress;  // called from the calling thread; false cancels
};

// Writes imagery.tif, elevation.tif, materials.tif, materials.json, lights.json and SCENE.json into `dir`,
// which is made when it is missing. Whatever the size, the middle of the scene is the same place: a larger
// scene shows more of the same world. Memory grows with the width only (a band of 256 rows). Uses the threads
// of the TBB arena that it is called in. kUsage: the size. kIo: the folder or a file. kExists: the folder has
// a file of one of these names that was not made here, or changed since: SCENE.json is written last, so
// whatever is younger than a sample scene's SCENE.json is somebody's work. kCancelled: `progress` said so;
// files that were not finished are gone.
[[nodiscard]] Result<void> write_sample_scene(const std::filesystem::path& dir, const SampleOptions& options);

}  // namespace vt::sample
