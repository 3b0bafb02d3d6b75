// What headers of pictures claim and say: claims beyond the file are refused before memory is taken for them,
// and nothing that changes what samples mean is passed over in silence. Files are made by stb, OpenEXR, and
// by hand.
#include "builder/source/picture/picture_header.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "builder/source/picture/picture_format.h"
#include "builder/source/raster_source.h"
#include "tests/source/raster_files.h"
#include "tests/support/raw_tiff.h"
#include "tests/support/temp_folder.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace vt::source {
namespace {

using namespace std::string_literals;

std::string big(std::uint32_t number, int bytes = 4) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 0xFF);
  return text;
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// The checksum of PNG chunks, bit by bit (ISO 3309).
std::uint32_t crc_of(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

std::string chunk(const std::string& name, const std::string& data) {
  return big(static_cast<std::uint32_t>(data.size())) + name + data + big(crc_of(name + data));
}

// A zlib stream of one stored block.
std::string stored_zlib(const std::string& data) {
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  for (const char c : data) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto size = static_cast<std::uint32_t>(data.size());
  const std::string length = {static_cast<char>(size & 0xFF), static_cast<char>(size >> 8 & 0xFF)};
  const std::string inverse = {static_cast<char>(~size & 0xFF), static_cast<char>(~size >> 8 & 0xFF)};
  return "\x78\x01\x01"s + length + inverse + data + big(b << 16 | a);
}

// An Exif directory with nothing but an orientation.
std::string exif(int orientation) {
  return "MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01"s + big(static_cast<std::uint32_t>(orientation), 2) + "\0\0\0\0\0\0"s;
}

// An ICC profile of three colorants and one parametric curve, `gamma` 0 for the curve of sRGB.
std::string profile(const std::string& name, std::array<double, 9> colorants, double gamma) {
  const auto fixed = [](double value) { return big(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536.0)))); };
  std::vector<std::pair<std::string, std::string>> tags;
  tags.emplace_back("desc", "desc\0\0\0\0"s + big(static_cast<std::uint32_t>(name.size() + 1)) + name + std::string(79, '\0'));
  for (std::size_t i = 0; i < 3; ++i)
    tags.emplace_back(std::string(1, "rgb"[i]) + "XYZ",
                      "XYZ \0\0\0\0"s + fixed(colorants[3 * i]) + fixed(colorants[3 * i + 1]) + fixed(colorants[3 * i + 2]));
  const std::string curve =
      gamma == 0.0 ? "para\0\0\0\0\0\x03\0\0"s + fixed(2.4) + fixed(1 / 1.055) + fixed(0.055 / 1.055) + fixed(1 / 12.92) + fixed(0.04045)
                   : "curv\0\0\0\0\0\0\0\x01"s + big(static_cast<std::uint32_t>(std::lround(gamma * 256)), 2) + "\0\0"s;
  for (const char c : {'r', 'g', 'b'}) tags.emplace_back(std::string(1, c) + "TRC", curve);
  std::string table = big(static_cast<std::uint32_t>(tags.size()));
  std::string data;
  for (const auto& [tag, value] : tags) {
    table +=
        tag + big(static_cast<std::uint32_t>(128 + 4 + 12 * tags.size() + data.size())) + big(static_cast<std::uint32_t>(value.size()));
    data += value;
    data.resize((data.size() + 3) / 4 * 4);
  }
  std::string header(128, '\0');
  const std::string spaces = "mntrRGB XYZ ";
  header.replace(12, spaces.size(), spaces);
  std::string whole = header + table + data;
  whole.replace(0, 4, big(static_cast<std::uint32_t>(whole.size())));
  return whole;
}
constexpr std::array<double, 9> kSrgbColorants = {0.43607, 0.22249, 0.01392, 0.38515, 0.71687, 0.09708, 0.14307, 0.06061, 0.71410};
constexpr std::array<double, 9> kWideColorants = {0.60974, 0.31111, 0.01947, 0.20528, 0.62567, 0.06087, 0.14919, 0.06322, 0.74457};

class PictureHeaderTest : public testing::Test {
 protected:
  static constexpr int kEdge = 16;

