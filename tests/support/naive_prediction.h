// The section "Prediction" of schemas/tile-store.md as its words go, one value at a time; knows nothing of
// store/. The truth for the naive reader and for the tests of store/codec/prediction.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vt::test {

struct NaivePrediction {
  std::size_t sample_bytes = 1;  // 1, 2 or 4
  bool is_float = false;         // of 2 or 4 bytes
  std::size_t width = 0;
  std::size_t height = 0;
  bool subtracts_green = false;
  std::vector<unsigned> predictors;  // one a channel
};

// Texels from planes, and planes from texels. Throws std::runtime_error on an impossible predictor or a wrong
// size.
[[nodiscard]] std::vector<std::byte> naive_texels(std::span<const std::byte> planes, const NaivePrediction& prediction);
[[nodiscard]] std::vector<std::byte> naive_planes(std::span<const std::byte> texels, const NaivePrediction& prediction);

}  // namespace vt::test
