// The test suite of the W3C for SCXML (tests/languages/scxml/README.md): each document ends in its state "pass".
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "languages/scxml/system.h"

namespace takt::languages {
namespace {

/// The documents of a list beside the suite: a name per line.
std::vector<std::string> documents(const std::string& list) {
  std::ifstream file(std::filesystem::path("tests/languages/scxml") / list);
  std::vector<std::string> names;
  for (std::string name; file >> name;) names.push_back(name);
  return names;
}

std::filesystem::path suite() { return TAKT_W3C_SUITE; }

/// The state in which the document ends, on a clock that jumps to the next event.
std::string end_of(const std::string& name) {
  const auto chart = read_chart_file(suite() / (name + ".txml.scxml"));
  if (!chart) return chart.error().to_string();
  std::string log;
  ChartSystem system({.told = [&](const ChartSession& session, std::string_view what, const std::string& text) {
    log += session.id() + " " + std::string(what) + " " + text + "\n";
  }});
  ChartSession& session = system.add(*chart, "test");
  std::string last;
  for (std::int64_t now = 0; now >= 0 && !system.over(); now = system.next_ns()) {
    system.advance(now);
    if (!session.configuration().empty()) last = session.configuration().back();
  }
  const auto at = log.rfind("test entered ");
  const std::string end = log.substr(at + 13, log.find('\n', at) - at - 13);
  return end == "pass" ? end : log;
}

TEST(W3c, EachMandatoryAutomaticTestPasses) {
  const auto names = documents("mandatory.txt");
  ASSERT_EQ(names.size(), 160u);
  for (const std::string& name : names) EXPECT_EQ(end_of(name), "pass") << name;
}

TEST(W3c, EachOptionalTestWithoutHttpPasses) {
  const auto names = documents("optional.txt");
  ASSERT_EQ(names.size(), 21u);
  for (const std::string& name : names) EXPECT_EQ(end_of(name), "pass") << name;
}

}  // namespace
}  // namespace takt::languages
