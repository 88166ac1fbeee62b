#include "core/base/diagnostics.h"

#include <algorithm>
#include <array>
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

/// What is said of a code.
struct CodeRow {
  Code code;
  std::string_view name;
  std::string_view meaning;
};

constexpr auto kCodes = std::to_array<CodeRow>({
    {Code::kSyntax, "syntax", "The text cannot be read as what it should be."},
    {Code::kMissing, "missing", "Something required is absent."},
    {Code::kUnknownKey, "unknown-key", "A key that is not known at this location."},
    {Code::kUnknownName, "unknown-name", "A name that refers to nothing."},
    {Code::kDuplicate, "duplicate", "The same name, key or element a second time."},
    {Code::kInvalidName, "invalid-name", "A name that is not allowed here."},
    {Code::kInvalidValue, "invalid-value", "A value that is not allowed here."},
    {Code::kWrongType, "wrong-type", "A value of another JSON type than expected."},
    {Code::kWrongSize, "wrong-size", "A list with too few or too many elements."},
    {Code::kOutOfRange, "out-of-range", "A number outside the allowed range."},
    {Code::kTooLarge, "too-large", "More than takt reads, plans or holds: bytes, elements, levels."},
    {Code::kConflict, "conflict", "Two things that exclude each other."},
    {Code::kRequires, "requires", "Something that needs something else which is absent."},
    {Code::kUnsupported, "unsupported", "Valid elsewhere, but not supported by takt."},
    {Code::kUsage, "usage", "A command line that cannot be understood."},
    {Code::kInvalidModel, "invalid-model", "A robot model that its reader refuses."},
    {Code::kIncompatible, "incompatible", "Made for, or by, something of another version or build."},
    {Code::kNotFound, "not-found", "A file that does not exist."},
    {Code::kFileNotReadable, "file-not-readable", "A file that exists and cannot be read."},
    {Code::kFileNotWritable, "file-not-writable", "A file that cannot be written."},
    {Code::kSystem, "system", "The operating system, the graphics library or a helper program refuses."},
    {Code::kInternal, "internal", "An exception of a primitive, a plug-in or of takt itself."},
    {Code::kTypeMismatch, "type-mismatch", "Two types that do not match."},
    {Code::kUnitMismatch, "unit-mismatch", "Two physical units that do not match."},
    {Code::kFrameMismatch, "frame-mismatch", "Two frames that do not match."},
    {Code::kUnlinkedInput, "unlinked-input", "An input of a net with neither link nor constant."},
    {Code::kCycleWithoutDelay, "cycle-without-delay", "A cycle of links without a delayed one."},
    {Code::kResourceConflict, "resource-conflict", "One device driven twice at a time."},
    {Code::kOverBudget, "over-budget", "More computing time per cycle than is free."},
    {Code::kReactionBound, "reaction-bound", "A demanded reaction time that the net cannot keep."},
    {Code::kUnreachable, "unreachable", "A pose that the arm does not reach."},
    {Code::kLimitExceeded, "limit-exceeded",
     "A limit of velocity, acceleration, torque, range or load would be exceeded."},
    {Code::kPayloadMismatch, "payload-mismatch", "The mass that an arm is told to carry is not that of what it holds."},
    {Code::kPlanningFailed, "planning-failed", "No motion was found that does what is asked."},
    {Code::kUnknownPosition, "unknown-position", "Where an arm will be cannot be known before the run."},
    {Code::kCollision, "collision", "Two bodies of the cell would collide, or come nearer than the margin."},
    {Code::kUnknownPose, "unknown-pose", "The pose of a frame or object is not known."},
    {Code::kNotKnownYet, "not-known-yet", "A value that is not known at this time."},
    {Code::kNeverFires, "never-fires", "An event that can never happen."},
    {Code::kNotPossibleNow, "not-possible-now", "Refused in the present state; possible in another."},
    {Code::kSensorSilent, "sensor-silent", "A sensor or device did not answer."},
    {Code::kConditionNotMet, "condition-not-met", "A condition that was waited for never held."},
    {Code::kAbortCondition, "abort-condition", "The condition that aborts the step became true."},
    {Code::kTimeout, "timeout", "Something took longer than allowed."},
    {Code::kStopped, "stopped", "Stopped, given up or refused by the control core before its end."},
    {Code::kNoContact, "no-contact", "A contact was expected and there was none, or it does not fit."},
    {Code::kUnexpectedContact, "unexpected-contact", "Two bodies touched in the run, and no step allows it."},
    {Code::kDeviceFault, "device-fault", "A device reports a fault."},
    {Code::kRaised, "raised", "A failure that the program itself raised."},
    {Code::kCancelled, "cancelled", "Cancelled by the operator or by the program."},
    {Code::kNote, "note", "Nothing is wrong; worth knowing."},
});

