// Stores with channels and texel formats that this program does not know, as tests/golden/unknown-numbers.vts
// has them: layers "aspect" (a user's channel, 32769), "later" (channel 4711) and "strange" (format 999, in
// truth rgba8 with tiles of 8 x 8).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/pack.h"
#include "store/region.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;

constexpr auto kStrangeFormat = static_cast<TexelFormat>(999);
constexpr auto kLaterChannel = static_cast<ChannelType>(4711);
constexpr auto kUsersChannel = static_cast<ChannelType>(32769);

struct UnknownNumbers : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";

  UnknownNumbers() { std::filesystem::copy_file(std::filesystem::path(VT_SOURCE_DIR) / "tests/golden/unknown-numbers.vts", path); }

  // The offset of a layer's entry in the file.
  static std::uint64_t entry_of(const Bytes& file, const std::string& name) {
    const Superblock newest = choose_superblock(std::span(file).first(kLogStart), file.size())->newest;
    const std::uint64_t payload = newest.catalog.offset + kRecordHeaderBytes;
    const auto catalog =
        decode_catalog(std::span(file).subspan(payload).first(newest.catalog.stored_bytes), newest.file_end, newest.version);
    for (std::size_t i = 0; i < catalog->layers.size(); ++i)
      if (catalog->layers[i].info.name == name) return payload + 48 + 192 * i;
    throw std::runtime_error("no layer " + name);
  }
  // What a newer program reads, for which 999 is known: here it is rgba8.
  static Contents contents_for_a_newer_program(const std::filesystem::path& store) {
    const TempFolder newer;
    Bytes file = read_file(store);
    const std::uint64_t format = entry_of(file, "strange") + 4;
    EXPECT_EQ(get<std::uint16_t>(file, format), 999);
    put<std::uint16_t>(file, format, static_cast<std::uint16_t>(TexelFormat::kRgba8));
    reseal(file);
    write_file(newer / "newer.vts", file);
    EXPECT_TRUE(value_of(validate(newer / "newer.vts")).ok());
    return read_all(value_of(StoreReader::open(newer / "newer.vts")));
  }
  static void expect_numbers(const std::filesystem::path& store) {
    const StoreReader reader = value_of(StoreReader::open(store));
    EXPECT_EQ(reader.find_layer("aspect")->channel, kUsersChannel);
    EXPECT_EQ(reader.find_layer("later")->channel, kLaterChannel);
    EXPECT_EQ(reader.find_layer("strange")->format, kStrangeFormat);
    EXPECT_TRUE(reader.find_layer("strange")->zero_is_nodata);
    EXPECT_TRUE(value_of(validate(store)).ok());
  }
  template <class T>
  static void expect_unreadable(const Result<T>& result) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(result.error().message, AllOf(HasSubstr("a.vts: layer strange"), HasSubstr("999"), HasSubstr("newer program")));
  }
};

TEST_F(UnknownNumbers, TheStoreOpensAndListsItsLayers) {
  expect_numbers(path);
  const StoreReader reader = value_of(StoreReader::open(path));
  EXPECT_EQ(reader.layers().size(), 5U);
  EXPECT_FALSE(reader.find_layer("strange")->has_known_format());
  EXPECT_EQ(reader.find_layer("strange")->tiles, 3U);
  EXPECT_TRUE(reader.find_layer("later")->has_known_format());
}

TEST_F(UnknownNumbers, TexelsOfAnUnknownChannelAreStillTexels) {
  const StoreReader reader = value_of(StoreReader::open(path));
  for (const std::string name : {"aspect", "later"}) {
    const LayerInfo& layer = *reader.find_layer(name);
    EXPECT_TRUE(reader.check_readable(layer.id));
    Bytes texels(layer.tile_payload_bytes());
    succeed(reader.read(layer.id, {}, texels));
    EXPECT_EQ(texels, tile_bytes(layer, {}));
    Bytes region(texels.size());
    EXPECT_EQ(value_of(read_region(reader, layer.id, {}, {0, 0, 4, 4}, region)).texels_own_level, 16U);
    EXPECT_EQ(region, texels);
  }
}

