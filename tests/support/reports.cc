#include "tests/support/reports.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace takt::test {
namespace {

bool is_of_a_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// What is before `at` belongs to the same name or number.
bool continues_before(std::string_view text, std::size_t at) {
  if (at == 0 || !is_of_a_name(text[at])) return false;
  if (is_of_a_name(text[at - 1])) return true;
  return at > 1 && text[at - 1] == '.' && is_digit(text[at]) && is_digit(text[at - 2]);
}
bool continues_after(std::string_view text, std::size_t end) {
  if (end >= text.size() || !is_of_a_name(text[end - 1])) return false;
  if (is_of_a_name(text[end])) return true;
  return end + 1 < text.size() && text[end] == '.' && is_digit(text[end - 1]) && is_digit(text[end + 1]);
}

std::string_view name_of(Severity severity) {
  return severity == Severity::kError ? "error" : severity == Severity::kWarning ? "warning" : "note";
}

}  // namespace

double first_number(std::string_view text) {
  const std::size_t at = text.find_first_of("0123456789");
  return at == std::string_view::npos ? std::numeric_limits<double>::quiet_NaN()
                                      : std::stod(std::string(text.substr(at)));
}

bool contains_name(std::string_view text, std::string_view name) {
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    if (!continues_before(text, at) && !continues_after(text, at + name.size())) return true;
  }
  return false;
}

bool fits(const Diagnostic& diagnostic, const Expected& expected) {
  const std::string text = diagnostic.message + "\n" + diagnostic.hint;
  return diagnostic.code == expected.code && diagnostic.severity == expected.severity &&
         diagnostic.pointer == expected.pointer && !diagnostic.message.empty() &&
         std::ranges::all_of(expected.names, [&](const std::string& name) { return contains_name(text, name); });
}

std::string to_string(const Expected& expected) {
  return fmt::format("{} {} at '{}'{}{}", name_of(expected.severity), takt::name_of(expected.code), expected.pointer,
                     expected.names.empty() ? "" : " naming ", fmt::join(expected.names, ", "));
}

}  // namespace takt::test
