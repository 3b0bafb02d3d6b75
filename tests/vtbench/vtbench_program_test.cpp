#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "builder/source/geotiff_writer.h"
#include "tests/support/temp_folder.h"
#include "tests/vtbench/result_files.h"
#include "tools/bench_child.h"
#include "tools/bench_support.h"

namespace vt::bench {
namespace {

class Vtbench : public ::testing::Test {
 protected:
  int run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), VT_VTBENCH);
    const auto child = run_child({arguments, {}, folder_ / "out", folder_ / "err"});
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

  test::TempFolder folder_;
};

double number(const std::map<std::string, std::string>& row, const std::string& key) { return std::stod(row.at(key)); }

TEST_F(Vtbench, AccuracyWritesWhatItMeasured) {
  ASSERT_EQ(run({"accuracy", "--size", "512", "--runs", "1", "--compressions", "none,zstd:1", "--csv", file("a.csv"), "--svg",
                 file("a.svg"), "--scratch", file("scratch")}),
            0)
      << text("err");
  const auto rows = parse_csv(text("a.csv"));
  ASSERT_EQ(rows.size(), 9U);  // 2 kernels x 2 formats x 2 compressions, and the codes averaged
  std::map<std::string, std::map<std::string, std::string>> by_name;
  for (const auto& row : rows) by_name[row.at("kernel") + " " + row.at("format") + " " + row.at("compression")] = row;
  const auto& box = by_name.at("box rgb8 none");
  const auto& kaiser = by_name.at("kaiser3 rgb8 none");
  const auto& kaiser_bc1 = by_name.at("kaiser3 bc1 zstd:1");
  EXPECT_GT(number(box, "mpx_per_s"), 0.0);
  EXPECT_EQ(box.at("base_psnr_code_db"), "inf");  // the finest level is kept byte for byte
  EXPECT_GT(number(kaiser, "psnr_linear_db"), number(box, "psnr_linear_db"));
  EXPECT_GT(number(kaiser, "psnr_linear_db"), number(kaiser_bc1, "psnr_linear_db"));
  EXPECT_GT(number(kaiser_bc1, "psnr_code_db"), 25.0);
  EXPECT_LT(std::abs(number(kaiser, "luminance_drift_percent")), 0.1);
  EXPECT_LT(number(kaiser_bc1, "bytes_per_texel"), 0.51);
  EXPECT_NEAR(number(box, "bytes_per_texel"), 3.0, 0.01);
  // Compression loses nothing.
  EXPECT_EQ(by_name.at("box rgb8 zstd:1").at("psnr_code_db"), box.at("psnr_code_db"));
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
  ASSERT_EQ(run({"build", file("in.tif"), "--runs", "1", "--peers", "none", "--csv", file("b.csv"), "--svg", file("b.svg"), "--scratch",
                 file("scratch")}),
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
    }
    if (row.at("kind") == "parts") {
      EXPECT_GT(number(row, "build_over_parts"), 1.0);
    }
  }
  EXPECT_EQ(kinds["ours"], 4);
  EXPECT_EQ(kinds["parts"], 4);
  EXPECT_EQ(kinds["part"], 3 + 3 + 5 + 4);
  EXPECT_EQ(xml_complaint(text("b.svg")), "");
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
  EXPECT_EQ(run({"frame", file("missing.vts"), "--path", "vulkan"}), 1);
  for (const char* command : {"build", "accuracy", "lookup", "frame"}) {
    EXPECT_EQ(run({command, "--help"}), 0);
    EXPECT_NE(text("out").find("Examples:"), std::string::npos);
  }
}

}  // namespace
}  // namespace vt::bench
