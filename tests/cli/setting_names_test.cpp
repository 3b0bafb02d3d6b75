#include "tools/cli/setting_names.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <array>

namespace vt::cli {
namespace {

class SettingNames : public testing::Test {
 protected:
  SettingNames() {
    app_.add_flag("--version");
    layer_->add_option("--bands", bands_, "see `crs`, `bands` and `vtinspect info`");
    layer_->add_option("--source-crs", crs_);
  }

  CLI::App app_{"", "program"};
  CLI::App* layer_ = app_.add_subcommand("layer");
  CLI::App* other_ = app_.add_subcommand("other");
  std::string bands_;
  std::string crs_;
};

TEST_F(SettingNames, OptionsOfTheCommandBecomeFlags) {
  EXPECT_EQ(with_flags("choose with `bands`, for example `bands` 4", *layer_), "choose with --bands, for example --bands 4");
  EXPECT_EQ(with_flags("`source-crs`", *layer_), "--source-crs");
}

TEST_F(SettingNames, WhatIsNoOptionOfTheCommandStays) {
  for (const char* text :
       {"", "`range` LOW,HIGH", "`Bands`", "``", "`vtinspect info` bands", "bands", "a lone ` before bands", "`version`"})
    EXPECT_EQ(with_flags(text, *layer_), text);
  EXPECT_EQ(with_flags("choose with `bands`", *other_), "choose with `bands`");
  EXPECT_EQ(with_flags("`version`", app_), "--version");
}

// A path may hold a backquote.
TEST_F(SettingNames, ALoneBackquoteHidesNoName) {
  EXPECT_EQ(with_flags("it`s.tif: choose with `bands`", *layer_), "it`s.tif: choose with --bands");
}

TEST_F(SettingNames, HelpNamesFlagsToo) {
  put_flags_in_help(*layer_);
  EXPECT_EQ(layer_->get_option("--bands")->get_description(), "see `crs`, --bands and `vtinspect info`");
}

TEST_F(SettingNames, OtherPlacesHaveOtherNames) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 1> kNames = {{{"source-crs", "source_crs"}}};
  EXPECT_EQ(with_other_names("say `source-crs` EPSG:nnnn or `crs`", kNames), "say `source_crs` EPSG:nnnn or `crs`");
}

TEST_F(SettingNames, TheRunningCommandIsTheChosenOne) {
  EXPECT_EQ(&running_command(app_), &app_);
  std::vector<std::string> arguments = {"layer"};
  app_.parse(arguments);
  EXPECT_EQ(&running_command(app_), layer_);
}

}  // namespace
}  // namespace vt::cli
