// Every texel format on a real OpenGL: a tile of noise drawn texel by texel is what the store's decoder says,
// on the shader path with blocks as they are and decoded, and on the fixed path where it has such textures.
#include <algorithm>
#include <cmath>

#include "store/texel/half.h"
#include "store/texel/texel_decoder.h"
#include "tests/runtime/glsl_fixture.h"
#include "tests/support/format_lists.h"

namespace vt::runtime {
namespace {

using test::Frame;
using test::hash_of;
using test::kFrame;
using test::Paint;
using test::Painted;

constexpr int kTileExponent = 9;  // as wide as the frame

bool has_fractions(TexelFormat format) { return format == TexelFormat::kBc3 || format == TexelFormat::kBc4 || format == TexelFormat::kBc5; }

// Samples are no codes: OpenGL takes them as they are, and OpenGL 1.2 has no such textures.
bool has_numbers(const FormatInfo& info) { return greatest_code(info.samples) == 0 || info.format == TexelFormat::kBc6h; }

// Numbers from -0.1 to 1.1, so that clamping is seen; any bits in all other formats.
Paint paint_of(TexelFormat format) {
  const FormatInfo& info = format_info(format);
  const auto number = [](std::int64_t x, std::int64_t y, unsigned c) {
    return -0.1F + 1.2F * static_cast<float>(hash_of(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), c) % 1000) / 999.0F;
  };
  if (info.samples == SampleKind::kHalf)
    return [=](Level, std::int64_t x, std::int64_t y, std::byte* texel) {
      for (unsigned c = 0; c < info.channels; ++c) {
        const std::uint16_t half = half_from_float(number(x, y, c));
        std::memcpy(texel + 2UL * c, &half, sizeof half);
      }
    };
  if (info.samples == SampleKind::kFloat)
    return [=](Level, std::int64_t x, std::int64_t y, std::byte* texel) {
      for (unsigned c = 0; c < info.channels; ++c) {
        const float value = number(x, y, c);
        std::memcpy(texel + 4UL * c, &value, sizeof value);
      }
    };
  return test::noise_paint(format);
}

// What the tile is worth, 0 to 255, four channels a texel as a shader sees them.
std::vector<float> wanted_texels(const Painted& p) {
  const FormatInfo& info = format_info(p.layer.format);
  std::vector<std::byte> payload(p.layer.tile_payload_bytes());
  const std::int64_t edge = p.layer.tile_texels();
  EXPECT_TRUE(p.source->read(Level{0}, {0, 0, edge, edge}, payload));
  std::vector<float> samples(static_cast<std::size_t>(edge * edge) * info.channels);
  store::decode_texels(info.format, payload, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge), samples);
  const float scale = has_numbers(info) ? 255.0F : 255.0F / static_cast<float>(greatest_code(info.samples));
  std::vector<float> texels(static_cast<std::size_t>(edge * edge) * 4);
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const std::size_t c = i % 4;
    const float missing = c == 3 ? 255.0F : 0.0F;
    texels[i] = c < info.channels ? std::clamp(samples[i / 4 * info.channels + c] * scale, 0.0F, 255.0F) : missing;
  }
  return texels;
}

// The frame's rows come from the bottom. A frame's code is a rounded value: one code apart at most. Where the
// driver decodes sevenths and fifths to whole codes, by rounding down as Mesa does, that takes up to one
// more.
void expect_frame(const Frame& frame, const std::vector<float>& wanted, std::span<const std::size_t> channels, const char* name,
                  bool is_decoded_by_driver) {
  const float tolerance = is_decoded_by_driver ? 2.0F : 1.0F;
  int wrong = 0;
  for (std::size_t y = 0; y < kFrame; ++y)
    for (std::size_t x = 0; x < kFrame; ++x)
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const float drawn = frame[((kFrame - 1 - y) * kFrame + x) * 4 + c];
        if (std::abs(drawn - wanted[(y * kFrame + x) * 4 + channels[c]]) > tolerance && wrong++ < 3)
          ADD_FAILURE() << name << ", texel " << x << "," << y << ", channel " << c << ": drawn " << drawn << ", wanted "
                        << wanted[(y * kFrame + x) * 4 + channels[c]];
      }
  EXPECT_EQ(wrong, 0) << name;
}

