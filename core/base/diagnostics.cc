#include "core/base/diagnostics.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace takt {
namespace {

std::string_view severity_name(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kNote:
      return "note";
  }
  return "error";
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string to_string(const Diagnostic& diagnostic) {
  std::string place = diagnostic.file;
  if (!diagnostic.pointer.empty()) place += (place.empty() ? "" : ":") + diagnostic.pointer;
  std::string text = fmt::format("{}{}: {}", place.empty() ? "" : place + ": ", severity_name(diagnostic.severity),
                                 diagnostic.message);
  if (!diagnostic.hint.empty()) text += fmt::format(" ({})", diagnostic.hint);
  return text;
}

void Diagnostics::error(std::string pointer, std::string message, std::string hint) {
  add({Severity::kError, {}, std::move(pointer), std::move(message), std::move(hint)});
}

void Diagnostics::warning(std::string pointer, std::string message, std::string hint) {
  add({Severity::kWarning, {}, std::move(pointer), std::move(message), std::move(hint)});
}

void Diagnostics::note(std::string pointer, std::string message, std::string hint) {
  add({Severity::kNote, {}, std::move(pointer), std::move(message), std::move(hint)});
}

void Diagnostics::append(const Diagnostics& other, std::string_view prefix, std::string_view file) {
  for (Diagnostic diagnostic : other.list_) {
    diagnostic.pointer.insert(0, prefix);
    if (diagnostic.file.empty()) diagnostic.file = file;
    add(std::move(diagnostic));
  }
}

void Diagnostics::set_file(std::string_view file) {
  for (Diagnostic& diagnostic : list_) {
    if (diagnostic.file.empty()) diagnostic.file = file;
  }
}

bool Diagnostics::has_errors() const {
  return std::ranges::any_of(list_,
                             [](const Diagnostic& diagnostic) { return diagnostic.severity == Severity::kError; });
}

std::string Diagnostics::to_string() const {
  std::string text;
  for (const Diagnostic& diagnostic : list_) text += takt::to_string(diagnostic) + "\n";
  return text;
}

std::unexpected<Diagnostics> failure(std::string pointer, std::string message, std::string hint) {
  Diagnostics diagnostics;
  diagnostics.error(std::move(pointer), std::move(message), std::move(hint));
  return std::unexpected(std::move(diagnostics));
}

std::string nearest_choice(std::string_view name, const std::vector<std::string>& choices, std::size_t most) {
  if (choices.empty()) return "there are none";
  // Whoever writes the beginning of a name means it; one letter may be anything.
  const auto distance = [&](const std::string& choice) -> std::size_t {
    return name.size() > 1 && choice.starts_with(name) ? 1 : edit_distance(name, choice);
  };
  const auto nearest = std::ranges::min_element(choices, {}, distance);
  std::string text;
  if (!name.empty() && distance(*nearest) <= std::max<std::size_t>(name.size() > 2 ? 2 : 1, name.size() / 2)) {
    text = fmt::format("did you mean '{}'? ", *nearest);
  }
  text += "allowed: ";
  for (std::size_t i = 0; i < choices.size() && i < most; ++i) text += (i ? ", " : "") + choices[i];
  if (choices.size() > most) text += fmt::format(", and {} more", choices.size() - most);
  return text;
}

std::string pointer_segment(std::string_view token) {
  std::string segment = "/";
  for (const char c : token) {
    if (c == '~') {
      segment += "~0";
    } else if (c == '/') {
      segment += "~1";
    } else {
      segment += c;
    }
  }
  return segment;
}

std::string pointer_segment(std::size_t index) { return "/" + std::to_string(index); }

}  // namespace takt
