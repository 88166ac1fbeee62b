#include "core/command/check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/command/broken_rule.h"
#include "core/command/command_tree.h"
#include "core/command/effect_check.h"
#include "core/command/formula_check.h"
#include "core/command/handler_check.h"

namespace takt::command {
namespace {

using Kind = Effect::Kind;

constexpr double kLongestTime = 1e6;  ///< s: what timers take

/// Of several arms the one that does not have the mode.
std::string without_mode(const ActuatorModel& actuator, device::ControlMode mode) {
  for (const expression::MountedArm* arm : actuator.compliant_arms()) {
    const bool one_of_many = actuator.arms().size() > 1;
    if (one_of_many && !arm->device->description().modes.has(mode)) return arm->device->name();
  }
  return actuator.name();
}

/// The rules about commands and about the tree as a whole; those about formulas and handlers are parts of their own.
class Checker {
 public:
  Checker(const CommandTree& tree, bool planned) : tree_(tree), planned_(planned) {}

  Diagnostics run() {
    for (const std::string& path : tree_.doubles()) {
      error(Code::kDuplicate, path, "C6", "this command is in the tree twice",
            "Add a command of its own: each runs once at most");
    }
    for (int i = 0; i < tree_.size(); ++i) {
      check_name(i);
      if (node(i).is_runtime()) check_runtime(i);
      if (node(i).is_wait()) check_wait(i);
      if (node(i).is_transaction()) check_transaction(i);
      for (const Observation& observation : node(i).observations) check_observation(i, observation);
    }
    for (const auto& handler : tree_.handlers()) check_handler(handler);
    check_cycle();
    check_rivals();
    check_acting(tree_, diagnostics_);
    // What makes a command fail is mostly what its handlers react to: a fault of it is told once.
    for (int i = 0; i < tree_.size() && !diagnostics_.has_errors(); ++i)
      if (node(i).fails_if) formulas_.check(node(i).fails_if->node(), path(i) + "/fails_if");
    // What is not planned because of another fault is no fault of its own.
    if (planned_ && !diagnostics_.has_errors()) check_planned();
    return std::move(diagnostics_);
  }

 private:
  const CommandNode& node(int i) const { return *tree_.at(i).node; }
  const std::string& path(int i) const { return tree_.at(i).path; }
  void error(Code code, const std::string& location, const char* rule, const std::string& message,
             const std::string& hint) {
    report_broken_rule(diagnostics_, code, location, rule, message, hint);
  }

  void check_name(int i) {
    if (node(i).name.empty())
      diagnostics_.error(Code::kMissing, path(i), "a command without a name", "Give it a name of its own");
    const int parent = tree_.at(i).parent;
    if (parent < 0 || names_.emplace(parent, node(i).name).second) return;
    diagnostics_.error(Code::kDuplicate, path(i), fmt::format("'{}' has two commands of this name", node(parent).name),
                       "Use each name once");
  }

  void check_observation(int i, const Observation& observation) {
    const std::string location = path(i) + "/observations" + pointer_segment(observation.name);
    const std::string name = tree_.name_of(i, observation);
    if (!observed_.insert(name).second) {
      diagnostics_.error(Code::kDuplicate, location, fmt::format("'{}' is observed twice", name),
                         "Use each name once in a tree");
    }
    formulas_.check(observation.value, location);
    if (observation.when) formulas_.check(observation.when, location);
  }

  // -- Commands ------------------------------------------------------------------------------------------------------

  void check_runtime(int i) {
    const ActuatorModel& actuator = node(i).actuator->model();
    if (const auto fault = actuator.fault())
      return diagnostics_.error(fault->code, path(i) + fault->pointer, fault->message, fault->hint);
    const ActionModel& action = node(i).model();
    for (const expression::ExpressionPtr& formula : action.formulas()) formulas_.check(formula, path(i));
    if (const auto speed = actuator.speed()) formulas_.check(speed->node(), path(i));
    const auto takes = actuator.takes();
    const SetPointKind gives = action.gives(actuator);
    if (std::ranges::find(takes, gives) == takes.end()) {
      std::vector<std::string_view> names;
      for (const SetPointKind kind : takes) names.push_back(name_of(kind));
      return error(
          Code::kInvalidValue, path(i), "C8",
          fmt::format("{} gives {}, which '{}' does not accept", action.name(), name_of(gives), actuator.name()),
          fmt::format("Use an action that gives {}", fmt::join(names, ", ")));
    }
    const auto modes = actuator.modes();
    const auto mode = action.mode();
    if (mode && std::ranges::find(modes, *mode) == modes.end()) {
      std::vector<std::string_view> names;
      for (const device::ControlMode one : modes) names.push_back(device::name_of(one));
      return error(
          Code::kInvalidValue, path(i), "C8",
          fmt::format("{} gives {} for mode {}, which '{}' does not accept", action.name(), name_of(gives),
                      device::name_of(*mode), without_mode(actuator, *mode)),
          names.empty() ? std::string("Remove the mode") : fmt::format("Use one for {}", fmt::join(names, ", ")));
    }
    if (!action.needs_plan()) diagnostics_.append(action.check(actuator), path(i));
  }

  void check_planned() {
    for (int i = 0; i < tree_.size(); ++i) {
      if (!node(i).is_runtime() || !node(i).model().needs_plan()) continue;
      diagnostics_.error(Code::kRequires, path(i), fmt::format("{} is not planned", node(i).model().name()),
                         "Call plan() before it is mapped");
    }
  }

