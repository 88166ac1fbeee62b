#include "core/net/load_report.h"

#include <fmt/format.h>

#include "core/net/value.h"

namespace takt::net {

void LoadReport::error(Code code, std::string pointer, std::string message, std::string hint) {
  if (++errors_ <= kMostErrors) diagnostics_.error(code, std::move(pointer), std::move(message), std::move(hint));
}

void LoadReport::note(std::string pointer, std::string message, std::string hint) {
  diagnostics_.note(std::move(pointer), std::move(message), std::move(hint));
}

void LoadReport::append(const Diagnostics& diagnostics, std::string_view prefix) {
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    if (diagnostic.severity == Severity::kError && ++errors_ > kMostErrors) continue;
    Diagnostic placed = diagnostic;
    placed.pointer.insert(0, prefix);
    diagnostics_.add(std::move(placed));
  }
}

std::string LoadReport::nearest_of(std::string_view name, const std::vector<std::string>& choices) {
  std::size_t work = 1;
  for (const std::string& choice : choices) work += (name.size() + 1) * (choice.size() + 1);
  const bool enough = work <= work_left_;
  work_left_ = enough ? work_left_ - work : 0;
  return enough ? nearest_choice(name, choices) : std::string();
}

Diagnostics LoadReport::take() {
  if (errors_ == 0) return std::move(diagnostics_);
  Diagnostics errors;
  for (const Diagnostic& diagnostic : diagnostics_.list()) {
    if (diagnostic.severity == Severity::kError) errors.add(diagnostic);
  }
  if (errors_ > kMostErrors) errors.error(Code::kTooLarge, {}, fmt::format("{} more errors", errors_ - kMostErrors));
  return errors;
}

std::string shown(std::string_view name) {
  const Text text(name);
  return text.view().size() == name.size() ? std::string(name) : std::string(text.view()) + "...";
}

}  // namespace takt::net
