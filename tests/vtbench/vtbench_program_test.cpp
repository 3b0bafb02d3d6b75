#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "builder/source/tiff/geotiff_writer.h"
#include "store/io/output_file.h"
#include "tests/support/temp_folder.h"
#include "tests/vtbench/result_files.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/child_process.h"

namespace vt::bench {
namespace {

class Vtbench : public ::testing::Test {
 protected:
  int run(std::vector<std::string> arguments, std::vector<std::pair<std::string, std::string>> environment = {}) {
    arguments.insert(arguments.begin(), VT_VTBENCH);
    const auto child = run_child({arguments, std::move(environment), folder_ / "out", folder_ / "err"});
    EXPECT_TRUE(child.has_value()) << (child ? "" : child.error().message);
    return child ? child->exit_code : -1;
  }
  [[nodiscard]] std::string text(const std::string& name) const { return read_text_file(folder_ / name).value_or(""); }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  // The scratch folder's contents after a run.
  [[nodiscard]] bool left_nothing() const { return std::filesystem::is_empty(folder_ / "scratch"); }

  void write_picture(const std::string& name, std::int64_t size) const {
    source::GeoTiffSpec spec;
    spec.width = spec.height = size;
    spec.bands = 3;
    auto writer = source::GeoTiffWriter::create(folder_ / name, spec);
    ASSERT_TRUE(writer.has_value()) << writer.error().message;
    std::vector<std::byte> rgb;
    for (std::int64_t i = 0; i < size * size * 3; ++i) rgb.push_back(static_cast<std::byte>(i * i >> 7));
    ASSERT_TRUE(writer->write_rows(rgb, size).has_value());
    ASSERT_TRUE(writer->finish().has_value());
  }

  void write_heights(const std::string& name, std::int64_t size) const {
    source::GeoTiffSpec spec;
    spec.width = spec.height = size;
    spec.sample_type = SampleType::kFloat32;
    auto writer = source::GeoTiffWriter::create(folder_ / name, spec);
    ASSERT_TRUE(writer.has_value()) << writer.error().message;
    std::vector<float> heights;
    for (std::int64_t i = 0; i < size * size; ++i) heights.push_back(static_cast<float>(i % 977) * 0.25F);
    ASSERT_TRUE(writer->write_rows(std::as_bytes(std::span(heights)), size).has_value());
    ASSERT_TRUE(writer->finish().has_value());
  }

