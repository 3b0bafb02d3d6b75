// vtinspect sample: one texel of a layer, found by longitude and latitude, by column and row, or by (u, v);
// JSON in schemas/vtinspect-sample.schema.json.
#pragma once

#include <filesystem>
#include <string>

#include "store/result.h"
#include "tools/vtinspect/layer_values.h"

namespace vt::inspect {

struct SampleOptions {
  std::filesystem::path store;
  LayerChoice choice;
  // Exactly one is not empty.
  std::string lonlat;  // "LON,LAT", degrees on the CRS's own datum; longitudes any number of turns away from the layer's
  std::string texel;   // "X,Y", whole numbers in the level's data rectangle
  std::string uv;      // "U,V"
  bool json = false;
};

// kNotFound (exit code 2) outside the data; the message gives the valid range in the caller's own terms.
[[nodiscard]] Result<int> run_sample(const SampleOptions& options);

}  // namespace vt::inspect
