// Layers that belong to others: which bonds a store takes, and what goes with what.
#include <gtest/gtest.h>

#include "store/pack.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

LayerInfo part_of(LayerId owner, std::string name) {
  LayerInfo part = small_layer(std::move(name), TexelFormat::kR8, 2, 1);
  part.is_part = true;
  part.owner = owner;
  return part;
}
LayerInfo carry_of(LayerId owner, std::string name) {
  LayerInfo carry = small_layer(std::move(name), TexelFormat::kRg32Float, 2, 1);
  carry.role = LayerRole::kCarry;
  carry.owner = owner;
  return carry;
}

// ground with its length, a carry layer of each, and a layer that has nothing to do with them.
StoreWriter family(const std::filesystem::path& path) {
  StoreWriter writer = value_of(StoreWriter::create(path, {}));
  const LayerId ground = value_of(writer.add_layer(small_layer("ground", TexelFormat::kRg8, 2, 1)));
  const LayerId length = value_of(writer.add_layer(part_of(ground, "ground/length")));
  const LayerId other = value_of(writer.add_layer(small_layer("other", TexelFormat::kRgb8, 2, 1)));
  for (const LayerId owner : {ground, length})
    static_cast<void>(value_of(writer.add_layer(carry_of(owner, "carry " + std::to_string(owner.value)))));
  for (const LayerInfo& layer : writer.layers()) succeed(writer.put(layer.id, {}, encoded(tile_bytes(layer, {}))));
  for (const LayerId id : {ground, length, other}) succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.commit());
  return writer;
}

std::vector<std::string> names_in(std::span<const LayerInfo> layers) {
  std::vector<std::string> names;
  for (const LayerInfo& layer : layers) names.push_back(layer.name);
  return names;
}

TEST(Part, IsReadBackWithItsOwnerAlsoWhenThatHasIdZero) {
  const TempFolder folder;
  succeed(family(folder / "a.vts").finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_TRUE(reader.find_layer("ground/length")->is_part);
  EXPECT_EQ(reader.find_layer("ground/length")->owner, LayerId{0});
  EXPECT_FALSE(reader.find_layer("ground")->is_part);
  EXPECT_FALSE(reader.find_layer("other")->has_owner());
  EXPECT_TRUE(value_of(validate(folder / "a.vts")).ok());
}

TEST(Part, NeedsAnOwnerThatIsATextureLayerAndNoPart) {
  const TempFolder folder;
  StoreWriter writer = family(folder / "a.vts");
  const auto code_of = [&](const LayerInfo& info) { return writer.add_layer(info).error().code; };
  EXPECT_EQ(code_of(part_of({77}, "p")), ErrorCode::kInvalidData);
  EXPECT_EQ(code_of(part_of(writer.find_layer("carry 0")->id, "p")), ErrorCode::kInvalidData);
  EXPECT_EQ(code_of(part_of(writer.find_layer("ground/length")->id, "p")), ErrorCode::kInvalidData);
  LayerInfo carry_and_part = carry_of({0}, "p");
  carry_and_part.is_part = true;
  EXPECT_EQ(code_of(carry_and_part), ErrorCode::kInvalidData);
  EXPECT_TRUE(writer.add_layer(part_of(writer.find_layer("other")->id, "p")));
}

TEST(Part, GoesWithItsOwnerAndSoDoTheirCarryLayers) {
  const TempFolder folder;
  StoreWriter writer = family(folder / "a.vts");
  succeed(writer.remove_layer(writer.find_layer("ground")->id));
  succeed(writer.finish());
  EXPECT_EQ(names_in(value_of(StoreReader::open(folder / "a.vts")).layers()), std::vector<std::string>{"other"});
  EXPECT_TRUE(value_of(validate(folder / "a.vts")).ok());
}

TEST(Part, GoesAloneWithWhatItOwns) {
  const TempFolder folder;
  StoreWriter writer = family(folder / "a.vts");
  succeed(writer.remove_layer(writer.find_layer("ground/length")->id));
  succeed(writer.finish());
  EXPECT_EQ(names_in(value_of(StoreReader::open(folder / "a.vts")).layers()), (std::vector<std::string>{"ground", "other", "carry 0"}));
}

TEST(Part, StaysWhereCarryLayersAreLeftBehind) {
  const TempFolder folder;
  succeed(family(folder / "a.vts").finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  const auto report = value_of(pack(reader, folder / "b.vts"));
  EXPECT_EQ(report.dropped_layers, (std::vector<std::string>{"carry 0", "carry 1"}));
  const StoreReader packed = value_of(StoreReader::open(folder / "b.vts"));
  EXPECT_EQ(names_in(packed.layers()), (std::vector<std::string>{"ground", "ground/length", "other"}));
  EXPECT_TRUE(packed.find_layer("ground/length")->is_part);
  EXPECT_TRUE(value_of(validate(folder / "b.vts")).ok());
}

}  // namespace
}  // namespace vt::store