  test::TempFolder folder_;
};

double number(const std::map<std::string, std::string>& row, const std::string& key) { return std::stod(row.at(key)); }

TEST_F(Vtbench, AccuracyWritesWhatItMeasured) {
  ASSERT_EQ(run({"accuracy", "--size", "512", "--runs", "1", "--compressions", "none,zstd:1", "--csv", file("a.csv"), "--svg",
                 file("a.svg"), "--scratch", file("scratch")}),
            0)
      << text("err");
  const auto rows = parse_csv(text("a.csv"));
  // 2 kernels x 2 formats x 2 compressions, and the codes averaged
  EXPECT_GE(rows.size(), 9U);
  std::map<std::string, std::map<std::string, std::string>> by_name;
  for (const auto& row : rows)
    by_name[row.at("program") + " " + row.at("kernel") + " " + row.at("format") + " " + row.at("compression")] = row;
  const auto& box = by_name.at("vtbuild box rgb8 none");
  const auto& kaiser = by_name.at("vtbuild kaiser3 rgb8 none");
  const auto& kaiser_bc1 = by_name.at("vtbuild kaiser3 bc1 zstd:1");
  EXPECT_GT(number(box, "mpx_per_s"), 0.0);
  EXPECT_EQ(box.at("base_psnr_code_db"), "inf");  // the finest level is kept byte for byte
  EXPECT_GT(number(kaiser, "psnr_linear_db"), number(box, "psnr_linear_db"));
  EXPECT_GT(number(kaiser, "psnr_linear_db"), number(kaiser_bc1, "psnr_linear_db"));
  EXPECT_GT(number(kaiser_bc1, "psnr_code_db"), 25.0);
  EXPECT_LT(std::abs(number(kaiser, "luminance_drift_percent")), 0.1);
  EXPECT_LT(number(kaiser_bc1, "bytes_per_texel"), 0.51);
  EXPECT_NEAR(number(box, "bytes_per_texel"), 3.0, 0.01);
  // Only rounding, half a code, stands between a stored level and its kernel's formula; floats on the way add
  // a few thousandths.
  EXPECT_LT(number(box, "kernel_max_dn"), 0.51);
  EXPECT_LT(number(kaiser, "kernel_max_dn"), 0.51);
  const auto& by_definition = by_name.at("by definition box of codes rgb8 ");
  EXPECT_GT(number(by_definition, "kernel_max_dn"), 1.0);
  if (find_program("gdal_translate") && find_program("gdaladdo")) {
    // Means of codes, whoever takes them: as far from the ideal as their definition, but for the rounding of
    // ties.
    const auto& gdal = by_name.at("gdaladdo -r average  rgb8 none");
    EXPECT_GT(number(gdal, "mpx_per_s"), 0.0);
    EXPECT_EQ(gdal.at("base_psnr_code_db"), "inf");
    EXPECT_NEAR(number(gdal, "psnr_linear_db"), number(by_definition, "psnr_linear_db"), 0.5);
  }
  if (find_program("gdal_translate") && find_program("vips")) {
    const auto& vips = by_name.at("vips tiffsave --pyramid  rgb8 none");
    EXPECT_NEAR(number(vips, "psnr_linear_db"), number(by_definition, "psnr_linear_db"), 0.5);
  }
  // Compression loses nothing.
  EXPECT_EQ(by_name.at("vtbuild box rgb8 zstd:1").at("psnr_code_db"), box.at("psnr_code_db"));
  EXPECT_EQ(xml_complaint(text("a.svg")), "");
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, LookupTimesTheIndexAndTheCodecs) {
  ASSERT_EQ(run({"lookup", "--tiles", "1,5000", "--peer-tiles", "2000", "--runs", "1", "--json", "--csv", file("l.csv"), "--scratch",
                 file("scratch")}),
            0)
      << text("err");
  const auto rows = parse_csv(text("l.csv"));
  std::map<std::string, int> count;
  for (const auto& row : rows) {
    ++count[row.at("what")];
    const bool is_left_out = row.at("note").find("left out") != std::string::npos;
    EXPECT_EQ(row.at("median_ns").empty(), is_left_out) << row.at("what");
    if (is_left_out) continue;
    EXPECT_GT(number(row, "median_ns"), 0.0) << row.at("what");
  }
  for (const char* what : {"write the index", "open", "lookup, anywhere", "lookup_many, anywhere", "lookup, along a flight",
                           "update 1000 tiles anywhere", "validate"})
    EXPECT_EQ(count[what], 2) << what;
  EXPECT_EQ(count["read a tile, bc1 zstd:3"], 1);
  const auto report = nlohmann::json::parse(text("out"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["results"].size(), rows.size());
  EXPECT_TRUE(report["machine"]["cpu"].is_string());
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, BuildMeasuresOursAndItsParts) {
  write_picture("in.tif", 300);
  ASSERT_EQ(run({"build", file("in.tif"), "--runs", "1", "--peers", "none", "--csv", file("b.csv"), "--svg", file("b.svg"), "--markdown",
                 file("b.md"), "--scratch", file("scratch")}),
            0)
      << text("err");
  std::map<std::string, int> kinds;
  for (const auto& row : parse_csv(text("b.csv"))) {
    ++kinds[row.at("kind")];
    EXPECT_GT(number(row, "median_s"), 0.0) << row.at("name");
    EXPECT_EQ(row.at("input_width"), "300");
    if (row.at("kind") == "ours") {
      EXPECT_GT(number(row, "peak_rss_bytes"), 1e6);
      EXPECT_GT(number(row, "output_bytes"), 300 * 300 * 0.5);
      EXPECT_EQ(row.at("command").substr(0, 16), "vtbuild layer IN");
      EXPECT_GE(number(row, "sync_s"), 0.0);
    }
    if (row.at("kind") == "parts") {
      EXPECT_GT(number(row, "build_over_parts"), 0.0);
    }
  }
  EXPECT_EQ(kinds["ours"], 4);
  EXPECT_EQ(kinds["parts"], 4);
  EXPECT_EQ(kinds["parts and sync"], 4);
  EXPECT_EQ(kinds["part"], 5 + 5 + 7 + 6);  // reading, filter, writing, sync, hashing; encoder; compression
  EXPECT_NE(text("b.md").find("| box filter, rgb8, uncompressed | vtbuild |"), std::string::npos);
  EXPECT_EQ(xml_complaint(text("b.svg")), "");
  EXPECT_TRUE(left_nothing());
}

// The sums of the parts are what their rows say: over the threads, and with the disk's own time, which
// threads do not share.
TEST_F(Vtbench, PartsOfHeightsAddUp) {
  write_heights("dem.tif", 300);
  ASSERT_EQ(run({"build", file("dem.tif"), "--runs", "1", "--threads", "2", "--peers", "none", "--csv", file("b.csv"), "--scratch",
                 file("scratch")}),
            0)
      << text("err");
  std::map<std::string, double> sum;
  std::map<std::string, double> sync;
  std::set<std::string> jobs;
  for (const auto& row : parse_csv(text("b.csv"))) {
    jobs.insert(row.at("job"));
    const bool is_hashing = row.at("name").find("hashing") != std::string::npos;
    const bool is_sync = row.at("name").find("sync to the disk") != std::string::npos;
    double& so_far = sum[row.at("job")];
    if (is_sync) sync[row.at("job")] = number(row, "median_s");
    if (row.at("kind") == "part" && !is_hashing && !is_sync) so_far += number(row, "median_s") / 2.0;
    if (row.at("kind") == "parts") {
      EXPECT_NEAR(number(row, "median_s"), so_far, 1e-4 * so_far);  // six digits in the file
    }
    if (row.at("kind") == "parts and sync") {
      EXPECT_NEAR(number(row, "median_s"), so_far + sync[row.at("job")], 1e-4 * (so_far + sync[row.at("job")]));
    }
  }
  EXPECT_EQ(jobs, (std::set<std::string>{"elevation, box filter, r32f, uncompressed", "elevation, box filter, r32f, zstd:1"}));
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, APeerThatFailsIsLeftOutAndTheRestIsMeasured) {
  write_picture("in.tif", 64);
  ASSERT_TRUE(std::filesystem::create_directory(folder_ / "programs"));
  const auto fake = folder_ / "programs" / "vips";
  ASSERT_TRUE(store::write_whole_file(fake, "#!/bin/sh\necho out of order >&2\nexit 3\n").has_value());
  std::filesystem::permissions(fake, std::filesystem::perms::owner_all);
  ASSERT_EQ(run({"build", file("in.tif"), "--runs", "2", "--no-parts", "--csv", file("b.csv"), "--scratch", file("scratch")},
                {{"PATH", file("programs")}}),
            0)
      << text("err");
  EXPECT_EQ(parse_csv(text("b.csv")).size(), 4U);  // ours
  EXPECT_NE(text("err").find("vips tiffsave --pyramid is left out"), std::string::npos);
  EXPECT_NE(text("err").find("out of order"), std::string::npos);
}

TEST_F(Vtbench, SourcesBuildsEveryKindOfFile) {
  write_picture("in.tif", 300);
  ASSERT_EQ(run({"sources", file("in.tif"), "--size", "272", "--runs", "1", "--csv", file("s.csv"), "--svg", file("s.svg"), "--scratch",
                 file("scratch")}),
            0)
      << text("err");
  const bool has_gdal = find_program("gdal_translate").has_value();
  std::set<std::string> kinds;
  double tiled_mib = 0.0;
  for (const auto& row : parse_csv(text("s.csv"))) {
    kinds.insert(row.at("file"));
    EXPECT_EQ(row.at("width"), "272");
    EXPECT_GT(number(row, "mpx_per_s"), 0.0);
    EXPECT_EQ(row.at("decode_s").empty(), !has_gdal);
    EXPECT_EQ(row.at("build_over_decode").empty(), !has_gdal);
    if (row.at("file") == "tiled") tiled_mib = number(row, "output_mib");
    // The same samples give the same tiles, beside which a store keeps the files' names; a lossy file gives
    // others.
    if (row.at("file") != "tiled, JPEG") {
      EXPECT_NEAR(number(row, "output_mib"), tiled_mib, 4096.0 / (1024.0 * 1024.0)) << row.at("file");
    }
  }
  EXPECT_EQ(kinds.size(), has_gdal ? 8U : 7U);
  EXPECT_EQ(xml_complaint(text("s.svg")), "");
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, SizesReportsFlatnessAndLeavesOutWhatDoesNotFit) {
  write_picture("in.tif", 1024);
  // 65536 gigapixels need 47 TB.
  ASSERT_EQ(run({"sizes", file("in.tif"), "--gigapixels", "0.0005,0.001,65536", "--csv", file("s.csv"), "--svg", file("s.svg"), "--scratch",
                 file("scratch")}),
            0)
      << text("err");
  const auto rows = parse_csv(text("s.csv"));
  ASSERT_EQ(rows.size(), 4U);
  const double slow = std::min(number(rows[0], "mpx_per_s"), number(rows[1], "mpx_per_s"));
  const double fast = std::max(number(rows[0], "mpx_per_s"), number(rows[1], "mpx_per_s"));
  EXPECT_EQ(rows[0].at("edge"), "768");
  EXPECT_EQ(rows[1].at("edge"), "1024");
  EXPECT_EQ(rows[2].at("mpx_per_s"), "");
  EXPECT_NE(rows[2].at("note").find("left out"), std::string::npos);
  EXPECT_NE(text("err").find("left out"), std::string::npos);
  EXPECT_EQ(rows[3].at("kind"), "flatness");
  EXPECT_NEAR(number(rows[3], "rate_max_over_min"), fast / slow, 1e-4);
  EXPECT_EQ(number(rows[3], "peak_rss_bytes"), std::max(number(rows[0], "peak_rss_bytes"), number(rows[1], "peak_rss_bytes")));
  EXPECT_NE(text("out").find("16 stored tiles"), std::string::npos);
  EXPECT_EQ(xml_complaint(text("s.svg")), "");
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, MosaicHasTheSameTexelsAsTheOneFile) {
  write_picture("in.tif", 1024);
  ASSERT_EQ(run({"mosaic", file("in.tif"), "--files", "7", "--csv", file("m.csv"), "--svg", file("m.svg"), "--scratch", file("scratch")}),
            0)
      << text("err");
  const auto rows = parse_csv(text("m.csv"));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("files"), "1");
  EXPECT_EQ(rows[1].at("files"), "6");  // the largest rectangle of at most seven that is nearly square
  EXPECT_EQ(rows[0].at("gigapixels"), rows[1].at("gigapixels"));
  EXPECT_NEAR(number(rows[1], "time_over_one_file"), number(rows[1], "median_s") / number(rows[0], "median_s"), 1e-3);
  EXPECT_EQ(xml_complaint(text("m.svg")), "");
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, DryRunPrintsCommandsAndRunsNone) {
  write_picture("in.tif", 64);
  ASSERT_EQ(run({"build", file("in.tif"), "--peers", "none", "--dry-run", "--scratch", file("scratch")}), 0) << text("err");
  const std::string out = text("out");
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 4);
  EXPECT_NE(out.find("--kernel kaiser3 --format bc1 --compression zstd:3"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scratch"));
}

TEST_F(Vtbench, WrongUsageAndMissingFilesHaveTheirExitCodes) {
  EXPECT_EQ(run({}), 1);
  EXPECT_EQ(run({"accuracy", "--size", "1000"}), 1);
  EXPECT_EQ(text("err").find("vtbench: --size is a power of two"), 0U);
  EXPECT_EQ(run({"accuracy", "--compressions", "zip"}), 1);
  EXPECT_EQ(run({"build", file("missing.tif")}), 2);
  EXPECT_NE(text("err").find("missing.tif"), std::string::npos);
  write_heights("dem.tif", 64);
  for (const char* command : {"sources", "sizes", "mosaic"}) {
    EXPECT_EQ(run({command, file("missing.tif")}), 2) << command;
    EXPECT_EQ(run({command, file("dem.tif")}), 1) << command;
    EXPECT_NE(text("err").find("dem.tif"), std::string::npos) << command;
  }
  EXPECT_EQ(run({"frame", file("missing.vts"), "--path", "vulkan"}), 1);
  for (const char* command : {"build", "sources", "sizes", "mosaic", "accuracy", "lookup", "frame"}) {
    EXPECT_EQ(run({command, "--help"}), 0);
    EXPECT_NE(text("out").find("Examples:"), std::string::npos);
  }
}

// Ours against the answers by analysis; what other tools make of them is theirs.
TEST_F(Vtbench, TheScoreboardsAnswersAreRight) {
  ASSERT_EQ(
      run({"scoreboard", "--only-ours", "--scratch", (std::filesystem::create_directory(folder_ / "scratch"), file("scratch")), "--json"}),
      0)
      << text("err");
  const auto rows = nlohmann::json::parse(text("out")).at("results");
  const auto ours = [&](std::size_t row) { return rows.at(row).at("vtbuild").get<std::string>(); };
  ASSERT_EQ(rows.size(), 10U);
  EXPECT_EQ(ours(0), "188");
  EXPECT_EQ(ours(1), "255,0,0 alpha 128");
  EXPECT_EQ(ours(2), "100");
  // Half a code of light is 0.3 % of the bar; 8.2 % are Kaiser-3's lobes, which the limit to ringing takes
  // away.
  EXPECT_EQ(ours(3), "box, kaiser3 anti-ringing: 0.3 %; mitchell: 1.7 %; kaiser3: 8.2 %");
  EXPECT_EQ(ours(4), "1.00 (spread kept: 0.50)");
  EXPECT_EQ(ours(5), "129, 0.000, 0.000");
  EXPECT_EQ(ours(6), "33, 0.000, 0.000");
  EXPECT_EQ(ours(7), "0,0,0,0");
  EXPECT_NEAR(std::stod(ours(8)), 0.0, 0.02);  // of a code
  EXPECT_EQ(ours(9), "40/30/30");
  EXPECT_TRUE(left_nothing());
}

TEST_F(Vtbench, EveryChannelAndFormatIsMeasured) {
  std::filesystem::create_directory(folder_ / "scratch");
  ASSERT_EQ(run({"channels", "--size", "128", "--runs", "1", "--only-ours", "--scratch", file("scratch"), "--json"}), 0) << text("err");
  const auto rows = nlohmann::json::parse(text("out")).at("results");
  std::set<std::string> channels;
  for (const auto& row : rows) {
    channels.insert(row.at("channel").get<std::string>());
    EXPECT_GT(row.at("mpx_per_s").get<double>(), 0.0);
  }
  EXPECT_EQ(channels.size(), 8U);
  EXPECT_TRUE(left_nothing());
}

}  // namespace
}  // namespace vt::bench
