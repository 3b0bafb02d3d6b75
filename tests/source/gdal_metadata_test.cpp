#include "builder/source/metadata/gdal_metadata.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

TEST(GdalMetadata, BandsGetWhatIsNotedOfThem) {
  const auto declared = parse_gdal_metadata(R"(<GDALMetadata>
  <Item name="OVR_RESAMPLING_ALG">NEAREST</Item>
  <Item name="OFFSET" sample="0" role="offset"> -3.5 </Item>
  <Item name="SCALE" sample="0" role="scale">1e-2</Item>
  <Item name="UNITTYPE" sample="0" role="unittype">US survey foot</Item>
  <Item name="COLORINTERP" sample="3" role="colorinterp">Undefined</Item>
  <Item name="STATISTICS_MEAN" sample="0">17</Item>
</GDALMetadata>)");
  ASSERT_TRUE(declared.has_value()) << declared.error().message;
  ASSERT_TRUE(declared->bands.contains(0) && declared->bands.contains(3));
  EXPECT_EQ(declared->bands.at(0).scale, 0.01);
  EXPECT_EQ(declared->bands.at(0).offset, -3.5);
  EXPECT_EQ(declared->bands.at(0).unit, "US survey foot");
  EXPECT_EQ(declared->bands.at(3).role_name, "Undefined");
  EXPECT_TRUE(declared->not_read.empty());
  EXPECT_TRUE(parse_gdal_metadata("")->bands.empty());
}

TEST(GdalMetadata, WhatIsNoXmlIsMentionedAndWhatIsNoNumberIsRefused) {
  for (const std::string text : {"<GDALMetadata><Item", "nothing", "<a></b>"}) {
    const auto declared = parse_gdal_metadata(text);
    ASSERT_TRUE(declared.has_value()) << text;
    EXPECT_EQ(declared->not_read.size(), 1U) << text;
  }
  for (const std::string number : {"abc", "1,5", "nan", "inf", "1e999", "2 3"}) {
    const auto declared = parse_gdal_metadata("<GDALMetadata><Item sample=\"0\" role=\"scale\">" + number + "</Item></GDALMetadata>");
    ASSERT_FALSE(declared.has_value()) << number;
    EXPECT_EQ(declared.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(declared.error().message.find("scale"), std::string::npos) << declared.error().message;
  }
}

// Deep nesting, entities that would unfold, and every prefix of a good text end in an answer.
TEST(GdalMetadata, HostileTextsEndInAnAnswer) {
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "<a>";
  EXPECT_TRUE(parse_gdal_metadata(deep).has_value());
  const std::string bomb =
      "<!DOCTYPE b [<!ENTITY x \"xxxxxxxxxx\"><!ENTITY y \"&x;&x;&x;&x;&x;&x;&x;&x;\">]><GDALMetadata><Item sample=\"0\" "
      "role=\"unittype\">&y;&y;&y;</Item></GDALMetadata>";
  const auto unfolded = parse_gdal_metadata(bomb);
  ASSERT_TRUE(unfolded.has_value());
  const std::string good = "<GDALMetadata><Item sample=\"2\" role=\"scale\">0.5</Item></GDALMetadata>";
  for (std::size_t length = 0; length < good.size(); ++length) {
    const auto declared = parse_gdal_metadata(good.substr(0, length));
    EXPECT_TRUE(!declared || declared->bands.empty() || declared->bands.at(2).scale.value_or(0.5) == 0.5) << length;
  }
  for (const std::string band : {"-1", "99999999999", "x"})
    EXPECT_TRUE(parse_gdal_metadata("<GDALMetadata><Item sample=\"" + band + "\" role=\"scale\">2</Item></GDALMetadata>").has_value());
}

TEST(GdalMetadata, ASidecarSaysTheSameAndWhatItSaysBeyondThatIsListed) {
  const test::TempFolder folder;
  RasterInfo info;
  info.path = folder / "a.png";
  info.bands = 2;
  info.meaning.resize(2);
  EXPECT_TRUE(read_aux_xml(info)->bands.empty()) << "no sidecar";
  EXPECT_TRUE(info.companions.empty());
  std::ofstream(folder / "a.png.aux.xml") << R"(<PAMDataset>
  <SRS dataAxisToSRSAxisMapping="1,2">PROJCS[]</SRS>
  <GeoTransform>1,2,3,4,5,6</GeoTransform>
  <PAMRasterBand band="2"><NoDataValue le_hex_endian="00000000000059C0">-1.00000000000000E+02</NoDataValue>
  <UnitType>ft</UnitType><Offset>2</Offset><Scale>0.1</Scale><ColorInterp>Alpha</ColorInterp></PAMRasterBand>
  <PAMRasterBand band="7"><Scale>9</Scale></PAMRasterBand>
  </PAMDataset>)";
  const auto declared = read_aux_xml(info);
  ASSERT_TRUE(declared.has_value()) << declared.error().message;
  apply_declared(*declared, info);
  EXPECT_EQ(info.meaning[1].nodata, -100.0);
  EXPECT_EQ(info.meaning[1].unit, "ft");
  EXPECT_EQ(info.meaning[1].offset, 2.0);
  EXPECT_EQ(info.meaning[1].scale, 0.1);
  EXPECT_EQ(info.meaning[1].role, BandRole::kCoverage);
  EXPECT_FALSE(info.meaning[0].scale.has_value());
  ASSERT_EQ(info.companions.size(), 1U);
  ASSERT_EQ(info.unused.size(), 2U) << "a coordinate system and a place";
  EXPECT_NE(info.unused[0].what.find("a.png.aux.xml"), std::string::npos) << info.unused[0].what;
}

TEST(GdalMetadata, ASidecarOfStatisticsAloneIsNothingToMention) {
  const test::TempFolder folder;
  RasterInfo info;
  info.path = folder / "a.tif";
  std::ofstream(folder / "a.tif.aux.xml")
      << "<PAMDataset><PAMRasterBand band=\"1\"><Metadata><MDI key=\"STATISTICS_MEAN\">3</MDI></Metadata></PAMRasterBand></PAMDataset>";
  ASSERT_TRUE(read_aux_xml(info).has_value());
  EXPECT_TRUE(info.unused.empty());
}

TEST(GdalMetadata, NodataTextsOfSeveralLibraries) {
  EXPECT_EQ(parse_nodata(" -9999 \n"), -9999.0);
  EXPECT_EQ(parse_nodata("+5"), 5.0);
  EXPECT_TRUE(std::isnan(parse_nodata("nan").value()));
  EXPECT_TRUE(std::isnan(parse_nodata("-1.#IND").value()));
  EXPECT_EQ(parse_nodata("1.#INF"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_nodata("1e400"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_nodata("1e-400"), 0.0);
  EXPECT_EQ(parse_nodata("none"), std::nullopt);
  EXPECT_EQ(parse_nodata(""), std::nullopt);
}

}  // namespace
}  // namespace vt::source
