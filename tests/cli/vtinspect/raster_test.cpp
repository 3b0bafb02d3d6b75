// vtinspect compare of what vtbuild makes with what it made it from: every channel, and the formats and
// options that take a path of their own. Nothing here knows how a layer is stored: the truth is that a raster
// which was not changed is equal, and one that was is not.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>

#include "tests/cli/vtinspect/run.h"
#include "tests/pipeline/layers/layer_kinds.h"

namespace vt::test {
namespace {

using pipeline::Case;
using pipeline::RasterSpec;
using testing::HasSubstr;
using Value = std::function<double(std::int64_t, std::int64_t, int)>;

class VtinspectRaster : public VtinspectTest, public testing::WithParamInterface<Case> {
 protected:
  void build(const Case& c) const {
    std::vector<std::string> arguments{
        "layer",      "in.tif", "-o",     "s.vts", "--channel", std::string(channels::kind_of(c.channel).name),
        "--kernel",   c.kernel, "--tile", "64",    "--threads", "1",
        "--progress", "none"};
    if (c.format) arguments.insert(arguments.end(), {"--format", std::string(format_info(*c.format).name)});
    for (const auto& [name, value] : c.options) {
      const bool is_file = name == "basis";
      if (is_file) write_file(name + ".json", value);
      arguments.push_back("--" + name + "=" + (is_file ? name + ".json" : value));
    }
    arguments.insert(arguments.end(), extra_.begin(), extra_.end());
    const Outcome built = run_program(VT_VTBUILD, arguments, directory_.path());
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }
  [[nodiscard]] std::string layer_of(const Case& c) const { return std::string(channels::kind_of(c.channel).name); }
  nlohmann::json compare(const std::string& raster, const std::string& layer, int exit_code) const {
    SCOPED_TRACE(raster);
    return run_json("vtinspect-compare", {"compare", "s.vts", raster, "--layer", layer, "--progress", "none"}, exit_code);
  }

