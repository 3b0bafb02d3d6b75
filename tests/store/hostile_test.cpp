// Damaged and hostile stores: whatever the bytes are, a read gives the right data or an error, and nothing
// crashes (run under the sanitizers).
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <random>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

// Two generations with raw, compressed and constant tiles, a replaced tile (so that there is garbage), and an
// index two pages deep.
struct Victim {
  Bytes bytes;
  Contents truth;
};

Victim make_victim() {
  const TempFolder folder;
  Victim victim;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}, {.sync = false}));
  const LayerInfo color = small_layer("color", TexelFormat::kRgb8, 2, 2);
  const LayerInfo height = small_layer("height", TexelFormat::kR32Float, 3, 6);
  const LayerId color_id = value_of(writer.add_layer(color));
  const LayerId height_id = value_of(writer.add_layer(height));
  Contents& contents = victim.truth;
  for (int version = 0; version < 2; ++version) {
    for (const TileId tile : {tile_at(0, 0, 0), tile_at(1, 1, 0), tile_at(2, 3, 1)}) {
      contents[{"color", tile}] = tile_bytes(color, tile, version);
      succeed(writer.put(color_id, tile, encoded(contents[{"color", tile}])));
    }
    for (const TileId tile : {tile_at(2, 2, 1), tile_at(2, 3, 0)}) {  // equal to another
      contents[{"color", tile}] = contents[{"color", tile_at(2, 3, 1)}];
      succeed(writer.put(color_id, tile, encoded(contents[{"color", tile}])));
    }
    for (int level = 0; level <= 6; ++level) {
      const TileId tile = tile_at(level, version == 0 ? 0 : (1U << level) - 1, 0);
      if (level == 6) {
        Bytes constant(height.tile_payload_bytes());
        for (std::size_t i = 0; i < constant.size(); i += 4) put<std::uint32_t>(constant, i, 0x3F800000);
        succeed(writer.put_constant(height_id, tile, std::span(constant).first(4)));
        contents[{"height", tile}] = constant;
      } else {
        contents[{"height", tile}] = level % 2 == 0 ? tile_bytes(height, tile, version) : smooth_tile_bytes(height, tile);
        succeed(writer.put(height_id, tile, encoded(height, contents[{"height", tile}], {Codec::kZstd, 3})));
      }
    }
    succeed(writer.set_state(color_id, LayerState::kComplete));
    succeed(writer.set_state(height_id, LayerState::kComplete));
    succeed(writer.commit());
  }
  succeed(writer.finish());
  victim.bytes = read_file(folder / "a.vts");
  return victim;
}

// A file in memory whose single bytes can be changed quickly.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::byte> bytes) : fd_(memfd_create("store", 0)) { assign(bytes); }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  void assign(std::span<const std::byte> bytes) const {
    truncate(bytes.size());
    if (pwrite(fd_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) throw std::runtime_error("pwrite");
  }
  void set(std::size_t at, std::byte value) const {
    if (pwrite(fd_, &value, 1, static_cast<off_t>(at)) != 1) throw std::runtime_error("pwrite");
  }
  void truncate(std::size_t bytes) const {
    if (ftruncate(fd_, static_cast<off_t>(bytes)) != 0) throw std::runtime_error("ftruncate");
  }
  [[nodiscard]] std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

// Reads every tile that `truth` names: each is right or an error. Gives the number of errors.
int errors_reading(const StoreReader& reader, const Contents& truth) {
  int errors = 0;
  for (const auto& [name, bytes] : truth) {
    const LayerInfo* layer = reader.find_layer(name.first);
    if (layer == nullptr || layer->tile_payload_bytes() != bytes.size()) {
      ADD_FAILURE() << "layer changed unnoticed";
      return errors;
    }
    Bytes out(bytes.size());
    if (const auto read = reader.read(layer->id, name.second, out); !read) {
      EXPECT_NE(read.error().code, ErrorCode::kNotFound) << read.error().message;
      ++errors;
    } else {
      EXPECT_EQ(out, bytes);
    }
  }
  return errors;
}

std::string summary(const ValidationReport& report) {
  std::string text;
  for (const Finding& finding : report.findings)
    text += std::to_string(finding.number) + " " + finding.place + ": " + finding.sentence + "\n";
  return text;
}

