// Random charts with random events, against a plain reading of the standard's algorithm.
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "languages/scxml/system.h"
#include "tests/languages/scxml/plain_reading.h"

namespace takt::languages {
namespace {

/// A chart as text: states in states, parallels, histories, transitions of all sorts.
class RandomChart {
 public:
  explicit RandomChart(Random& random) : random_(random) {}

  std::string text() {
    count_ = 2 + below(14);
    std::string body;
    while (made_ < count_) body += state(0);
    return fmt::format("<scxml xmlns=\"{}\" version=\"1.0\" datamodel=\"null\">{}</scxml>", kScxmlSpace, body);
  }

 private:
  int below(int limit) { return static_cast<int>(random_.bits() % static_cast<std::uint64_t>(limit)); }
  bool chance(int percent) { return below(100) < percent; }
  std::string some_state() { return fmt::format("s{}", below(count_)); }

  std::string transitions() {
    std::string text;
    for (int i = below(4); i > 0; --i) {
      std::string attributes;
      static constexpr const char* kEvents[] = {"a", "b", "c", "*", "r", "a b"};
      const bool eventless = chance(12);
      if (!eventless) attributes += fmt::format(" event=\"{}\"", kEvents[below(6)]);
      if (eventless || chance(20)) attributes += fmt::format(" cond=\"In('{}')\"", some_state());
      if (chance(85)) attributes += fmt::format(" target=\"{}\"", some_state());
      if (chance(25)) attributes += " type=\"internal\"";
      text += fmt::format("<transition{}>{}</transition>", attributes, chance(10) ? "<raise event=\"r\"/>" : "");
    }
    return text;
  }

  std::string state(int depth) {
    const int number = made_++;
    const int form = below(10);
    const bool has_children = depth < 4 && made_ < count_ && form < 6;
    if (!has_children && depth > 0 && chance(12)) return fmt::format("<final id=\"s{}\"/>", number);
    std::string inside = transitions();
    if (chance(15)) inside += "<onentry><raise event=\"b\"/></onentry>";
    if (chance(10)) inside += "<onexit><raise event=\"r\"/></onexit>";
    if (!has_children) return fmt::format("<state id=\"s{}\">{}</state>", number, inside);
    const bool parallel = form < 2;
    int children = 1 + below(3);
    const int first = made_;
    std::string states;
    while (children-- > 0 && made_ < count_) {
      std::string one = state(depth + 1);
      if (parallel && one.starts_with("<final")) one = fmt::format("<state id=\"s{}\"/>", made_ - 1);
      states += one;
    }
    if (chance(30))
      inside += fmt::format(
          "<history id=\"h{}\" type=\"{}\"><transition target=\"s{}\">{}</transition></history>"
          "<transition event=\"c\" target=\"h{}\"/>",
          number, chance(50) ? "deep" : "shallow", first, chance(30) ? "<raise event=\"r\"/>" : "", number);
    return fmt::format("<{0} id=\"s{1}\">{2}{3}</{0}>", parallel ? "parallel" : "state", number, states, inside);
  }

  Random& random_;
  int count_ = 0, made_ = 0;
};

int wanted_events() {
  const char* text = std::getenv("TAKT_CHART_EVENTS");
  return text != nullptr ? std::atoi(text) : 25'000;
}

TEST(RandomCharts, EnterAndLeaveWhatAPlainReadingOfTheStandardDoes) {
  Random random(44);
  int events = 0, charts = 0;
  while (events < wanted_events()) {
    const std::string text = RandomChart(random).text();
    const auto chart = read_chart(text, {});
    if (!chart) continue;  // a target may not exist, for example
    ++charts;
    test::PlainReading plain(**chart);
    plain.interpret();
    std::string trace;
    ChartSystem system({.told = [&](const ChartSession&, std::string_view what, const std::string& state) {
      if (what == "entered") trace += "+" + state;
      if (what == "left") trace += "-" + state;
    }});
    const ChartSession& session = system.add(*chart, "chart");
    system.advance(0);
    std::int64_t now = 0;
    for (int i = 0; i < 40 && plain.running; ++i) {
      ASSERT_EQ(trace, plain.trace) << text;
      ASSERT_EQ(session.active(), [&] {
        auto with_root = plain.configuration;
        with_root.insert(0);
        return with_root;
      }()) << text;
      const std::string name(1, static_cast<char>('a' + random.bits() % 3));
      plain.event(name);
      ASSERT_TRUE(system.post("chart", {.name = name}));
      system.advance(++now);
      ++events;
    }
    if (plain.endless) {
      EXPECT_FALSE(session.failure().empty()) << text;
    } else if (!plain.running) {  // at its end a session leaves its states
      EXPECT_TRUE(trace.starts_with(plain.trace)) << text;
      EXPECT_TRUE(session.active().empty());
    }
  }
  EXPECT_GT(charts, wanted_events() / 50);
}

}  // namespace
}  // namespace takt::languages
