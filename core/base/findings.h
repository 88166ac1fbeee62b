#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt {

/// How bad a finding is: an error refuses the input, a warning and a note do not.
enum class Severity { kError, kWarning, kNote };

/// One thing found in an input of the user: where it stands, what is wrong, what would be right.
struct Finding {
  Severity severity = Severity::kError;
  std::string file;     ///< as the user named it; empty if the input is no file
  std::string pointer;  ///< JSON pointer (RFC 6901) or another place inside the file; empty = the whole
  std::string message;  ///< what is wrong, with the value
  std::string hint;     ///< what is allowed, or how to mend it; may be empty
};

/// "FILE:POINTER: error: MESSAGE (HINT)" on one line.
[[nodiscard]] std::string to_string(const Finding& finding);

/// The findings of one check, in the order found. Checks add and go on, so that the user sees all at once.
/// Thread: any, one at a time. Realtime: setup.
class Findings {
 public:
  void add(Finding finding) { list_.push_back(std::move(finding)); }
  void error(std::string pointer, std::string message, std::string hint = {});
  void warning(std::string pointer, std::string message, std::string hint = {});
  void note(std::string pointer, std::string message, std::string hint = {});

  /// Appends what `other` found; `prefix` goes before each of its pointers, `file` fills in where it names none.
  void append(const Findings& other, std::string_view prefix = {}, std::string_view file = {});

  /// Names the file in every finding that names none yet.
  void set_file(std::string_view file);

  [[nodiscard]] bool has_errors() const;
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] const std::vector<Finding>& list() const { return list_; }
  /// All findings, a line each.
  [[nodiscard]] std::string to_string() const;

 private:
  std::vector<Finding> list_;
};

/// A value, or the findings that say why there is none.
template <class T>
using Result = std::expected<T, Findings>;

/// The findings with one error, ready to be returned from a function that gives a Result.
[[nodiscard]] std::unexpected<Findings> failure(std::string pointer, std::string message, std::string hint = {});

/// `", did you mean 'x'?"`-style text for a mistyped `name`: the nearest of `choices` by edit distance and the list of
/// all of them (at most `most`); an empty name is near to nothing.
[[nodiscard]] std::string nearest_choice(std::string_view name, const std::vector<std::string>& choices,
                                         std::size_t most = 12);

/// `token` escaped as one JSON-pointer segment, with the leading slash.
[[nodiscard]] std::string pointer_segment(std::string_view token);
[[nodiscard]] std::string pointer_segment(std::size_t index);

}  // namespace takt
