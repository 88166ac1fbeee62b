#pragma once

#include <string>
#include <string_view>

#include "core/base/diagnostics.h"
#include "languages/krl/syntax.h"

namespace takt::languages::krl {

/// The text of a module: what a folder has as NAME.src and NAME.dat. Either may be empty.
struct ModuleText {
  std::string name, file, source, data_file, data;
};

/// Reads a module. Diagnostics, all at once with file, line and column: what is no KRL, and each word that is not
/// supported. Blocks and expressions nest 64 deep at most. Realtime: setup.
[[nodiscard]] Module parse_module(const ModuleText& text, Diagnostics& diagnostics);

/// A module as text again, in capitals and without comments: read again it is the same tree.
[[nodiscard]] std::string print_source(const Module& module);
[[nodiscard]] std::string print_data(const Module& module);
[[nodiscard]] std::string to_string(const Expression& expression);
/// The same expression once more, not bound yet.
[[nodiscard]] ExpressionPtr copy(const Expression& one);

}  // namespace takt::languages::krl
