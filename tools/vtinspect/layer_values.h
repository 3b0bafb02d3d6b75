// What vtinspect's subcommands share: opening a store, choosing a layer and a level, decoded texels.
// One thread. Failures are Results that name the file and what would be accepted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "builder/geo/crs.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"
#include "tools/cli/cli_support.h"

namespace vt::inspect {

// --layer and --level as they stand on the command line.
struct LayerChoice {
  std::string layer;         // "" means the only texture layer that is no part
  std::optional<int> level;  // nothing means the finest
};

// A texture or carry layer by name, or by number when no layer has that name. kNotFound: the message lists
// the layers.
[[nodiscard]] Result<const LayerInfo*> choose_layer(const store::StoreReader& reader, const std::string& layer);
// kNotFound: the message gives the layer's levels.
[[nodiscard]] Result<Level> choose_level(const store::StoreReader& reader, const LayerInfo& layer, std::optional<int> level);

// The store's own metadata, an object. kInvalidData names the store and what is wrong with the text.
[[nodiscard]] Result<nlohmann::json> dataset_metadata(const store::StoreReader& reader);
// From the "crs" of the store's metadata; kPixel when there is none. kInvalidData names the store.
[[nodiscard]] Result<geo::Crs> crs_of(const store::StoreReader& reader);

// How decoded texels lie in memory: channels interleaved, bytes or floats. Bytes are codes, of 8-bit formats
// (BC1, BC3 and BC7 too) whose codes are what they mean; floats are values, offset + scale * sample, NaN
// where there are no data.
struct TexelLayout {
  int channels = 0;
  bool is_float = false;
  [[nodiscard]] std::size_t texel_bytes() const { return static_cast<std::size_t>(channels) * (is_float ? sizeof(float) : 1); }
};
[[nodiscard]] TexelLayout layout_of(const LayerInfo& layer);
// The fourth channel says how much of the texel is covered, rather than being one more measured value.
[[nodiscard]] bool has_coverage_channel(const LayerInfo& layer);

// What texels are that no tile holds: what the same texels would be inside a tile that has data elsewhere.
struct AbsentTexels {
  // The class that stands for no data; 0 of shares, and of light without or with its coverage; the height
  // that voids are filled with; of all else NaN, or 0 in bytes.
  float value = 0.0F;
  bool is_data = false;                // filled heights of a complete layer are heights like others
  std::optional<double> code_of_none;  // a value that means "no data" inside tiles as well
};
[[nodiscard]] AbsentTexels absent_texels(const LayerInfo& layer, Level level);

// What a sample of a texel is worth by the layer's range; NaN: no data. `texel` begins with the texel's first
// sample, as decode_texels() (store/texel/texel_decoder.h) gives it.
[[nodiscard]] double value_of(const LayerInfo& layer, std::span<const float> texel, std::size_t component);
// Texels of one tile to TexelLayout. `payload` is tile_payload_bytes() long, `out` tile_texels()^2 texels.
void decode_tile(const LayerInfo& layer, std::span<const std::byte> payload, std::span<std::byte> out);

// Reads rectangles of one level, tile by tile, with no filling from coarser levels.
class LevelReader {
 public:
  LevelReader(const store::StoreReader& reader, const LayerInfo& layer, Level level);

  // `rect` lies inside the level's padded square; `out` is its texels, tightly packed. Where no tile is they
  // are as absent_texels() says, and `is_present` (one entry a texel, may be empty) is 0 unless they are
  // data.
  [[nodiscard]] Result<void> read(const TexelRect& rect, std::span<std::byte> out, std::span<std::uint8_t> is_present);
  // Tiles with any part in `rect` that the store does not hold. kCancelled after Ctrl-C.
  [[nodiscard]] Result<std::uint64_t> count_missing(const TexelRect& rect) const;

 private:
  const store::StoreReader& reader_;
  const LayerInfo& layer_;
  Level level_;
  TexelLayout layout_;
  AbsentTexels absent_;
  std::vector<std::byte> payload_;
  std::vector<std::byte> texels_;
};

// Linear light, 0..1, of every 8-bit sRGB code (IEC 61966-2-1).
[[nodiscard]] const std::array<double, 256>& linear_from_srgb();

[[nodiscard]] std::string_view role_name(LayerRole role);
[[nodiscard]] std::string_view state_name(LayerState state);
[[nodiscard]] std::string_view transfer_name(Transfer transfer);

}  // namespace vt::inspect
