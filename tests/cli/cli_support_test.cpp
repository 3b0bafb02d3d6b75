#include "tools/cli/cli_support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <charconv>
#include <new>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

namespace vt::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(ExitCode, FollowsTheDocumentedTable) {
  EXPECT_EQ(exit_code(ErrorCode::kUsage), 1);
  EXPECT_EQ(exit_code(ErrorCode::kIo), 2);
  EXPECT_EQ(exit_code(ErrorCode::kExists), 2);
  EXPECT_EQ(exit_code(ErrorCode::kNotFound), 2);
  EXPECT_EQ(exit_code(ErrorCode::kInvalidData), 3);
  EXPECT_EQ(exit_code(ErrorCode::kUnsupported), 3);
  EXPECT_EQ(exit_code(ErrorCode::kCorrupt), 3);
  EXPECT_EQ(exit_code(ErrorCode::kInternal), 4);
  EXPECT_EQ(exit_code(ErrorCode::kCancelled), 130);
}

// run_main with one argument, and what it wrote.
struct Observed {
  int code = -1;
  std::string out;
  std::string err;
};
Observed run_app(const char* argument, const std::function<Result<int>()>& command) {
  CLI::App app("A program.", "prog");
  add_help_footer(app, "  prog --number 3");
  int number = 0;
  app.add_option("--number", number, "a number");
  std::vector<const char*> argv = {"prog"};
  if (argument != nullptr) argv.push_back(argument);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Observed result;
  result.code = run_main(app, static_cast<int>(argv.size()), argv.data(), command);
  result.out = testing::internal::GetCapturedStdout();
  result.err = testing::internal::GetCapturedStderr();
  return result;
}

TEST(RunMain, GivesTheCommandsOwnCode) {
  EXPECT_EQ(run_app(nullptr, [] { return 0; }).code, 0);
  EXPECT_EQ(run_app(nullptr, [] { return 3; }).code, 3);
}

TEST(RunMain, PrintsAnErrorAsOneLine) {
  const Observed result = run_app(nullptr, []() -> Result<int> { return fail(ErrorCode::kIo, "base.tif: no such file"); });
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(result.err, "prog: base.tif: no such file\n");
  EXPECT_EQ(result.out, "");
}

TEST(RunMain, TurnsAnEscapedExceptionIntoAnInternalError) {
  const Observed result = run_app(nullptr, []() -> Result<int> { throw std::runtime_error("surprise"); });
  EXPECT_EQ(result.code, 4);
  EXPECT_THAT(result.err, AllOf(StartsWith("prog: internal error"), HasSubstr("surprise")));
}

TEST(RunMain, WhatTheSystemRefusesIsNotOurFault) {
  const Observed memory = run_app(nullptr, []() -> Result<int> { throw std::bad_alloc(); });
  EXPECT_EQ(memory.code, 2);
  EXPECT_THAT(memory.err, HasSubstr("prog: not enough memory"));
  const Observed threads = run_app(
      nullptr, []() -> Result<int> { throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again), "thread"); });
  EXPECT_EQ(threads.code, 2);
  EXPECT_THAT(threads.err, HasSubstr("prog: the system refused something that is needed: thread"));
}

TEST(RunMain, NothingThatIsPrintedSteersTheTerminal) {
  const std::string name = "a\x1b[31m\xc2\x9b\xff\nb\tc";
  const std::string shown = "a\\u001b[31m\\u009b\\xff\nb\tc";
  const Observed observed = run_app(nullptr, [&]() -> Result<int> {
    print(name + "\n");
    print_json({{"name", name}});
    print_note("prog", name);
    return fail(ErrorCode::kIo, name);
  });
  EXPECT_EQ(observed.out, shown + "\n{\n  \"name\": \"a\\u001b[31m\\u009b\xef\xbf\xbd\\nb\\tc\"\n}\n");
  EXPECT_EQ(observed.err, "prog: " + shown + "\nprog: " + shown + "\n");
  EXPECT_THAT(run_app("--\x1b[31m", []() -> Result<int> { return 0; }).err, AllOf(HasSubstr("\\u001b[31m"), Not(HasSubstr("\x1b"))));

  std::ostringstream out;
  Progress progress({.title = "building \x1b[31m\n", .unit = "texels", .total = 4, .out = &out, .out_is_terminal = false});
  progress.update(0);
  progress.note(name);
  progress.finish();
  EXPECT_THAT(out.str(), AllOf(HasSubstr("building \\u001b[31m\\u000a: 4 texels"), HasSubstr(shown), Not(HasSubstr("\x1b"))));
}

TEST(RunMain, CallsWrongUsageByItsName) {
  for (const char* argument : {"--number=three", "--nonsense", "stray"}) {
    const Observed result = run_app(argument, []() -> Result<int> { throw std::logic_error("must not run"); });
    EXPECT_EQ(result.code, 1) << argument;
    EXPECT_THAT(result.err, AllOf(StartsWith("prog: "), HasSubstr("--help"))) << argument;
    EXPECT_EQ(result.out, "") << argument;
  }
}

