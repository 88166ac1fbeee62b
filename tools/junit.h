#pragma once

#include <string>
#include <vector>

namespace takt::tools {

/// One case of a JUnit report. A case that could not be run to its end has an error, one that did not hold a failure;
/// one about which a run says nothing is skipped.
struct JunitCase {
  std::string name;
  std::string failure = {}, error = {}, skipped = {};  ///< in words; all empty: it held
  double seconds = 0.0;
  std::string output = {};  ///< what was measured
};

struct JunitSuite {
  std::string name;  ///< the scenario file
  double seconds = 0.0;
  std::vector<JunitCase> cases;
};

/// A report in the XML that continuous integration reads. Realtime: setup.
[[nodiscard]] std::string junit_xml(const std::vector<JunitSuite>& suites);

}  // namespace takt::tools
