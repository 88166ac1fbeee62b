#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "cell/file/description.h"
#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"

namespace takt::cell {

/// A kind of expectation: the word in "kind", and its keys.
struct ExpectationKind {
  std::string_view name;
  std::string_view doc;
};
[[nodiscard]] const std::vector<ExpectationKind>& expectation_kinds();

/// Makes the expectations of a scenario. All diagnostics at once: unknown kinds, keys, names. Contacts that they look
/// at are watched in the simulated world from then on. Realtime: setup.
/// @param steps  names of the program's steps; nothing: nobody knows them before the run (a program in C++)
[[nodiscard]] Result<std::vector<std::unique_ptr<Expectation>>> make_expectations(
    const std::vector<ExpectationEntry>& entries, BuiltCell& built, const StepNames& steps);

}  // namespace takt::cell
