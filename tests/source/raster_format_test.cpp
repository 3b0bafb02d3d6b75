// Files are known by their content, and those that are not read are called by their name: nobody's decoder is
// started to find out.
#include "builder/source/raster_format.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string_view>

#include "builder/source/raster_source.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using namespace std::string_literals;

class RasterFormatTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& content, std::uintmax_t size = 0) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    if (size != 0) std::filesystem::resize_file(folder_ / name, size);
    return folder_ / name;
  }
  static Error error_of(const std::filesystem::path& path) {
    const auto source = open_raster(path);
    EXPECT_FALSE(source.has_value());
    return source ? Error{} : source.error();
  }
  test::TempFolder folder_;
};

TEST_F(RasterFormatTest, WhatIsNotReadIsCalledByItsNameWhateverItsSuffix) {
  struct Case {
    std::string content;
    std::string name;
    std::string advice;
  };
  const std::string dted = "UHL1" + std::string(76, '0');
  const Case cases[] = {
      {"NITF02.10", "NITF", "gdal_translate"},
      {"EHFA_HEADER_TAG\0"s, "ERDAS Imagine", "gdal_translate"},
      {"SQLite format 3\0"s + std::string(52, '\0') + "GPKG", "GeoPackage", "gdal_translate"},
      {"msid\1\4", "MrSID", "gdal_translate"},
      {"CDF\1", "netCDF", "SUBDATASET_NAME"},
      {"\x89HDF\r\n\x1a\n", "HDF5", "SUBDATASET_NAME"},
      {"\x0e\x03\x13\x01", "HDF4", "SUBDATASET_NAME"},
      {"GRIB", "GRIB", "gdal_translate"},
      {dted, "DTED", "gdal_translate"},
      {"VOL1" + std::string(76, ' ') + "HDR1" + std::string(76, ' ') + dted, "DTED", "gdal_translate"},
      {"north: 4928010\nsouth: 4913700\n", "ASCII grid", "gdal_translate"},
      {"<VRTDataset rasterXSize=\"4\"", "VRT", "gdal_translate"},
      {"<?xml version=\"1.0\"?>\n<VRTDataset>", "VRT", "gdal_translate"},
      {"BM", "BMP", "save it as PNG"},
      {"GIF89a", "GIF", "save it as PNG"},
      {"RIFF1234WEBPVP8L", "WebP", "save it as PNG"},
      {"\x01\xda\x01\x01", "SGI", "save it as PNG"},
      {"\0\0\1\0\1\0"s, "icon", "save it as PNG"},
      {"PK\3\4", "ZIP", "unpack"},
      {"\x1f\x8b\x08", "gzip", "unpack"},
      {"VTSTORE1", "tile store", ""},
      {std::string(150, ' ') + "     1     1", "USGS DEM", "gdal_translate"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    for (const char* name : {"plain", "ortho.tif", "picture.png"}) {
      const Error error = error_of(write(name, c.content));
      EXPECT_EQ(error.code, ErrorCode::kUnsupported);
      EXPECT_NE(error.message.find("is in a format that is not read, "), std::string::npos) << error.message;
      EXPECT_NE(error.message.find(c.name), std::string::npos) << error.message;
      EXPECT_NE(error.message.find(c.advice), std::string::npos) << error.message;
      EXPECT_EQ(error.message.find("as a picture"), std::string::npos) << error.message;
    }
  }
}

TEST_F(RasterFormatTest, FormatsWithoutAMagicAreKnownByTheirNameSizeAndCompanions) {
  // Sea level first: the same bytes as an icon has.
  EXPECT_NE(error_of(write("N36W112.hgt", "\0\0\1\0"s, 2 * 1201 * 1201)).message.find("HGT"), std::string::npos);
  EXPECT_NE(error_of(write("n36w112.bin", "\0\1"s, 2 * 3601 * 3601)).message.find("HGT"), std::string::npos);
  write("raw.hdr", "ENVI\nsamples = 4\n");
  EXPECT_NE(error_of(write("raw.img", "\1\2\3\4")).message.find("raw raster"), std::string::npos);
  EXPECT_NE(error_of(folder_ / "raw.hdr").message.find("header of a raw raster"), std::string::npos);
  write("b.hdr", "BYTEORDER I\nLAYOUT BIL\nNROWS 4\n");
  EXPECT_NE(error_of(write("b.bil", "\1\2\3\4")).message.find("raw raster"), std::string::npos);
  EXPECT_NE(error_of(write("a.ecw", "e\1\2")).message.find("ECW"), std::string::npos);
}

TEST_F(RasterFormatTest, WhatNobodyKnowsIsShownByItsFirstBytes) {
  const Error error = error_of(write("a.tif", "what?"));
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_NE(error.message.find("begins with the bytes 77 68 61 74 3f"), std::string::npos) << error.message;
  EXPECT_NE(error.message.find("OpenEXR"), std::string::npos) << "what is read: " << error.message;
  EXPECT_EQ(error_of(write("empty.tif", "")).code, ErrorCode::kInvalidData);
}

// A row says all that anybody needs to know of its format, and no two rows claim the same suffix.
TEST_F(RasterFormatTest, EveryRowIsComplete) {
  std::set<std::string_view> names;
  std::set<std::string_view> suffixes;
  for (const RasterFormat& format : raster_formats()) {
    SCOPED_TRACE(format.name);
    EXPECT_TRUE(names.insert(format.name).second);
    EXPECT_EQ(format.open == nullptr, format.advice != Advice::kNone);
    EXPECT_TRUE(format.is_this != nullptr || !format.magic.front().bytes.empty());
    EXPECT_TRUE(format.open == nullptr || !format.suffixes.front().empty()) << "left out of folders";
    for (const std::string_view suffix : format.suffixes) {
      if (suffix.empty()) continue;
      EXPECT_TRUE(suffixes.insert(suffix).second) << suffix;
      EXPECT_EQ(suffix, in_lower_case(std::string(suffix)));
      EXPECT_TRUE(suffix.starts_with('.')) << suffix;
      EXPECT_TRUE(format.has_suffix("a" + std::string(suffix)));
      std::string upper(suffix);
      std::ranges::transform(upper, upper.begin(), [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
      EXPECT_TRUE(format.has_suffix("a" + upper)) << upper;
    }
    EXPECT_FALSE(format.has_suffix("a"));
  }
  const auto tiff = format_of(**FileBytes::open(write("a.png", "II*\0"s)));
  ASSERT_TRUE(tiff.has_value());
  EXPECT_EQ((*tiff)->name, "GeoTIFF");
  EXPECT_TRUE((*tiff)->has_suffix("A.TIF"));
}

// Opening one of these may wait for ever; the test would too.
TEST_F(RasterFormatTest, PipesDevicesSocketsAndFoldersAreRefusedAtOnce) {
  const auto pipe = folder_ / "pipe.tif";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto socket_path = folder_ / "socket.tif";
  const int listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(socket_path.string().size(), sizeof address.sun_path);
  socket_path.string().copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::filesystem::create_symlink(pipe, folder_ / "link.tif");
  const std::pair<std::filesystem::path, const char*> cases[] = {
      {pipe, "pipe"}, {folder_ / "link.tif", "pipe"}, {socket_path, "socket"}, {"/dev/zero", "device"}, {folder_.path(), "folder"}};
  for (const auto& [path, word] : cases) {
    const Error error = error_of(path);
    EXPECT_EQ(error.code, ErrorCode::kIo);
    EXPECT_NE(error.message.find(path.string()), std::string::npos) << error.message;
    EXPECT_NE(error.message.find(word), std::string::npos) << error.message;
  }
  ::close(listener);
}

}  // namespace
}  // namespace vt::source
