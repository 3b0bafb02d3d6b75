// Appends tiles and layers to a store file and makes them durable. One writer at a time (an advisory lock
// keeps others out); any number of readers beside it. Nothing is visible to readers before commit(); a crash
// at any moment leaves the last commit whole. Threads: put, put_constant, remove, contains, holds,
// holds_constant, read and read_blob may be called from many threads at once, also while one thread is in
// commit(): what was not finished when the commit took its turn belongs to the next one. create, open,
// add_layer, set_* and finish from one thread, alone.
//
// A layer whose texel format is not known, because a newer program wrote it, stays as it is and can be
// removed, whole or tile by tile. To put, hold or read its tiles is kUnsupported.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "store/codec/codec.h"
#include "store/description.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/writer_options.h"

namespace vt::store {

class StoreWriter {
 public:
  // Makes a new store (written beside the target, then renamed into place). kExists when `path` is there
  // already.
  [[nodiscard]] static Result<StoreWriter> create(const std::filesystem::path& path, const StoreDescription& description,
                                                  WriterOptions options = {});
  // Opens the newest whole generation for appending, forgets what was never committed and mends a damaged
  // superblock. kExists when another writer holds it. kCorrupt: also when a later generation may have been
  // committed (StoreReader::health() is kMayBeOlder).
  [[nodiscard]] static Result<StoreWriter> open(const std::filesystem::path& path, WriterOptions options = {});

  StoreWriter(StoreWriter&&) noexcept;
  StoreWriter& operator=(StoreWriter&&) noexcept;
  ~StoreWriter();  // drops what was not committed

  [[nodiscard]] const StoreDescription& description() const;
  // What killed writers of this store had left beside it, and create() or open() removed. Tell your user.
  [[nodiscard]] const std::vector<std::filesystem::path>& removed_leftovers() const;
  [[nodiscard]] std::vector<LayerInfo> layers() const;  // with current counts
  [[nodiscard]] std::optional<LayerInfo> find_layer(std::string_view name) const;

  // The id, counts and state in `info` are ignored; the layer starts kBuilding. kInvalidData when a field is
  // out of its range, kExists for a taken name.
  [[nodiscard]] Result<LayerId> add_layer(const LayerInfo& info);
  // The space is garbage until packed. What the layer owns goes with it: its parts, and its and their carry
  // layers.
  [[nodiscard]] Result<void> remove_layer(LayerId layer);
  [[nodiscard]] Result<void> set_state(LayerId layer, LayerState state);
  [[nodiscard]] Result<void> set_metadata(LayerId layer, std::string metadata_json);

  // Stores one tile as `encode_payload` made it. Replaces an older one of the same name. Tiles of equal
  // payloads that are put while the writer is open share one record (of a very large number of different
  // ones, the recent). kIo on a full disk: the store stays at its last commit. In a layer of blobs a tile is
  // 1 to kMaxRawBytes bytes, raw or zstd, and shares its record with none.
  [[nodiscard]] Result<void> put(LayerId layer, TileId tile, const PayloadView& payload);
  // A tile of one value everywhere: `block` is one texel (or one 4x4 block) of the layer's format. Equal
  // values share one record. kUsage for a layer of blobs.
  [[nodiscard]] Result<void> put_constant(LayerId layer, TileId tile, std::span<const std::byte> block);
  [[nodiscard]] Result<void> remove(LayerId layer, TileId tile);

  [[nodiscard]] bool contains(LayerId layer, TileId tile) const;  // committed or not
  // The tiles of a level one after another, in Morton order, committed or not: the one that follows `after`,
  // the first for nullopt. Empty: no more. Costs the pages of the index that are there, whatever the layer's
  // size.
  [[nodiscard]] Result<std::optional<TileId>> next_tile(LayerId layer, Level level, std::optional<TileId> after) const;
  // The tile is there, committed or not, with exactly these stored bytes. False says nothing more: the same
  // texels may be stored otherwise.
  [[nodiscard]] Result<bool> holds(LayerId layer, TileId tile, const PayloadView& payload) const;
  [[nodiscard]] Result<bool> holds_constant(LayerId layer, TileId tile, std::span<const std::byte> block) const;
  // The decoded texels of a tile, committed or not; `out` is tile_payload_bytes() long. kUsage for a layer of
  // blobs. Uses pread, so it adds nothing to the resident set.
  [[nodiscard]] Result<void> read(LayerId layer, TileId tile, std::span<std::byte> out) const;

  // The bytes of one tile of a layer of blobs, committed or not; `out` takes their length. kUsage for other
  // layers.
  [[nodiscard]] Result<void> read_blob(LayerId layer, TileId tile, std::vector<std::byte>& out) const;

  // Makes everything put so far durable and visible, as one step.
  [[nodiscard]] Result<void> commit();
  // commit(), then closes. Call it: the destructor cannot report. kIo also when the store's name leads to
  // another file by now, or to none.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] std::uint64_t generation() const;  // grows with every commit
  [[nodiscard]] std::uint64_t file_bytes() const;

 private:
  struct Impl;
  explicit StoreWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace vt::store
