#include "tools/vtbench/inputs/tiled_tiff.h"

#include <array>
#include <cassert>
#include <cstring>

#include "builder/geo/geo_keys.h"
#include "store/io/bytes.h"

namespace vt::bench {
namespace {

constexpr std::uint64_t kFirstTile = 4096;  // after the header, at the start of a page

// Field types of TIFF 6 and BigTIFF.
enum Type : std::uint16_t { kAscii = 2, kShort = 3, kLong = 4, kDouble = 12, kLong8 = 16 };

// One directory with the values that do not fit into it behind it.
class Directory {
 public:
  template <class T>
  void add(std::uint16_t tag, Type type, std::span<const T> values) {
    Entry entry{tag, type, values.size(), std::vector<std::byte>(values.size() * sizeof(T))};
    for (std::size_t i = 0; i < values.size(); ++i) {
      if constexpr (std::is_same_v<T, double>)
        store::put_f64(entry.value, i * sizeof(T), values[i]);
      else
        store::put<std::make_unsigned_t<T>>(entry.value, i * sizeof(T), static_cast<std::make_unsigned_t<T>>(values[i]));
    }
    entries_.push_back(std::move(entry));
  }
  template <class T>
  void add_one(std::uint16_t tag, Type type, T value) {
    add<T>(tag, type, std::span<const T>(&value, 1));
  }

  // The bytes of the directory when it lies at `offset` of the file. Tags have been added in rising order, as
  // TIFF demands.
  [[nodiscard]] std::vector<std::byte> bytes(std::uint64_t offset) const {
    constexpr std::size_t kEntry = 20;
    std::vector<std::byte> out(8 + entries_.size() * kEntry + 8);
    store::put<std::uint64_t>(out, 0, entries_.size());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const Entry& entry = entries_[i];
      const std::size_t at = 8 + i * kEntry;
      store::put<std::uint16_t>(out, at, entry.tag);
      store::put<std::uint16_t>(out, at + 2, entry.type);
      store::put<std::uint64_t>(out, at + 4, entry.count);
      if (entry.value.size() <= 8) {
        std::memcpy(out.data() + at + 12, entry.value.data(), entry.value.size());
        continue;
      }
      out.resize((out.size() + 7) / 8 * 8);
      store::put<std::uint64_t>(out, at + 12, offset + out.size());
      out.insert(out.end(), entry.value.begin(), entry.value.end());
    }
    return out;
  }

 private:
  struct Entry {
    std::uint16_t tag;
    std::uint16_t type;
    std::uint64_t count;
    std::vector<std::byte> value;
  };
  std::vector<Entry> entries_;
};

void add_place(Directory& directory, const TiledTiffSpec& spec) {
  if (spec.transform) {
    const std::array scale = {spec.transform->x_column, -spec.transform->y_row, 0.0};
    const std::array tie = {0.0, 0.0, 0.0, spec.transform->x0, spec.transform->y0, 0.0};
    directory.add<double>(33550, kDouble, scale);
    directory.add<double>(33922, kDouble, tie);
  }
  if (!spec.crs) return;
  const geo::GeoKeyTags keys = geo::geo_keys_from_crs(*spec.crs);
  directory.add<std::uint16_t>(34735, kShort, keys.directory);
  if (!keys.doubles.empty()) directory.add<double>(34736, kDouble, keys.doubles);
  if (!keys.ascii.empty()) directory.add<char>(34737, kAscii, std::span(keys.ascii.c_str(), keys.ascii.size() + 1));
}

std::uint64_t mixed(std::uint64_t value) {  // the finaliser of SplitMix64
  value += 0x9E3779B97F4A7C15U;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31);
}

}  // namespace

Result<TiledTiffWriter> TiledTiffWriter::create(const std::filesystem::path& path, const TiledTiffSpec& spec) {
  assert(spec.width > 0 && spec.height > 0 && spec.tile > 0 && spec.tile % 16 == 0);
  assert(!spec.transform || spec.transform->is_north_up());
  VT_ASSIGN(store::File file, store::File::open(path, store::File::Mode::kCreate));
  return TiledTiffWriter(std::move(file), spec);
}

Result<void> TiledTiffWriter::add_tile(std::span<const std::byte> rgb) {
  assert(rgb.size() == tile_bytes());
  return file_.write_at(kFirstTile + tile_bytes() * stored_++, rgb);
}

Result<void> TiledTiffWriter::finish(std::span<const std::uint32_t> table) {
  assert(table.size() == static_cast<std::size_t>(spec_.columns() * spec_.rows()));
  std::vector<std::uint64_t> offsets(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    assert(table[i] < stored_);
    offsets[i] = kFirstTile + tile_bytes() * table[i];
  }
  const std::vector<std::uint32_t> counts(table.size(), static_cast<std::uint32_t>(tile_bytes()));
  const std::array<std::uint16_t, 3> bits = {8, 8, 8};

  Directory directory;
  directory.add_one<std::uint32_t>(256, kLong, static_cast<std::uint32_t>(spec_.width));   // width
  directory.add_one<std::uint32_t>(257, kLong, static_cast<std::uint32_t>(spec_.height));  // height
  directory.add<std::uint16_t>(258, kShort, bits);
  directory.add_one<std::uint16_t>(259, kShort, 1);  // uncompressed
  directory.add_one<std::uint16_t>(262, kShort, 2);  // RGB
  directory.add_one<std::uint16_t>(277, kShort, 3);  // samples
  directory.add_one<std::uint16_t>(284, kShort, 1);  // interleaved
  directory.add_one<std::uint32_t>(322, kLong, static_cast<std::uint32_t>(spec_.tile));
  directory.add_one<std::uint32_t>(323, kLong, static_cast<std::uint32_t>(spec_.tile));
  directory.add<std::uint64_t>(324, kLong8, offsets);
  directory.add<std::uint32_t>(325, kLong, counts);
  add_place(directory, spec_);

  const std::uint64_t at = kFirstTile + tile_bytes() * stored_;  // a multiple of 8, as tiles are
  VT_CHECK(file_.write_at(at, directory.bytes(at)));
  std::array<std::byte, 16> header{};
  store::put_text(header, 0, "II");
  store::put<std::uint16_t>(header, 2, 43);  // BigTIFF
  store::put<std::uint16_t>(header, 4, 8);   // bytes of an offset
  store::put<std::uint64_t>(header, 8, at);
  VT_CHECK(file_.write_at(0, header));
  return file_.close();
}

std::vector<std::uint32_t> scattered_tiles(std::int64_t columns, std::int64_t rows, std::uint32_t stored) {
  assert(stored >= 3);
  std::vector<std::uint32_t> table(static_cast<std::size_t>(columns * rows));
  for (std::int64_t y = 0; y < rows; ++y)
    for (std::int64_t x = 0; x < columns; ++x) {
      const auto i = static_cast<std::size_t>(y * columns + x);
      auto tile = static_cast<std::uint32_t>(mixed(i) % stored);
      const auto is_beside = [&] {
        return (x > 0 && table[i - 1] == tile) || (y > 0 && table[i - static_cast<std::size_t>(columns)] == tile);
      };
      while (is_beside()) tile = (tile + 1) % stored;
      table[i] = tile;
    }
  return table;
}

}  // namespace vt::bench