TEST(RunMain, HelpHasExamplesAndExitCodes) {
  const Observed result = run_app("--help", []() -> Result<int> { throw std::logic_error("must not run"); });
  EXPECT_EQ(result.code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:\n  prog --number 3"), HasSubstr("Exit codes:"), HasSubstr("3 invalid data")));
  EXPECT_EQ(result.err, "");
}

TEST(Format, BytesStayBelowAThousandTwentyFour) {
  EXPECT_EQ(format_bytes(0), "0 B");
  EXPECT_EQ(format_bytes(1023), "1023 B");
  EXPECT_EQ(format_bytes(1024), "1.0 KiB");
  EXPECT_EQ(format_bytes((1U << 20) - 1), "1.0 MiB");  // not "1024.0 KiB"
  EXPECT_EQ(format_bytes(std::uint64_t{5} << 30), "5.0 GiB");
  EXPECT_EQ(format_bytes(~std::uint64_t{0}), "16.0 EiB");
}

TEST(Format, QuantitiesKeepThreeDigits) {
  EXPECT_EQ(format_quantity(0.0), "0");
  EXPECT_EQ(format_quantity(12.0), "12");
  EXPECT_EQ(format_quantity(0.333), "0.33");
  EXPECT_EQ(format_quantity(1234.0), "1.23 k");
  EXPECT_EQ(format_quantity(999600.0), "1.00 M");
  EXPECT_EQ(format_quantity(256e6), "256 M");
}

TEST(Format, DurationsReadLikeAClock) {
  EXPECT_EQ(format_duration(0.2), "0:00");
  EXPECT_EQ(format_duration(67.0), "1:07");
  EXPECT_EQ(format_duration(3723.0), "1:02:03");
  EXPECT_EQ(format_duration(1e300).substr(0, 3), "277");  // capped, not overflown
}

TEST(Format, ExactNumbersReadBackAsThemselves) {
  for (const double value : {0.1, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 499980.0}) {
    const std::string text = format_exact(value);
    double back = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    EXPECT_EQ(back, value) << text;
  }
}

// A progress display in a world where time passes when the test says so.
class ProgressTest : public testing::Test {
 protected:
  ProgressOptions options(bool terminal, std::uint64_t total) {
    ProgressOptions result;
    result.title = "building";
    result.unit = "tiles";
    result.total = total;
    result.clock = [this] { return now_; };
    result.out = &out_;
    result.out_is_terminal = terminal;
    result.terminal_columns = 80;
    return result;
  }
  [[nodiscard]] std::size_t count(char c) const {
    const std::string text = out_.str();
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), c));
  }

  std::chrono::steady_clock::time_point now_{};
  std::ostringstream out_;
};

TEST_F(ProgressTest, RedrawsATerminalAtMostTenTimesASecond) {
  Progress progress(options(true, 10000));
  for (int i = 0; i < 2000; ++i) {  // two seconds, a thousand updates each
    progress.update(static_cast<std::uint64_t>(i));
    now_ += milliseconds(1);
  }
  EXPECT_GE(count('\r'), 19U);
  EXPECT_LE(count('\r'), 21U);
  EXPECT_EQ(count('\n'), 0U);
}

TEST_F(ProgressTest, NeverDrawsWiderThanTheTerminal) {
  for (const int columns : {10, 40, 80, 200}) {
    ProgressOptions narrow = options(true, 1000000);
    narrow.terminal_columns = columns;
    out_.str("");
    {
      Progress progress(narrow);
      progress.update(0);
      now_ += seconds(1);
      progress.update(123456);
    }
    std::string line;
    std::istringstream lines(out_.str());
    while (std::getline(lines, line, '\r')) {
      const std::size_t visible = line.substr(0, line.find('\x1b')).size();
      EXPECT_LT(visible, static_cast<std::size_t>(columns)) << line;
    }
  }
}

TEST_F(ProgressTest, SaysRateAndTimeLeft) {
  Progress progress(options(true, 1000));
  progress.update(0);
  now_ += seconds(2);
  progress.update(200);  // 100 a second, 8 seconds to go
  EXPECT_THAT(out_.str(), AllOf(HasSubstr(" 20 %"), HasSubstr("200/1000 tiles"), HasSubstr("100/s"), HasSubstr("0:08 left")));
}

