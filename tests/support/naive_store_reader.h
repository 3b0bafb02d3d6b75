// A second reader for tile stores, written from schemas/tile-store.md alone and kept apart from store/: it
// shares no code, no constant and no type with it. Tests hold the two together; where they differ, the
// document or one of them is wrong. It is slow on purpose: the whole file in memory, nothing remembered
// between lookups, one function for each structure of the document. Section numbers in comments are the
// document's. All of it throws std::runtime_error for whatever a damaged file may hold, because that keeps
// the text close to the document's. Any number of threads may use one reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vt::test {

using NaiveBytes = std::vector<std::byte>;

// Section 4.
struct NaiveReference {
  std::uint64_t offset = 0;
  unsigned kind = 0;
  unsigned codec = 0;
  std::uint32_t stored_bytes = 0;
  std::uint32_t check = 0;
};

// Section 3.
struct NaiveSuperblock {
  NaiveBytes uuid;  // 16 bytes
  std::uint64_t generation = 0;
  std::uint64_t file_end = 0;
  NaiveReference catalog;
  unsigned version = 0;
};

// Section 6: the layer entry, field by field, with its roots and texts.
struct NaiveLayer {
  unsigned id = 0;
  unsigned channel = 0;
  unsigned format = 0;
  unsigned transfer = 0;
  unsigned role = 0;
  unsigned state = 0;
  unsigned tile_exponent = 0;
  unsigned finest = 0;
  unsigned owner = 0;
  std::int64_t data_x = 0;
  std::int64_t data_y = 0;
  std::int64_t data_width = 0;
  std::int64_t data_height = 0;
  double origin_x = 0.0;
  double origin_y = 0.0;
  double step_x = 0.0;
  double step_y = 0.0;
  double source_nodata = 0.0;
  std::uint64_t tiles = 0;
  std::uint64_t constant_tiles = 0;
  std::uint64_t stored_bytes = 0;
  bool is_part = false;
  bool zero_is_nodata = false;
  bool is_point_sampled = false;
  double scale[4] = {1.0, 1.0, 1.0, 1.0};
  double offset[4] = {0.0, 0.0, 0.0, 0.0};
  std::vector<NaiveReference> roots;  // finest + 1 of them, level 0 first
  std::string name;
  std::string metadata_json;  // as in the file, possibly empty
};

struct NaiveCatalog {
  double west = 0.0;
  double south = 0.0;
  double east = 0.0;
  double north = 0.0;
  std::string metadata_json;  // as in the file, possibly empty
  std::vector<NaiveLayer> layers;
};

class NaiveStoreReader {
 public:
  // Both throw when the store is damaged above its index. The first takes the bytes of the whole file.
  explicit NaiveStoreReader(NaiveBytes file);
  [[nodiscard]] static NaiveStoreReader open(const std::filesystem::path& path);

  [[nodiscard]] const NaiveBytes& uuid() const { return superblock_.uuid; }
  [[nodiscard]] std::uint64_t generation() const { return superblock_.generation; }
  [[nodiscard]] const NaiveCatalog& catalog() const { return catalog_; }

  // The decoded bytes of a tile, or nothing when it is absent. Throws when the store has no such layer, or
  // damage on the way.
  [[nodiscard]] std::optional<NaiveBytes> tile(unsigned layer_id, unsigned level, std::uint64_t x, std::uint64_t y) const;

 private:
  NaiveBytes file_;
  NaiveSuperblock superblock_;
  NaiveCatalog catalog_;
};

}  // namespace vt::test
