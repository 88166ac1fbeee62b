#pragma once

#include <string>
#include <vector>

namespace takt::tools {

/// One case of a JUnit report. A case that could not be judged has an error, one that did not hold a failure.
struct JunitCase {
  std::string name;
  std::string failure = {}, error = {};  ///< in words; empty: it held
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
