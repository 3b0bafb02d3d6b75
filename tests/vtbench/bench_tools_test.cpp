#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "store/io/output_file.h"
#include "tests/support/temp_folder.h"
#include "tests/vtbench/result_files.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/child_process.h"
#include "tools/vtbench/report/svg.h"
#include "tools/vtbench/report/table.h"

namespace vt::bench {
namespace {

TEST(Spread, MedianIsTheMiddleOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(spread_of({5.0, 1.0, 3.0}).median, 3.0);
  EXPECT_EQ(spread_of({8.0, 1.0, 3.0, 4.0}).median, 3.5);
  EXPECT_EQ(spread_of({8.0, 1.0, 3.0, 4.0}).min, 1.0);
  EXPECT_EQ(spread_of({8.0, 1.0, 3.0, 4.0}).max, 8.0);
  EXPECT_EQ(spread_of({2.0}).median, 2.0);
}

TEST(ScratchFolder, GoesWithItsContents) {
  const test::TempFolder parent;
  std::filesystem::path path;
  {
    auto scratch = ScratchFolder::create(parent / "new");
    ASSERT_TRUE(scratch.has_value()) << scratch.error().message;
    const ScratchFolder moved = std::move(*scratch);
    path = moved.path();
    ASSERT_TRUE(store::write_whole_file(moved / "file", "text").has_value());
    EXPECT_EQ(read_text_file(moved / "file").value(), "text");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::exists(parent / "new"));
}

TEST(Table, CsvKeepsCommasQuotesLinesAndFullByteCounts) {
  Table table({{"name", "name"}, {"bytes", "bytes", 0}, {"rate", "", 1}});
  table.add_row({std::string("a, \"b\"\r\nc"), 1073741824.0, 1.0 / 3.0});
  table.add_row({std::string("d"), Cell(), std::numeric_limits<double>::infinity()});
  const auto rows = parse_csv(table.csv());
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("name"), "a, \"b\"\r\nc");
  EXPECT_EQ(rows[0].at("bytes"), "1073741824");
  EXPECT_EQ(rows[0].at("rate"), "0.333333");
  EXPECT_EQ(rows[1].at("bytes"), "");
  EXPECT_EQ(rows[1].at("rate"), "inf");
  EXPECT_TRUE(table.json()[1]["rate"].is_null());
  EXPECT_EQ(table.json()[0]["bytes"], 1073741824.0);
}

TEST(Table, TextAlignsNumbersRightAndLeavesUntitledColumnsOut) {
  Table table({{"name", "name"}, {"hidden", ""}, {"rate", "rate", 1}});
  table.add_row({std::string("long name"), 1.0, 9.25});
  table.add_row({std::string("x"), 1.0, 100.0});
  EXPECT_EQ(table.text(),
            "name        rate\n"
            "long name    9.2\n"
            "x          100.0\n");
}

TEST(Table, NamedCellsFindTheirColumnsAndOthersStayEmpty) {
  Table table({{"a", "A"}, {"b", "B"}, {"c", "C", 0}});
  table.add_named_row({{"c", 3.0}, {"a", std::string("one")}});
  const auto rows = parse_csv(table.csv());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("a"), "one");
  EXPECT_EQ(rows[0].at("b"), "");
  EXPECT_EQ(rows[0].at("c"), "3");
}

TEST(Table, MarkdownShowsWhatPeopleSeeAndEscapesBars) {
  Table table({{"name", "name"}, {"hidden", ""}, {"rate", "rate", 1}});
  table.add_row({std::string("a|b\nc"), 1.0, 9.25});
  table.add_row({std::string("x"), 1.0, Cell()});
  EXPECT_EQ(table.markdown(),
            "| name | rate |\n"
            "| --- | ---: |\n"
            "| a\\|b c | 9.2 |\n"
            "| x |  |\n");
}

TEST(Svg, TicksAreRoundAndEncloseTheRange) {
  EXPECT_EQ(round_ticks(0.0, 47.0, 5), (std::vector<double>{0, 10, 20, 30, 40, 50}));
  EXPECT_EQ(round_ticks(-3.0, 4.0, 4), (std::vector<double>{-4, -2, 0, 2, 4}));
  const auto fine = round_ticks(0.1, 0.11, 5);
  EXPECT_LE(fine.front(), 0.1);
  EXPECT_GE(fine.back(), 0.11);
  EXPECT_GE(round_ticks(3.0, 3.0, 5).size(), 2U);  // one value only
}

