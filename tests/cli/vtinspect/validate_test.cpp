#include "tests/cli/vtinspect/run.h"

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

// tests/golden/unknown-numbers.vts: its layers "aspect" and "later" have unknown channels, "strange" an
// unknown texel format.
TEST_F(VtinspectValidate, UnknownNumbersAreNotesAndConcernTheirLayersOnly) {
  std::filesystem::copy_file(std::filesystem::path(VT_SCHEMAS) / "../tests/golden/unknown-numbers.vts", directory_ / "s.vts");
  const Outcome validated = run({"validate", "s.vts"});
  EXPECT_EQ(validated.exit_code, 0) << validated.err;
  EXPECT_THAT(validated.out,
              testing::AllOf(HasSubstr("note 504: layer aspect: its channel has number 32769"),
                             HasSubstr("note 504: layer later: its channel has number 4711"),
                             HasSubstr("note 505: layer strange: its texel format has number 999"), HasSubstr("s.vts: valid, ")));

  const Outcome info = run({"info", "s.vts"});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, testing::AllOf(HasSubstr("\"later\": channel 4711, rgb8"), HasSubstr("\"strange\": color, format 999"),
                                       HasSubstr("a newer program wrote this format")));
  const auto layers = run_json("vtinspect-info", {"info", "s.vts"})["layers"];
  EXPECT_EQ(layers[1]["channel"], "channel 32769");
  EXPECT_EQ(layers[3]["format"], "format 999");
  EXPECT_EQ(layers[3]["levels"][0]["tiles"], nullptr);

  const auto sampled = run_json("vtinspect-sample", {"sample", "s.vts", "--layer", "later", "--texel", "0,0", "--level", "0"});
  EXPECT_EQ(sampled["channel"], "channel 4711");
  EXPECT_EQ(run({"extract", "s.vts", "--layer", "later", "--level", "0", "-o", "later.png"}).exit_code, 0);
  EXPECT_EQ(run({"compare", "s.vts", "s.vts", "--layer", "later"}).exit_code, 0);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"sample", "s.vts", "--layer", "strange", "--texel", "0,0"}, {"extract", "s.vts", "--layer", "strange", "-o", "o.png"}}) {
    const Outcome refused = run(arguments);
    EXPECT_EQ(refused.exit_code, 3) << arguments[0];
    EXPECT_THAT(refused.err,
                testing::AllOf(HasSubstr("s.vts: layer strange: its texel format has number 999"), HasSubstr("newer program")));
  }
  const Outcome compared = run({"compare", "s.vts", "s.vts"});
  EXPECT_EQ(compared.exit_code, 3);  // that two layers are equal is not said of what cannot be read
  EXPECT_THAT(compared.out + compared.err, HasSubstr("layer strange: its texel format has number 999"));
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