class ShaderFormats : public test::Glsl {};

TEST_P(ShaderFormats, EveryFormatIsDrawnAsTheStoreDecodesIt) {
  const unsigned shader = program(VirtualTexture::glsl_function("vt_sample", 1), "colour = vt_sample(uv);");
  for (const bool allow_extensions : {true, false}) {
    for (const TexelFormat format : vt::test::formats_with_samples()) {
      const std::string name = std::string(format_info(format).name) + (allow_extensions ? "" : " without extensions");
      const Painted p = test::painted(format, kTileExponent, 0, paint_of(format));
      Options options;
      options.layout.tile_exponent = kTileExponent;
      VirtualTexture texture = test::open_painted(p, options);
      GlHost with = host();
      with.allow_extensions = allow_extensions;
      const auto attached = texture.attach(with);
      ASSERT_TRUE(attached.has_value()) << name << ": " << attached.error().message;
      settle(texture);
      const auto binding = texture.shader_binding(shader, "vt_sample", 1, 1);
      ASSERT_TRUE(binding.has_value()) << binding.error().message;
      texture.bind(*binding, texture.select({0, 0, 1, 1}), {0, 0});
      const Frame drawn = draw(shader, test::quad_views()[0], {0, 0}, {1, 1});
      // The three-colour mode of bc1 has transparent black, which the opaque texture shows as black.
      constexpr std::array<std::size_t, 4> kChannels = {0, 1, 2, 3};
      expect_frame(drawn, wanted_texels(p), std::span(kChannels).first(format == TexelFormat::kBc1 ? 3 : 4), name.c_str(),
                   allow_extensions && has_fractions(format));
      texture.detach();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Profiles, ShaderFormats, ::testing::Values(tools::GlProfile::kCompatibility, tools::GlProfile::kCore33));

class FixedFormats : public test::GlTest {
 protected:
  void SetUp() override { open(tools::GlProfile::kCompatibility); }
};

TEST_F(FixedFormats, EveryFormatIsDrawnAsTheStoreDecodesItOrRefusedWithAReason) {
  for (const bool allow_extensions : {true, false}) {
    for (const TexelFormat format : vt::test::formats_with_samples()) {
      const FormatInfo& info = format_info(format);
      const Painted p = test::painted(format, kTileExponent, 0, paint_of(format));
      Options options;
      options.layout.tile_exponent = kTileExponent;
      VirtualTexture texture = test::open_painted(p, options);
      const auto attached = texture.attach(
          {.getproc = tools::EglContext::getproc, .user = nullptr, .path = Path::kFixedFunction, .allow_extensions = allow_extensions});
      ASSERT_EQ(attached.has_value(), !has_numbers(info)) << info.name;
      if (!attached) {
        EXPECT_EQ(attached.error().code, ErrorCode::kUnsupported);
        EXPECT_NE(attached.error().message.find(std::string(info.name) + " textures do not exist in OpenGL 1.2"), std::string::npos);
        continue;
      }
      settle(texture);
      texture.forget_bindings();
      texture.bind(texture.select({0, 0, 1, 1}), {0, 0});
      const Frame drawn = draw_fixed(test::quad_views()[0], {0, 0}, {1, 1});
      // Luminance is all three colours; a second channel is alpha.
      constexpr std::array<std::size_t, 3> kLuminance = {0, 0, 0};
      constexpr std::array<std::size_t, 4> kLuminanceAlpha = {0, 0, 0, 1};
      constexpr std::array<std::size_t, 4> kColor = {0, 1, 2, 3};
      const std::span<const std::size_t> channels = info.channels == 1   ? std::span<const std::size_t>(kLuminance)
                                                    : info.channels == 2 ? kLuminanceAlpha
                                                                         : kColor;
      expect_frame(drawn, wanted_texels(p), channels.first(format == TexelFormat::kBc1 ? 3 : channels.size()), info.name.data(),
                   allow_extensions && format == TexelFormat::kBc3);
      texture.detach();
    }
  }
}

}  // namespace
}  // namespace vt::runtime
