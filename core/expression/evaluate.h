#pragma once

#include <memory>
#include <optional>

#include "core/expression/expression.h"

namespace takt::expression {

/// The value of the formula now, outside of any net: its primitives are run for one first cycle on the newest samples.
/// @return nothing for null, and for formulas that speak of a subject or are broken. Thread: the one that steps the
/// core, between cycles. Realtime: setup.
template <class T>
[[nodiscard]] std::optional<T> evaluate(const ExpressionPtr& node);

/// The same for a formula that is read again and again: it is compiled once, and each reading is a cycle of its
/// primitives. Devices that it names outlive it.
/// Thread: the one that steps the core, between cycles. Realtime: setup; now() any.
template <class T>
class CompiledFormula {
 public:
  explicit CompiledFormula(const ExpressionPtr& node);
  ~CompiledFormula();
  CompiledFormula(CompiledFormula&&) noexcept;
  CompiledFormula& operator=(CompiledFormula&&) noexcept;

  [[nodiscard]] std::optional<T> now();

 private:
  struct Net;
  std::unique_ptr<Net> net_;  ///< none: there is no value
};

}  // namespace takt::expression
