#pragma once

#include <memory>

#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"
#include "core/base/object_reader.h"

/// Expectations about a part of the program: values while a step runs, what happens and in which order, who touches
/// whom. Realtime: setup.
namespace takt::cell {

/// "value": the value of an expression while a step runs, or all along: bounds, a share of the time within them, mean.
[[nodiscard]] std::unique_ptr<Expectation> value_expectation(ObjectReader& reader, const BuiltCell& built,
                                                             const StepNames& steps);
/// "event": how often something happens, and when.
[[nodiscard]] std::unique_ptr<Expectation> event_expectation(ObjectReader& reader, const StepNames& steps);
/// "order": several things happen one after the other, each within a time of the one before.
[[nodiscard]] std::unique_ptr<Expectation> order_expectation(ObjectReader& reader, const StepNames& steps);
/// "contacts": nothing touches but these pairs of devices and objects.
[[nodiscard]] std::unique_ptr<Expectation> contacts_expectation(ObjectReader& reader, const BuiltCell& built);

}  // namespace takt::cell
