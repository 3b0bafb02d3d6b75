// What vtinspect makes of numbers that are not their codes: scales and offsets, codes for "no data",
// directions, light; and of what a build has measured.
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "store/store_writer.h"
#include "store/texel/half.h"
#include "tests/cli/picture_file.h"
#include "tests/cli/vtinspect/run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kEdge = 16;

// Layers of one tile each, 16 x 16 texels, over the same square.
class VtinspectValues : public VtinspectTest {
 protected:
  void add_layer(LayerInfo layer, const std::vector<std::byte>& payload) {
    if (!writer_)
      writer_.emplace(value_of(store::StoreWriter::create(directory_ / "s.vts", {.area = {0.0, 0.0, 16.0, 16.0}}, {.sync = false})));
    layer.tile_exponent = 4;
    layer.data = {0, 0, kEdge, kEdge};
    layer.grid = {.origin_x = 0.0, .origin_y = 16.0};
    layer.state = LayerState::kComplete;
    const LayerId id = value_of(writer_->add_layer(layer));
    std::vector<std::byte> scratch;
    check(writer_->put(id, TileId{}, value_of(store::encode_payload(payload, {}, scratch))));
  }
  void finish_store() { check(writer_->finish()); }

  template <class T>
  static T value_of(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
  }
  static void check(const Result<void>& result) {
    if (!result) throw std::runtime_error(result.error().message);
  }

 private:
  std::optional<store::StoreWriter> writer_;
};

std::vector<std::byte> bytes_of(const std::vector<std::uint16_t>& samples) {
  std::vector<std::byte> bytes(samples.size() * 2);
  std::memcpy(bytes.data(), samples.data(), bytes.size());
  return bytes;
}

TEST_F(VtinspectValues, SixteenBitHeightsAreMetresAndCodeZeroIsNoData) {
  std::vector<std::uint16_t> codes(kEdge * kEdge);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint16_t>(i);  // 0 is the first texel alone
  LayerInfo layer;
  layer.name = "ground";
  layer.channel = ChannelType::kElevation;
  layer.format = TexelFormat::kR16;
  layer.components[0] = {.scale = 1.0 / 64.0, .offset = -500.0};
  layer.zero_is_nodata = true;
  layer.metadata_json = R"({"components":["height"],"unit":"m"})";
  add_layer(layer, bytes_of(codes));
  finish_store();

  const auto at = [&](const std::string& texel) { return run_json("vtinspect-sample", {"sample", "s.vts", "--texel", texel}); };
  EXPECT_EQ(at("0,1")["value"][0].get<double>(), -500.0 + 16.0 / 64.0);
  EXPECT_EQ(at("0,1")["unit"], "m");
  EXPECT_TRUE(at("0,0")["value"][0].is_null());
  EXPECT_THAT(run({"sample", "s.vts", "--texel", "0,0"}).out, HasSubstr("no data"));
  EXPECT_THAT(run({"info", "s.vts"}).out, HasSubstr("height = -500 + 0.015625 * sample m"));

  EXPECT_EQ(run({"extract", "s.vts", "-o", "h.exr"}).exit_code, 0);
  const auto picture = read_exr(directory_ / "h.exr");
  EXPECT_TRUE(std::isnan(picture.at(0, 0, 0)));
  for (int i = 1; i < kEdge * kEdge; ++i) ASSERT_EQ(picture.at(i % kEdge, i / kEdge, 0), -500.0F + static_cast<float>(i) / 64.0F) << i;
}

TEST_F(VtinspectValues, DirectionsOfTwoComponentsAreShownWithTheirThird) {
  std::vector<std::uint16_t> codes;
  for (int i = 0; i < kEdge * kEdge; ++i) {
    codes.push_back(static_cast<std::uint16_t>(32768 + (i % 2 == 0 ? 0 : 19660)));  // x = 0 or 0.6
    codes.push_back(32768);
  }
  LayerInfo layer;
  layer.name = "normal";
  layer.channel = ChannelType::kNormal;
  layer.format = TexelFormat::kRg16;
  for (std::size_t c = 0; c < 2; ++c) layer.components[c] = {.scale = 1.0 / 32767.0, .offset = -32768.0 / 32767.0};
  add_layer(layer, bytes_of(codes));
  finish_store();
  EXPECT_EQ(run({"extract", "s.vts", "-o", "n.png"}).exit_code, 0);
  const auto picture = read_png(directory_ / "n.png");
  ASSERT_EQ(picture.channels, 3);
  // A component c is shown as 127.5 + 127.5 c; 0.6 beside it has z = 0.8.
  EXPECT_EQ(picture.at(0, 0, 0), 128);
  EXPECT_EQ(picture.at(0, 0, 2), 255);
  EXPECT_NEAR(picture.at(1, 0, 0), 127.5 + 127.5 * 0.6, 0.51);
  EXPECT_NEAR(picture.at(1, 0, 2), 127.5 + 127.5 * 0.8, 0.51);
}

