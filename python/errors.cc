#include "python/errors.h"

#include <exception>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/cell.h"
#include "cell/judge/run_report.h"
#include "core/activity/runtime.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;

struct RaisedError {
  std::string kind;
  Diagnostics diagnostics;
};
struct Interrupted {};

/// Makes the exception in Python, where its classes are.
void set_error(const std::string& kind, const Diagnostics& diagnostics) {
  const std::string text = cell::to_output_text({{"diagnostics", cell::to_json(diagnostics)}});
  try {
    const nb::object made = nb::module_::import_("takt._errors").attr("made")(kind, text);
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
  } catch (nb::python_error& error) {
    error.restore();
  }
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  } catch (const RaisedError& error) {
    set_error(error.kind, error.diagnostics);
  } catch (const app::OpenError& error) {
    set_error("OpenError", error.diagnostics());
  } catch (const activity::ProgramCancelled& error) {
    set_error("Cancelled", error.diagnostics());
  } catch (const activity::ActivityError& error) {
    set_error("OperationError", error.diagnostics());
  }
}

}  // namespace

void bind_errors(nb::module_& module) {
  (void)module;
  nb::register_exception_translator(translate);
}

void raise_error(const std::string& kind, Diagnostics diagnostics) { throw RaisedError{kind, std::move(diagnostics)}; }

void raise_error(const std::string& kind, Code code, std::string pointer, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, std::move(pointer), std::move(message), std::move(hint));
  raise_error(kind, std::move(why));
}

void raise_interrupt() { throw Interrupted{}; }

Diagnostics diagnostics_from(const std::string& text) {
  Diagnostics diagnostics;
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_array()) return diagnostics;
  for (const Json& one : json) {
    if (!one.is_object()) continue;
    const auto code = code_named(one.value("code", std::string()));
    diagnostics.add({.severity = Severity::kError,
                     .code = code.value_or(Code::kInternal),
                     .file = one.value("file", std::string()),
                     .pointer = one.value("pointer", std::string()),
                     .message = one.value("message", std::string()),
                     .hint = one.value("hint", std::string())});
  }
  return diagnostics;
}

}  // namespace takt::python