  std::filesystem::path save(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  // A grey RGB picture with chunks after its first.
  std::filesystem::path png(const std::string& chunks) {
    std::vector<unsigned char> samples(kEdge * kEdge * 3, 100);
    stbi_write_png((folder_ / "plain.png").c_str(), kEdge, kEdge, 3, samples.data(), kEdge * 3);
    std::string content = content_of(folder_ / "plain.png");
    return save("a.png", content.insert(33, chunks));
  }
  // With segments after its first marker.
  std::filesystem::path jpeg(const std::vector<std::pair<int, std::string>>& segments) {
    std::vector<unsigned char> samples(kEdge * kEdge * 3, 100);
    stbi_write_jpg((folder_ / "plain.jpg").c_str(), kEdge, kEdge, 3, samples.data(), 90);
    std::string added;
    for (const auto& [marker, data] : segments)
      added += "\xff"s + static_cast<char>(marker) + big(static_cast<std::uint32_t>(data.size() + 2), 2) + data;
    std::string content = content_of(folder_ / "plain.jpg");
    return save("a.jpg", content.insert(2, added));
  }
  static std::vector<UnusedFact> remarks_of(const std::filesystem::path& path) {
    const auto source = open_raster(path);
    EXPECT_TRUE(source.has_value()) << (source ? "" : source.error().message);
    return source ? (*source)->info().unused : std::vector<UnusedFact>{};
  }
  static void expect_remark(const std::filesystem::path& path, const std::string& words) {
    const auto remarks = remarks_of(path);
    ASSERT_EQ(remarks.size(), 1U) << words;
    EXPECT_NE(remarks[0].what.find(words), std::string::npos) << remarks[0].what;
    EXPECT_EQ(remarks[0].concern, Concern::kColor);
  }
  static Error error_of(const std::filesystem::path& path) {
    const auto source = open_raster(path);
    EXPECT_FALSE(source.has_value()) << path;
    return source ? Error{} : source.error();
  }
  test::TempFolder folder_;
};

TEST_F(PictureHeaderTest, ColourInformationOfAPngIsRemarkedUnlessItSaysSrgb) {
  const std::string standard = big(31270) + big(32900) + big(64000) + big(33000) + big(30000) + big(60000) + big(15000) + big(6000);
  const std::string wide = big(31270) + big(32900) + big(73500) + big(26500) + big(11500) + big(82600) + big(15700) + big(1800);
  const auto packed = [](const std::string& name, const std::string& icc) { return chunk("iCCP", name + "\0\0"s + stored_zlib(icc)); };
  EXPECT_TRUE(remarks_of(png("")).empty());
  EXPECT_TRUE(remarks_of(png(chunk("sRGB", "\0"s))).empty());
  EXPECT_TRUE(remarks_of(png(chunk("gAMA", big(45455)))).empty());
  EXPECT_TRUE(remarks_of(png(chunk("gAMA", big(45455)) + chunk("cHRM", standard))).empty());
  EXPECT_TRUE(remarks_of(png(packed("sRGB", profile("whatever", kSrgbColorants, 0.0)))).empty()) << "its numbers count, not its name";
  EXPECT_TRUE(remarks_of(png(chunk("cICP", "\x01\x0d\0\x01"s))).empty());
  expect_remark(png(chunk("gAMA", big(100000))), "gamma of 1 (gAMA)");
  expect_remark(png(chunk("gAMA", big(55556))), "gamma of 0.55556");
  expect_remark(png(chunk("cHRM", wide)), "cHRM");
  expect_remark(png(packed("x", profile("Wide one", kWideColorants, 0.0))), "ICC profile \"Wide one\"");
  expect_remark(png(packed("x", profile("sRGB?", kSrgbColorants, 2.2))), "ICC profile \"sRGB?\"");
  expect_remark(png(chunk("cICP", "\x09\x10\0\x01"s)), "colour space 9, 16");
  expect_remark(png(chunk("iCCP", "x\0\0damaged"s)), "an ICC profile");
  // The first of the list counts, as viewers take them.
  EXPECT_TRUE(remarks_of(png(chunk("sRGB", "\0"s) + chunk("gAMA", big(100000)))).empty());
}

TEST_F(PictureHeaderTest, ColourInformationOfAJpegIsRemarked) {
  const std::string wide = profile("Wide one", kWideColorants, 2.2);
  EXPECT_TRUE(remarks_of(jpeg({})).empty());
  EXPECT_TRUE(remarks_of(jpeg({{0xE2, "ICC_PROFILE\0\x01\x01"s + profile("x", kSrgbColorants, 0.0)}})).empty());
  expect_remark(jpeg({{0xE2, "ICC_PROFILE\0\x01\x01"s + wide}}), "ICC profile \"Wide one\"");
  // In two segments.
  expect_remark(jpeg({{0xE2, "ICC_PROFILE\0\x01\x02"s + wide.substr(0, 300)}, {0xE2, "ICC_PROFILE\0\x02\x02"s + wide.substr(300)}}),
                "ICC profile \"Wide one\"");
}

TEST_F(PictureHeaderTest, ColourInformationOfATiffIsRemarked) {
  test::RawTiff tiff = test::RawTiff::grey(16, 16);
  tiff.bytes(34675, 7, profile("x", kSrgbColorants, 0.0));
  tiff.write(folder_ / "a.tif");
  EXPECT_TRUE(remarks_of(folder_ / "a.tif").empty());
  tiff.bytes(34675, 7, profile("Wide one", kWideColorants, 1.8));
  tiff.write(folder_ / "a.tif");
  expect_remark(folder_ / "a.tif", "ICC profile \"Wide one\"");
}

TEST_F(PictureHeaderTest, PicturesThatLieOnTheirSideAreRefused) {
  for (int orientation = 0; orientation <= 9; ++orientation) {
    for (const auto& path : {jpeg({{0xE1, "Exif\0\0"s + exif(orientation)}}), png(chunk("eXIf", exif(orientation)))}) {
      SCOPED_TRACE(path.string() + " " + std::to_string(orientation));
      if (orientation < 2 || orientation > 8) {
        EXPECT_TRUE(open_raster(path).has_value()) << "upright, or nonsense";
        continue;
      }
      const Error error = error_of(path);
      EXPECT_EQ(error.code, ErrorCode::kUnsupported);
      EXPECT_NE(error.message.find("(tag 274) is " + std::to_string(orientation)), std::string::npos) << error.message;
      EXPECT_NE(error.message.find("-auto-orient"), std::string::npos) << "what to do: " << error.message;
    }
  }
}

TEST_F(PictureHeaderTest, RadianceHeadersAreHeard) {
  std::vector<float> samples(kEdge * kEdge * 3, 2.0F);
  stbi_write_hdr((folder_ / "plain.hdr").c_str(), kEdge, kEdge, 3, samples.data());
  const std::string plain = content_of(folder_ / "plain.hdr");
  const std::string usual = "-Y 16 +X 16";
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string content = plain;
    return save("a.hdr", content.replace(content.find(from), from.size(), to));
  };
  ASSERT_NE(plain.find(usual), std::string::npos);
  EXPECT_TRUE(remarks_of(folder_ / "plain.hdr").empty());
  for (const char* other : {"+Y 16 +X 16", "-Y 16 -X 16", "+Y 16 -X 16", "+X 16 -Y 16", "-X 16 +Y 16"})
    EXPECT_EQ(error_of(changed(usual, other)).code, ErrorCode::kUnsupported) << other;
  const auto remarks = remarks_of(changed("\n\n", "\nEXPOSURE=4\nPRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.3 0.3\n\n"));
  ASSERT_EQ(remarks.size(), 2U);
  EXPECT_EQ(remarks[0].concern, Concern::kColor);
  EXPECT_NE(remarks[1].what.find("EXPOSURE of 4"), std::string::npos) << remarks[1].what;
  EXPECT_EQ(remarks[1].concern, Concern::kAll) << "light is measured, too";
  EXPECT_EQ(error_of(changed("FORMAT=32-bit_rle_rgbe", "FORMAT=32-bit_rle_xyze")).code, ErrorCode::kUnsupported);
}

