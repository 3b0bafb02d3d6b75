// What readers get of a small store's layer: decoded, and by its component ranges.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "store/texel/texel_decoder.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {

// One layer of a store that was built with request_for()'s tiles, its texels as numbers.
class Values {
 public:
  Values(const std::filesystem::path& store, const std::string& name) : tiles_(tiles_of(store, name)) {
    auto reader = store::StoreReader::open(store);
    EXPECT_TRUE(reader.has_value());
    info_ = *reader->find_layer(name);
  }
  [[nodiscard]] const LayerInfo& info() const { return info_; }
  // `steps` levels above the finest.
  [[nodiscard]] std::array<double, 4> at(int steps, std::int64_t x, std::int64_t y) {
    const Level level{static_cast<std::uint8_t>(info_.finest.value - steps)};
    const TileId tile{level, static_cast<std::uint32_t>(x >> 5), static_cast<std::uint32_t>(y >> 5)};
    std::vector<float>& samples = decoded_[tile];
    const std::size_t channels = format_info(info_.format).channels;
    if (samples.empty()) {
      samples.resize(32 * 32 * channels);
      EXPECT_TRUE(tiles_.contains(tile));
      store::decode_texels(info_.format, tiles_.at(tile), 32, 32, samples);
    }
    std::array<double, 4> value{};
    for (std::size_t c = 0; c < channels; ++c) {
      const float sample = samples[static_cast<std::size_t>((y & 31) * 32 + (x & 31)) * channels + c];
      value[c] = info_.components[c].offset + info_.components[c].scale * static_cast<double>(sample);
    }
    return value;
  }

 private:
  Tiles tiles_;
  LayerInfo info_;
  std::map<TileId, std::vector<float>> decoded_;
};

}  // namespace vt::pipeline
