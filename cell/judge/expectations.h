#pragma once

#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cell/file/description.h"
#include "cell/judge/expectation_kind.h"

namespace takt::cell {

/// One entry of "expectations", of all kinds that are registered.
[[nodiscard]] const Form& expectation_form();

/// Makes the expectations of a scenario. All diagnostics at once: unknown kinds, keys, names. Contacts that they look
/// at are watched in the simulated world from then on. Realtime: setup.
/// @param steps  names of the program's steps; nothing: nobody knows them before the run (a program in C++)
[[nodiscard]] Result<std::vector<std::unique_ptr<Expectation>>> make_expectations(
    const std::vector<ExpectationEntry>& entries, BuiltCell& built, const StepNames& steps);

}  // namespace takt::cell