// Files that stand for their kind: whole pictures whose header is made to claim more.
TEST_F(PictureHeaderTest, ClaimsBeyondTheFileAreRefused) {
  std::vector<unsigned char> samples(kEdge * kEdge * 3, 100);
  const auto expect_claim = [&](const std::filesystem::path& path, const std::string& size) {
    const Error error = error_of(path);
    EXPECT_EQ(error.code, ErrorCode::kInvalidData) << error.message;
    EXPECT_NE(error.message.find("claims to be a picture of " + size), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("the file has " + std::to_string(std::filesystem::file_size(path))), std::string::npos) << error.message;
  };
  std::string content = content_of(png(""));
  content.replace(16, 8, big(60000) + big(60000));
  content.replace(29, 4, big(crc_of(content.substr(12, 17))));
  expect_claim(save("a.png", content), "60000 x 60000 with 3 channels");

  content = content_of(jpeg({}));
  const std::size_t frame = content.find("\xff\xc0"s);
  ASSERT_NE(frame, std::string::npos);
  content.replace(frame + 5, 4, big(60000, 2) + big(60000, 2));
  expect_claim(save("a.jpg", content), "60000 x 60000 with 3 channels");

  std::vector<float> light(kEdge * kEdge * 3, 2.0F);
  stbi_write_hdr((folder_ / "a.hdr").c_str(), kEdge, kEdge, 3, light.data());
  content = content_of(folder_ / "a.hdr");
  content.replace(content.find("-Y 16 +X 16"), 11, "-Y 60000 +X 60000");
  expect_claim(save("a.hdr", content), "60000 x 60000");

  expect_claim(save("a.ppm", "P6\n# a comment\n60000 60000\n255\n" + std::string(100, 'x')), "60000 x 60000 with 3 channels");
  expect_claim(save("a.pbm", "P4 60000 60000\n" + std::string(100, 'x')), "60000 x 60000 with 1 channels");

  // A JPEG 2000 codestream that is nothing but its size.
  const std::string siz = "\xff\x4f\xff\x51"s + big(47, 2) + big(0, 2) + big(60000) + big(60000) + big(0) + big(0) + big(60000) +
                          big(60000) + big(0) + big(0) + big(3, 2) + std::string(200, '\x07');
  expect_claim(save("a.j2k", siz), "60000 x 60000 with 3 channels");
}

