// What a document or a script may not do: each ends with a message.
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "languages/script/engine.h"
#include "languages/scxml/system.h"

namespace takt::languages {
namespace {

std::string document(const std::string& inside, const std::string& attributes = "") {
  return fmt::format("<scxml xmlns=\"{}\" version=\"1.0\" {}>\n{}\n</scxml>", kScxmlSpace, attributes, inside);
}

std::vector<std::tuple<Code, int, int>> faults_of(const std::string& text) {
  std::vector<std::tuple<Code, int, int>> faults;
  const auto chart = read_chart(text, {});
  if (chart) return faults;
  for (const Diagnostic& one : chart.error().list())
    if (one.severity == Severity::kError) faults.emplace_back(one.code, one.line, one.column);
  return faults;
}

TEST(ScriptEngine, EndsWhatNeverEnds) {
  for (const char* text : {
           "(function(){for(;;);})()",
           "(function f(){return f();})()",
           "(function(){for(;;)try{for(;;);}catch(e){}})()",
           "Array.prototype.indexOf.call({length:4294967295},1)",
           "(function(){try{Array.prototype.indexOf.call({length:4294967295},1)}catch(e){for(;;);}})()",
           "(function(){var a='x';for(;;)a+=a;})()",
           "(function(){var a=[];for(;;)a.push({});})()",
           "new Array(4294967295).join('x')",
           "'x'.repeat(1e9)",
           "/(a+)+$/.test('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab')",
           "(function(){for(;;)try{/(a+)+$/.test('aaaaaaaaaaaaaaaaaaaaaaaaaaaaab')}catch(e){}})()",
           "JSON.stringify((function(){var a={};var b=a;for(var i=0;i<1e5;i++){b.b={};b=b.b;}return a;})())",
           "[3,1,2].sort(function(){for(;;);})",
           "({toString:function(){return this+''}})+''",
       }) {
    ScriptEngine engine;
    EXPECT_FALSE(engine.evaluate(text).has_value()) << text;
    const auto after = engine.evaluate("1+1");  // the engine goes on
    ASSERT_TRUE(after.has_value()) << text << ": " << after.error();
    EXPECT_EQ(after->text, "2") << text;
  }
}

TEST(ScriptEngine, HasNoClockAndNothingOfTheMachine) {
  ScriptEngine engine;
  for (const char* name :
       {"Date", "performance", "Duktape", "Proxy", "Reflect", "Buffer", "require", "process", "print"}) {
    const auto type = engine.evaluate(fmt::format("typeof {}", name));
    ASSERT_TRUE(type.has_value());
    EXPECT_EQ(type->text, "\"undefined\"") << name;
  }
}

TEST(ScriptEngine, RandomNumbersAreThoseOfTheSeed) {
  ScriptEngine one(7), same(7), other(8);
  const auto a = one.evaluate("Math.random()"), b = same.evaluate("Math.random()"), c = other.evaluate("Math.random()");
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(a->text, b->text);
  EXPECT_NE(a->text, c->text);
}

TEST(ChartReader, SaysAllFaultsAtOnceWithLineAndColumn) {
  const std::string text = document(
      "<state id=\"a\">\n"
      "  <transition event=\"go\" target=\"nowhere\"/>\n"
      "  <onentry><sned event=\"x\"/></onentry>\n"
      "</state>\n"
      "<state id=\"a\" colour=\"red\"/>\n"
      "<parallel id=\"p\"><final id=\"f\"/></parallel>\n"
      "<state id=\"b\"><onentry><send event=\"x\" delay=\"soon\"/></onentry></state>");
  using testing::Contains;
  const auto faults = faults_of(text);
  EXPECT_THAT(faults, Contains(std::tuple(Code::kUnknownName, 3, 34)));
  EXPECT_THAT(faults, Contains(std::tuple(Code::kUnknownKey, 4, 12)));
  EXPECT_THAT(faults, Contains(std::tuple(Code::kDuplicate, 6, 1)));
  EXPECT_THAT(faults, Contains(std::tuple(Code::kUnknownKey, 6, 23)));
  EXPECT_THAT(faults, Contains(std::tuple(Code::kUnknownKey, 7, 18)));
  EXPECT_THAT(faults, Contains(std::tuple(Code::kInvalidValue, 8, 47)));
  EXPECT_EQ(faults.size(), 6u);
}

TEST(ChartReader, RefusesStatesThatCannotBeActiveTogether) {
  const auto faults =
      faults_of(document("<state id=\"a\"><transition event=\"x\" target=\"b c\"/></state><state id=\"b\"/>"
                         "<state id=\"c\"/>"));
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(std::get<0>(faults.front()), Code::kConflict);
}

TEST(ChartReader, RefusesEntities) {
  const auto laughs =
      faults_of("<!DOCTYPE scxml [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]>" + document("<state id=\"a\"/>"));
  const auto foreign = faults_of("<!DOCTYPE scxml SYSTEM \"file:///etc/passwd\">" + document("<state id=\"a\"/>"));
  ASSERT_EQ(laughs.size(), 1u);
  ASSERT_EQ(foreign.size(), 1u);
  EXPECT_EQ(std::get<0>(laughs.front()), Code::kUnsupported);
  EXPECT_EQ(std::get<0>(foreign.front()), Code::kUnsupported);
}

TEST(ChartReader, RefusesWhatIsTooDeepOrTooLarge) {
  std::string deep, end;
  for (int i = 0; i < 10'000; ++i) {
    deep += "<state>";
    end += "</state>";
  }
  EXPECT_EQ(std::get<0>(faults_of(document(deep + end)).at(0)), Code::kTooLarge);
  EXPECT_EQ(std::get<0>(faults_of(document(std::string(2'000'000, ' '))).at(0)), Code::kTooLarge);
  EXPECT_EQ(faults_of(document("<script src=\"../../etc/passwd\"/><state id=\"a\"/>")).size(), 1u);
}

/// Why the only session of the document had to end.
std::string failure_of(const std::string& text) {
  const auto chart = read_chart(text, {});
  if (!chart) return chart.error().to_string();
  ChartSystem system;
  const ChartSession& session = system.add(*chart, "chart");
  for (std::int64_t now = 0; now >= 0 && now < 1'000'000'000'000 && !system.over(); now = system.next_ns())
    system.advance(now);
  return session.failure();
}

TEST(ChartSession, EndsWhatNeverComesToRest) {
  EXPECT_NE(
      failure_of(document(
          "<state id=\"a\"><transition target=\"b\"/></state><state id=\"b\"><transition target=\"a\"/></state>")),
      "");
  EXPECT_NE(
      failure_of(document(
          "<state id=\"a\"><transition event=\"x\" target=\"a\"/><onentry><raise event=\"x\"/></onentry></state>")),
      "");
  EXPECT_NE(
      failure_of(document(
          "<state id=\"a\"><transition event=\"x\" target=\"a\"/><onentry><send event=\"x\"/></onentry></state>")),
      "");
  EXPECT_NE(failure_of(document("<state id=\"a\"><onentry><script>for(;;);</script></onentry></state>")), "");
  EXPECT_NE(
      failure_of(document("<state id=\"a\"><transition cond=\"(function(){for(;;);})()\" target=\"a\"/></state>")), "");
  EXPECT_NE(
      failure_of(document("<state id=\"a\"><onentry><foreach array=\"[1,2,3]\" item=\"i\"><script>for(;;);</script>"
                          "</foreach></onentry></state>")),
      "");
}

TEST(ChartSession, OneChartThatNeverRestsLeavesOthersRunning) {
  const auto busy = read_chart(document("<state id=\"a\"><transition target=\"a\"/></state>"), {});
  const auto calm =
      read_chart(document("<state id=\"a\"><transition event=\"go\" target=\"b\"/></state><state id=\"b\"/>"), {});
  ASSERT_TRUE(busy && calm);
  ChartSystem system;
  const ChartSession& bad = system.add(*busy, "busy");
  const ChartSession& good = system.add(*calm, "calm");
  system.advance(0);
  EXPECT_NE(bad.failure(), "");
  EXPECT_TRUE(system.post("calm", {.name = "go"}));
  system.advance(1);
  EXPECT_EQ(good.configuration(), std::vector<std::string>{"b"});
}

TEST(ChartSystem, ChartsSendEachOtherEventsAndTheClockIsTheirs) {
  const auto ping = read_chart(
      document("<state id=\"a\"><onentry><send event=\"ping\" target=\"#_scxml_two\" delay=\"1.5s\"/></onentry>"
               "<transition event=\"pong\" cond=\"_event.data.n == 3\" target=\"end\"/></state><final id=\"end\"/>"),
      {});
  const auto pong = read_chart(
      document(
          "<state id=\"a\"><transition event=\"ping\" target=\"end\"><send event=\"pong\" targetexpr=\"_event.origin\">"
          "<param name=\"n\" expr=\"1+2\"/></send></transition></state><final id=\"end\"/>"),
      {});
  ASSERT_TRUE(ping && pong);
  ChartSystem system;
  (void)system.add(*ping, "one");
  (void)system.add(*pong, "two");
  system.advance(1'499'999'999);
  EXPECT_FALSE(system.over());
  EXPECT_EQ(system.next_ns(), 1'500'000'000);
  system.advance(1'500'000'000);
  EXPECT_TRUE(system.over());
}

}  // namespace
}  // namespace takt::languages