TEST_F(UnknownNumbers, AnUnknownFormatMakesItsLayerUnreadableAndNoOther) {
  const StoreReader reader = value_of(StoreReader::open(path));
  const LayerId id = reader.find_layer("strange")->id;
  Bytes out(256);
  std::array<TileLookup, 1> lookups;
  expect_unreadable(reader.check_readable(id));
  expect_unreadable(reader.lookup(id, {}));
  expect_unreadable(reader.lookup_many(id, std::array{TileId{}}, lookups));
  expect_unreadable(reader.read(id, {}, out));
  expect_unreadable(reader.read_blob(id, {}, out));
  expect_unreadable(reader.nearest_present(id, tile_at(1, 0, 0)));
  expect_unreadable(reader.for_each_tile(id, {}, [](TileId) { return Result<void>(); }));
  expect_unreadable(read_region(reader, id, {}, {0, 0, 8, 8}, out));

  const LayerInfo& color = *reader.find_layer("color");
  succeed(reader.read(color.id, {}, out));  // the record is one that the two share
  EXPECT_EQ(out, tile_bytes(color, {}));
  succeed(reader.read_blob(reader.find_layer("strange notes")->id, {}, out));
  EXPECT_EQ(out.size(), 5U);
}

TEST_F(UnknownNumbers, TheValidatorRemarksOnThem) {
  for (const std::uint64_t sample : {0, 3}) {
    const ValidationReport report = value_of(validate(path, {.sample_tiles = sample}));
    EXPECT_TRUE(report.ok());
    ASSERT_EQ(report.findings.size(), 3U);
    EXPECT_EQ(report.findings[0].number, 504);
    EXPECT_EQ(report.findings[0].place, "layer aspect");
    EXPECT_THAT(report.findings[0].sentence, AllOf(HasSubstr("32769"), HasSubstr("users")));
    EXPECT_EQ(report.findings[1].number, 504);
    EXPECT_EQ(report.findings[1].place, "layer later");
    EXPECT_THAT(report.findings[1].sentence, AllOf(HasSubstr("4711"), HasSubstr("newer program")));
    EXPECT_EQ(report.findings[2].number, 505);
    EXPECT_EQ(report.findings[2].place, "layer strange");
    EXPECT_THAT(report.findings[2].sentence, AllOf(HasSubstr("999"), HasSubstr("newer program")));
    EXPECT_FALSE(report.is_sampled != (sample > 0));
  }
}

