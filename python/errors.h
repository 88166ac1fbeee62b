#pragma once

#include <string>

#include <nanobind/nanobind.h>

#include "core/base/diagnostics.h"

/// Diagnostics as Python exceptions. Realtime: setup.
namespace takt::python {

/// The exceptions of takt/_errors.py by their names, and KeyboardInterrupt for what Ctrl-C has cancelled.
void bind_errors(nanobind::module_& module);

/// Throws `takt.Error` (or the one below it that `kind` names) with these diagnostics.
[[noreturn]] void raise_error(const std::string& kind, Diagnostics diagnostics);
[[noreturn]] void raise_error(const std::string& kind, Code code, std::string pointer, std::string message,
                              std::string hint);

/// Throws KeyboardInterrupt.
[[noreturn]] void raise_interrupt();

/// A list of diagnostics as Python hands it back: what an exception was made of. What is no such list is empty.
[[nodiscard]] Diagnostics diagnostics_from(const std::string& json);

}  // namespace takt::python