  void check_wait(int i) {
    check_time(path(i), node(i).seconds.value_or(0.0));
    if (node(i).until) formulas_.check(node(i).until->node(), path(i));
  }

  void check_time(const std::string& location, double seconds) {
    if (seconds >= 0.0 && seconds <= kLongestTime) return;
    diagnostics_.error(Code::kOutOfRange, location, fmt::format("a time of {:g} s", seconds),
                       fmt::format("Choose 0 to {:g} s", kLongestTime));
  }

  void check_transaction(int i) {
    for (const expression::SubjectPtr& target : node(i).cancel_policy.targets) {
      const int child = tree_.find(target);
      if (child >= 0 && tree_.at(child).parent == i) continue;
      error(Code::kInvalidValue, path(i), "C4",
            fmt::format("cancel is forwarded to '{}', which is not directly inside", target->name),
            "Forward it to commands of this transaction");
    }
    if (startable(i).empty()) {
      return error(Code::kNeverFires, path(i), "C9",
                   fmt::format("nothing starts in '{}', so it would never end", node(i).name),
                   "Use add_started(), or a handler that starts something by what is not inside of it");
    }
    for (const int child : tree_.at(i).children) {
      if (!tree_.at(child).with_parent && tree_.acting_on(Kind::kStart, child).empty())
        error(Code::kNeverFires, path(child), "C9", fmt::format("nothing ever starts '{}'", node(child).name),
              "Use add_started(), or a handler that starts it");
    }
  }

  /// The commands directly inside that can come to run: those that start with it, and those whose event does not wait
  /// for a command inside that cannot run.
  std::set<int> startable(int transaction) const {
    std::set<int> can;
    std::vector<int> open;
    const auto add = [&](int child) {
      if (can.insert(child).second) open.push_back(child);
    };
    std::map<int, std::vector<int>> waiting;  // handlers by what they wait for
    std::map<int, std::size_t> missing;       // by handler
    for (const int child : tree_.at(transaction).children) {
      if (tree_.at(child).with_parent) add(child);
      for (const int h : tree_.acting_on(Kind::kStart, child)) {
        const std::set<int> needs = needed_by(h, transaction);
        missing[h] = needs.size();
        for (const int need : needs) waiting[need].push_back(h);
        if (needs.empty()) add(child);
      }
    }
    while (!open.empty()) {
      const int child = open.back();
      open.pop_back();
      for (const int h : waiting[child])
        if (--missing[h] == 0) add(tree_.find(tree_.handler(h).handler->effect.target));
    }
    return can;
  }

  /// The commands directly inside that the handler speaks of.
  std::set<int> needed_by(int h, int transaction) const {
    std::set<int> needs;
    for (const expression::SubjectPtr& subject : expression::subjects_of(tree_.handler(h).handler->state.node())) {
      int of = tree_.find(subject);
      while (of >= 0 && tree_.at(of).parent != transaction) of = tree_.at(of).parent;
      if (of >= 0) needs.insert(of);
    }
    return needs;
  }

  // -- Handlers ------------------------------------------------------------------------------------------------------

  void check_handler(const CommandTree::Handler& h) {
    formulas_.check(h.handler->state.node(), h.path);
    check_time(h.path, h.handler->trigger.delay);
    effects_.check(h);
  }

  // -- The whole tree ------------------------------------------------------------------------------------------------

  void check_cycle() {
    const std::vector<int> cycle = tree_.cycle_of_starts();
    if (cycle.empty()) return;
    std::vector<std::string> names;
    for (const int i : cycle) names.push_back(path(i));
    names.push_back(names.front());
    error(Code::kInvalidValue, names.front(), "C5", fmt::format("it would start itself: {}", fmt::join(names, " -> ")),
          "Repeat it in the program: each command runs once at most");
  }

  /// Commands that run together for sure: those that begin in the first cycle of the whole.
  bool in_first_cycle(int i) const {
    for (; i >= 0; i = tree_.at(i).parent) {
      if (!tree_.at(i).with_parent) return false;
    }
    return true;
  }

  void check_rivals() {
    std::vector<int> first;
    for (int i = 0; i < tree_.size(); ++i) {
      if (!node(i).is_runtime() || !in_first_cycle(i)) continue;
      for (const int other : first) check_rivals(other, i);
      first.push_back(i);
    }
  }

  void check_rivals(int first, int second) {
    for (const std::string& device : node(first).actuator->model().devices()) {
      const auto devices = node(second).actuator->model().devices();
      if (std::ranges::find(devices, device) == devices.end()) continue;
      error(Code::kResourceConflict, path(second), "C7",
            fmt::format("it drives '{}' together with '{}'", device, path(first)),
            "Start one after the other, by a handler on `completed`");
    }
  }

  const CommandTree& tree_;
  bool planned_;
  Diagnostics diagnostics_;
  FormulaCheck formulas_{tree_, diagnostics_};
  EffectCheck effects_{tree_, diagnostics_};
  std::set<std::string> observed_;
  std::set<std::pair<int, std::string>> names_;  ///< by transaction
};

}  // namespace

Diagnostics check(const Command& command, bool planned) { return Checker(CommandTree(command), planned).run(); }

void append_new(const Diagnostics& more, Diagnostics& found) {
  for (const Diagnostic& one : more.list()) {
    const bool known = std::ranges::any_of(found.list(), [&](const Diagnostic& other) {
      return other.message == one.message && other.pointer.starts_with(one.pointer);
    });
    if (!known) found.add(one);
  }
}

}  // namespace takt::command
