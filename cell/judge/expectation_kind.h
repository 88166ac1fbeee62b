#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"
#include "core/base/form.h"
#include "core/base/keys_of.h"
#include "core/base/kind_registry.h"

namespace takt::cell {

/// What an expectation is made from: its keys, the cell, and the steps of the program. Realtime: setup.
class ExpectationReader : public FormReader {
 public:
  ExpectationReader(const Form& form, ObjectReader& object, BuiltCell& cell, const StepNames& step_names)
      : FormReader(form, object), built(cell), steps(step_names) {}

  /// Key "arm": a single one needs no name.
  [[nodiscard]] std::string arm();
  /// Key "during".
  [[nodiscard]] std::string during() { return read_during(*this, steps); }
  /// The name of a step.
  [[nodiscard]] std::string step(std::string_view key) { return steps ? name(key, *steps) : text(key); }

  BuiltCell& built;
  const StepNames& steps;
};

/// A kind of expectation: the word in "kind", its keys, and what is made of them.
/// Ours and those of plug-ins use the same way (docs/tables.md).
struct ExpectationKind {
  static constexpr std::string_view kWhat = "expectation";
  /// Ours are there from the beginning.
  static KindRegistry<ExpectationKind>& registry();

  std::string name;
  Form form;
  std::function<std::unique_ptr<Expectation>(ExpectationReader&)> make;
};

/// A kind whose expectation is made by a constructor. @param E  Expectation(ExpectationReader&)
template <class E>
[[nodiscard]] ExpectationKind expectation_kind(std::string name, Form form) {
  return {std::move(name), std::move(form), [](ExpectationReader& from) { return std::make_unique<E>(from); }};
}

/// Rows that several kinds have.
[[nodiscard]] Key arm_key();
[[nodiscard]] Key below_key();
[[nodiscard]] Key within_m_key();
[[nodiscard]] Key within_deg_key();

/// Registers a kind of expectation in a plug-in: a function that returns an ExpectationKind.
///   TAKT_EXPECTATION(cool_expectation);
#define TAKT_EXPECTATION(function)                                                                              \
  ::takt::KindRegistration<::takt::cell::ExpectationKind> registration_of_##function(::takt::own_registrations, \
                                                                                     function())

}  // namespace takt::cell
