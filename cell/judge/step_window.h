#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cell/judge/run_log.h"
#include "core/base/form.h"

namespace takt::cell {

/// Names of the program's steps; nothing: nobody knows them before the run (a program in C++).
using StepNames = std::optional<std::vector<std::string>>;

/// The time in which a node of the program runs: a step, or anything that steps run in.
class StepWindow {
 public:
  /// @param name  of the node, or the path of goes_through(); empty: the whole run
  explicit StepWindow(std::string name) : name_(std::move(name)), inside_(name_.empty()), ran_(inside_) {}

  /// The steps that run have changed.
  void look(std::span<const std::string> paths);
  [[nodiscard]] bool inside() const { return inside_; }
  /// It has begun, though perhaps without a cycle.
  [[nodiscard]] bool ran() const { return ran_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
  bool inside_, ran_;
};

/// Time since a node of the program has begun, anew each time that it does, or since the run has. Only steps tell that
/// they begin: a node around them begins with its first one.
class StepClock {
 public:
  explicit StepClock(std::string node) : node_(std::move(node)) {}

  void hear(const LogEntry& entry);
  /// @return s
  [[nodiscard]] double at(Nanoseconds time) const { return to_seconds(time - begin_); }

 private:
  std::string node_, running_;  ///< running: with the path that leads to it
  Nanoseconds begin_ = 0;
};

/// Keys "from_s" and "to_s": a part of the time of a window, in its own time.
struct TimeSpan {
  static constexpr Range kAllowed{.low = 0.0, .high = 3600.0};
  double from = 0.0, to = std::numeric_limits<double>::infinity();  ///< s

  [[nodiscard]] bool contains(double time) const { return time >= from && time <= to; }
};
[[nodiscard]] TimeSpan read_span(FormReader& reader);
/// Their rows. @param what  does not count outside of them: "Events"
[[nodiscard]] std::vector<Key> span_keys(const std::string& what);

/// True if a path of steps ("sort / for_each (2) / grip") goes through a node of this name. A name may be that of one
/// round ("for_each (2)") and may have the nodes around it before it ("sort / grip"), not all of them.
[[nodiscard]] bool goes_through(std::string_view path, std::string_view name);

/// The beginning of a path up to a node of that name, without its round if the name has none: equal for all steps of
/// one run of the node. Empty: the path does not go through it.
[[nodiscard]] std::string_view node_in(std::string_view path, std::string_view name);

/// True if a path of steps ends with a node of this name: it has just begun. A name as of goes_through().
[[nodiscard]] bool ends_with(std::string_view path, std::string_view name);

/// The parts of such a name that are no steps. @param steps  names of the program's steps
[[nodiscard]] std::vector<std::string_view> unknown_parts(std::string_view name, std::span<const std::string> steps);

/// The key "during": what goes_through() takes as a name; a diagnostic for each node that does not exist.
[[nodiscard]] std::string read_during(FormReader& reader, const StepNames& steps);
/// Its row.
[[nodiscard]] Key during_key();

}  // namespace takt::cell