TEST(HostileStore, EveryFlippedByteIsFoundExceptInGarbage) {
  const Victim victim = make_victim();
  const MemoryFile file(victim.bytes);
  const auto clean = value_of(validate(file.path()));
  ASSERT_TRUE(clean.ok()) << summary(clean);
  const std::string clean_summary = summary(clean);
  const std::uint64_t garbage_bytes = victim.bytes.size() - clean.bytes_checked;
  ASSERT_GT(garbage_bytes, 0U);

  for (const std::byte mask : {std::byte{0x01}, std::byte{0x80}, std::byte{0xFF}}) {
    std::uint64_t unnoticed = 0;
    for (std::size_t at = 0; at < victim.bytes.size(); ++at) {
      // The reserved zeros of the superblocks all fall under one hash; one in 64 stands for them.
      if (at < kLogStart && at % kSuperblockBytes > 160 && at % kSuperblockBytes < kSuperblockBytes - 16 && at % 64 != 0) continue;
      file.set(at, victim.bytes[at] ^ mask);
      const bool is_noticed = summary(value_of(validate(file.path()))) != clean_summary;
      unnoticed += is_noticed ? 0 : 1;
      int errors = 0;
      if (const auto reader = StoreReader::open(file.path())) {
        errors = errors_reading(*reader, victim.truth);
        // Either superblock is enough.
        EXPECT_EQ(reader->health(), at < kLogStart ? StoreHealth::kOneSuperblock : StoreHealth::kWhole) << at;
        if (at < kLogStart) {
          EXPECT_EQ(errors, 0) << at;
        }
      } else {
        EXPECT_GE(at, kLogStart);
        ++errors;
      }
      if (errors > 0) {
        EXPECT_TRUE(is_noticed) << at;
      }
      file.set(at, victim.bytes[at]);
    }
    EXPECT_EQ(unnoticed, garbage_bytes);
  }
}

TEST(HostileStore, EveryTruncationIsRefused) {
  const Victim victim = make_victim();
  const MemoryFile file(victim.bytes);
  for (std::size_t size = victim.bytes.size(); size-- > 0;) {
    file.truncate(size);
    const auto reader = StoreReader::open(file.path());
    ASSERT_FALSE(reader) << size;
    ASSERT_TRUE(reader.error().code == ErrorCode::kCorrupt || reader.error().code == ErrorCode::kInvalidData);
    if (size % 7 == 0) {
      ASSERT_FALSE(value_of(validate(file.path())).ok()) << size;
      ASSERT_FALSE(StoreWriter::open(file.path()));
    }
  }
}

TEST(HostileStore, BytesAfterTheEndAreHarmlessAndTheNextWriterRemovesThem) {
  const Victim victim = make_victim();
  Bytes longer = victim.bytes;
  longer.insert(longer.end(), 1000, std::byte{0x5A});
  const MemoryFile file(longer);
  const auto report = value_of(validate(file.path()));
  EXPECT_TRUE(report.ok());
  EXPECT_THAT(summary(report), testing::HasSubstr("108 "));
  EXPECT_EQ(read_all(value_of(StoreReader::open(file.path()))), victim.truth);
  succeed(value_of(StoreWriter::open(file.path())).finish());
  EXPECT_EQ(read_file(file.path()), victim.bytes);
}

