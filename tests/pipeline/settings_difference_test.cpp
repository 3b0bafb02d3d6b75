#include "builder/pipeline/plan/settings_difference.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace vt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

TEST(SettingsDifference, NamesWhatUsersGiveWithBothValues) {
  const Json there =
      Json::parse(R"({"kernel": "kaiser3", "tile": 256, "options": {"zero": "128", "y": "up"}, "parts": [1], "sources": [1]})");
  EXPECT_EQ(settings_difference(there, there), "");
  Json here = there;
  here["sources"] = {2};
  EXPECT_EQ(settings_difference(there, here), "") << "sources are told apart elsewhere";
  here["kernel"] = "box";
  here["parts"] = {2};
  EXPECT_EQ(settings_difference(there, here), "`kernel`: kaiser3 there, box here");
  here["options"] = {{"y", "down"}};
  EXPECT_EQ(settings_difference(there, here),
            "`kernel`: kaiser3 there, box here; `zero`: 128 there, not given here; `y`: up there, down here");
  here["range"] = {0.5, 1.0};
  EXPECT_EQ(settings_difference(there, here).substr(settings_difference(there, here).size() - 11), " and 1 more");
}

TEST(SettingsDifference, NamesWhatFollowsWhenNothingElseDiffers) {
  EXPECT_EQ(settings_difference(Json::parse(R"({"rules": 2})"), Json::object()), "rules: 2 there, not given here");
  EXPECT_EQ(settings_difference(Json::parse(R"({"grid": [0, 1]})"), Json::parse(R"({"grid": [0, 2]})")), "grid: [0,1] there, [0,2] here");
}

TEST(SourceDifference, TellsChangedFromNewAndGone) {
  const Json a = {{"path", "a.tif"}, {"content", "1"}};
  const Json b = {{"path", "b.tif"}, {"content", "2"}};
  Json changed = a;
  changed["content"] = "3";
  EXPECT_EQ(source_difference({a, b}, {a, b}), "");
  EXPECT_EQ(source_difference({a, b}, {b, a}), "in another order");
  EXPECT_EQ(source_difference(Json::array({a}), Json::array({changed})), "changed: a.tif");
  EXPECT_EQ(source_difference(Json::array({a}), Json::array({changed, b})), "changed: a.tif; new: b.tif");
  EXPECT_EQ(source_difference(Json::array({a, b}), Json::array({b})), "gone: a.tif");
  EXPECT_EQ(source_difference({{"count", 70}, {"content", "x"}}, Json::array({a})), "70 sources there and 1 here, not all the same");
}

}  // namespace
}  // namespace vt::pipeline
