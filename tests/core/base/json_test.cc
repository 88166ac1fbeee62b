#include "core/base/json.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/processor_time.h"
#include "tests/support/reports.h"

namespace takt {
namespace {

using takt::test::Reports;

TEST(ParseJson, KeepsOrderAndValues) {
  const auto document = parse_json(R"({"b": 1, "a": [true, null, 2.5, "x"]})");
  ASSERT_TRUE(document.has_value());
  EXPECT_EQ(document->dump(), R"({"b":1,"a":[true,null,2.5,"x"]})");
}

TEST(ParseJson, NamesEveryDuplicateKeyWithItsPointer) {
  const auto document = parse_json(R"({"a": {"x": 1, "x": 2}, "a": 3})");
  ASSERT_FALSE(document.has_value());
  ASSERT_EQ(document.error().list().size(), 2u);
  EXPECT_EQ(document.error().list()[0].pointer, "/a/x");
  EXPECT_EQ(document.error().list()[1].pointer, "/a");
}

TEST(ParseJson, RefusesWhatOtherLibrariesWouldCrashOn) {
  const auto deep = parse_json(std::string(100'000, '[') + std::string(100'000, ']'));
  ASSERT_FALSE(deep.has_value());
  std::string place;
  for (int level = 0; level < 64; ++level) place += "/0";
  EXPECT_THAT(deep.error(), Reports(Code::kTooLarge, place, {"64"}));
  EXPECT_FALSE(parse_json("[1e999]").has_value());
  EXPECT_FALSE(parse_json("[NaN]").has_value());
  EXPECT_FALSE(parse_json("").has_value());
  EXPECT_FALSE(parse_json(" \n").has_value());
  EXPECT_FALSE(parse_json("\"\xff\"").has_value());
  EXPECT_FALSE(parse_json("{\"a\": 1").has_value());
  EXPECT_FALSE(parse_json("1 2").has_value());
  EXPECT_FALSE(parse_json("[1, 2]", {.bytes = 3}).has_value());
}

TEST(ParseJson, PlacesASyntaxErrorByLine) {
  const auto document = parse_json("{\n  \"a\": [1,\n  oops]\n}");
  ASSERT_FALSE(document.has_value());
  EXPECT_THAT(document.error(), Reports(Code::kSyntax, "/a/1"));
  EXPECT_EQ(document.error().list()[0].line, 3);
}

TEST(ParseJson, SaysWhatIsWrongInItsOwnWords) {
  // What the library calls a token, a literal or its own exception means nothing to who writes a scenario.
  for (const auto& [text, found] :
       std::initializer_list<std::pair<const char*, const char*>>{{R"({"a": 1,, "b": 2})", "','"},
                                                                  {R"({"a" 1})", "'1'"},
                                                                  {R"({"a": tru})", "'tru'"},
                                                                  {R"([1 2])", "'2'"},
                                                                  {R"([01])", "'01'"},
                                                                  {R"([-])", "'-'"},
                                                                  {R"({"a": 1} {)", "'{'"},
                                                                  {R"({"a": 1 "b": 2})", "'\"b\"'"},
                                                                  {R"({"a": )", ""}}) {
    const auto document = parse_json(text);
    ASSERT_FALSE(document) << text;
    const Diagnostic& diagnostic = document.error().list().at(0);
    EXPECT_EQ(diagnostic.code, Code::kSyntax);
    EXPECT_NE(diagnostic.message.find(found), std::string::npos) << diagnostic.message;
    for (const char* foreign : {"literal", "token", "parse error", "json.exception", "syntax error"}) {
      EXPECT_EQ(diagnostic.message.find(foreign), std::string::npos) << diagnostic.message;
      EXPECT_EQ(diagnostic.hint.find(foreign), std::string::npos) << diagnostic.hint;
    }
    EXPECT_FALSE(diagnostic.hint.empty()) << text;
    EXPECT_EQ(diagnostic.line, 1);
  }
}

/// Best of three, so that a busy machine does not fail a test.
template <class Work>
double seconds_of(Work work) {
  const test::ProcessorTime time;
  work();
  return time.seconds();
}

std::string with_keys(int count) {
  std::string text = "{";
  for (int i = 0; i < count; ++i) text += fmt::format("{}\"key {}\": {}", i ? ", " : "", i, i);
  return text + "}";
}

TEST(ParseJson, AnObjectOfManyKeysTakesTimeByItsSize) {
  // 80 000 keys are 1.6 MiB: 34 s when each key was searched for in all that came before. Wanted: 100 ms per MiB.
  const std::string text = with_keys(80'000);
  EXPECT_LT(seconds_of([&] { ASSERT_TRUE(parse_json(text).has_value()); }), 1.0);
}

TEST(ParseJson, ManyDuplicatesAreListedUpToABound) {
  std::string text = "{";
  for (int i = 0; i < 50'000; ++i) text += fmt::format("{}\"key\": {}", i ? ", " : "", i);
  const auto document = parse_json(text + "}");
  ASSERT_FALSE(document.has_value());
  EXPECT_EQ(document.error().list().size(), 100u);
  EXPECT_THAT(document.error(), Reports(Code::kDuplicate, "/key", {"key"}));
}

TEST(ParseJson, ANumberBeyondRangeIsToldInOurWords) {
  const auto document = parse_json(R"({"a": [0, -1e999]})");
  ASSERT_FALSE(document.has_value());
  EXPECT_THAT(document.error(), Reports(Code::kOutOfRange, "/a/1", {"-1e999"}));
  EXPECT_THAT(document.error().to_string(), testing::Not(testing::HasSubstr("json.exception")))
      << "the library's words";
}

TEST(ReadFile, SaysWhyAPathCannotBeRead) {
  const auto long_path = read_file(std::string(5'000, 'a'), 100);
  ASSERT_FALSE(long_path.has_value());
  EXPECT_THAT(long_path.error(), Reports(Code::kFileNotReadable, ""));
}

TEST(ResolveBelow, RefusesWhatLeavesTheFolder) {
  EXPECT_TRUE(resolve_below("models", "kuka/arm.urdf", "").has_value());
  EXPECT_TRUE(resolve_below("models", "a/../b", "").has_value());
  EXPECT_FALSE(resolve_below("models", "../etc", "").has_value());
  EXPECT_FALSE(resolve_below("models", "a/../../b", "").has_value());
  EXPECT_FALSE(resolve_below("models", "/etc/passwd", "").has_value());
  EXPECT_FALSE(resolve_below("models", "", "").has_value());
}

TEST(NearestChoice, FindsATypo) {
  EXPECT_THAT(nearest_choice("sequnce", {"parallel", "sequence"}), testing::HasSubstr("did you mean 'sequence'?"));
  EXPECT_THAT(nearest_choice("lwr4", {"ur5", "lwr4plus"}), testing::HasSubstr("did you mean 'lwr4plus'?"));
  EXPECT_THAT(nearest_choice("nn", {"up", "to"}), testing::Not(testing::HasSubstr("did you mean")));
  EXPECT_THAT(nearest_choice("qqqqqqq", {"parallel", "sequence"}), testing::Not(testing::HasSubstr("did you mean")));
}

}  // namespace
}  // namespace takt