// With the checksums made right again, every structure's own checks have to hold: no crash, and reads of the
// right size or an error.
TEST(HostileStore, ChangedFieldsUnderRightChecksumsNeverCrash) {
  const Victim victim = make_victim();
  const MemoryFile file(victim.bytes);
  Bytes same = victim.bytes;
  reseal(same);
  ASSERT_EQ(same, victim.bytes);  // sealing changes nothing by itself
  std::mt19937 random(5);
  int opened = 0;
  int refused = 0;
  const auto attack = [&](const Bytes& bytes) {
    Bytes sealed = bytes;
    reseal(sealed);
    file.assign(sealed);
    static_cast<void>(value_of(validate(file.path())));
    const auto reader = StoreReader::open(file.path());
    if (!reader) {
      ++refused;
      return;
    }
    ++opened;
    for (const LayerInfo& layer : reader->layers()) {
      if (layer.tile_payload_bytes() > (std::size_t{1} << 20)) continue;
      Bytes out(layer.tile_payload_bytes());
      for (const auto& [name, unused] : victim.truth) static_cast<void>(reader->read(layer.id, name.second, out));
    }
  };
  for (std::size_t at = 0; at < victim.bytes.size(); ++at) {
    if (at < kLogStart && at % kSuperblockBytes > 136) continue;
    for (const std::byte value : {victim.bytes[at] ^ std::byte{0x01}, std::byte{0xFF}}) {
      if (value == victim.bytes[at]) continue;
      Bytes changed = victim.bytes;
      changed[at] = value;
      attack(changed);
    }
  }
  for (int i = 0; i < 500; ++i) {  // and several fields at once
    Bytes changed = victim.bytes;
    for (int k = 0; k < 4; ++k) {
      const std::size_t at = kLogStart + random() % (changed.size() - kLogStart);
      changed[at] = static_cast<std::byte>(random());
    }
    attack(changed);
  }
  EXPECT_GT(refused, 500);
  EXPECT_GT(opened, 1000);
}

// Every change that a writer has, to every tile of the store and to a new one. False when it refused.
bool write_to(const std::filesystem::path& path, const Contents& truth, unsigned order) {
  auto writer = StoreWriter::open(path, {.sync = false});
  if (!writer) return false;
  for (const LayerInfo& layer : writer->layers()) {
    if (layer.tile_payload_bytes() > (std::size_t{1} << 16) || layer.holds_blobs()) continue;
    const Bytes block(format_info(layer.format).block_bytes);
    for (const auto& [name, unused] : truth) {
      const TileId tile = name.second;
      if (order % 4 != 0) static_cast<void>(writer->put_constant(layer.id, tile, block));
      if (order % 4 == 1) static_cast<void>(writer->put(layer.id, tile, encoded(tile_bytes(layer, tile, 5))));
      if (order % 4 == 2) static_cast<void>(writer->remove(layer.id, tile));
    }
    if (order % 3 == 0) static_cast<void>(writer->set_metadata(layer.id, R"({"written":true})"));
  }
  LayerInfo carry = small_layer("carry", TexelFormat::kRgba8, 2, 1);
  carry.role = LayerRole::kCarry;
  if (!writer->layers().empty()) carry.owner = writer->layers().back().id;
  static_cast<void>(writer->add_layer(carry));
  static_cast<void>(writer->add_layer(small_layer("new", TexelFormat::kRgb8, 2, 1)));
  if (order % 4 == 3 && !writer->layers().empty()) static_cast<void>(writer->remove_layer(writer->layers().front().id));
  return writer->finish().has_value();
}

// A writer takes up what it finds in a store, and its readers find it again.
TEST(HostileStore, AWriterNeverCommitsWhatItsReaderRefuses) {
  const Victim victim = make_victim();
  const MemoryFile file(victim.bytes);
  // The records that a writer takes up: catalogs and pages.
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at < 136; ++at) places.push_back(at);
  for (std::uint64_t at = kLogStart; at + kRecordHeaderBytes <= victim.bytes.size(); at += kRecordAlignment) {
    const auto type = static_cast<RecordType>(get<std::uint8_t>(victim.bytes, at + 12));
    if (get<std::uint32_t>(victim.bytes, at + 8) != 0x43525456 || (type != RecordType::kCatalog && type != RecordType::kPage)) continue;
    for (std::size_t i = 0; i < kRecordHeaderBytes + get<std::uint32_t>(victim.bytes, at + 20); ++i) places.push_back(at + i);
  }
  int committed = 0;
  int refused = 0;
  unsigned order = 0;
  const auto attack = [&](const Bytes& changed) {
    Bytes sealed = changed;
    reseal(sealed);
    file.assign(sealed);
    const bool opened = StoreReader::open(file.path()).has_value();
    const bool was_valid = value_of(validate(file.path())).ok();
    const bool is_written = write_to(file.path(), victim.truth, order++);
    (is_written ? committed : refused) += 1;
    EXPECT_TRUE(!is_written || opened);
    const auto after = StoreReader::open(file.path());
    EXPECT_EQ(after.has_value(), opened) << (after ? std::string() : after.error().message);
    if (was_valid) {
      EXPECT_TRUE(value_of(validate(file.path())).ok());
    }
  };
  for (const std::size_t at : places) {
    for (const std::byte value : {victim.bytes[at] ^ std::byte{0x01}, std::byte{0xFF}}) {
      if (value == victim.bytes[at]) continue;
      Bytes changed = victim.bytes;
      changed[at] = value;
      ASSERT_NO_FATAL_FAILURE(attack(changed));
      if (HasFailure()) FAIL() << "byte " << at << " is " << std::to_integer<int>(value);
    }
  }
  std::mt19937 random(8);
  for (int i = 0; i < 1000; ++i) {
    Bytes changed = victim.bytes;
    for (int k = 0; k < 3; ++k) changed[places[random() % places.size()]] = static_cast<std::byte>(random());
    ASSERT_NO_FATAL_FAILURE(attack(changed));
    if (HasFailure()) FAIL() << "case " << i;
  }
  EXPECT_GT(committed, 1000);
  EXPECT_GT(refused, 500);
}