// Decoders bring codes to 255 or 65535: right for colours, wrong for numbers.
TEST_F(PictureHeaderTest, CodesThatAreExpandedAreNoNumbers) {
  std::string pixels;
  for (int i = 0; i < kEdge * kEdge; ++i) pixels += big(static_cast<std::uint32_t>(i), 2);
  const auto pgm = save("a.pgm", "P5 16 16 5000\n" + pixels);
  EXPECT_TRUE(open_raster(pgm).has_value());
  const auto numbers = open_raster(pgm, {.as_numbers = true});
  ASSERT_FALSE(numbers.has_value());
  EXPECT_NE(numbers.error().message.find("codes of 0 to 5000"), std::string::npos) << numbers.error().message;
  EXPECT_TRUE(open_raster(save("b.pgm", "P5 16 16 65535\n" + pixels), {.as_numbers = true}).has_value());
  EXPECT_FALSE(open_raster(save("a.pbm", "P4 16 16\n" + std::string(32, 'x')), {.as_numbers = true}).has_value());
}

TEST_F(PictureHeaderTest, Jpeg2000SaysHowItsNumbersAre) {
  // Boxes with a channel definition, or none, and a codestream that is nothing but its size; `depth` as the
  // standard has it, sign and all.
  const auto header_of = [&](unsigned depth, int opacity) {
    const std::string cdef =
        opacity == 0 ? "" : big(8 + 2 + 6) + "cdef" + big(1, 2) + big(3, 2) + big(static_cast<std::uint32_t>(opacity), 2) + big(0, 2);
    const std::string components = big(depth, 1) + "\1\1"s + big(depth, 1) + "\1\1"s + big(depth, 1) + "\1\1"s + big(depth, 1) + "\1\1"s;
    const std::string content = big(12) + "jP  \r\n\x87\n" + big(20) + "ftypjp2 \0\0\0\0jp2 "s +
                                big(8 + static_cast<std::uint32_t>(cdef.size())) + "jp2h" + cdef + big(0) + "jp2c\xff\x4f\xff\x51" +
                                big(50, 2) + big(0, 2) + big(16) + big(16) + big(0) + big(0) + big(16) + big(16) + big(0) + big(0) +
                                big(4, 2) + components + std::string(200, '\x07');
    const auto file = FileBytes::open(save("a.jp2", content), {});
    EXPECT_TRUE(file.has_value());
    const auto header = read_picture_header(**file, kJpeg2000Format);
    EXPECT_TRUE(header.has_value()) << (header ? "" : header.error().message);
    return header ? *header : PictureHeader{};
  };
  EXPECT_EQ(header_of(7, 0).expanded_codes, "");
  EXPECT_EQ(header_of(15, 0).expanded_codes, "");
  EXPECT_EQ(header_of(11, 0).expanded_codes, "codes of 12 bits");
  EXPECT_FALSE(header_of(15, 0).is_signed);
  EXPECT_TRUE(header_of(0x80 | 15, 0).is_signed);
  EXPECT_TRUE(header_of(7, 0).alpha_is_straight);
  EXPECT_TRUE(header_of(7, 1).alpha_is_straight);
  EXPECT_FALSE(header_of(7, 2).alpha_is_straight);
}

