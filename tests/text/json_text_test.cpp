#include "builder/text/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vt::text {
namespace {

using testing::HasSubstr;

std::string nested(int depth, char open = '[', char close = ']') {
  return std::string(static_cast<std::size_t>(depth), open) + std::string(static_cast<std::size_t>(depth), close);
}

std::string refusal(const std::string& json) {
  const auto parsed = parse_json(json);
  if (parsed) return "no error";
  EXPECT_EQ(parsed.error().code, ErrorCode::kInvalidData);
  return parsed.error().message;
}

TEST(JsonText, KeepsTheOrderOfMembersWhereThatIsAskedFor) {
  const auto parsed = parse_ordered_json(R"({"z": 1, "a": [true, null, "ü"]})");
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(parsed->dump(), R"({"z":1,"a":[true,null,"ü"]})");
  EXPECT_EQ(parse_json(R"({"z": 1, "a": 2})")->dump(), R"({"a":2,"z":1})");
}

TEST(JsonText, NestsAsDeepAsItSaysAndNoDeeper) {
  EXPECT_TRUE(parse_json(nested(kMaxJsonDepth)));
  EXPECT_THAT(refusal(nested(kMaxJsonDepth + 1)), HasSubstr("line 1, column 65: lists and objects lie more than 64 deep"));
  EXPECT_THAT(refusal("{\"a\":\n" + nested(kMaxJsonDepth) + "}"), HasSubstr("line 2, column 64: lists"));
  // Depths at which a tree could not be destroyed, copied or printed by recursion.
  for (const int depth : {40'000, 200'000, 5'000'000}) {
    EXPECT_THAT(refusal(nested(depth)), HasSubstr("more than 64 deep"));
    std::string objects;
    for (int i = 0; i < depth; ++i) objects += "{\"a\":";
    EXPECT_THAT(refusal(objects), HasSubstr("more than 64 deep"));
  }
}

TEST(JsonText, BracketsInStringsAreNoNesting) {
  EXPECT_TRUE(parse_json("[\"" + std::string(1000, '[') + "\"]"));
  EXPECT_TRUE(parse_json("[\"\\\"" + std::string(1000, '{') + "\\\\\"]"));
  // Closed and opened again is not deep.
  std::string flat = "[";
  for (int i = 0; i < 1000; ++i) flat += "[],";
  EXPECT_TRUE(parse_json(flat + "[]]"));
}

TEST(JsonText, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(refusal("{\"a\": 1,\n \"b\": ]}"), testing::AllOf(HasSubstr("is not JSON: line 2, column 7: "), HasSubstr("']'")));
  EXPECT_THAT(refusal(""), HasSubstr("is not JSON: line 1, column 1: "));
  EXPECT_THAT(refusal("[1, 1e999]"), HasSubstr("number overflow parsing '1e999'"));
  EXPECT_THAT(refusal("[\"\xff\"]"), HasSubstr("ill-formed UTF-8"));
  EXPECT_THAT(refusal("[1] 2"), HasSubstr("is not JSON: line 1, column 5"));
  for (const char* json : {"", "[", "1e999", "nul", "{\"a\"}", "\"\\q\""}) EXPECT_TRUE(json_or_null(json).is_null()) << json;
  EXPECT_EQ(json_or_null("{\"a\": 1}")["a"], 1);
}

// The scanner for depth looks at texts that are no JSON as well; it must come to an end in every one of them.
TEST(JsonText, EveryPrefixOfATextIsRefusedOrRead) {
  const std::string whole = R"({"a": ["\"]}", {"b": [1e-3, -0.5, "\\"]}], "c": "é\u0041"})";
  ASSERT_TRUE(parse_json(whole));
  for (std::size_t length = 0; length < whole.size(); ++length) EXPECT_FALSE(parse_json(whole.substr(0, length))) << length;
}

}  // namespace
}  // namespace vt::text
