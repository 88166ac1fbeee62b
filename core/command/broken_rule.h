#pragma once

#include <string>

#include "core/base/diagnostics.h"

namespace takt::command {

/// Reports that a rule of docs/command-layer.md is broken. @param rule  "C6". Realtime: setup.
inline void report_broken_rule(Diagnostics& diagnostics, Code code, const std::string& location, const char* rule,
                               const std::string& message, const std::string& hint) {
  diagnostics.error(code, location, std::string(rule) + ": " + message, hint);
}

}  // namespace takt::command
