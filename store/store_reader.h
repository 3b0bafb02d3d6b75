// Reads a store: one generation, seen unchanged for the reader's whole life whatever a writer does meanwhile.
// Every byte that comes from the file is checked before use. Const functions may be called from any number of
// threads.
//
// The file is a memory map, so that finding a tile costs no call of the system, reading one no copy, and an
// index of any size no memory of ours. Other programs may cut the file off or overwrite it meanwhile, which
// no writer does: after guard_mappings() (mapping_guard.h), which a program may call, that ends in kIo;
// otherwise it may end in SIGBUS. Read errors of the disk are kIo in the same way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "store/codec/codec.h"
#include "store/description.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::store {

struct Snapshot;  // store/format/snapshot.h

enum class TileKind : std::uint8_t {
  kAbsent,    // never written: use an ancestor
  kStored,    // a record of texels, its own or one that it shares with equal tiles
  kConstant,  // one value everywhere
};

struct TileLookup {
  TileKind kind = TileKind::kAbsent;
  Codec codec = Codec::kRaw;
  std::uint64_t offset = 0;        // of the record in the file
  std::uint32_t stored_bytes = 0;  // of its payload
};

class StoreReader {
 public:
  [[nodiscard]] static Result<StoreReader> open(const std::filesystem::path& path);
  StoreReader(StoreReader&&) noexcept;
  StoreReader& operator=(StoreReader&&) noexcept;
  ~StoreReader();

  [[nodiscard]] const std::filesystem::path& path() const;
  [[nodiscard]] const StoreDescription& description() const;
  [[nodiscard]] std::string uuid() const;          // 8-4-4-4-12 hex digits
  [[nodiscard]] std::uint64_t generation() const;  // grows with every commit
  [[nodiscard]] std::uint64_t file_bytes() const;  // of this generation
  // Whether this is surely the last generation that was committed when the store was opened. Tell your user
  // when it may not be.
  [[nodiscard]] StoreHealth health() const;
  [[nodiscard]] const std::string& health_remark() const;  // a sentence about it; empty when kWhole

  [[nodiscard]] std::span<const LayerInfo> layers() const;  // ordered by id, carry layers included
  [[nodiscard]] const LayerInfo* find_layer(std::string_view name) const;
  [[nodiscard]] const LayerInfo* find_layer(LayerId layer) const;
  // kUnsupported: the layer has a texel format that only newer programs know; its message names both. Every
  // call below fails in this way for such a layer. kUsage: there is no such layer.
  [[nodiscard]] Result<void> check_readable(LayerId layer) const;

  // What was read at open(): for code of this library that copies records as they are. Lives as long as the
  // reader.
  [[nodiscard]] const Snapshot& snapshot() const;

  // kIo when another program has cut off or overwritten the file since it was opened. All that reads says so
  // by itself; this is for whoever wants to know without reading.
  [[nodiscard]] Result<void> check_intact() const;

  // What the index says; does not touch the tile itself. kCorrupt: an index page is damaged.
  [[nodiscard]] Result<TileLookup> lookup(LayerId layer, TileId tile) const;
  // The same for many tiles of a layer, several times as fast in an index that no cache holds: the misses
  // overlap. `out` is as long as `tiles`. After an error `out` holds nothing of use.
  [[nodiscard]] Result<void> lookup_many(LayerId layer, std::span<const TileId> tiles, std::span<TileLookup> out) const;
  // Copies one tile, decompressed and ready for upload, into `out`, which is exactly tile_payload_bytes()
  // long. Constants are expanded. kNotFound: absent, use its ancestor. kCorrupt: its checksum differs.
  // kUsage: a layer of blobs.
  [[nodiscard]] Result<void> read(LayerId layer, TileId tile, std::span<std::byte> out) const;
  // The bytes of one tile of a layer of blobs; `out` takes their length, at most kMaxRawBytes. kUsage for
  // other layers; else as read().
  [[nodiscard]] Result<void> read_blob(LayerId layer, TileId tile, std::vector<std::byte>& out) const;
  // Calls `visit` for every tile of a level that is present, in Morton order; in a sparse level this is
  // cheaper by far than to look every one up. Stops at the first error, its own or that of `visit`. kCorrupt:
  // an index page is damaged.
  [[nodiscard]] Result<void> for_each_tile(LayerId layer, Level level, const std::function<Result<void>(TileId)>& visit) const;
  // The nearest tile at or above `tile` that is present; nullopt when even the root is absent.
  [[nodiscard]] Result<std::optional<TileId>> nearest_present(LayerId layer, TileId tile) const;

 private:
  struct Impl;
  explicit StoreReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace vt::store
