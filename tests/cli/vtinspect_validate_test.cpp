#include "tests/cli/vtinspect_run.h"

namespace vt::test {
namespace {

using testing::HasSubstr;

class VtinspectValidate : public VtinspectTest {};

TEST_F(VtinspectValidate, AcceptsAGoodStore) {
  write_sample_store(directory_ / "s.vts");
  const Outcome outcome = run({"validate", "s.vts"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("s.vts: valid, "));
  const auto json = run_json("vtinspect-validate", {"validate", "s.vts"});
  EXPECT_EQ(json["ok"], true);
  EXPECT_EQ(json["errors"], 0);
  EXPECT_EQ(json["tiles_checked"], 6 + 2 + 1 + 2 + 1);  // color: 3 x 2, 2 x 1, 1; elevation: 2 x 1, 1
}

TEST_F(VtinspectValidate, FindsADamagedTile) {
  write_sample_store(directory_ / "s.vts");
  flip_bit(directory_ / "s.vts", tile_offset(directory_ / "s.vts", "color", {Level{2}, 1, 1}) + 100);
  const Outcome outcome = run({"validate", "s.vts"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.out, testing::ContainsRegex("error 4[0-9][0-9]: "));
  EXPECT_THAT(outcome.out, HasSubstr("NOT valid"));
  for (const bool quick : {false, true}) {
    std::vector<std::string> arguments = {"validate", "s.vts"};
    if (quick) arguments.emplace_back("--quick");
    const auto json = run_json("vtinspect-validate", arguments, 3);
    EXPECT_EQ(json["ok"], false);
    EXPECT_GE(json["errors"].get<int>(), 1);
    EXPECT_EQ(json["tiles_decoded"], !quick);
    EXPECT_EQ(json["findings"][0]["severity"], "error");
    EXPECT_THAT(json["findings"][0]["place"].get<std::string>(), HasSubstr("color"));
  }
}

TEST_F(VtinspectValidate, ASampleSaysThatItIsOne) {
  write_sample_store(directory_ / "s.vts");
  const Outcome outcome = run({"validate", "s.vts", "--sample", "3", "--seed", "7", "--progress", "none"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::ContainsRegex("sampled: [123] of 12 tiles, seed 7; "));
  auto json = run_json("vtinspect-validate", {"validate", "s.vts", "--sample", "3"});
  EXPECT_EQ(json["sampled"], true);
  EXPECT_EQ(json["tiles_in_store"], 12);
  EXPECT_LE(json["tiles_checked"], 3);
  json = run_json("vtinspect-validate", {"validate", "s.vts", "--sample", "12"});
  EXPECT_EQ(json["sampled"], false);
  EXPECT_EQ(json["tiles_checked"], 12);
}

TEST_F(VtinspectValidate, ProgressGoesToStandardErrorOnly) {
  write_sample_store(directory_ / "s.vts");
  const Outcome plain = run({"validate", "s.vts", "--progress", "plain"});
  const Outcome none = run({"validate", "s.vts", "--progress", "none"});
  EXPECT_THAT(plain.err, HasSubstr("validating: 12 tiles in "));
  EXPECT_EQ(none.err, "");
  EXPECT_EQ(plain.out, none.out);
}

}  // namespace
}  // namespace vt::test