static_assert(
    [] {
      for (std::size_t i = 0; i < kCodes.size(); ++i)
        if (kCodes[i].code != static_cast<Code>(i)) return false;
      return kCodes.back().code == Code::kNote;
    }(),
    "a row for every code, in the order of the enumeration");

const CodeRow& row_of(Code code) { return kCodes.at(static_cast<std::size_t>(code)); }

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

std::string_view name_of(Code code) { return row_of(code).name; }

std::string_view meaning_of(Code code) { return row_of(code).meaning; }

std::span<const Code> all_codes() {
  static constexpr auto kAll = [] {
    std::array<Code, kCodes.size()> all{};
    std::ranges::transform(kCodes, all.begin(), &CodeRow::code);
    return all;
  }();
  return kAll;
}

std::optional<Code> code_named(std::string_view name) {
  const auto row = std::ranges::find(kCodes, name, &CodeRow::name);
  return row == kCodes.end() ? std::nullopt : std::optional(row->code);
}

std::string to_string(const Diagnostic& diagnostic) {
  std::string where = diagnostic.file;
  if (diagnostic.line > 0) where += fmt::format(":{}:{}", diagnostic.line, diagnostic.column);
  if (!diagnostic.pointer.empty()) where += (where.empty() ? "" : ":") + diagnostic.pointer;
  std::string text = fmt::format("{}{}: {}", where.empty() ? "" : where + ": ", severity_name(diagnostic.severity),
                                 diagnostic.message);
  if (!diagnostic.hint.empty()) text += fmt::format(" ({})", diagnostic.hint);
  if (diagnostic.code != Code::kNote) text += fmt::format(" [{}]", name_of(diagnostic.code));
  return text;
}

void Diagnostics::error(Code code, std::string pointer, std::string message, std::string hint) {
  add({.severity = Severity::kError,
       .code = code,
       .file = {},
       .pointer = std::move(pointer),
       .message = std::move(message),
       .hint = std::move(hint)});
}

void Diagnostics::warning(Code code, std::string pointer, std::string message, std::string hint) {
  error(code, std::move(pointer), std::move(message), std::move(hint));
  list_.back().severity = Severity::kWarning;
}

void Diagnostics::note(std::string pointer, std::string message, std::string hint) {
  error(Code::kNote, std::move(pointer), std::move(message), std::move(hint));
  list_.back().severity = Severity::kNote;
}

void Diagnostics::append(const Diagnostics& other, std::string_view prefix, std::string_view file) {
  for (Diagnostic diagnostic : other.list_) {
    diagnostic.pointer.insert(0, prefix);
    const bool of_command_line = diagnostic.pointer.starts_with("--");
    if (diagnostic.file.empty() && !of_command_line) diagnostic.file = file;
    add(std::move(diagnostic));
  }
}

void Diagnostics::set_file(std::string_view file) {
  for (Diagnostic& diagnostic : list_) {
    const bool of_command_line = diagnostic.pointer.starts_with("--");
    if (diagnostic.file.empty() && !of_command_line) diagnostic.file = file;
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

std::unexpected<Diagnostics> failure(Code code, std::string pointer, std::string message, std::string hint) {
  Diagnostics diagnostics;
  diagnostics.error(code, std::move(pointer), std::move(message), std::move(hint));
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
