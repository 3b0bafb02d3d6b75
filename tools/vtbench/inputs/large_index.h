// A large index without pictures: as many tiles as wanted, all of one of a few values, in a complete pyramid.
// The bulk builder writes it straight into a new store, so that even 10^9 tiles take seconds and the 16 bytes
// a tile that the index takes anyway.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <vector>

#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"

namespace vt::bench {

// A square pyramid: level n has side(n) x side(n) tiles from the north-west corner on, all of them present.
class IndexShape {
 public:
  // The smallest that has `tiles` tiles in all its levels together. At least 1, at most 2^40.
  explicit IndexShape(std::uint64_t tiles);

  [[nodiscard]] Level finest() const { return finest_; }
  [[nodiscard]] std::uint64_t side(Level level) const;
  [[nodiscard]] std::uint64_t tiles() const;
  [[nodiscard]] LayerInfo layer() const;

  // Any tile of any level, each as likely as every other one.
  [[nodiscard]] TileId any_tile(std::mt19937_64& random) const;

  // Calls visit(first, count) for stretches of Morton codes that are all in the level, in ascending order.
  [[nodiscard]] Result<void> for_each_run(Level level, const std::function<Result<void>(std::uint64_t, std::uint64_t)>& visit) const;

 private:
  Level finest_;
  std::uint64_t side_ = 1;
};

// What an image generator asks for that flies over the finest level: random tiles of the five finest levels,
// each within 32 tiles of where the eye is, which goes on by a tile every 16 look-ups and turns round at the
// edge.
[[nodiscard]] std::vector<TileId> flight(const IndexShape& shape, std::size_t count, std::mt19937_64& random);
[[nodiscard]] std::vector<TileId> anywhere(const IndexShape& shape, std::size_t count, std::mt19937_64& random);

// Writes the store, layer "index". `progress` gets tiles done. kIo when the disk has no room for it.
[[nodiscard]] Result<void> write_index(const std::filesystem::path& path, const IndexShape& shape,
                                       const std::function<Result<void>(std::uint64_t done)>& progress);

// Looks once into every leaf page, so that all are in memory and known.
[[nodiscard]] Result<void> warm_index(const store::StoreReader& reader, LayerId layer, const IndexShape& shape);

}  // namespace vt::bench