// Work whose speed goes up and down by half at random from second to second. What is left when that no longer
// averages out, the last minute and a half, is not looked at.
TEST_F(ProgressTest, TimeLeftIsWithinTenPercentAfterTheFirstTenth) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> speed(0.5, 1.5);
    std::vector<double> done_after{0.0};
    while (done_after.back() < 1e6) {
      done_after.push_back(done_after.back() + 1000.0 * speed(random));
    }
    const double end = static_cast<double>(done_after.size() - 1);
    Progress progress(options(false, 1000000));
    progress.update(0);
    for (std::size_t second = 1; second + 90 < done_after.size(); ++second) {
      now_ += seconds(1);
      out_.str("");
      progress.update(static_cast<std::uint64_t>(done_after[second]));
      const std::string line = out_.str();
      if (line.empty() || done_after[second] < 1e5) continue;
      std::istringstream text(line.substr(line.rfind("/s") + 2));
      int minutes = 0;
      int rest = 0;
      char colon = 0;
      ASSERT_TRUE(text >> minutes >> colon >> rest) << line;
      const double left = end - static_cast<double>(second);
      EXPECT_NEAR(60.0 * minutes + rest, left, 0.1 * left + 1.0) << line;  // printed in whole seconds
    }
  }
}

TEST_F(ProgressTest, DoesNotCountResumedWorkIntoTheRate) {
  Progress progress(options(true, 1000));
  progress.update(500);  // an earlier run's
  now_ += seconds(10);
  progress.update(600);
  EXPECT_THAT(out_.str(), AllOf(HasSubstr("10/s"), HasSubstr("0:40 left")));
  progress.finish();
  EXPECT_THAT(out_.str(), HasSubstr("building: 1000 tiles (500 of them before this run) in 10.0 s, 50/s\n"));
}

TEST_F(ProgressTest, WritesALogLineEveryFiveSeconds) {
  Progress progress(options(false, 1000000));
  for (int i = 0; i <= 300; ++i) {  // 30 seconds, far from the first tenth
    progress.update(static_cast<std::uint64_t>(i));
    now_ += milliseconds(100);
  }
  EXPECT_EQ(count('\n'), 6U);
  EXPECT_EQ(count('\r'), 0U);
}

TEST_F(ProgressTest, WritesALogLineForEveryTenth) {
  Progress progress(options(false, 100));
  for (std::uint64_t i = 0; i <= 100; ++i) {  // 10 s: a tenth a second
    progress.update(i);
    now_ += milliseconds(100);
  }
  EXPECT_EQ(count('\n'), 10U);
}

TEST_F(ProgressTest, DoesNotFloodALogWithShortWork) {
  Progress progress(options(false, 1000));
  for (std::uint64_t i = 0; i <= 1000; ++i) progress.update(i);
  EXPECT_EQ(out_.str(), "");
  progress.finish();
  EXPECT_EQ(count('\n'), 1U);
}

TEST_F(ProgressTest, IgnoresValuesThatComeLate) {
  Progress progress(options(true, 100));
  progress.update(0);
  now_ += seconds(1);
  progress.update(50);
  now_ += seconds(1);
  progress.update(40);
  EXPECT_THAT(out_.str(), AllOf(HasSubstr("50/100"), Not(HasSubstr("40/100"))));
}

TEST_F(ProgressTest, EndsAnOpenLineWhenWorkIsGivenUp) {
  {
    Progress progress(options(true, 100));
    progress.update(10);
  }
  EXPECT_EQ(out_.str().back(), '\n');
  EXPECT_THAT(out_.str(), Not(HasSubstr("100 tiles in")));
}

TEST_F(ProgressTest, KeepsNotesApartFromTheBar) {
  Progress progress(options(true, 100));
  progress.update(10);
  progress.note("a.tif: no CRS");
  EXPECT_THAT(out_.str(), HasSubstr("\r\x1b[Ka.tif: no CRS\n\rbuilding"));
}

TEST_F(ProgressTest, IsSilentWhenAskedToBe) {
  ProgressOptions silent = options(true, 100);
  silent.mode = ProgressMode::kNone;
  {
    Progress progress(silent);
    progress.update(10);
    now_ += seconds(10);
    progress.update(20);
    progress.finish();
  }
  EXPECT_EQ(out_.str(), "");
}

TEST_F(ProgressTest, WritesLinesOnATerminalInPlainMode) {
  ProgressOptions plain = options(true, 100);
  plain.mode = ProgressMode::kPlain;
  Progress progress(plain);
  progress.update(0);
  now_ += seconds(6);
  progress.update(20);
  EXPECT_EQ(count('\r'), 0U);
  EXPECT_EQ(count('\n'), 1U);
}

TEST(Progress, MayBeUpdatedFromManyThreads) {
  std::ostringstream out;
  ProgressOptions options;
  options.title = "building";
  options.unit = "tiles";
  options.total = 40000;
  options.out = &out;
  options.out_is_terminal = true;
  options.terminal_columns = 80;
  Progress progress(options);
  progress.update(0);
  std::atomic<std::uint64_t> done{0};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (int j = 0; j < 10000; ++j) progress.update(++done);
      });
    }
  }
  progress.finish();
  EXPECT_THAT(out.str(), HasSubstr("building: 40000 tiles in "));
}

}  // namespace
}  // namespace vt::cli
