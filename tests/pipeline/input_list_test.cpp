#include "builder/pipeline/request/input_list.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/temp_folder.h"

namespace vt::pipeline {
namespace {

using Paths = std::vector<std::filesystem::path>;

class InputList : public testing::Test {
 protected:
  void touch(const std::string& name, const std::string& text = "x") { std::ofstream(folder_ / name) << text; }
  void expect_refused(const std::string& input, ErrorCode code, const std::string& words) {
    const auto files = expand_input(input, folder_.path());
    ASSERT_FALSE(files.has_value()) << input;
    EXPECT_EQ(files.error().code, code);
    EXPECT_NE(files.error().message.find(words), std::string::npos) << files.error().message;
  }
  test::TempFolder folder_;
};

TEST_F(InputList, AFileIsItselfEvenWhenItIsNotThere) {
  EXPECT_EQ(expand_input("a.tif", folder_.path()).value(), Paths{folder_ / "a.tif"});
  EXPECT_EQ(expand_input("/elsewhere/b.tif", folder_.path()).value(), Paths{"/elsewhere/b.tif"});
}

TEST_F(InputList, AFolderIsItsRastersByName) {
  std::filesystem::create_directory(folder_ / "tiles");
  for (const char* name : {"b.tif", "a10.TIF", "a2.tiff", "c.png", "c.pgw", "notes.txt", "b.tif.aux.xml"})
    touch(std::string("tiles/") + name);
  std::filesystem::create_directories(folder_ / "tiles/inner.tif");
  touch("tiles/inner.tif/d.tif");
  const auto tiles = folder_ / "tiles";
  EXPECT_EQ(expand_input("tiles", folder_.path()).value(), (Paths{tiles / "a10.TIF", tiles / "a2.tiff", tiles / "b.tif", tiles / "c.png"}));
}

// Content counts where others use a suffix, too, and where the format is not read.
TEST_F(InputList, AFolderIsWithoutWhatOnlySoundsLikeARaster) {
  std::filesystem::create_directory(folder_ / "tiles");
  touch("tiles/codestream.j2k", "");
  touch("tiles/grid.asc", "ncols 2\nnrows 2\n");
  touch("tiles/signature.asc", "-----BEGIN PGP SIGNATURE-----");
  touch("tiles/light.hdr", "#?RADIANCE\n");
  touch("tiles/raw.hdr", "ENVI\nsamples = 4\n");
  touch("tiles/raw.bil");
  touch("tiles/imagine.img", "EHFA_HEADER_TAG");
  touch("tiles/disk.img");
  touch("tiles/catalogue.vrt", "<VRTDataset>");
  const auto tiles = folder_ / "tiles";
  EXPECT_EQ(expand_input("tiles", folder_.path()).value(),
            (Paths{tiles / "codestream.j2k", tiles / "grid.asc", tiles / "imagine.img", tiles / "light.hdr", tiles / "raw.bil"}));
}

TEST_F(InputList, AListKeepsItsOrderAndIsRelativeToItself) {
  std::filesystem::create_directories(folder_ / "lists/tiles");
  touch("lists/tiles/2.tif");
  touch("lists/tiles/1.tif");
  touch("lists/all.txt", "# on top last\nz.tif\r\n\n  \ntiles\n/elsewhere/a.tif\n");
  const auto lists = folder_ / "lists";
  EXPECT_EQ(expand_input("@lists/all.txt", folder_.path()).value(),
            (Paths{lists / "z.tif", lists / "tiles/1.tif", lists / "tiles/2.tif", "/elsewhere/a.tif"}));
}

TEST_F(InputList, SaysWhatIsEmptyOrMissing) {
  std::filesystem::create_directory(folder_ / "tiles");
  touch("empty.txt", "# nothing\n");
  expect_refused("tiles", ErrorCode::kInvalidData, "no rasters in this folder");
  expect_refused("@empty.txt", ErrorCode::kInvalidData, "names no inputs");
  expect_refused("@missing.txt", ErrorCode::kIo, "No such file");
}

}  // namespace
}  // namespace vt::pipeline
