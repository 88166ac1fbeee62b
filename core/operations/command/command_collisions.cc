#include "core/operations/command/command_collisions.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/command/actions/motion_action.h"
#include "core/operations/review/possible_meetings.h"

namespace takt::operations {
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

activity::CheckedMotion checked_motion(const Part& part, const command::PlannedMotion& motion,
                                       const Rehearsal& rehearsal, const collision::Touching& all) {
  const OperationCommand::IntendedContact touch = part.request->meant_touch();
  activity::CheckedMotion checked{.tracks = activity::tracks_of(motion, part.made.actuator->model(), rehearsal.cell),
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

/// Numbers of what runs beside each other, from 0: motions that share a device run one after the other.
std::vector<std::size_t> lines_of(const std::vector<TreeMotion>& motions) {
  std::vector<std::size_t> lines;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    std::size_t own = i;
    for (std::size_t j = 0; j < i; ++j) {
      if (!share_a_device(*motions[i].part, *motions[j].part)) continue;
      if (own == i) own = lines[j];
      std::ranges::replace(lines, lines[j], own);
    }
    lines.push_back(own);
  }
  return lines;
}

/// Where it is not known when a motion begins: when all before it in the file have ended that share a device with it.
void assume_begins(std::vector<TreeMotion>& motions) {
  for (std::size_t i = 0; i < motions.size(); ++i) {
    for (std::size_t j = 0; j < i && !motions[i].timed; ++j) {
      if (!share_a_device(*motions[i].part, *motions[j].part)) continue;
      motions[i].begin = std::max(motions[i].begin, motions[j].begin + motions[j].motion.duration());
    }
  }
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

/// Pointers of those that never run beside it.
std::set<std::string> never_beside(const std::map<const OperationCommand*, Succession>& after, const TreeMotion& one,
                                   const std::vector<TreeMotion>& motions) {
  std::set<std::string> pointers;
  for (const TreeMotion& other : motions)
    if (comes_after(after, one.part->request, other.part->request) ||
        comes_after(after, other.part->request, one.part->request))
      pointers.insert(other.part->request->pointer);
  return pointers;
}

/// How long all of it takes, s. Nothing: that is not known.
std::optional<double> known_duration(const CommandBuilder& tree,
                                     const std::map<const OperationCommand*, double>& begins) {
  double last = 0.0;
  for (const Part& part : tree.parts()) {
    if (part.request->transaction() != nullptr) continue;
    const auto begin = begins.find(part.request);
    const auto duration = duration_of(part);
    if (begin == begins.end() || !duration) return std::nullopt;
    last = std::max(last, begin->second + *duration);
  }
  return last;
}

}  // namespace

std::vector<TreeMotion> motions_of(const CommandBuilder& tree, const Rehearsal& rehearsal) {
  const collision::Touching all = touching(tree);
  const auto begins = begin_times(tree);
  const auto after = successions(tree);
  std::vector<TreeMotion> motions;
  for (const Part& part : tree.parts()) {
    const command::PlannedMotion* motion = planned_motion(part);
    if (motion == nullptr) continue;
    const auto begin = begins.find(part.request);
    const bool timed = begin != begins.end();
    motions.push_back({.part = &part,
                       .motion = checked_motion(part, *motion, rehearsal, all),
                       .begin = timed ? begin->second : 0.0,
                       .timed = timed});
  }
  assume_begins(motions);
  const auto lines = lines_of(motions);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    motions[i].line = lines[i];
    motions[i].never_beside = never_beside(after, motions[i], motions);
  }
  return motions;
}

void rehearse_time(const CommandBuilder& tree, Rehearsal& rehearsal) {
  if (const auto all = known_duration(tree, begin_times(tree))) {
    rehearsal.duration += *all;
    return;
  }
  for (const Part& part : tree.parts())
    if (part.made.action) rehearsal.duration += part.made.command.node()->model().duration();
  invalidate_timing(rehearsal);
}

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
      if (request.parent() == nullptr) {
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
  const std::set<std::string> driven = all_driven_by(tree), timed = on_the_clock(tree, begin_times(tree));
  std::vector<TreeMotion> motions = motions_of(tree, rehearsal);
  check_untimed(tree, motions, timed, rehearsal, diagnostics);
  std::map<std::size_t, int> branches;  // of a parallel, by line
  const auto as_checked = [&](TreeMotion& one) {
    const auto [branch, fresh] = branches.try_emplace(one.line, 0);
    if (fresh) branch->second = branch_within(rehearsal);
    OperationCommand::OwnPaths own = one.part->request->own_paths();
    return TimedMotion{.motion = std::move(one.motion),
                       .begin = one.begin,
                       .timed = one.timed,
                       .branch = branch->second,
                       .arm = std::move(own.arm),
                       .moves = std::move(own.pointers),
                       .never_beside = std::move(one.never_beside)};
  };
  std::vector<TimedMotion> together;
  for (TreeMotion& one : motions) {
    if (drives_only(*one.part, timed)) {
      together.push_back(as_checked(one));
      continue;
    }
    std::set<std::string> others = driven;
    for (const std::string& device : one.part->made.actuator->model().devices()) others.erase(device);
    check_together(rehearsal, {as_checked(one)}, diagnostics, others);
  }
  std::set<std::string> others = driven;
  for (const std::string& device : timed) others.erase(device);
  check_together(rehearsal, std::move(together), diagnostics, others);
}

}  // namespace takt::operations
