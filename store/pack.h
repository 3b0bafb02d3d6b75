// Packing: a new store file with what the newest generation of another one holds, in the order in which it is
// read, and nothing else. Tiles are copied as they are, also those of a texel format that this program does
// not know, of which it checks the records. Whatever validate() finds in a store that is an error of its
// tiles or its index is found on the way, so that a packed store is a valid one; counts that were wrong are
// right in it. schemas/tile-store.md section 10 has the order.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "store/result.h"
#include "store/store_reader.h"
#include "store/writer_options.h"

namespace vt::store {

struct PackOptions {
  // Carry layers, the builder's own working state, serve to resume and to update a build and nothing else;
  // without this they stay behind.
  bool keep_carry = false;
  // The most that the cold start may take: what lies at the front of the file for a reader that begins with
  // nothing.
  std::uint64_t cold_start_bytes = std::uint64_t{1} << 20;
  std::function<void(std::uint64_t tiles_done, std::uint64_t tiles)> progress = nullptr;
  const std::atomic<bool>* cancel = nullptr;  // when true: kCancelled, and nothing is left behind
  WriterOptions writer;
};

struct PackReport {
  std::uint64_t tiles = 0;
  std::uint64_t source_bytes = 0;  // of the generation that was packed
  std::uint64_t packed_bytes = 0;
  std::uint64_t cold_start_bytes = 0;
  // For every layer in the new store: how many of its levels the cold start holds with all their tiles, from
  // level 0 on.
  struct Layer {
    std::string name;
    int cold_levels = 0;
  };
  std::vector<Layer> layers;
  std::vector<std::string> dropped_layers;               // carry layers that stayed behind
  std::vector<std::filesystem::path> removed_leftovers;  // of killed writers of the same store
};

// Writes what `reader` sees as a new store with a UUID of its own. Memory is a few pages of the index and a
// table of shared records. kExists: `path` is there already. kInvalidData: a texture layer is unfinished.
// kCorrupt: a tile or a page is damaged, does not decode or has no parent, and the message names it. kIo:
// also when the disk has no room. After any error there is no file at `path` and none beside it.
[[nodiscard]] Result<PackReport> pack(const StoreReader& reader, const std::filesystem::path& path, const PackOptions& options = {});

// Packs a store into a file beside it and puts that in its place. The store keeps its UUID, its owner and its
// permissions; its generation goes on. Nobody can write to it meanwhile, and a file that gets its name
// meanwhile keeps it (kExists). Readers that have the old file open keep it. kExists: a writer has the store
// open. kCorrupt: also when StoreReader::health() is kMayBeOlder. After any error the store is as it was.
[[nodiscard]] Result<PackReport> pack_in_place(const std::filesystem::path& path, const PackOptions& options = {});

}  // namespace vt::store
