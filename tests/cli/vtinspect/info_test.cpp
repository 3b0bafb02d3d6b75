#include "store/store_writer.h"
#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

class VtinspectInfo : public VtinspectTest {};

TEST_F(VtinspectInfo, JsonTellsWhatWasWritten) {
  SampleStore options;
  options.absent_color_tile = TileId{Level{2}, 2, 1};
  options.with_carry = true;
  write_sample_store(directory_ / "s.vts", options);
  const auto json = run_json("vtinspect-info", {"info", "s.vts"});

  EXPECT_EQ(json["path"], "s.vts");
  EXPECT_EQ(json["crs"], "EPSG:32633 (WGS 84 / UTM zone 33N)");
  EXPECT_EQ(json["area"]["west"], kWest);
  EXPECT_EQ(json["area"]["north"], kNorth);
  EXPECT_EQ(json["file_bytes"], std::filesystem::file_size(directory_ / "s.vts"));
  EXPECT_EQ(json["metadata"]["created_by"], "test 1");
  EXPECT_EQ(schema_complaints("store-metadata", json["metadata"]), "");
  ASSERT_EQ(json["layers"].size(), 3U);

  const auto& color = json["layers"][0];
  EXPECT_EQ(color["name"], "color");
  EXPECT_EQ(color["role"], "texture");
  EXPECT_EQ(color["state"], "complete");
  EXPECT_EQ(color["channel"], "color");
  EXPECT_EQ(color["format"], "rgb8");
  EXPECT_EQ(color["transfer"], "srgb");
  EXPECT_EQ(color["vt_exponent"], 6);
  EXPECT_TRUE(color["source_nodata"].is_null());
  EXPECT_EQ(color["metadata"]["kernel"], "box");
  ASSERT_EQ(color["levels"].size(), 3U);

  // 40 x 24 texels at 4,8 touch 3 x 2 tiles of 16; one is left out. 768 bytes a tile.
  const auto& finest = color["levels"][2];
  EXPECT_EQ(finest["level"], 2);
  EXPECT_EQ(finest["paper_level"], 0);
  EXPECT_EQ(finest["gsd_crs_units"]["x"], 10.0);
  // On the central meridian of a UTM zone the scale is 0.9996; the area's centre is 200 m beside it.
  EXPECT_NEAR(finest["gsd_m"]["x"].get<double>(), 10.0 / 0.9996, 1e-6);
  EXPECT_EQ(finest["tiles_in_data"], 6);
  EXPECT_EQ(finest["tiles"]["stored"], 5);
  EXPECT_EQ(finest["tiles"]["absent"], 1);
  EXPECT_EQ(finest["stored_bytes"], 5 * 768);
  EXPECT_EQ(finest["compression_ratio"], 1.0);
  // Rounded outward on the square's grid: columns 1..10, rows 2..7 at 1:4.
  const auto& root = color["levels"][0];
  EXPECT_EQ(root["data"], (nlohmann::json{{"x", 1}, {"y", 2}, {"width", 10}, {"height", 6}}));
  EXPECT_EQ(root["gsd_crs_units"]["y"], 40.0);

  EXPECT_EQ(json["layers"][1]["source_nodata"], -9999.0);
  EXPECT_EQ(json["layers"][2]["role"], "carry");
  EXPECT_EQ(json["layers"][2]["owner"], color["id"]);
  EXPECT_EQ(json["layers"][2]["levels"][0]["tiles"]["constant"], 1);
}

TEST_F(VtinspectInfo, TableShowsLayersAndBothNumberings) {
  write_sample_store(directory_ / "s.vts");
  const Outcome outcome = run({"info", "s.vts"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* const part : {"s.vts\n", "EPSG:32633", "created by  test 1", "layer 0 \"color\": color, rgb8 sRGB, complete",
                                 "40 x 24 texels, tiles of 16, finest level 2, vt 6", "source's nodata -9999", "10.004"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  EXPECT_THAT(outcome.out, testing::ContainsRegex("\n +0 +2 +10 x 6 +40 "));
  EXPECT_THAT(outcome.out, testing::ContainsRegex("\n +2 +0 +40 x 24 +10 "));
}

TEST_F(VtinspectInfo, EmptyMetadataMeansNoPlaceOnTheEarth) {
  auto writer = store::StoreWriter::create(directory_ / "s.vts", {.area = {}, .metadata_json = ""});
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  ASSERT_TRUE(writer->finish().has_value());
  const Outcome outcome = run({"info", "s.vts"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr("CRS         pixel"));
}

TEST_F(VtinspectInfo, ListsTextureLayersForScripts) {
  SampleStore options;
  options.with_carry = true;
  write_sample_store(directory_ / "s.vts", options);
  EXPECT_EQ(run({"info", "s.vts", "--names"}).out, "color\nelevation\n");
}

TEST_F(VtinspectInfo, SaysThatASuperblockIsDamaged) {
  write_sample_store(directory_ / "s.vts");
  EXPECT_EQ(run_json("vtinspect-info", {"info", "s.vts"})["health"], "whole");
  EXPECT_THAT(run({"info", "s.vts"}).out, testing::Not(HasSubstr("damaged")));
  flip_bit(directory_ / "s.vts", 4096 + 40);
  EXPECT_EQ(run_json("vtinspect-info", {"info", "s.vts"})["health"], "one superblock");
  const Outcome info = run({"info", "s.vts"});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.out, testing::AllOf(HasSubstr("damaged     superblock B"), HasSubstr("nothing is lost")));
  EXPECT_EQ(run({"sample", "s.vts", "--layer", "color", "--texel", "0,0"}).err, "") << "it is the last state all the same";
}

// A store that a program has written which had each commit in one superblock only.
TEST_F(VtinspectInfo, WhatMayBeOlderIsSaidByWhoeverReadsIt) {
  std::filesystem::copy_file(std::filesystem::path(VT_SCHEMAS) / "../tests/golden/version-3-unpaired.vts", directory_ / "s.vts");
  flip_bit(directory_ / "s.vts", 40);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"info", "s.vts"}, {"sample", "s.vts", "--texel", "0,0"}, {"extract", "s.vts", "-o", "o.png"}, {"compare", "s.vts", "s.vts"}})
    EXPECT_THAT(run(arguments).err,
                HasSubstr("vtinspect: s.vts: superblock A: its checksum differs; it may have held a generation after 1"))
        << arguments[0];
  EXPECT_EQ(run_json("vtinspect-info", {"info", "s.vts"})["health"], "may be older");
  const Outcome validated = run({"validate", "s.vts"});
  EXPECT_EQ(validated.exit_code, 3);
  EXPECT_THAT(validated.out, HasSubstr("error 110: superblocks: superblock A"));
}

}  // namespace
}  // namespace vt::test