// Sizes that are none, which would make any bound of the file's bytes one that holds.
TEST_F(PictureHeaderTest, SizesBelowOneAreRefused) {
  const auto expect_refused = [&](const std::filesystem::path& path, const std::string& size) {
    const Error error = error_of(path);
    EXPECT_EQ(error.code, ErrorCode::kInvalidData) << error.message;
    EXPECT_NE(error.message.find("claims to be a picture of " + size + ", which is none"), std::string::npos) << error.message;
  };
  std::string content = content_of(png(""));
  content.replace(16, 4, big(0));
  content.replace(29, 4, big(crc_of(content.substr(12, 17))));
  expect_refused(save("a.png", content), "0 x " + std::to_string(kEdge));
  expect_refused(save("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y -16 +X 16\n" + std::string(2000, 'x')), "16 x -16");
  // The size of a JPEG 2000 is what is left to the right of the image's offset.
  const std::string siz = "\xff\x4f\xff\x51"s + big(47, 2) + big(0, 2) + big(16) + big(16) + big(20) + big(0) + big(16) + big(16) + big(0) +
                          big(0) + big(3, 2) + std::string(200, '\x07');
  expect_refused(save("a.j2k", siz), "-4 x 16");
}

// A whole picture of one colour is the most compressed one that there is: it is read, so no bound is too
// tight.
TEST_F(PictureHeaderTest, PicturesOfOneColourAreBelieved) {
  constexpr int kLarge = 1000;
  std::vector<unsigned char> samples(kLarge * kLarge * 3, 7);
  stbi_write_png((folder_ / "a.png").c_str(), kLarge, kLarge, 3, samples.data(), kLarge * 3);
  EXPECT_TRUE(open_raster(folder_ / "a.png").has_value());
  stbi_write_jpg((folder_ / "a.jpg").c_str(), kLarge, kLarge, 3, samples.data(), 1);
  EXPECT_TRUE(open_raster(folder_ / "a.jpg").has_value());
  std::vector<float> light(kLarge * kLarge * 3, 2.0F);
  stbi_write_hdr((folder_ / "a.hdr").c_str(), kLarge, kLarge, 3, light.data());
  EXPECT_TRUE(open_raster(folder_ / "a.hdr").has_value());
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION,
        Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION, Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    Imf::Header header(kLarge, kLarge);
    header.compression() = compression;
    std::vector<std::uint16_t> halves(kLarge * kLarge, 0);
    Imf::FrameBuffer frame;
    for (const char* name : {"R", "G", "B"}) {
      header.channels().insert(name, Imf::Channel(Imf::HALF));
      frame.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data()), 2, 2 * kLarge));
    }
    {
      Imf::OutputFile file((folder_ / "a.exr").c_str(), header);
      file.setFrameBuffer(frame);
      file.writePixels(kLarge);
    }
    const auto source = open_raster(folder_ / "a.exr");
    EXPECT_TRUE(source.has_value()) << compression << ": " << (source ? "" : source.error().message);
  }
}

