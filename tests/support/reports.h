#pragma once

#include <ostream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"

/// Matchers for what takt reports. They ask for what programs may rely on: code, severity and JSON pointer, and for the
/// names and numbers in it. They never ask for words, so that a message can be improved without touching a test; lint
/// refuses tests that do (docs/testing.md).
namespace takt::test {

/// One diagnostic as a test expects it.
struct Expected {
  Code code;
  std::string pointer;
  /// What message or hint have to contain: names, numbers, keys. "5" is in "at most 5 kg", not in "5.1" or "15".
  std::vector<std::string> names = {};
  Severity severity = Severity::kError;
};

/// The first number of a message or hint, for checks of the figures that it gives; NaN: there is none.
[[nodiscard]] double first_number(std::string_view text);
/// `name` is in the text, not as a part of another name or number.
[[nodiscard]] bool contains_name(std::string_view text, std::string_view name);
[[nodiscard]] bool fits(const Diagnostic& diagnostic, const Expected& expected);
[[nodiscard]] std::string to_string(const Expected& expected);

/// The diagnostics of whatever has some: of a Result that has a value there are none.
inline std::vector<Diagnostic> diagnostics_in(const Diagnostic& one) { return {one}; }
inline std::vector<Diagnostic> diagnostics_in(const Diagnostics& all) { return all.list(); }
inline std::vector<Diagnostic> diagnostics_in(const std::vector<Diagnostic>& all) { return all; }
template <class T>
std::vector<Diagnostic> diagnostics_in(const Result<T>& result) {
  return result ? std::vector<Diagnostic>() : result.error().list();
}

/// Of Diagnostics, a Result or a Diagnostic: one of them is the expected one.
class ReportsMatcher {
 public:
  using is_gtest_matcher = void;
  explicit ReportsMatcher(Expected expected) : expected_(std::move(expected)) {}

  template <class T>
  bool MatchAndExplain(const T& value, std::ostream* out) const {
    const std::vector<Diagnostic> all = diagnostics_in(value);
    for (const Diagnostic& one : all)
      if (fits(one, expected_)) return true;
    if (out != nullptr) {
      *out << "which has " << all.size();
      for (const Diagnostic& one : all) *out << "\n  " << takt::to_string(one);
    }
    return false;
  }
  void DescribeTo(std::ostream* out) const { *out << "reports " << to_string(expected_); }
  void DescribeNegationTo(std::ostream* out) const { *out << "does not report " << to_string(expected_); }

 private:
  Expected expected_;
};

inline ReportsMatcher Reports(Expected expected) { return ReportsMatcher(std::move(expected)); }
inline ReportsMatcher Reports(Code code, std::string pointer, std::vector<std::string> names = {}) {
  return ReportsMatcher({code, std::move(pointer), std::move(names)});
}
inline ReportsMatcher Warns(Code code, std::string pointer, std::vector<std::string> names = {}) {
  return ReportsMatcher({code, std::move(pointer), std::move(names), Severity::kWarning});
}
inline ReportsMatcher Notes(std::string pointer, std::vector<std::string> names = {}) {
  return ReportsMatcher({Code::kNote, std::move(pointer), std::move(names), Severity::kNote});
}

/// The same wherever it is, for checks that something is not reported at all.
class ReportsAnywhereMatcher {
 public:
  using is_gtest_matcher = void;
  ReportsAnywhereMatcher(Code code, std::vector<std::string> names) : code_(code), names_(std::move(names)) {}

  template <class T>
  bool MatchAndExplain(const T& value, std::ostream* out) const {
    bool found = false;
    for (const Diagnostic& one : diagnostics_in(value)) {
      found = found || fits(one, {code_, one.pointer, names_, one.severity});
      if (out != nullptr) *out << "\n  " << takt::to_string(one);
    }
    return found;
  }
  void DescribeTo(std::ostream* out) const { *out << "reports " << takt::name_of(code_); }
  void DescribeNegationTo(std::ostream* out) const { *out << "does not report " << takt::name_of(code_); }

 private:
  Code code_;
  std::vector<std::string> names_;
};
inline ReportsAnywhereMatcher ReportsAnywhere(Code code, std::vector<std::string> names = {}) {
  return {code, std::move(names)};
}

/// Of a text that has no code, such as a line of a log or the cause of an event: it contains these names and numbers.
class NamesMatcher {
 public:
  using is_gtest_matcher = void;
  explicit NamesMatcher(std::vector<std::string> names) : names_(std::move(names)) {}

  bool MatchAndExplain(std::string_view text, std::ostream* out) const {
    for (const std::string& name : names_) {
      if (contains_name(text, name)) continue;
      if (out != nullptr) *out << "which does not name " << name;
      return false;
    }
    return true;
  }
  void DescribeTo(std::ostream* out) const { print("names", out); }
  void DescribeNegationTo(std::ostream* out) const { print("does not name", out); }

 private:
  void print(std::string_view verb, std::ostream* out) const {
    *out << verb;
    for (const std::string& name : names_) *out << " " << name;
  }
  std::vector<std::string> names_;
};

template <class... Text>
NamesMatcher Names(const Text&... names) {
  return NamesMatcher({std::string(names)...});
}

}  // namespace takt::test
