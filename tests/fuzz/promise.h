#pragma once

#include <cstdio>
#include <cstdlib>

#include "core/base/diagnostics.h"

namespace takt::test {

/// Ends the process, which libFuzzer takes for a crash, if a promise does not hold.
inline void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// What is refused is refused with reasons.
inline void expect_reasons(const Diagnostics& diagnostics) {
  demand(diagnostics.has_errors(), "what is refused has at least one error");
  for (const Diagnostic& diagnostic : diagnostics.list())
    demand(!diagnostic.message.empty(), "every diagnostic says something");
}

}  // namespace takt::test