// Counts that a forged catalog has too low: each tile that is replaced takes from them what was never there.
TEST(HostileStore, CountsThatAreTooLowStayReadable) {
  const TempFolder folder;
  const auto path = folder / "a.vts";
  const LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 1);
  {
    StoreWriter writer = value_of(StoreWriter::create(path, {}));
    const LayerId id = value_of(writer.add_layer(layer));
    for (std::uint32_t x = 0; x < 2; ++x) succeed(writer.put(id, tile_at(1, x, 0), encoded(tile_bytes(layer, tile_at(1, x, 0)))));
    succeed(writer.finish());
  }
  Bytes bytes = read_file(path);
  const std::uint64_t entry =
      choose_superblock(std::span(bytes).first(kLogStart), bytes.size())->newest.catalog.offset + kRecordHeaderBytes + 48;
  put<std::uint64_t>(bytes, entry + 96, 1);   // tiles
  put<std::uint64_t>(bytes, entry + 104, 1);  // of them constant
  put<std::uint64_t>(bytes, entry + 112, 0);  // bytes
  reseal(bytes);
  write_file(path, bytes);
  ASSERT_TRUE(StoreReader::open(path));
  StoreWriter writer = value_of(StoreWriter::open(path));
  for (std::uint32_t x = 0; x < 2; ++x) succeed(writer.put_constant(LayerId{0}, tile_at(1, x, 0), Bytes(3)));
  succeed(writer.finish());
  const auto reader = StoreReader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(read_all(*reader).size(), 2U);
}

// ---- The structures one by one, in buffers of exact size ----

TEST(Layout, EveryPrefixOfACatalogIsRefused) {
  Catalog catalog;
  for (std::uint16_t i = 0; i < 3; ++i) {
    LayerInfo info = small_layer("layer " + std::to_string(i), TexelFormat::kRgb8, 4, 3);
    info.id = {i};
    info.metadata_json = "{}";
    catalog.layers.push_back({info, std::vector<Reference>(4)});
  }
  const Bytes whole = value_of(encode_catalog(catalog));
  ASSERT_TRUE(decode_catalog(whole, kLogStart, kFormatVersion));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes prefix(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decode_catalog(prefix, kLogStart, kFormatVersion)) << size;
  }
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_catalog(longer, kLogStart, kFormatVersion));
}

TEST(Layout, HugeCountsInACatalogAreRefusedBeforeAnythingIsAllocated) {
  Bytes bytes(48 + 192);
  for (const std::size_t at : {0, 4, 48 + 16}) {
    Bytes huge = bytes;
    put<std::uint32_t>(huge, at, 0xFFFFFFFF);
    EXPECT_FALSE(decode_catalog(huge, kLogStart, kFormatVersion));
  }
}