// The display window is the raster, wherever the stored samples lie in it.
TEST_F(PictureHeaderTest, TheDisplayWindowOfAnOpenExrIsItsExtent) {
  struct Case {
    Imath::Box2i display;
    Imath::Box2i data;
  };
  const Case cases[] = {
      {{{0, 0}, {63, 47}}, {{16, 8}, {31, 23}}},       // inside
      {{{0, 0}, {63, 47}}, {{-8, -8}, {31, 23}}},      // over two edges
      {{{0, 0}, {63, 47}}, {{-8, -8}, {80, 60}}},      // around it
      {{{5, -7}, {40, 20}}, {{10, -3}, {70, 9}}},      // nothing begins at zero
      {{{0, 0}, {63, 47}}, {{100, 100}, {110, 110}}},  // nothing in common
  };
  for (const bool has_alpha : {false, true}) {
    for (const Case& c : cases) {
      const int width = c.data.max.x - c.data.min.x + 1;
      const int height = c.data.max.y - c.data.min.y + 1;
      SCOPED_TRACE(testing::Message() << c.data.min.x << " " << c.data.min.y << " " << has_alpha);
      const auto value = [](std::int64_t x, std::int64_t y) { return static_cast<float>(1000 * y + x); };
      std::vector<float> stored(static_cast<std::size_t>(width * height));
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) stored[static_cast<std::size_t>(y * width + x)] = value(c.data.min.x + x, c.data.min.y + y);
      std::vector<float> ones(stored.size(), 1.0F);
      Imf::Header header(c.display, c.data);
      Imf::FrameBuffer frame;
      const auto add = [&](const char* name, std::vector<float>& plane) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        const std::ptrdiff_t origin = (static_cast<std::ptrdiff_t>(c.data.min.y) * width + c.data.min.x) * 4;
        frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(plane.data()) - origin, 4, static_cast<std::size_t>(4 * width)));
      };
      add("Y", stored);
      if (has_alpha) add("A", ones);
      {
        Imf::OutputFile file((folder_ / "a.exr").c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(height);
      }
      const auto source = open_raster(folder_ / "a.exr");
      ASSERT_TRUE(source.has_value()) << source.error().message;
      const RasterInfo& info = (*source)->info();
      ASSERT_EQ(info.width, c.display.max.x - c.display.min.x + 1);
      ASSERT_EQ(info.height, c.display.max.y - c.display.min.y + 1);
      ASSERT_EQ(info.bands, has_alpha ? 2 : 1);
      const auto whole = read_all(**source);
      std::vector<float> found(whole.size() / 4);
      std::memcpy(found.data(), whole.data(), whole.size());
      for (std::int64_t y = 0; y < info.height; ++y)
        for (std::int64_t x = 0; x < info.width; ++x) {
          const std::int64_t file_x = c.display.min.x + x;
          const std::int64_t file_y = c.display.min.y + y;
          const bool is_stored = file_x >= c.data.min.x && file_x <= c.data.max.x && file_y >= c.data.min.y && file_y <= c.data.max.y;
          const float* const texel = found.data() + static_cast<std::size_t>((y * info.width + x) * info.bands);
          const float values = texel[info.alpha_band == 0 ? 1 : 0];
          if (is_stored) {
            ASSERT_EQ(values, value(file_x, file_y));
          } else {
            ASSERT_TRUE(std::isnan(values)) << file_x << ", " << file_y;
          }
          if (has_alpha) {
            ASSERT_EQ(texel[info.alpha_band], is_stored ? 1.0F : 0.0F);
          }
        }
      expect_windows_match(**source, whole, 7, 30);
      const bool is_cropped = c.data.min.x < c.display.min.x || c.data.min.y < c.display.min.y || c.data.max.x > c.display.max.x ||
                              c.data.max.y > c.display.max.y;
      EXPECT_EQ(info.unused.size(), is_cropped ? 1U : 0U);
    }
  }
}

