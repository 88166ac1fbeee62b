#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cell/judge/expectation.h"
#include "cell/judge/step_window.h"
#include "core/base/form.h"

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
struct ExpectationKind {
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

/// The names in a map.
template <class Map>
[[nodiscard]] std::vector<std::string> names_in(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

}  // namespace takt::cell