TEST(Layout, APageGivesBackEveryEntryAndRefusesEveryPrefixAndEveryWrongRank) {
  std::mt19937 random(9);
  const std::uint64_t file_end = std::uint64_t{1} << 40;
  for (const unsigned density : {1U, 3U, 400U, 1023U}) {
    std::vector<Reference> entries(kPageSlots);
    entries[random() % kPageSlots] = {.offset = kLogStart, .stored_bytes = 1, .check = 2, .kind = ReferenceKind::kTile};
    for (Reference& entry : entries) {
      if (random() % 1024 >= density) continue;
      entry = {.offset = kLogStart + 64 * (random() % 1000000U),
               .stored_bytes = static_cast<std::uint32_t>(random() % (kMaxRawBytes + 1)),
               .check = static_cast<std::uint32_t>(random()),
               .kind = random() % 2 == 0 ? ReferenceKind::kTile : ReferenceKind::kConstant};
    }
    const Bytes page = encode_page(entries, 0);
    ASSERT_TRUE(check_page(page, {9}, 0, file_end));
    for (int slot = 0; slot < kPageSlots; ++slot) ASSERT_EQ(page_entry(page, slot), entries[static_cast<std::size_t>(slot)]);
    for (std::size_t size = 0; size < page.size(); size += 1 + size / 64) {
      const Bytes prefix(page.begin(), page.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(check_page(prefix, {9}, 0, file_end));
    }
    for (std::size_t at = 0; at < kPageEntriesAt; ++at) {
      Bytes changed = page;
      changed[at] ^= std::byte{0x10};
      EXPECT_FALSE(check_page(changed, {9}, 0, file_end)) << at;
    }
  }
}

TEST(Layout, APageRefusesEntriesOutsideItsLevelOrTheFile) {
  const Reference good{.offset = kLogStart, .stored_bytes = 100, .check = 0, .kind = ReferenceKind::kTile};
  const std::uint64_t file_end = kLogStart + 192;
  const auto page_with = [](int slot, const Reference& entry, int height) {
    std::vector<Reference> entries(kPageSlots);
    entries[static_cast<std::size_t>(slot)] = entry;
    return encode_page(entries, height);
  };
  EXPECT_TRUE(check_page(page_with(63, good, 0), {3}, 0, file_end));
  EXPECT_FALSE(check_page(page_with(64, good, 0), {3}, 0, file_end));  // level 3 has 64 tiles
  EXPECT_FALSE(check_page(page_with(0, good, 1), {9}, 1, file_end));   // an inner page holds pages
  EXPECT_FALSE(check_page(page_with(0, good, 0), {3}, 0, file_end - 64));
  for (const std::uint64_t offset :
       {std::uint64_t{0}, std::uint64_t{4096}, kLogStart + 32, kLogStart + 128, (std::uint64_t{1} << 48) - 64}) {
    Reference bad = good;
    bad.offset = offset;
    EXPECT_FALSE(check_page(page_with(0, bad, 0), {3}, 0, file_end)) << offset;
  }
  Reference bad = good;
  bad.stored_bytes = kMaxRawBytes + 1;
  EXPECT_FALSE(check_page(page_with(0, bad, 0), {3}, 0, std::uint64_t{1} << 40));
  bad.stored_bytes = kMaxRawBytes;
  EXPECT_TRUE(check_page(page_with(0, bad, 0), {3}, 0, std::uint64_t{1} << 40));
  bad.codec = static_cast<Codec>(7);
  EXPECT_FALSE(check_page(page_with(0, bad, 0), {3}, 0, file_end));
}

TEST(Layout, KeysAndHeightsFollowTheDocument) {
  EXPECT_EQ(top_height({0}), 0);
  EXPECT_EQ(top_height({5}), 0);
  EXPECT_EQ(top_height({6}), 1);
  EXPECT_EQ(top_height({10}), 1);
  EXPECT_EQ(top_height({11}), 2);
  EXPECT_EQ(top_height({23}), 4);
  EXPECT_EQ(usable_slots({0}, 0), 1);
  EXPECT_EQ(usable_slots({5}, 0), 1024);
  EXPECT_EQ(usable_slots({6}, 1), 4);
  EXPECT_EQ(usable_slots({6}, 0), 1024);
  EXPECT_EQ(usable_slots({23}, 4), 64);
  EXPECT_EQ(record_key({0xABC}, {23}, (std::uint64_t{1} << 46) - 1),
            0xABC0000000000000 | (std::uint64_t{23} << 46) | ((std::uint64_t{1} << 46) - 1));
}

}  // namespace
}  // namespace vt::store
