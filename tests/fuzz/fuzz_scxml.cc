// Any bytes as a state chart lead to a chart, or to diagnostics with reasons; a chart runs without harm, and the same
// again.
#include <string>
#include <string_view>

#include "languages/scxml/system.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"

namespace takt {
namespace {

using test::demand;

/// What a chart does in a few events.
std::string trace_of(const std::shared_ptr<const languages::Chart>& chart) {
  std::string trace;
  languages::ChartSystem system({.told = [&](const auto&, std::string_view what, const std::string& text) {
    if (trace.size() < 100'000) trace += std::string(what) + text;
  }});
  (void)system.add(chart, "chart");
  std::int64_t now = 0;
  for (const char* event : {"a", "b", "timeout", "done.invoke.x", "error.execution"}) {
    system.advance(now);
    (void)system.post("chart", {.name = event});
    now += 1'000'000'000;
  }
  system.advance(now);
  return trace;
}

void load(std::string_view input) {
  const auto chart = languages::read_chart(input, {});
  if (!chart) return test::expect_reasons(chart.error());
  demand(trace_of(*chart) == trace_of(*chart), "a chart does the same again");
}

}  // namespace

const test::FuzzTarget& test::fuzz_target() {
  static const FuzzTarget target{.words = {"<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\">",
                                           "</scxml>",
                                           "<state id=\"a\">",
                                           "</state>",
                                           "<parallel>",
                                           "</parallel>",
                                           "<final id=\"b\"/>",
                                           "<history type=\"deep\">",
                                           "</history>",
                                           "<transition ",
                                           "event=\"a\"",
                                           "cond=\"In('a')\"",
                                           "target=\"a\"",
                                           "type=\"internal\"",
                                           "<onentry>",
                                           "</onentry>",
                                           "<send event=\"a\" delay=\"1s\"/>",
                                           "<raise event=\"b\"/>",
                                           "<assign location=\"x\" expr=\"1\"/>",
                                           "<script>",
                                           "</script>",
                                           "<foreach array=\"[1]\" item=\"x\">",
                                           "</foreach>",
                                           "<if cond=\"x\">",
                                           "<else/>",
                                           "</if>",
                                           "<datamodel>",
                                           "<data id=\"x\" expr=\"0\"/>",
                                           "</datamodel>",
                                           "<invoke type=\"scxml\">",
                                           "<content>",
                                           "</content>",
                                           "</invoke>",
                                           "<donedata>",
                                           "</donedata>",
                                           "<param name=\"x\" expr=\"1\"/>",
                                           "<!DOCTYPE",
                                           "<![CDATA[",
                                           "]]>",
                                           "&amp;"},
                                 .load = load,
                                 .share = 0.0,
                                 .mutate = nullptr};
  return target;
}

}  // namespace takt