TEST_F(PictureHeaderTest, ColourInformationOfAnOpenExrIsRemarked) {
  std::vector<float> plane(16 * 16, 0.5F);
  const auto write = [&](const std::optional<Imf::Chromaticities>& chromaticities) {
    Imf::Header header(16, 16);
    if (chromaticities) Imf::addChromaticities(header, *chromaticities);
    Imf::FrameBuffer frame;
    for (const char* name : {"R", "G", "B"}) {
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(plane.data()), 4, 64));
    }
    Imf::OutputFile file((folder_ / "a.exr").c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(16);
  };
  write(std::nullopt);
  EXPECT_TRUE(remarks_of(folder_ / "a.exr").empty());
  write(Imf::Chromaticities());  // Rec. 709
  EXPECT_TRUE(remarks_of(folder_ / "a.exr").empty());
  write(Imf::Chromaticities({0.7347F, 0.2653F}, {0.0F, 1.0F}, {0.0001F, -0.077F}, {0.32168F, 0.33767F}));  // ACES
  expect_remark(folder_ / "a.exr", "chromaticities");
}

// Damage of any kind in a header is an error or nothing, never a crash or a wait. The decoders behind it are
// not ours to test.
TEST_F(PictureHeaderTest, DamagedHeadersNeitherCrashNorHang) {
  std::vector<float> light(kEdge * kEdge * 3, 2.0F);
  stbi_write_hdr((folder_ / "plain.hdr").c_str(), kEdge, kEdge, 3, light.data());
  {
    Imf::Header header(16, 16);
    Imf::addChromaticities(header, Imf::Chromaticities());
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    Imf::FrameBuffer frame;
    frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(light.data()), 4, 64));
    Imf::OutputFile file((folder_ / "plain.exr").c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(16);
  }
  const std::string icc = profile("Wide one", kWideColorants, 0.0);
  const std::string jp2 = big(12) + "jP  \r\n\x87\n" + big(20) + "ftypjp2 \0\0\0\0jp2 "s + big(8 + 22 + 15) + "jp2h" + big(22) + "ihdr" +
                          big(16) + big(16) + big(3, 2) + "\x07\x07\0\0"s + big(15) + "colr\x01\0\0"s + big(16) +
                          big(static_cast<std::uint32_t>(24 + exif(6).size())) + "uuidJpgTiffExif->JP2" + exif(6) + big(0) +
                          "jp2c\xff\x4f\xff\x51" + big(47, 2) + big(0, 2) + big(16) + big(16) + big(0) + big(0) + big(16) + big(16) +
                          big(0) + big(0) + big(3, 2) + std::string(60, '\x07');
  const std::pair<const PictureFormat*, std::string> files[] = {
      {&kPngFormat,
       content_of(png(chunk("iCCP", "x\0\0"s + stored_zlib(icc)) + chunk("cHRM", std::string(32, '\1')) + chunk("eXIf", exif(6))))},
      {&kJpegFormat, content_of(jpeg({{0xE1, "Exif\0\0"s + exif(6)}, {0xE2, "ICC_PROFILE\0\x01\x01"s + icc}}))},
      {&kJpeg2000Format, jp2},
      {&kOpenExrFormat, content_of(folder_ / "plain.exr")},
      {&kRadianceFormat, content_of(folder_ / "plain.hdr")},
      {&kPnmFormat, "P5 # comment\n16 16\n255\n" + std::string(256, 'x')},
  };
  for (const auto& [format, content] : files) {
    SCOPED_TRACE(format->reader);
    const auto read = [&](const std::string& bytes) {
      const auto file = FileBytes::open(save("damaged", bytes));
      ASSERT_TRUE(file.has_value());
      const auto header = read_picture_header(**file, *format);
      if (!header) {
        EXPECT_NE(header.error().code, ErrorCode::kInternal) << header.error().message;
      }
    };
    const auto good = FileBytes::open(save("good", content)).value();
    EXPECT_TRUE(read_picture_header(*good, *format).has_value()) << read_picture_header(*good, *format).error().message;
    const std::size_t head = std::min<std::size_t>(content.size(), 900);
    for (std::size_t length = 12; length < head; length += 3) read(content.substr(0, length));
    std::mt19937 random(9);
    for (int round = 0; round < 400; ++round) {
      std::string flipped = content;
      for (int flips = 0; flips < 4; ++flips) flipped[4 + random() % (head - 4)] = static_cast<char>(random() % 3 != 0 ? random() : 0xFF);
      read(flipped);
    }
  }
}

}  // namespace
}  // namespace vt::source
