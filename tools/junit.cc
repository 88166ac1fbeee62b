#include "tools/junit.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/xml_text.h"

namespace takt::tools {
namespace {

std::string case_xml(const JunitSuite& suite, const JunitCase& one) {
  std::string xml = fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">\n", xml_text(suite.name),
                                xml_text(one.name), one.seconds);
  if (!one.failure.empty()) xml += fmt::format("      <failure message=\"{}\"/>\n", xml_text(one.failure));
  if (!one.error.empty()) xml += fmt::format("      <error message=\"{}\"/>\n", xml_text(one.error));
  if (!one.skipped.empty()) xml += fmt::format("      <skipped message=\"{}\"/>\n", xml_text(one.skipped));
  if (!one.output.empty()) xml += fmt::format("      <system-out>{}</system-out>\n", xml_text(one.output));
  return xml + "    </testcase>\n";
}

std::string suite_xml(const JunitSuite& suite) {
  const auto count = [&](std::string JunitCase::*text) {
    return std::ranges::count_if(suite.cases, [&](const JunitCase& one) { return !(one.*text).empty(); });
  };
  std::string xml = fmt::format(
      "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n",
      xml_text(suite.name), suite.cases.size(), count(&JunitCase::failure), count(&JunitCase::error),
      count(&JunitCase::skipped), suite.seconds);
  for (const JunitCase& one : suite.cases) xml += case_xml(suite, one);
  return xml + "  </testsuite>\n";
}

}  // namespace

std::string junit_xml(const std::vector<JunitSuite>& suites) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (const JunitSuite& suite : suites) xml += suite_xml(suite);
  return xml + "</testsuites>\n";
}

}  // namespace takt::tools