TEST(Svg, TheXmlCheckFindsFaults) {
  EXPECT_EQ(xml_complaint("<a b=\"1\"><c/>text &amp; more</a>\n"), "");
  for (const char* bad :
       {"", "<a>", "<a></b>", "<a/><b/>", "<a b=1/>", "<a b=\"1\" b=\"2\"/>", "<a>x & y</a>", "<a b=\"<\"/>", "<a", "text"})
    EXPECT_NE(xml_complaint(bad), "") << bad;
}

TEST(Svg, ChartsAreWellFormedWhateverTheLabelsSay) {
  const std::string hostile = "<b> & \"c\" \n 'd'";
  const BarChart bars{hostile, hostile, {hostile}, {{hostile, {{hostile, 3.0, 2.0, 4.0, true}, {"zero", 0.0, 0.0, 0.0, false}}}}};
  EXPECT_EQ(xml_complaint(svg_of(bars)), "");
  EXPECT_EQ(svg_of(bars).find("nan"), std::string::npos);

  ScatterChart points{
      hostile, hostile, hostile, true, {hostile}, {{hostile, {{0.5, 40.0, hostile}, {250.0, 40.0, "x"}}}}, ReferenceLine{44.0, hostile}};
  EXPECT_EQ(xml_complaint(svg_of(points)), "");
  EXPECT_EQ(svg_of(points).find("nan"), std::string::npos);
  points.log_x = false;
  points.line.reset();  // then all points share one height
  EXPECT_EQ(xml_complaint(svg_of(points)), "");
  EXPECT_EQ(svg_of(points).find("nan"), std::string::npos);
}

class Child : public ::testing::Test {
 protected:
  [[nodiscard]] Result<ChildRun> shell(const std::string& script) const {
    return run_child({{"/bin/sh", "-c", script}, {{"VT_CHILD_TEST", "given"}}, folder_ / "out", folder_ / "err"});
  }
  test::TempFolder folder_;
};

TEST_F(Child, ReportsExitCodesAndSignals) {
  EXPECT_EQ(shell("exit 0").value().exit_code, 0);
  EXPECT_EQ(shell("exit 7").value().exit_code, 7);
  EXPECT_EQ(shell("kill -TERM $$").value().exit_code, 128 + 15);
}

TEST_F(Child, KeepsOutputAndErrorsApartAndPassesTheEnvironment) {
  ASSERT_EQ(shell("echo $VT_CHILD_TEST; echo trouble >&2; test -n \"$PATH\"").value().exit_code, 0);
  EXPECT_EQ(read_text_file(folder_ / "out").value(), "given\n");
  EXPECT_EQ(read_text_file(folder_ / "err").value(), "trouble\n");
}

TEST_F(Child, MeasuresTimeFromOutside) {
  const ChildRun asleep = shell("sleep 0.1").value();
  EXPECT_GE(asleep.seconds, 0.1);
  EXPECT_LT(asleep.processor_seconds, asleep.seconds);
  EXPECT_GT(asleep.peak_bytes, 100000U);  // a shell is larger than 100 kB
}

TEST_F(Child, PeakFollowsWhatTheChildTouches) {
  // dd fills one buffer of the block's size: more than this process has itself, so what is seen is the
  // child's.
  constexpr std::uint64_t kBlock = std::uint64_t{256} << 20;
  const ChildRun small = shell("exec dd if=/dev/zero of=/dev/null bs=1 count=1").value();
  const ChildRun large = shell("exec dd if=/dev/zero of=/dev/null bs=268435456 count=1").value();
  EXPECT_EQ(large.exit_code, 0);
  EXPECT_GE(large.peak_bytes, kBlock);
  EXPECT_LT(large.peak_bytes, kBlock + (std::uint64_t{64} << 20));
  EXPECT_LT(small.peak_bytes, kBlock);
}

TEST_F(Child, AProgramThatIsNotThereIsAnErrorThatNamesIt) {
  const auto run = run_child({{"/nowhere/program"}, {}, folder_ / "out", folder_ / "out"});
  ASSERT_FALSE(run.has_value());
  EXPECT_EQ(run.error().code, ErrorCode::kIo);
  EXPECT_NE(run.error().message.find("/nowhere/program"), std::string::npos);
  EXPECT_NE(run.error().message.find("No such file"), std::string::npos);
}

TEST(FindProgram, FindsWhatAShellWouldFind) {
  EXPECT_TRUE(find_program("sh").has_value());
  EXPECT_FALSE(find_program("no-such-program-anywhere").has_value());
  EXPECT_FALSE(find_program("").has_value());  // a folder is no program
}

TEST(ShellText, QuotesWhatAShellWouldTakeApart) { EXPECT_EQ(shell_text({"a", "b c", "it's", "", "x=1"}), "a 'b c' 'it'\\''s' '' x=1"); }

}  // namespace
}  // namespace vt::bench
