// vtbuild pack and remove: what they say, what they leave alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <vector>

#include "store/store_reader.h"
#include "store/store_writer.h"
#include "tests/cli/program_run.h"
#include "tests/cli/sample_store.h"
#include "tests/support/temp_folder.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Tiles = std::map<std::pair<std::string, TileId>, std::vector<std::byte>>;

Tiles tiles_of(const std::filesystem::path& path) {
  const auto reader = store::StoreReader::open(path);
  if (!reader) throw std::runtime_error(reader.error().message);
  Tiles tiles;
  for (const LayerInfo& layer : reader->layers())
    for (int level = 0; level <= layer.finest.value; ++level)
      for (std::uint32_t y = 0; y < 1U << level; ++y)
        for (std::uint32_t x = 0; x < 1U << level; ++x) {
          const TileId tile{Level{static_cast<std::uint8_t>(level)}, x, y};
          std::vector<std::byte> texels(layer.tile_payload_bytes());
          if (reader->read(layer.id, tile, texels)) tiles[{layer.name, tile}] = std::move(texels);
        }
  return tiles;
}

class VtbuildPack : public testing::Test {
 protected:
  Outcome run(const std::vector<std::string>& arguments) { return run_program(VT_VTBUILD, arguments, folder_.path()); }
  Outcome inspect(const std::vector<std::string>& arguments) { return run_program(VT_VTINSPECT, arguments, folder_.path()); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  TempFolder folder_;
};

TEST_F(VtbuildPack, WritesAStoreWithTheSameTilesAndNothingElse) {
  write_sample_store(folder_ / "s.vts", {.with_carry = true});
  const Tiles before = tiles_of(folder_ / "s.vts");
  const Outcome packed = run({"pack", "s.vts", "-o", "p.vts", "--progress", "plain"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_THAT(packed.out, AllOf(HasSubstr("s.vts -> p.vts: 12 tiles, "), HasSubstr("cold start "), HasSubstr("color: levels 0 to 2\n"),
                                HasSubstr("elevation: levels 0 to 1\n"), HasSubstr("left out     color.carry (")));
  EXPECT_THAT(packed.err, HasSubstr("packing"));
  Tiles wanted = before;
  std::erase_if(wanted, [](const auto& tile) { return tile.first.first == "color.carry"; });
  ASSERT_LT(wanted.size(), before.size());
  EXPECT_EQ(tiles_of(folder_ / "p.vts"), wanted);
  const Outcome valid = inspect({"validate", "p.vts"});
  EXPECT_EQ(valid.exit_code, 0);
  EXPECT_THAT(valid.out, HasSubstr("0 errors, 0 notes"));
  EXPECT_EQ(inspect({"compare", "s.vts", "p.vts", "--layer", "color"}).exit_code, 0);

  ASSERT_EQ(run({"pack", "s.vts", "-o", "with.vts", "--keep-carry", "--cold-start", "4K", "--progress", "none"}).exit_code, 0);
  EXPECT_EQ(tiles_of(folder_ / "with.vts"), before);
  EXPECT_EQ(tiles_of(folder_ / "s.vts"), before);
}

TEST_F(VtbuildPack, WithoutAnOutputTheStoreItselfIsPacked) {
  write_sample_store(folder_ / "s.vts");
  const Tiles before = tiles_of(folder_ / "s.vts");
  const auto bytes = std::filesystem::file_size(folder_ / "s.vts");
  const Outcome packed = run({"pack", "s.vts", "--progress", "none"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_THAT(packed.out, HasSubstr("s.vts: 12 tiles, "));
  EXPECT_LT(std::filesystem::file_size(folder_ / "s.vts"), bytes);
  EXPECT_EQ(tiles_of(folder_ / "s.vts"), before);
  EXPECT_THAT(files(), ElementsAre("s.vts"));
}

TEST_F(VtbuildPack, SaysWhatIsWrongAndLeavesNothing) {
  write_sample_store(folder_ / "s.vts");
  std::filesystem::copy_file(folder_ / "s.vts", folder_ / "damaged.vts");
  flip_bit(folder_ / "damaged.vts", tile_offset(folder_ / "damaged.vts", "color", {Level{2}, 1, 1}) + 100);
  {
    auto writer = store::StoreWriter::create(folder_ / "unfinished.vts", {});
    ASSERT_TRUE(writer);
    LayerInfo layer;
    layer.name = "half";
    layer.data = {0, 0, 256, 256};
    ASSERT_TRUE(writer->add_layer(layer));
    ASSERT_TRUE(writer->finish());
  }
  std::ofstream(folder_ / "text.vts") << "hello";
  const auto before = files();
  const auto expect_failure = [&](const std::vector<std::string>& arguments, int exit_code, const std::string& phrase) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(testing::StartsWith("vtbuild: "), HasSubstr(phrase)));
    EXPECT_EQ(files(), before);
  };
  expect_failure({"pack", "damaged.vts", "-o", "p.vts", "--progress", "none"}, 3, "layer color, level 2, tile 1,1");
  expect_failure({"pack", "damaged.vts", "--progress", "none"}, 3, "layer color, level 2, tile 1,1");
  expect_failure({"pack", "unfinished.vts", "-o", "p.vts"}, 3, "layer half is unfinished");
  expect_failure({"pack", "none.vts", "-o", "p.vts"}, 2, "none.vts");
  expect_failure({"pack", "text.vts"}, 3, "not a tile store");
  expect_failure({"pack", "s.vts", "-o", "damaged.vts"}, 2, "is there already");
  expect_failure({"pack", "s.vts", "-o", "nowhere/p.vts"}, 2, "nowhere");
  expect_failure({"pack", "s.vts", "-o", "p.vts", "--cold-start", "many"}, 1, "many");
  expect_failure({"pack", "s.vts", "-o", "p.vts", "--progress", "loud"}, 1, "loud");
  expect_failure({"pack"}, 1, "STORE");
}

TEST_F(VtbuildPack, RemoveTakesALayerAndLeavesTheOthers) {
  write_sample_store(folder_ / "s.vts", {.with_carry = true});
  Tiles wanted = tiles_of(folder_ / "s.vts");
  const auto bytes = std::filesystem::file_size(folder_ / "s.vts");
  const Outcome removed = run({"remove", "s.vts", "color"});
  ASSERT_EQ(removed.exit_code, 0) << removed.err;
  EXPECT_THAT(removed.out,
              AllOf(HasSubstr("removed layer color, 9 tiles"), HasSubstr("removed layer color.carry"),
                    HasSubstr("layers left: elevation\n"), HasSubstr("garbage"), HasSubstr("`vtbuild pack s.vts --keep-carry`")));
  std::erase_if(wanted, [](const auto& tile) { return tile.first.first != "elevation"; });
  ASSERT_EQ(wanted.size(), 3U);
  EXPECT_EQ(tiles_of(folder_ / "s.vts"), wanted);
  EXPECT_EQ(inspect({"validate", "s.vts"}).exit_code, 0);
  EXPECT_GT(std::filesystem::file_size(folder_ / "s.vts"), bytes) << "a removal is appended";

  ASSERT_EQ(run({"pack", "s.vts", "--progress", "none"}).exit_code, 0);
  EXPECT_LT(std::filesystem::file_size(folder_ / "s.vts"), bytes);
  EXPECT_EQ(tiles_of(folder_ / "s.vts"), wanted);
}

// Adds a part of color, a carry layer of that part, and a layer of blobs that color owns.
void add_family(const std::filesystem::path& path) {
  auto writer = store::StoreWriter::open(path).value();
  LayerInfo layer = *writer.find_layer("color");
  layer.owner = layer.id;
  layer.is_part = true;
  layer.name = "color/length";
  layer.format = TexelFormat::kR16;
  layer.transfer = Transfer::kLinear;
  layer.components[0] = {.scale = 0.5, .offset = -100.0};
  layer.zero_is_nodata = true;
  const LayerId part = writer.add_layer(layer).value();
  const std::vector<std::byte> block(2, std::byte{7});
  if (!writer.put_constant(part, {}, block) || !writer.set_state(part, LayerState::kComplete)) throw std::runtime_error("no part");
  layer.is_part = false;
  layer.zero_is_nodata = false;
  layer.role = LayerRole::kCarry;
  layer.name = "notes";
  layer.format = TexelFormat::kBlob;
  const LayerId notes = writer.add_layer(layer).value();
  std::vector<std::byte> scratch;
  if (!writer.put(notes, {}, store::encode_payload(block, store::Compression{}, scratch).value())) throw std::runtime_error("no blob");
  layer.name = "color/length/carry";
  layer.owner = part;
  layer.format = TexelFormat::kRg32Float;
  if (!writer.add_layer(layer) || !writer.finish()) throw std::runtime_error("no carry");
}

TEST_F(VtbuildPack, RemoveTakesPartsAndWhatTheyOwnAndSaysSo) {
  write_sample_store(folder_ / "s.vts");
  add_family(folder_ / "s.vts");
  const Outcome info = inspect({"info", "s.vts"});
  EXPECT_THAT(info.out, AllOf(HasSubstr("r16, part of layer 0, complete"), HasSubstr("component 0 = -100 + 0.5 * sample"),
                              HasSubstr("code 0 is no data")));
  std::filesystem::copy_file(folder_ / "s.vts", folder_ / "copy.vts");
  EXPECT_EQ(inspect({"compare", "s.vts", "copy.vts", "--all", "--progress", "none"}).exit_code, 0);
  EXPECT_EQ(inspect({"validate", "s.vts"}).exit_code, 0);

  ASSERT_EQ(run({"pack", "s.vts", "-o", "p.vts", "--progress", "none"}).exit_code, 0);
  EXPECT_THAT(inspect({"info", "p.vts", "--names"}).out, HasSubstr("color/length\n")) << "a part is no working state";

  const Outcome removed = run({"remove", "s.vts", "color"});
  ASSERT_EQ(removed.exit_code, 0) << removed.err;
  for (const char* name : {"color, 9 tiles", "color/length, 1 tiles", "notes, 1 tiles", "color/length/carry, 0 tiles"})
    EXPECT_THAT(removed.out, HasSubstr(std::string("removed layer ") + name));
  EXPECT_THAT(removed.out, HasSubstr("layers left: elevation\n"));
}

TEST_F(VtbuildPack, RemoveTakesAllNamesOrNone) {
  write_sample_store(folder_ / "s.vts");
  const Tiles before = tiles_of(folder_ / "s.vts");
  const Outcome wrong = run({"remove", "s.vts", "elevation", "colour"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("no layer 'colour'"), HasSubstr("color, elevation")));
  EXPECT_EQ(tiles_of(folder_ / "s.vts"), before);
  ASSERT_EQ(run({"remove", "s.vts", "elevation", "color", "color"}).exit_code, 0);
  EXPECT_TRUE(tiles_of(folder_ / "s.vts").empty());
  EXPECT_EQ(run({"remove", "none.vts", "color"}).exit_code, 2);
  EXPECT_EQ(run({"remove", "s.vts"}).exit_code, 1);
}

}  // namespace
}  // namespace vt::test
