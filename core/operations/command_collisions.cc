#include "core/operations/command_collisions.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/command/actions/motion_action.h"

namespace takt::activity {
namespace {

using Part = CommandBuilder::Part;

const command::PlannedMotion* planned_motion(const Part& part) {
  return part.made.action ? part.made.command.node()->model().planned_motion() : nullptr;
}

/// The devices of all commands of a tree.
std::set<std::string> all_driven_by(const CommandBuilder& tree) {
  std::set<std::string> devices;
  for (const Part& part : tree.parts()) {
    if (!part.made.actuator) continue;
    for (std::string& device : part.made.actuator->model().devices()) devices.insert(std::move(device));
  }
  return devices;
}

/// Who begins when something completes, as the file says it: one start by one handler.
struct Succession {
  const OperationCommand* before = nullptr;  ///< null: a state that is known in the run only
  int starts = 0;
};
std::map<const OperationCommand*, Succession> successions(const CommandBuilder& tree) {
  std::map<const OperationCommand*, Succession> found;
  for (const Part& part : tree.parts()) {
    for (const HandlerParameters& handler : part.request->handlers) {
      const StateParameters& state = handler.state;
      const bool completes = handler.entered && state.kind == StateParameters::Kind::kCommand &&
                             state.is == "completed" && !state.held_for;
      for (const HandlerParameters::Effect& effect : handler.effects) {
        if (effect.kind != command::Effect::Kind::kStart) continue;
        Succession& one = found[part.request->find(effect.name)];
        one.before = completes ? part.request->find(state.of) : nullptr;
        ++one.starts;
      }
    }
  }
  return found;
}

/// How long a command takes, s; nothing: that shows in the run.
std::optional<double> duration_of(const Part& part) {
  if (planned_motion(part) == nullptr || part.request->meant_touch().ends) return std::nullopt;
  return part.made.command.node()->model().duration();
}

CheckedMotion checked_motion(const Part& part, const command::PlannedMotion& motion, const Rehearsal& rehearsal,
                             const collision::Touching& all) {
  const OperationCommand::MeantTouch touch = part.request->meant_touch();
  CheckedMotion checked{.tracks = tracks_of(motion, part.made.actuator->model(), rehearsal.cell),
                        .parts = {{0.0, part.request->name, part.request->pointer}},
                        .touching = all,
                        .ends_at_touch = touch.ends};
  if (touch.first_motion > 0 && touch.first_motion <= motion.handed_over.size())
    checked.touch_from = motion.handed_over[touch.first_motion - 1];
  return checked;
}

/// Devices of which it is known at any time where they are: only planned motions move them, at times that are known.
std::set<std::string> on_the_clock(const CommandBuilder& tree,
                                   const std::map<const OperationCommand*, double>& begins) {
  std::set<std::string> devices = all_driven_by(tree);
  for (const Part& part : tree.parts()) {
    if (!part.made.actuator || (planned_motion(part) != nullptr && begins.contains(part.request))) continue;
    for (const std::string& device : part.made.actuator->model().devices()) devices.erase(device);
  }
  return devices;
}

}  // namespace

collision::Touching touching(const CommandBuilder& tree) {
  collision::Touching all;
  for (const Part& part : tree.parts()) {
    const auto own = part.request->meant_touch().devices;
    all.insert(own.begin(), own.end());
  }
  return all;
}

std::map<const OperationCommand*, double> begin_times(const CommandBuilder& tree) {
  const auto after = successions(tree);
  std::map<const OperationCommand*, double> begins;
  std::map<const OperationCommand*, double> ends;
  // Who comes before may stand behind in the file.
  for (std::size_t known = 0, before = 1; known != before;) {
    before = known;
    for (const Part& part : tree.parts()) {
      const OperationCommand& request = *part.request;
      const auto succession = after.find(&request);
      const int starts = succession == after.end() ? 0 : succession->second.starts;
      const auto parent = begins.find(request.parent());
      if (request.is_alone()) {
        begins[&request] = 0.0;
      } else if (request.starts && starts == 0 && parent != begins.end()) {
        begins[&request] = parent->second;
      } else if (!request.starts && starts == 1 && ends.contains(succession->second.before)) {
        begins[&request] = ends.at(succession->second.before);
      }
      const auto duration = duration_of(part);
      if (begins.contains(&request) && duration) ends[&request] = begins.at(&request) + *duration;
    }
    known = begins.size() + ends.size();
  }
  return begins;
}

void check_motions(const CommandBuilder& tree, Rehearsal& rehearsal, Diagnostics& diagnostics) {
  const auto begins = begin_times(tree);
  const std::set<std::string> driven = all_driven_by(tree), timed = on_the_clock(tree, begins);
  const collision::Touching all = touching(tree);
  std::vector<TimedMotion> together;
  for (const Part& part : tree.parts()) {
    const command::PlannedMotion* motion = planned_motion(part);
    if (motion == nullptr) continue;
    CheckedMotion checked = checked_motion(part, *motion, rehearsal, all);
    const auto own = part.made.actuator->model().devices();
    if (std::ranges::all_of(own, [&](const std::string& device) { return timed.contains(device); })) {
      together.push_back({std::move(checked), begins.at(part.request)});
      continue;
    }
    std::set<std::string> others = driven;
    for (const std::string& device : own) others.erase(device);
    check_planned(rehearsal, std::move(checked), diagnostics, others);
  }
  std::set<std::string> others = driven;
  for (const std::string& device : timed) others.erase(device);
  check_together(rehearsal, std::move(together), diagnostics, others);
}

}  // namespace takt::activity
