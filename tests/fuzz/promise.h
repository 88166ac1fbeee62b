#pragma once

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/base/findings.h"

namespace takt::test {

/// Ends the process, which libFuzzer takes for a crash, if a promise does not hold.
inline void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// What is refused is refused with reasons.
inline void expect_reasons(const Findings& findings) {
  demand(findings.has_errors(), "what is refused has at least one error");
  for (const Finding& finding : findings.list()) demand(!finding.message.empty(), "every finding says something");
}

/// As `--dictionary`, the first argument of a fuzz program, asks for it: words in the format of libFuzzer.
inline void print_dictionary_if_asked(int argc, char** argv, const std::vector<std::string>& words) {
  if (argc < 2 || std::string_view(argv[1]) != "--dictionary") return;
  for (const std::string& word : words) std::printf("\"\\\"%s\\\"\"\n", word.c_str());
  std::exit(0);
}

}  // namespace takt::test