  std::vector<std::string> extra_;
};

// With layer_kinds.h, every format of every channel.
std::vector<Case> other_formats() {
  const std::vector<Case> kinds = pipeline::cases();
  struct Row {
    const char* kind;
    TexelFormat format;
    channels::Options options;  // instead of the kind's, where there are any
  };
  const channels::Options radiance{{"quantity", "temperature"}, {"band", "8,12"}};
  std::vector<Case> cases;
  for (const Row& row :
       {Row{"translucent_kaiser", TexelFormat::kBc3, {}}, Row{"translucent_kaiser", TexelFormat::kBc7, {}},
        Row{"opaque_box", TexelFormat::kBc7, {}}, Row{"normal", TexelFormat::kRg16, {}}, Row{"normal", TexelFormat::kBc5, {}},
        Row{"horizon", TexelFormat::kRg16, {}}, Row{"horizon", TexelFormat::kRgba8, {}}, Row{"horizon", TexelFormat::kRg8, {}},
        Row{"elevation", TexelFormat::kR16Float, {}}, Row{"elevation", TexelFormat::kR16, {}}, Row{"land_cover", TexelFormat::kR16, {}},
        Row{"kelvins", TexelFormat::kR32Float, radiance}, Row{"kelvins", TexelFormat::kR16Float, radiance},
        Row{"thermal_basis", TexelFormat::kRgba16Float, {}}, Row{"thermal_basis", TexelFormat::kRgba32Float, {}},
        Row{"light_halves", TexelFormat::kRgba32Float, {}}, Row{"light_halves", TexelFormat::kBc6h, {}}, Row{"mask", TexelFormat::kR16, {}},
        Row{"mask", TexelFormat::kBc4, {}}}) {
    const auto kind = std::ranges::find(kinds, row.kind, &Case::name);
    Case c = kind == kinds.end() ? Case{} : *kind;
    c.name += std::string("_as_") + std::string(format_info(row.format).name);
    c.format = row.format;
    if (!row.options.empty()) c.options = row.options;
    cases.push_back(std::move(c));
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Formats, VtinspectRaster, testing::ValuesIn(other_formats()), [](const auto& kind) { return kind.param.name; });
INSTANTIATE_TEST_SUITE_P(Kinds, VtinspectRaster, testing::ValuesIn(pipeline::cases()), [](const auto& kind) { return kind.param.name; });

// A place in the data of every case where nothing is special.
constexpr std::int64_t kX = 70;
constexpr std::int64_t kY = 55;

double other_value(const Case& c, double value, int band) {
  switch (c.channel) {
    case ChannelType::kColor:
    case ChannelType::kMask:
      return c.raster.type == SampleType::kUint16 ? (value < 30000.0 ? 65000.0 : 100.0) : (value < 128.0 ? 250.0 : 5.0);
    case ChannelType::kNormal:
      if (c.raster.type == SampleType::kFloat32) return band == 2 ? 1.0 : value + 1.5;
      return band == 0 ? (value < 128.0 ? 240.0 : 15.0) : value;
    case ChannelType::kElevation:
      return value + 500.0;
    case ChannelType::kHorizon:
      return value + 20.0;
    case ChannelType::kMaterial:
      return value + 1.0;
    case ChannelType::kSensor:
      return c.options.contains("basis") ? (value == 1.0 ? 40.0 : 1.0) : value * 1.2;
    case ChannelType::kIllumination:
      if (band == 3 || c.raster.type != SampleType::kFloat32) return band == 3 ? 255.0 : (value < 128.0 ? 250.0 : 5.0);
      return value * 64.0 + (c.name.starts_with("light_in_small_units") ? 5e-5 : 100.0);  // within what the format holds
  }
  return value;
}

TEST_P(VtinspectRaster, ItsSourceIsEqualAndAnEditIsFound) {
  const Case& c = GetParam();
  write_raster(directory_ / "in.tif", c.raster, c.value);
  build(c);
  const std::string layer = layer_of(c);
  const auto same = compare("in.tif", layer, 0);
  EXPECT_EQ(same["equal"], true);
  EXPECT_EQ(same["raster"]["read_as"], "source");
  const auto& level = same["layers"][0]["levels"][0];
  // All of it was looked at, and nothing but what the format loses lies between the two.
  EXPECT_EQ(same["raster"]["compared"]["width"], c.raster.width);
  EXPECT_EQ(same["raster"]["compared"]["height"], c.raster.height);
  EXPECT_GT(level["texels"].get<std::int64_t>(), c.raster.width * c.raster.height / 2);
  EXPECT_EQ(level["differing_texels"], 0);
  EXPECT_EQ(level["hole_mismatches"], 0);
  EXPECT_EQ(level["max_error"], 0.0);
  EXPECT_THAT(run({"compare", "s.vts", "in.tif", "--layer", layer, "--progress", "none"}).out,
              HasSubstr("equal: a build from this raster would store the same"));

  // One texel of another value: one texel, or the rest of its block too, differs.
  write_raster(directory_ / "edited.tif", c.raster, [&](std::int64_t x, std::int64_t y, int band) {
    const double value = c.value(x, y, band);
    return x == kX && y == kY ? other_value(c, value, band) : value;
  });
  const auto edited = compare("edited.tif", layer, 3);
  EXPECT_EQ(edited["equal"], false);
  const auto differing = edited["layers"][0]["levels"][0]["differing_texels"].get<int>();
  const bool is_block = c.format && format_info(*c.format).block_edge > 1;
  EXPECT_GE(differing, 1);
  EXPECT_LE(differing, is_block ? 16 : 1);
  EXPECT_EQ(edited["layers"][0]["levels"][0]["differing_tiles"], 1);
}

TEST_P(VtinspectRaster, OneThatLiesElsewhereIsFound) {
  const Case& c = GetParam();
  write_raster(directory_ / "in.tif", c.raster, c.value);
  build(c);
  for (const double texels : {1.0, 0.4}) {
    RasterSpec moved = c.raster;
    moved.transform.x0 += texels * moved.transform.x_column;
    write_raster(directory_ / "moved.tif", moved, c.value);
    const auto json = compare("moved.tif", layer_of(c), 3);
    EXPECT_EQ(json["equal"], false) << texels;
    if (texels == 1.0) {
      EXPECT_GT(json["layers"][0]["levels"][0]["differing_texels"].get<int>(), 500);
    } else {
      EXPECT_THAT(json["mismatches"].dump(), HasSubstr("the raster's grid"));
    }
  }
}

TEST_P(VtinspectRaster, WhatExtractWritesIsEqual) {
  const Case& c = GetParam();
  write_raster(directory_ / "in.tif", c.raster, c.value);
  build(c);
  const auto info = run_json("vtinspect-info", {"info", "s.vts"});
  int compared = 0;
  for (const auto& layer : info["layers"]) {
    if (layer["role"] != "texture") continue;
    const std::string name = layer["name"];
    ASSERT_EQ(run({"extract", "s.vts", "--layer", name, "-o", "out.tif"}).exit_code, 0);
    const auto json = compare("out.tif", name, 0);
    EXPECT_EQ(json["equal"], true) << name;
    EXPECT_EQ(json["layers"][0]["levels"][0]["hole_mismatches"], 0) << name;
    ++compared;
  }
  EXPECT_GE(compared, 1);
}

// Layers whose sources lie on another grid, or are coarser or finer than the layer.
TEST_P(VtinspectRaster, AResampledSourceIsEqual) {
  const Case& c = GetParam();
  RasterSpec raster = c.raster;
  raster.width = std::min<std::int64_t>(raster.width, 130);
  raster.height = std::min<std::int64_t>(raster.height, 110);
  const double sample_m = raster.transform.x_column * (raster.epsg == 4326 ? 111319.49 : 1.0);
  for (const double samples : {2.65, 0.65}) {
    const std::string gsd = fmt::format("{}", samples * sample_m);
    write_raster(directory_ / "in.tif", raster, c.value);
    std::filesystem::remove(directory_ / "s.vts");
    extra_ = {"--gsd", gsd};
    build(c);
    const auto json = compare("in.tif", layer_of(c), 0);
    EXPECT_EQ(json["equal"], true) << gsd;
    EXPECT_EQ(json["layers"][0]["levels"][0]["max_error"], 0.0) << gsd;
    EXPECT_GT(json["layers"][0]["levels"][0]["texels"].get<int>(), 500) << gsd;

    write_raster(directory_ / "edited.tif", raster, [&](std::int64_t x, std::int64_t y, int band) {
      const double value = c.value(x, y, band);
      return x / 9 == kX / 9 && y / 9 == kY / 9 ? other_value(c, value, band) : value;
    });
    EXPECT_EQ(compare("edited.tif", layer_of(c), 3)["equal"], false) << gsd;
  }
}

class VtinspectRasterHoles : public VtinspectRaster {};

TEST_F(VtinspectRasterHoles, AHoleOnOneSideIsCountedAndNamed) {
  const Case heights{"",
                     {.width = 130, .height = 90, .bands = 1, .type = SampleType::kInt16, .nodata = -32768.0},
                     ChannelType::kElevation,
                     "box",
                     TexelFormat::kR16,
                     [](std::int64_t x, std::int64_t y, int) { return x == 5 && y == 6 ? -32768.0 : x * 3.0 - y; }};
  write_raster(directory_ / "in.tif", heights.raster, heights.value);
  build(heights);
  write_raster(directory_ / "filled.tif", heights.raster, [](std::int64_t x, std::int64_t y, int) { return x * 3.0 - y; });
  write_raster(directory_ / "holed.tif", heights.raster,
               [&](std::int64_t x, std::int64_t y, int band) { return x >= 7 && x < 10 && y == 6 ? -32768.0 : heights.value(x, y, band); });
  const auto filled = compare("filled.tif", "elevation", 3)["layers"][0]["levels"][0];
  EXPECT_EQ(filled["data_only_in_first"], 0);
  EXPECT_EQ(filled["data_only_in_second"], 1);
  const auto holed = compare("holed.tif", "elevation", 3)["layers"][0]["levels"][0];
  EXPECT_EQ(holed["data_only_in_first"], 3);
  EXPECT_EQ(holed["data_only_in_second"], 0);
  EXPECT_EQ(holed["hole_mismatches"], 3);
  EXPECT_THAT(run({"compare", "s.vts", "holed.tif"}).out, HasSubstr("3 texels have data only in s.vts"));
  EXPECT_THAT(run({"compare", "s.vts", "filled.tif", "--tolerance", "1e9"}).out, HasSubstr("1 texels have data only in filled.tif"));
  EXPECT_EQ(run({"compare", "s.vts", "filled.tif", "--tolerance", "1e9"}).exit_code, 3) << "no tolerance fills a hole";
}

TEST_F(VtinspectRasterHoles, AValueThatTheFormatCannotHoldIsADifferenceAndNoFailure) {
  const Case heights{"",
                     {.width = 130, .height = 90, .bands = 1, .type = SampleType::kFloat32},
                     ChannelType::kElevation,
                     "box",
                     TexelFormat::kR16,
                     [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(x) * 0.25 - y; }};
  write_raster(directory_ / "in.tif", heights.raster, heights.value);
  extra_ = {"--range", "-100,100"};
  build(heights);
  EXPECT_EQ(compare("in.tif", "elevation", 0)["equal"], true);
  write_raster(directory_ / "high.tif", heights.raster, [&](std::int64_t x, std::int64_t y, int band) {
    return heights.value(x, y, band) + (y == 30 && x >= 40 && x < 44 ? 9000.0 : 0.0);
  });
  const auto json = compare("high.tif", "elevation", 3);
  EXPECT_EQ(json["layers"][0]["levels"][0]["misfits"], 4);
  EXPECT_EQ(json["layers"][0]["levels"][0]["differing_texels"], 4);
  EXPECT_THAT(json["remarks"].dump(), HasSubstr("4 texels of the raster hold what the layer's format cannot: height 8980 m is outside"));
}

TEST_F(VtinspectRasterHoles, TheUnitIsTheChannels) {
  // Whole metres in steps of 2^-8 or so: what is stored is within half a step of the raster, and an edit of 3
  // m is one of 3 m.
  const Case heights{"",
                     {.width = 130, .height = 90, .bands = 1, .type = SampleType::kFloat32},
                     ChannelType::kElevation,
                     "box",
                     TexelFormat::kR16,
                     [](std::int64_t x, std::int64_t y, int) { return x * 0.3 + y * 0.01; }};
  write_raster(directory_ / "in.tif", heights.raster, heights.value);
  extra_ = {"--range", "0,100", "--quantum", "0.125"};
  build(heights);
  const auto same = compare("in.tif", "elevation", 0)["layers"][0]["levels"][0];
  ASSERT_EQ(same["measured"].size(), 1U);
  EXPECT_EQ(same["measured"][0]["unit"], "m");
  EXPECT_LE(same["measured"][0]["max"].get<double>(), 0.0625 + 1e-5);
  EXPECT_GT(same["measured"][0]["max"].get<double>(), 0.05);
  write_raster(directory_ / "edited.tif", heights.raster,
               [&](std::int64_t x, std::int64_t y, int band) { return heights.value(x, y, band) + (x == 9 && y == 9 ? 3.0 : 0.0); });
  const auto edited = compare("edited.tif", "elevation", 3)["layers"][0]["levels"][0];
  EXPECT_NEAR(edited["max_error"].get<double>(), 3.0, 0.125);
  EXPECT_EQ(run({"compare", "s.vts", "edited.tif", "--tolerance", "3.2"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "s.vts", "edited.tif", "--tolerance", "2.8"}).exit_code, 3);
}

// Its place is in the command that built the layer and nowhere else.
TEST_F(VtinspectRasterHoles, APictureThatWasPlacedByExtentIsFoundInItsPlace) {
  source::GeoTiffSpec spec{.width = 90, .height = 60, .bands = 1, .sample_type = SampleType::kUint8};
  const auto write_picture = [&](const std::string& name, int edited) {
    auto writer = source::GeoTiffWriter::create(directory_ / name, spec);
    std::vector<std::byte> samples(90 * 60);
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::byte>(i * 7 % 251);
    samples[2000] = static_cast<std::byte>(std::to_integer<int>(samples[2000]) + edited);
    ASSERT_TRUE(writer && writer->write_rows(samples, 60) && writer->finish());
  };
  write_picture("in.tif", 0);
  write_picture("edited.tif", 90);
  const Case picture{"", {}, ChannelType::kMask, "box", TexelFormat::kR8, nullptr};
  for (const char* gsd : {"10", "17"}) {
    std::filesystem::remove(directory_ / "s.vts");
    extra_ = {"--crs", "EPSG:32633", "--extent=500000,4999400,500900,5000000", "--gsd", gsd};
    build(picture);
    const auto json = compare("in.tif", "mask", 0);
    EXPECT_EQ(json["equal"], true) << gsd;
    EXPECT_GT(json["layers"][0]["levels"][0]["texels"].get<int>(), 1800) << gsd;
    EXPECT_EQ(compare("edited.tif", "mask", 3)["equal"], false) << gsd;
  }
}

TEST_F(VtinspectRasterHoles, InAMosaicASourceIsWhatItIsWhereItIsSeen) {
  const Case picture{
      "", {.width = 60, .height = 60, .bands = 1}, ChannelType::kMask, "box", TexelFormat::kR8, [](std::int64_t x, std::int64_t y, int) {
        return static_cast<double>((x * 5 + y * 3) % 200);
      }};
  write_raster(directory_ / "in.tif", picture.raster, picture.value);
  RasterSpec east = picture.raster;
  for (const std::int64_t overlap : {0, 7}) {
    east.transform.x0 = picture.raster.transform.x0 + static_cast<double>(60 - overlap) * east.transform.x_column;
    write_raster(directory_ / "east.tif", east, [](auto, auto, int) { return 255.0; });
    std::filesystem::remove(directory_ / "s.vts");
    extra_ = {"east.tif"};
    build(picture);
    EXPECT_EQ(compare("east.tif", "mask", 0)["equal"], true);
    const auto west = compare("in.tif", "mask", overlap == 0 ? 0 : 3);
    EXPECT_EQ(west["layers"][0]["levels"][0]["differing_texels"], overlap * 60);
    if (overlap > 0) {
      EXPECT_THAT(west["remarks"].dump(), HasSubstr("the layer has 2 sources"));
    }
  }
}

TEST_F(VtinspectRasterHoles, ARasterThatCannotBeReadIsAnErrorAndNoDifference) {
  const Case picture{
      "", {.width = 60, .height = 60, .bands = 1}, ChannelType::kMask, "box", TexelFormat::kR8, [](std::int64_t x, std::int64_t y, int) {
        return static_cast<double>((x * 5 + y * 3) % 200);
      }};
  write_raster(directory_ / "in.tif", picture.raster, picture.value);
  build(picture);
  std::filesystem::resize_file(directory_ / "in.tif", std::filesystem::file_size(directory_ / "in.tif") / 2);
  const Outcome outcome = run({"compare", "s.vts", "in.tif"});
  EXPECT_THAT(outcome.exit_code, testing::AnyOf(2, 3));
  EXPECT_THAT(outcome.err, HasSubstr("in.tif"));
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(run({"compare", "s.vts", "none.tif"}).exit_code, 2);
}

TEST_F(VtinspectRasterHoles, ClassesAreTheSameOrNot) {
  const Case cover{"",
                   {.width = 130, .height = 90, .bands = 1},
                   ChannelType::kMaterial,
                   "box",
                   TexelFormat::kR8,
                   [](std::int64_t x, std::int64_t y, int) { return static_cast<double>((x / 9 + y / 7) % 5); }};
  write_raster(directory_ / "in.tif", cover.raster, cover.value);
  build(cover);
  write_raster(directory_ / "edited.tif", cover.raster,
               [&](std::int64_t x, std::int64_t y, int band) { return x == 9 && y == 9 ? 200.0 : cover.value(x, y, band); });
  const auto edited = compare("edited.tif", "material", 3)["layers"][0]["levels"][0];
  EXPECT_EQ(edited["differing_texels"], 1);
  EXPECT_EQ(edited["max_error"], 1.0);
  EXPECT_EQ(run({"compare", "s.vts", "edited.tif", "--tolerance", "255"}).exit_code, 3) << "classes are not near or far";
}

}  // namespace
}  // namespace vt::test
