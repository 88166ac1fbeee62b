#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt {

/// How bad a diagnostic is: an error refuses the input, a warning and a note do not.
enum class Severity { kError, kWarning, kNote };

/// What kind of thing is wrong, for programs and tests: the names (name_of) are stable, while messages may be reworded.
enum class Code : std::uint8_t {
  // The text of a file, an option or a description.
  kSyntax,
  kMissing,
  kUnknownKey,
  kUnknownName,
  kDuplicate,
  kInvalidName,
  kInvalidValue,
  kWrongType,
  kWrongSize,
  kOutOfRange,
  kTooLarge,
  kConflict,
  kRequires,
  kUnsupported,
  kUsage,
  kInvalidModel,
  kIncompatible,
  // Files and the machine.
  kNotFound,
  kFileNotReadable,
  kFileNotWritable,
  kSystem,
  kInternal,
  // Nets.
  kTypeMismatch,
  kUnitMismatch,
  kFrameMismatch,
  kUnlinkedInput,
  kCycleWithoutDelay,
  kResourceConflict,
  kOverBudget,
  kReactionBound,
  // Planning.
  kUnreachable,
  kLimitExceeded,
  kPayloadMismatch,
  kPlanningFailed,
  kUnknownPosition,
  kCollision,
  kUnknownPose,
  kNotKnownYet,
  kNeverFires,
  // What happens while a program runs.
  kNotPossibleNow,
  kSensorSilent,
  kConditionNotMet,
  kAbortCondition,
  kTimeout,
  kStopped,
  kNoContact,
  kUnexpectedContact,
  kDeviceFault,
  kRaised,
  kCancelled,
  // Nothing is wrong.
  kNote,
};

/// The name of a code in outputs: lower case with hyphens, "unknown-name".
[[nodiscard]] std::string_view name_of(Code code);
/// What a code means, one sentence.
[[nodiscard]] std::string_view meaning_of(Code code);
/// Every code, in the order of the enumeration.
[[nodiscard]] std::span<const Code> all_codes();
/// The code of this name; null if there is none.
[[nodiscard]] std::optional<Code> code_named(std::string_view name);

/// One thing that is wrong, or worth knowing, in an input of the user: where, what, and what would be right.
struct Diagnostic {
  Severity severity = Severity::kError;
  Code code = Code::kInvalidValue;
  std::string file;     ///< as the user named it; empty if the input is no file
  std::string pointer;  ///< JSON pointer (RFC 6901) or another location inside the file; empty = the whole
  std::string message;  ///< what is wrong, with the value
  std::string hint;     ///< what is allowed, or how to fix it; may be empty
  int line = 0;         ///< from 1, in `file`; 0: not known (core/base/text_location.h fills it in)
  int column = 0;       ///< from 1, in bytes
};

/// "FILE:LINE:COLUMN:POINTER: error: MESSAGE (HINT) [CODE]" on one line, without what is not known.
[[nodiscard]] std::string to_string(const Diagnostic& diagnostic);

/// The diagnostics of one check, in the order found. Checks add and go on, so that the user sees all at once.
/// Thread: any, one at a time. Realtime: setup.
class Diagnostics {
 public:
  void add(Diagnostic diagnostic) { list_.push_back(std::move(diagnostic)); }
  void error(Code code, std::string pointer, std::string message, std::string hint = {});
  void warning(Code code, std::string pointer, std::string message, std::string hint = {});
  void note(std::string pointer, std::string message, std::string hint = {});

  /// Appends `other`; `prefix` goes before each of its pointers, `file` fills in where it names none.
  void append(const Diagnostics& other, std::string_view prefix = {}, std::string_view file = {});

  /// Names the file in every diagnostic that names none yet.
  void set_file(std::string_view file);

  [[nodiscard]] bool has_errors() const;
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] const std::vector<Diagnostic>& list() const { return list_; }
  [[nodiscard]] std::vector<Diagnostic>& list() { return list_; }
  /// All diagnostics, a line each.
  [[nodiscard]] std::string to_string() const;

 private:
  std::vector<Diagnostic> list_;
};

/// A value, or the diagnostics that say why there is none.
template <class T>
using Result = std::expected<T, Diagnostics>;

/// The diagnostics with one error, ready to be returned from a function that gives a Result.
[[nodiscard]] std::unexpected<Diagnostics> failure(Code code, std::string pointer, std::string message,
                                                   std::string hint = {});

/// `", did you mean 'x'?"`-style text for a mistyped `name`: the nearest of `choices` by edit distance and the list of
/// all of them (at most `most`); an empty name is near to nothing.
[[nodiscard]] std::string nearest_choice(std::string_view name, const std::vector<std::string>& choices,
                                         std::size_t most = 12);

/// `token` escaped as one JSON-pointer segment, with the leading slash.
[[nodiscard]] std::string pointer_segment(std::string_view token);
[[nodiscard]] std::string pointer_segment(std::size_t index);

}  // namespace takt