// The last bytes of the tile that is zstd's, of which a reader of the format would only know by decoding it.
TEST_F(UnknownNumbers, DamageInALayerOfAnUnknownFormatIsFound) {
  Bytes file = read_file(path);
  const LayerInfo strange = small_layer("strange", TexelFormat::kRgba8, 3, 1);
  const Bytes wanted = tile_bytes(strange, tile_at(1, 0, 0));
  const auto found = std::search(file.begin(), file.end(), wanted.begin(), wanted.end());
  ASSERT_NE(found, file.end());
  *found ^= std::byte{1};
  write_file(path, file);
  const ValidationReport report = value_of(validate(path));
  EXPECT_FALSE(report.ok());
  EXPECT_EQ(report.findings.back().number, 401);
  EXPECT_EQ(report.findings.back().place, "layer strange, level 1, tile 0,0");
  const auto packed = pack(value_of(StoreReader::open(path)), folder / "packed.vts");
  ASSERT_FALSE(packed);
  EXPECT_EQ(packed.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(packed.error().message, HasSubstr("layer strange, level 1, tile 0,0"));
}

TEST_F(UnknownNumbers, AWriterKeepsNumbersIndexAndTiles) {
  Contents wanted = contents_for_a_newer_program(path);
  {
    StoreWriter writer = value_of(StoreWriter::open(path));
    const LayerInfo color = *writer.find_layer("color");
    const TileId tile = tile_at(1, 0, 1);
    wanted[{"color", tile}] = tile_bytes(color, tile);
    succeed(writer.put(color.id, tile, encoded(wanted[{"color", tile}])));
    const LayerInfo later = *writer.find_layer("later");
    wanted[{"later", tile}] = tile_bytes(later, tile);
    succeed(writer.put(later.id, tile, encoded(wanted[{"later", tile}])));
    succeed(writer.set_metadata(writer.find_layer("strange")->id, R"({"note":1})"));
    succeed(writer.finish());
  }
  expect_numbers(path);
  EXPECT_EQ(contents_for_a_newer_program(path), wanted);
}

TEST_F(UnknownNumbers, AWriterPutsAndReadsNoTilesOfAnUnknownFormat) {
  StoreWriter writer = value_of(StoreWriter::open(path));
  const LayerId id = writer.find_layer("strange")->id;
  Bytes texels(256);
  expect_unreadable(writer.put(id, tile_at(1, 1, 1), encoded(texels)));
  expect_unreadable(writer.put(id, tile_at(1, 1, 1), PayloadView(Codec::kRaw, 0, {})));
  expect_unreadable(writer.put_constant(id, tile_at(1, 1, 1), std::span(texels).first(4)));
  expect_unreadable(writer.put_constant(id, tile_at(1, 1, 1), {}));
  expect_unreadable(writer.read(id, {}, texels));
  expect_unreadable(writer.read_blob(id, {}, texels));
  expect_unreadable(writer.holds(id, {}, encoded(texels)));
  expect_unreadable(writer.holds_constant(id, {}, std::span(texels).first(4)));
  EXPECT_TRUE(writer.contains(id, {}));
  EXPECT_EQ(value_of(writer.next_tile(id, Level{1}, std::nullopt)), tile_at(1, 0, 0));
  succeed(writer.remove(id, tile_at(1, 1, 0)));
  succeed(writer.finish());
  EXPECT_TRUE(value_of(validate(path)).ok());
  EXPECT_EQ(value_of(StoreReader::open(path)).find_layer("strange")->tiles, 2U);
}

TEST_F(UnknownNumbers, ALayerOfAnUnknownFormatCanBeRemoved) {
  {
    StoreWriter writer = value_of(StoreWriter::open(path));
    succeed(writer.remove_layer(writer.find_layer("strange")->id));
    succeed(writer.finish());
  }
  const StoreReader reader = value_of(StoreReader::open(path));
  EXPECT_EQ(reader.layers().size(), 3U);  // its carry layer went with it
  EXPECT_EQ(read_all(reader).size(), 5U);
  EXPECT_TRUE(value_of(validate(path)).ok());
}

TEST_F(UnknownNumbers, PackCopiesEverythingAsItIs) {
  const Contents wanted = contents_for_a_newer_program(path);
  static_cast<void>(value_of(pack(value_of(StoreReader::open(path)), folder / "packed.vts", {.keep_carry = true})));
  expect_numbers(folder / "packed.vts");
  EXPECT_EQ(contents_for_a_newer_program(folder / "packed.vts"), wanted);
  static_cast<void>(value_of(pack_in_place(path, {.keep_carry = true})));
  expect_numbers(path);
  EXPECT_EQ(contents_for_a_newer_program(path), wanted);
}

TEST_F(UnknownNumbers, AWriterMakesLayersOfKnownAndOfUsersNumbersOnly) {
  StoreWriter writer = value_of(StoreWriter::open(path));
  LayerInfo layer = small_layer("mine", TexelFormat::kRgb8, 2, 0);
  layer.channel = kLaterChannel;
  EXPECT_EQ(writer.add_layer(layer).error().code, ErrorCode::kInvalidData);
  layer.channel = ChannelType{};
  EXPECT_EQ(writer.add_layer(layer).error().code, ErrorCode::kInvalidData);
  layer.channel = static_cast<ChannelType>(0xFFFF);
  layer.format = kStrangeFormat;
  EXPECT_EQ(writer.add_layer(layer).error().code, ErrorCode::kInvalidData);
  layer.format = TexelFormat::kRgb8;
  EXPECT_TRUE(writer.add_layer(layer));
  succeed(writer.finish());
  EXPECT_EQ(value_of(StoreReader::open(path)).find_layer("mine")->channel, static_cast<ChannelType>(0xFFFF));
}

}  // namespace
}  // namespace vt::store
