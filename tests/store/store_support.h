// What the store's tests share: small layers, tiles whose content follows from their name, whole files as
// bytes.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/tile_id.h"
#include "tests/support/temp_folder.h"

namespace vt::store::test {

using Bytes = std::vector<std::byte>;

using vt::test::TempFolder;

[[nodiscard]] Bytes read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

[[nodiscard]] inline TileId tile_at(int level, std::uint32_t x, std::uint32_t y) { return {Level{static_cast<std::uint8_t>(level)}, x, y}; }

// The names of a folder's files, sorted.
[[nodiscard]] std::vector<std::string> names_in(const std::filesystem::path& folder);

// A layer whose data fill the padded square.
[[nodiscard]] LayerInfo small_layer(std::string name, TexelFormat format, int tile_exponent, int finest);

// Bytes that differ from tile to tile and from `version` to `version`; half of them repeat, so that zstd has
// something to do.
[[nodiscard]] Bytes tile_bytes(const LayerInfo& layer, TileId tile, int version = 0);
// Without prediction, and with it where that is smaller.
[[nodiscard]] EncodedPayload encoded(std::span<const std::byte> raw, Compression compression = {});
[[nodiscard]] EncodedPayload encoded(const LayerInfo& layer, std::span<const std::byte> raw, Compression compression);
// A tile that any predictor helps with: gentle slopes and a little noise. bc1 and hash128 get tile_bytes().
[[nodiscard]] Bytes smooth_tile_bytes(const LayerInfo& layer, TileId tile);

// What a generation holds: layer name and tile to decoded bytes.
using Contents = std::map<std::pair<std::string, TileId>, Bytes>;
// Every tile of every layer, by asking for all of them. Fails the test on an error.
[[nodiscard]] Contents read_all(const StoreReader& reader);

// The value, or a test failure with the error's sentence and an abort of the test program's current test.
template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}
inline void succeed(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message);
}

}  // namespace vt::store::test
