#include "core/operations/command_collisions.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/command/actions/motion_action.h"
#include "core/operations/possible_meetings.h"

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

/// A planned motion of a tree as it is checked.
struct TreeMotion {
  const Part* part;
  CheckedMotion motion;
};

std::vector<TreeMotion> motions_of(const CommandBuilder& tree, const Rehearsal& rehearsal) {
  const collision::Touching all = touching(tree);
  std::vector<TreeMotion> motions;
  for (const Part& part : tree.parts())
    if (const command::PlannedMotion* motion = planned_motion(part))
      motions.push_back({&part, checked_motion(part, *motion, rehearsal, all)});
  return motions;
}

/// One starts when the other has completed, directly or by what is between them.
bool comes_after(const std::map<const OperationCommand*, Succession>& after, const OperationCommand* later,
                 const OperationCommand* earlier) {
  std::set<const OperationCommand*> seen;
  while (later != nullptr && seen.insert(later).second) {
    const auto succession = after.find(later);
    if (later->starts || succession == after.end() || succession->second.starts != 1) return false;
    later = succession->second.before;
    if (later == earlier) return true;
  }
  return false;
}

bool share_a_device(const Part& a, const Part& b) {
  const auto of_b = b.made.actuator->model().devices();
  return std::ranges::any_of(a.made.actuator->model().devices(),
                             [&](const std::string& device) { return std::ranges::find(of_b, device) != of_b.end(); });
}

bool drives_only(const Part& part, const std::set<std::string>& devices) {
  return std::ranges::all_of(part.made.actuator->model().devices(),
                             [&](const std::string& device) { return devices.contains(device); });
}

/// Two motions of which it is not known when the one begins after the other.
/// @param timed  devices of which it is known at any time where they are
void check_untimed(const CommandBuilder& tree, const std::vector<TreeMotion>& motions,
                   const std::set<std::string>& timed, const Rehearsal& rehearsal, Diagnostics& diagnostics) {
  if (rehearsal.cell.shapes == nullptr || !rehearsal.cell.shapes->off.empty()) return;
  const auto after = successions(tree);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    for (std::size_t j = i + 1; j < motions.size(); ++j) {
      const OperationCommand *a = motions[i].part->request, *b = motions[j].part->request;
      if (drives_only(*motions[i].part, timed) && drives_only(*motions[j].part, timed)) continue;
      if (share_a_device(*motions[i].part, *motions[j].part)) continue;
      if (comes_after(after, a, b) || comes_after(after, b, a)) continue;
      note_possible_meetings(rehearsal.cell, situation_of(rehearsal), motions[i].motion, motions[j].motion,
                             diagnostics);
    }
  }
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
  std::vector<TreeMotion> motions = motions_of(tree, rehearsal);
  check_untimed(tree, motions, timed, rehearsal, diagnostics);
  std::vector<TimedMotion> together;
  for (auto& [part, checked] : motions) {
    if (drives_only(*part, timed)) {
      together.push_back({std::move(checked), begins.at(part->request)});
      continue;
    }
    std::set<std::string> others = driven;
    for (const std::string& device : part->made.actuator->model().devices()) others.erase(device);
    check_planned(rehearsal, std::move(checked), diagnostics, others);
  }
  std::set<std::string> others = driven;
  for (const std::string& device : timed) others.erase(device);
  check_together(rehearsal, std::move(together), diagnostics, others);
}

}  // namespace takt::activity
