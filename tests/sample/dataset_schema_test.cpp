#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <set>
#include <string>

#include "builder/channels/all_channels.h"
#include "store/texel_format.h"
#include "tests/sample/schema_check.h"

namespace vt::sample {
namespace {

using nlohmann::json;

// Everything that the format knows.
json full_document() {
  return json::parse(R"({
    "format": "vt-scene", "version": 1, "name": "All of it", "crs": "EPSG:32633",
    "area": {"west": 0, "south": -1.5, "east": 10, "north": 20},
    "layers": [
      {"name": "color", "channel": "color", "format": "bc1", "kernel": "kaiser3", "compression": "zstd:3", "tile": 256, "gsd": 0.5,
       "sources": ["a.tif", {"file": "b/c.png", "crs": "EPSG:4326", "extent": [0, 1, 2, 3], "nodata": 0, "bands": [1, 2, 3]}]},
      {"name": "height-2", "channel": "elevation", "format": "r32f", "kernel": "box", "compression": "none", "sources": ["d.tif"]}
    ],
    "references": [{"role": "materials", "file": "m.tif"}, {"role": "lights", "file": "l.json"}]
  })");
}

TEST(DatasetSchema, AcceptsTheFullAndTheSmallestDocument) {
  EXPECT_EQ(schema_complaint(full_document()), "");
  EXPECT_EQ(schema_complaint(json::parse(R"({"format": "vt-scene", "version": 1, "name": "x",
      "layers": [{"name": "c", "channel": "color", "format": "rgb8", "sources": ["a.tif"]}]})")),
            "");
}

TEST(DatasetSchema, RejectsEachWrongDocument) {
  struct Case {
    const char* what;
    std::function<void(json&)> break_it;
  };
  const Case cases[] = {
      {"an array", [](json& d) { d = json::array(); }},
      {"no format", [](json& d) { d.erase("format"); }},
      {"another format", [](json& d) { d["format"] = "vt-other"; }},
      {"a later version", [](json& d) { d["version"] = 2; }},
      {"version as text", [](json& d) { d["version"] = "1"; }},
      {"no name", [](json& d) { d.erase("name"); }},
      {"an empty name", [](json& d) { d["name"] = ""; }},
      {"no layers", [](json& d) { d.erase("layers"); }},
      {"an empty list of layers", [](json& d) { d["layers"] = json::array(); }},
      {"an unknown property", [](json& d) { d["colour"] = 1; }},
      {"an unknown layer property", [](json& d) { d["layers"][0]["filter"] = "box"; }},
      {"an unknown source property", [](json& d) { d["layers"][0]["sources"][1]["alpha"] = true; }},
      {"an unknown area property", [](json& d) { d["area"]["top"] = 1; }},
      {"an unknown reference property", [](json& d) { d["references"][0]["kind"] = "x"; }},
      {"half an area", [](json& d) { d["area"].erase("east"); }},
      {"an edge as text", [](json& d) { d["area"]["west"] = "0"; }},
      {"a CRS that is no code", [](json& d) { d["crs"] = "UTM 33"; }},
      {"a layer without a name", [](json& d) { d["layers"][0].erase("name"); }},
      {"a layer name with a slash", [](json& d) { d["layers"][0]["name"] = "a/b"; }},
      {"a layer without sources", [](json& d) { d["layers"][0].erase("sources"); }},
      {"an empty list of sources", [](json& d) { d["layers"][0]["sources"] = json::array(); }},
      {"a number as source", [](json& d) { d["layers"][0]["sources"][0] = 3; }},
      {"an empty path", [](json& d) { d["layers"][0]["sources"][0] = ""; }},
      {"a source without a file", [](json& d) { d["layers"][0]["sources"][1].erase("file"); }},
      {"three edges",
       [](json& d) {
         d["layers"][0]["sources"][1]["extent"] = {0, 1, 2};
       }},
      {"nodata as text", [](json& d) { d["layers"][0]["sources"][1]["nodata"] = "nan"; }},
      {"band zero", [](json& d) { d["layers"][0]["sources"][1]["bands"] = {0}; }},
      {"half a band", [](json& d) { d["layers"][0]["sources"][1]["bands"] = {1.5}; }},
      {"a channel that is not built", [](json& d) { d["layers"][0]["channel"] = "radar"; }},
      {"a format that is not one", [](json& d) { d["layers"][0]["format"] = "rgb565"; }},
      {"an option that is a list",
       [](json& d) {
         d["layers"][0]["options"] = {{"alpha", {1, 2}}};
       }},
      {"an unknown kernel", [](json& d) { d["layers"][0]["kernel"] = "nearest"; }},
      {"zstd at level 0", [](json& d) { d["layers"][0]["compression"] = "zstd:0"; }},
      {"zstd at level 23", [](json& d) { d["layers"][0]["compression"] = "zstd:23"; }},
      {"another compression", [](json& d) { d["layers"][0]["compression"] = "lz4"; }},
      {"a tile of 100", [](json& d) { d["layers"][0]["tile"] = 100; }},
      {"a GSD of nothing", [](json& d) { d["layers"][0]["gsd"] = 0; }},
      {"a negative GSD", [](json& d) { d["layers"][0]["gsd"] = -1.0; }},
      {"an unknown way to resample", [](json& d) { d["layers"][0]["resample"] = "cubic"; }},
      {"half an area of a layer",
       [](json& d) {
         d["layers"][0]["area"] = {{"west", 0}, {"south", 0}, {"east", 1}};
       }},
      {"expected samples without a type",
       [](json& d) {
         d["layers"][0]["expect"] = {{"bands", 3}};
       }},
      {"expected samples of a type that is not one",
       [](json& d) {
         d["layers"][0]["expect"] = {{"type", "byte"}, {"bands", 3}};
       }},
      {"no sources and no GSD",
       [](json& d) {
         d["layers"][0].erase("sources");
         d["layers"][0].erase("gsd");
         d["layers"][0]["expect"] = {{"type", "uint8"}, {"bands", 3}};
       }},
      {"an unknown role", [](json& d) { d["references"][0]["role"] = "trees"; }},
      {"a reference without a file", [](json& d) { d["references"][0].erase("file"); }},
  };
  for (const Case& wrong : cases) {
    json document = full_document();
    wrong.break_it(document);
    EXPECT_NE(schema_complaint(document), "") << "accepted " << wrong.what;
  }
}

// Follows the schema itself: a person must be able to read what each property is for, and nothing unknown may
// pass.
TEST(DatasetSchema, DescribesEveryPropertyAndClosesEveryObject) {
  std::ifstream file(VT_SCHEMAS "/dataset.schema.json");
  const json schema = json::parse(file);
  int properties = 0;
  const std::function<void(const json&, const std::string&, bool)> visit = [&](const json& node, const std::string& path, bool described) {
    if (!node.is_object()) return;
    if (described && !node.contains("$ref")) {
      EXPECT_TRUE(node.contains("description")) << path;
    }
    if (node.contains("type") && node["type"] == "object") {
      // Closed, or open for names whose values it describes.
      ASSERT_TRUE(node.contains("additionalProperties")) << path;
      const json& others = node["additionalProperties"];
      EXPECT_TRUE(others == false || (others.is_object() && others.contains("description") && others.contains("type"))) << path;
    }
    if (node.contains("properties") && node.contains("type")) {
      for (const auto& [name, child] : node["properties"].items()) {
        ++properties;
        visit(child, path + "/" + name, true);
      }
    }
    if (node.contains("items")) visit(node["items"], path + "[]", false);
    if (node.contains("definitions")) {
      for (const auto& [name, child] : node["definitions"].items()) visit(child, "#" + name, true);
    }
  };
  visit(schema, "", true);
  EXPECT_GE(properties, 25);
}

// The file, as it is shipped and as other programs read it, lists what the tables of the program hold.
TEST(DatasetSchema, ListsTheMembersOfTheProgramsTables) {
  std::ifstream file(VT_SCHEMAS "/dataset.schema.json");
  const nlohmann::json properties = nlohmann::json::parse(file)["definitions"]["layer"]["properties"];
  nlohmann::json names = nlohmann::json::array();
  for (const channels::ChannelKind* const kind : channels::all_channels()) names.push_back(kind->name);
  EXPECT_EQ(properties["channel"]["enum"], names);
  std::set<std::string> formats;
  for (const FormatInfo& info : kTexelFormats)
    if (has_samples(info)) formats.insert(std::string(info.name));
  EXPECT_EQ(properties["format"]["enum"].get<std::set<std::string>>(), formats);
}

}  // namespace
}  // namespace vt::sample
