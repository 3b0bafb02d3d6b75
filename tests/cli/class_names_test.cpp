#include "tools/vtinspect/class_names.h"

#include <gtest/gtest.h>

namespace vt::inspect {
namespace {

using Color = std::array<std::uint8_t, 3>;

LayerInfo layer_with(const std::string& metadata, ChannelType channel = ChannelType::kMaterial) {
  LayerInfo layer;
  layer.channel = channel;
  layer.metadata_json = metadata;
  return layer;
}

TEST(ClassTable, NamesAndColoursAreTheMetadatas) {
  const ClassTable table = class_table_of(
      layer_with(R"({"no_data_class": 255, "classes": [{"id": 3, "name": "rock"}, {"id": 1, "name": "water", "color": "#0a80ff"}]})"));
  EXPECT_EQ(table.name_of(1), "water");
  EXPECT_EQ(table.name_of(3), "rock");
  EXPECT_EQ(table.name_of(2), "");
  EXPECT_EQ(table.name_of(255), "no data");
  EXPECT_EQ(table.color_of(1), (Color{10, 128, 255}));
  EXPECT_EQ(table.color_of(3), (Color{3, 3, 3})) << "without a colour: its number as grey";
  EXPECT_FALSE(table.color_of(255).has_value());
  EXPECT_TRUE(table.has_colors());
  EXPECT_EQ(table.summary(), "1 water, 3 rock");
}

TEST(ClassTable, ALongTableIsCutShort) {
  std::string list;
  for (int id = 0; id < 20; ++id) list += (id == 0 ? "" : ",") + std::string(R"({"name": "c", "id": )") + std::to_string(id) + "}";
  EXPECT_EQ(class_table_of(layer_with(R"({"classes": [)" + list + "]}")).summary(), "0 c, 1 c, 2 c, 3 c, 4 c, 5 c, 6 c, 7 c, and 12 more");
}

TEST(ClassTable, WhatIsNoTableIsLeftOut) {
  for (const char* text : {"", "{", "7", "[]", "{}", R"({"classes": 7})", R"({"classes": [7, {"id": "1"}, {"id": 1}, {"name": "a"}]})",
                           R"({"classes": [{"id": -1, "name": "a"}, {"id": 65536, "name": "b"}], "no_data_class": 1.5})"}) {
    const ClassTable table = class_table_of(layer_with(text));
    EXPECT_TRUE(table.classes.empty()) << text;
    EXPECT_FALSE(table.no_data.has_value()) << text;
    EXPECT_EQ(table.summary(), "");
    EXPECT_FALSE(table.has_colors());
  }
  const ClassTable odd = class_table_of(layer_with(R"({"classes": [{"id": 1, "name": "a", "color": "#12345g"}]})"));
  EXPECT_FALSE(odd.classes.at(1).color.has_value());
  EXPECT_TRUE(class_table_of(layer_with(R"({"classes": [{"id": 1, "name": "a"}]})", ChannelType::kColor)).classes.empty());
}

}  // namespace
}  // namespace vt::inspect
