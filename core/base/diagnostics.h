#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt {

/// How bad a diagnostic is: an error refuses the input, a warning and a note do not.
enum class Severity { kError, kWarning, kNote };

/// One thing found in an input of the user: where it stands, what is wrong, what would be right.
struct Diagnostic {
  Severity severity = Severity::kError;
  std::string file;     ///< as the user named it; empty if the input is no file
  std::string pointer;  ///< JSON pointer (RFC 6901) or another place inside the file; empty = the whole
  std::string message;  ///< what is wrong, with the value
  std::string hint;     ///< what is allowed, or how to mend it; may be empty
};

/// "FILE:POINTER: error: MESSAGE (HINT)" on one line.
[[nodiscard]] std::string to_string(const Diagnostic& diagnostic);

/// The diagnostics of one check, in the order found. Checks add and go on, so that the user sees all at once.
/// Thread: any, one at a time. Realtime: setup.
class Diagnostics {
 public:
  void add(Diagnostic diagnostic) { list_.push_back(std::move(diagnostic)); }
  void error(std::string pointer, std::string message, std::string hint = {});
  void warning(std::string pointer, std::string message, std::string hint = {});
  void note(std::string pointer, std::string message, std::string hint = {});

  /// Appends what `other` found; `prefix` goes before each of its pointers, `file` fills in where it names none.
  void append(const Diagnostics& other, std::string_view prefix = {}, std::string_view file = {});

  /// Names the file in every diagnostic that names none yet.
  void set_file(std::string_view file);

  [[nodiscard]] bool has_errors() const;
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] const std::vector<Diagnostic>& list() const { return list_; }
  /// All diagnostics, a line each.
  [[nodiscard]] std::string to_string() const;

 private:
  std::vector<Diagnostic> list_;
};

/// A value, or the diagnostics that say why there is none.
template <class T>
using Result = std::expected<T, Diagnostics>;

/// The diagnostics with one error, ready to be returned from a function that gives a Result.
[[nodiscard]] std::unexpected<Diagnostics> failure(std::string pointer, std::string message, std::string hint = {});

/// `", did you mean 'x'?"`-style text for a mistyped `name`: the nearest of `choices` by edit distance and the list of
/// all of them (at most `most`); an empty name is near to nothing.
[[nodiscard]] std::string nearest_choice(std::string_view name, const std::vector<std::string>& choices,
                                         std::size_t most = 12);

/// `token` escaped as one JSON-pointer segment, with the leading slash.
[[nodiscard]] std::string pointer_segment(std::string_view token);
[[nodiscard]] std::string pointer_segment(std::size_t index);

}  // namespace takt