TEST_F(VtinspectValues, AFewLampsDoNotLeaveTheNightBlack) {
  std::vector<std::uint16_t> halves;
  for (int i = 0; i < kEdge * kEdge; ++i)
    for (int c = 0; c < 4; ++c) halves.push_back(half_from_float(c == 3 ? 1.0F : i == 37 ? 60000.0F : 0.25F));
  LayerInfo layer;
  layer.name = "night";
  layer.channel = ChannelType::kIllumination;
  layer.format = TexelFormat::kRgba16Float;
  add_layer(layer, bytes_of(halves));
  finish_store();
  EXPECT_EQ(run({"extract", "s.vts", "-o", "n.png"}).exit_code, 0);
  const auto picture = read_png(directory_ / "n.png");
  EXPECT_GT(picture.at(0, 0, 0), 100);
  EXPECT_EQ(picture.at(37 % kEdge, 37 / kEdge, 0), 255);
}

TEST_F(VtinspectValues, ClassesAreShownInTheColoursOfTheirTable) {
  std::vector<std::byte> ids(kEdge * kEdge, std::byte{7});
  ids[0] = std::byte{9};
  ids[1] = std::byte{255};
  LayerInfo layer;
  layer.name = "cover";
  layer.channel = ChannelType::kMaterial;
  layer.format = TexelFormat::kR8;
  layer.metadata_json =
      R"({"no_data_class":255,"classes":[{"id":7,"name":"water","color":"#102030"},{"id":9,"name":"rock","color":"#ff8000"}]})";
  add_layer(layer, ids);
  finish_store();
  EXPECT_EQ(run({"extract", "s.vts", "-o", "c.png"}).exit_code, 0);
  const auto picture = read_png(directory_ / "c.png");
  ASSERT_EQ(picture.channels, 4);  // with coverage, since a texel has no data
  const auto texel = [&](int x) {
    return std::array<int, 4>{picture.at(x, 0, 0), picture.at(x, 0, 1), picture.at(x, 0, 2), picture.at(x, 0, 3)};
  };
  EXPECT_EQ(texel(0), (std::array<int, 4>{0xFF, 0x80, 0x00, 255}));
  EXPECT_EQ(texel(1)[3], 0);
  EXPECT_EQ(texel(2), (std::array<int, 4>{0x10, 0x20, 0x30, 255}));
  // A GeoTIFF keeps the numbers.
  EXPECT_EQ(run({"extract", "s.vts", "-o", "c.tif"}).exit_code, 0);
  EXPECT_EQ(read_tiff(directory_ / "c.tif").bands, 1);
}

TEST_F(VtinspectValues, InfoShowsWhatWasMeasured) {
  LayerInfo layer;
  layer.name = "color";
  layer.metadata_json = R"({"components":["red","green","blue"],"quality":[
    {"name":"light","levels":[{"level":0,"measured":256,"mean":0.0005,"rms":0.001,"max":0.004,"kept":0.9999}]},
    {"name":"broken"}, 7]})";
  add_layer(layer, std::vector<std::byte>(kEdge * kEdge * 3, std::byte{9}));
  finish_store();
  const std::string text = run({"info", "s.vts"}).out;
  EXPECT_THAT(text, HasSubstr("error of light"));
  EXPECT_THAT(text, HasSubstr("60.0"));  // dB of an rms of 0.001
  EXPECT_THAT(text, HasSubstr("0.999900"));
  EXPECT_THAT(text, testing::Not(HasSubstr("broken")));
}

}  // namespace
}  // namespace vt::test
