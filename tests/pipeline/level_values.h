// One level of a layer, whole, as values in the channel's unit.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "store/store_reader.h"
#include "store/texel/texel_decoder.h"

namespace vt::pipeline {

// Positions count from the data rectangle's north-west corner. Absent tiles are void.
class LevelValues {
 public:
  LevelValues(const store::StoreReader& reader, const LayerInfo& layer, Level level)
      : data_(layer.data_rect(level)), channels_(format_info(layer.format).channels) {
    values_.assign(static_cast<std::size_t>(data_.width * data_.height) * channels_, std::numeric_limits<double>::quiet_NaN());
    const auto edge = static_cast<std::int64_t>(layer.tile_texels());
    std::vector<std::byte> payload(layer.tile_payload_bytes());
    std::vector<float> samples(static_cast<std::size_t>(edge * edge) * channels_);
    const TexelRect tiles = layer.tile_rect(level);
    for (std::int64_t ty = tiles.y; ty < tiles.bottom(); ++ty)
      for (std::int64_t tx = tiles.x; tx < tiles.right(); ++tx) {
        const TileId tile{level, static_cast<std::uint32_t>(tx), static_cast<std::uint32_t>(ty)};
        const auto read = reader.read(layer.id, tile, payload);
        if (!read) {
          EXPECT_EQ(read.error().code, ErrorCode::kNotFound) << read.error().message;
          continue;
        }
        store::decode_texels(layer.format, payload, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge), samples);
        const TexelRect rect = intersect({tx * edge, ty * edge, edge, edge}, data_);
        for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
          for (std::int64_t x = rect.x; x < rect.right(); ++x) {
            const float* texel = &samples[static_cast<std::size_t>((y - ty * edge) * edge + (x - tx * edge)) * channels_];
            if (layer.zero_is_nodata && texel[0] == 0.0F) continue;
            for (std::size_t c = 0; c < channels_; ++c)
              values_[index(x - data_.x, y - data_.y) + c] =
                  layer.components[c].offset + layer.components[c].scale * static_cast<double>(texel[c]);
          }
      }
  }

  [[nodiscard]] std::int64_t width() const { return data_.width; }
  [[nodiscard]] std::int64_t height() const { return data_.height; }
  [[nodiscard]] double at(std::int64_t x, std::int64_t y, std::size_t component = 0) const { return values_[index(x, y) + component]; }
  [[nodiscard]] bool is_void(std::int64_t x, std::int64_t y) const { return std::isnan(at(x, y)); }

 private:
  [[nodiscard]] std::size_t index(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(y * data_.width + x) * channels_;
  }

  TexelRect data_;
  std::size_t channels_;
  std::vector<double> values_;
};

}  // namespace vt::pipeline
