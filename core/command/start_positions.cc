#include "core/command/start_positions.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace takt::command {
namespace {

using kinematics::JointVector;
using Kind = Effect::Kind;

/// The parts of "a and b and c".
void add_conjuncts(const expression::ExpressionPtr& state, std::vector<expression::ExpressionPtr>& parts) {
  if (state->subject || state->primitive.type != "And") return parts.push_back(state);
  for (const auto& [port, input] : state->inputs) add_conjuncts(input, parts);
}

}  // namespace

StartPositions::StartPositions(const CommandTree& tree, expression::Places places)
    : tree_(tree), order_(tree), begins_(places), nominal_(std::move(places)) {
  for (int i = 0; i < tree_.size(); ++i) {
    if (!node(i).is_runtime()) continue;
    const ActuatorModel& actuator = node(i).actuator->model();
    auto devices = actuator.devices();
    const auto arms = actuator.arms();
    for (std::size_t k = 0; k < arms.size(); ++k) arms_.try_emplace(devices[k], arms[k]);
    if (std::ranges::find(devices, actuator.name()) == devices.end()) devices.push_back(actuator.name());
    for (const std::string& device : devices) drivers_[device].push_back(i);
  }
}

Result<expression::Places> StartPositions::begin_of(int i) const {
  const ActuatorModel& actuator = node(i).actuator->model();
  const auto devices = actuator.devices();
  const auto arms = actuator.arms();
  expression::Places places;
  Diagnostics diagnostics;
  for (std::size_t k = 0; k < arms.size(); ++k) {
    if (auto q = begin_of(i, devices[k], *arms[k])) {
      places[devices[k]] = std::move(*q);
    } else {
      report_unknown(i, devices[k], diagnostics);
    }
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return places;
}

Result<expression::Places> StartPositions::all_at_begin_of(int i) const {
  auto places = begin_of(i);
  if (places) add_others(i, *places);
  return places;
}

/// Arms of the tree that are not among the given positions; of size 0 where that depends on the run.
void StartPositions::add_others(int i, expression::Places& places) const {
  for (const auto& [device, arm] : arms_)
    if (!places.contains(device)) places[device] = begin_of(i, device, *arm).value_or(JointVector());
}

Result<expression::Places> StartPositions::all_at_given_begin(int i, const JointVector& q) const {
  const ActuatorModel& actuator = node(i).actuator->model();
  const std::string device = actuator.devices().front();
  const device::ArmDescription& arm = actuator.arms().front()->device->description();
  if (q.size() != arm.limits.velocity.size())
    return failure(Code::kWrongSize, "/from", fmt::format("{} joints for '{}'", q.size(), device),
                   fmt::format("Give {} joints", arm.limits.velocity.size()));
  // START checks an arm whose position is not known here.
  const bool said = begins_.contains(device) || !rivals_before(i, device).empty();
  const auto there = said ? begin_of(i, device, *actuator.arms().front()) : std::nullopt;
  if (there && (*there - q).cwiseAbs().maxCoeff() > arm.start_tolerance)
    return failure(Code::kConflict, "/from",
                   fmt::format("'{}' begins elsewhere than where '{}' will be: a joint is off by {:.3g}", node(i).name,
                               device, (*there - q).cwiseAbs().maxCoeff()),
                   "Begin where the motion before it ends");
  expression::Places places{{device, q}};
  add_others(i, places);
  return places;
}

/// Where an arm is when command `i` begins; nothing if that depends on the run.
std::optional<JointVector> StartPositions::begin_of(int i, const std::string& device,
                                                    const expression::MountedArm& arm) const {
  if (in_first_cycle(i)) return before_all(device, arm);
  const std::vector<int> rivals = rivals_before(i, device);
  if (rivals.empty()) return before_all(device, arm);
  const int last = last_of(rivals);
  const auto ends = ends_.find(last);
  if (ends == ends_.end()) return std::nullopt;
  const auto end = ends->second.find(device);
  return end != ends->second.end() && begins_at_end_of(i, last) ? std::optional(end->second) : std::nullopt;
}

/// The one that all others lead to; -1: there is none.
int StartPositions::last_of(const std::vector<int>& commands) const {
  int last = -1;
  for (const int one : commands)
    if (last < 0 || order_.leads_to(last, one)) last = one;
  const auto is_before = [&](int one) { return one == last || order_.leads_to(one, last); };
  return std::ranges::all_of(commands, is_before) ? last : -1;
}

void StartPositions::note(int i) {
  const auto devices = node(i).actuator->model().devices();
  const auto seams = node(i).model().ends();
  expression::Places ends;
  for (std::size_t k = 0; k < seams.size(); ++k) {
    if (seams[k].q.size() > 0) ends[devices.at(k)] = seams[k].q;
  }
  for (const auto& [device, q] : ends) nominal_[device] = q;
  const ActionModel& action = node(i).action->model();
  const bool says_begin = action.needs_plan() && !action.begins().empty();
  if (!ends.empty() && (says_begin || begin_of(i))) ends_[i] = std::move(ends);
}

bool StartPositions::follows_unplanned(int i) const {
  if (unplanned_.empty() || in_first_cycle(i)) return false;
  const auto is_unplanned = [this](int other) { return unplanned_.contains(other); };
  return std::ranges::any_of(node(i).actuator->model().devices(), [&](const std::string& device) {
    return std::ranges::any_of(rivals_before(i, device), is_unplanned);
  });
}

JointVector StartPositions::before_all(const std::string& device, const expression::MountedArm& arm) const {
  const auto told = begins_.find(device);
  return told != begins_.end() ? told->second : arm.set_point();
}

bool StartPositions::in_first_cycle(int i) const {
  for (; i >= 0; i = tree_.at(i).parent) {
    if (!tree_.at(i).with_parent) return false;
  }
  return true;
}

const std::vector<int>& StartPositions::drivers_of(const std::string& device) const {
  static const std::vector<int> kNone;
  const auto found = drivers_.find(device);
  return found == drivers_.end() ? kNone : found->second;
}

/// Other commands on a device that may have run when this one begins.
std::vector<int> StartPositions::rivals_before(int i, const std::string& device) const {
  std::vector<int> rivals;
  for (const int other : drivers_of(device))
    if (other != i && !order_.leads_to(i, other)) rivals.push_back(other);
  return rivals;
}

/// Whatever starts it, or a transaction around it, waits for the natural end of `before`.
bool StartPositions::begins_at_end_of(int i, int before) const {
  for (int at = i; at >= 0 && !tree_.is_inside(before, at); at = tree_.at(at).parent) {
    if (tree_.at(at).with_parent) continue;
    const auto& starts = tree_.acting_on(Kind::kStart, at);
    const auto waits = [&](int h) {
      const EventHandler& handler = *tree_.handler(h).handler;
      return handler.entered && is_natural_end(handler.state.node(), before, i);
    };
    if (!starts.empty() && std::ranges::all_of(starts, waits)) return true;
  }
  return false;
}

/// What holds only when `before` has come to its natural end. Recursion is bounded by the formula, and by the order of
/// starts.
bool StartPositions::is_natural_end(const expression::ExpressionPtr& state, int before, int i) const {
  std::vector<expression::ExpressionPtr> parts;
  add_conjuncts(state, parts);
  bool ended = false, not_cancelled = !may_be_cancelled(before, i), not_stopped = !may_be_stopped(before, i);
  for (const expression::ExpressionPtr& part : parts) {
    const auto& inputs = part->inputs;
    if (part->subject) {
      const int of = tree_.find(part->subject);
      const bool completed = of >= 0 && part->output == "completed" && tree_.is_inside(before, of);
      ended = ended || completed;
      not_stopped = not_stopped || (completed && of == before);  // what was stopped has not completed
      // Whatever holds of another command says that it has begun.
      if (of >= 0 && of != i && !tree_.is_inside(before, of) && begins_at_end_of(of, before)) return true;
    } else if (part->primitive.type == "Or") {
      if (std::ranges::all_of(inputs, [&](const auto& side) { return is_natural_end(side.second, before, i); }))
        return true;
    } else if (part->primitive.type == "Not" && inputs.size() == 1 && inputs.front().second->subject) {
      const expression::Expression& denied = *inputs.front().second;
      if (tree_.find(denied.subject) != before) continue;
      not_cancelled = not_cancelled || denied.output == "cancelled";
      not_stopped = not_stopped || denied.output == "stopped";
    }
  }
  return ended && not_cancelled && not_stopped;
}

/// A cancel may end `before` early although `i` is started then.
bool StartPositions::may_be_cancelled(int before, int i) const {
  const auto cut_by_cancel_of = [&](int target) {
    return is_forwarded_to(before, target, false) && !(tree_.is_inside(i, target) && is_forwarded_to(i, target, true));
  };
  if (cut_by_cancel_of(0)) return true;
  return std::ranges::any_of(tree_.handlers(), [&](const CommandTree::Handler& h) {
    if (h.handler->effect.kind != Kind::kCancel) return false;
    const int target = tree_.find(h.handler->effect.target);
    return target >= 0 && tree_.is_inside(before, target) && cut_by_cancel_of(target);
  });
}

/// A stop may end `before` early although `i` is started then.
bool StartPositions::may_be_stopped(int before, int i) const {
  return std::ranges::any_of(tree_.handlers(), [&](const CommandTree::Handler& h) {
    if (h.handler->effect.kind != Kind::kStop) return false;
    const int target = tree_.find(h.handler->effect.target);
    return target >= 0 && tree_.is_inside(before, target) && !tree_.is_inside(i, target);
  });
}

/// A cancel of `around` is forwarded to command `i`. @param by_all  and to everything else between, so that nothing
/// starts there any more (rule C4)
bool StartPositions::is_forwarded_to(int i, int around, bool by_all) const {
  for (; i != around; i = tree_.at(i).parent) {
    const CancelPolicy& policy = node(tree_.at(i).parent).cancel_policy;
    if (policy.kind == CancelPolicy::Kind::kForward) continue;
    if (by_all || std::ranges::find(policy.targets, node(i).subject) == policy.targets.end()) return false;
  }
  return true;
}

std::optional<JointVector> StartPositions::end_of(const std::string& device) const {
  const int last = last_of(drivers_of(device));
  const auto ends = ends_.find(last);
  if (ends == ends_.end() || is_cut_short(last) || !runs_for_certain(last)) return std::nullopt;
  const auto end = ends->second.find(device);
  return end == ends->second.end() ? std::nullopt : std::optional(end->second);
}

const CommandNode* StartPositions::left_in_motion() const {
  for (int i = 0; i < tree_.size(); ++i)
    if (node(i).is_runtime() && node(i).model().left_in_motion().motion != nullptr && is_last_of_all(i))
      return tree_.at(i).node;
  return nullptr;
}

/// All else is over before it begins, only its own abort condition ends it sooner, and nothing waits for its end.
bool StartPositions::is_last_of_all(int i) const {
  for (int other = 0; other < tree_.size(); ++other) {
    const bool acts = node(other).is_runtime() || node(other).is_wait();
    if (acts && other != i && !begins_at_end_of(i, other)) return false;
  }
  const int aborts = node(i).model().left_in_motion().abort_handlers;
  return std::ranges::none_of(tree_.handlers(), [&](const CommandTree::Handler& h) {
    if (h.owner == i && h.handler - node(i).handlers.data() < aborts) return false;
    return cuts_short(*h.handler, i) || speaks_of_end(h.handler->state.node(), i);
  });
}

/// A formula over states of a command, or of what is around it, that come later than its start.
bool StartPositions::speaks_of_end(const expression::ExpressionPtr& state, int i) const {
  if (state->subject) {
    const int of = tree_.find(state->subject);
    return of >= 0 && tree_.is_inside(i, of) && state->output != "started";
  }
  return std::ranges::any_of(state->inputs,
                             [&](const auto& input) { return input.second && speaks_of_end(input.second, i); });
}

/// It starts with the tree, or by natural ends of what runs for certain. The order of starts bounds the recursion.
bool StartPositions::runs_for_certain(int i) const {
  for (int at = i; at >= 0; at = tree_.at(at).parent) {
    if (tree_.at(at).with_parent) continue;
    const bool started = std::ranges::any_of(tree_.acting_on(Kind::kStart, at), [&](int h) {
      const EventHandler& handler = *tree_.handler(h).handler;
      return handler.entered && follows_for_certain(handler.state.node());
    });
    if (!started) return false;
  }
  return true;
}

/// "Completed", and maybe "not cancelled", of commands that run and are not cut short.
bool StartPositions::follows_for_certain(const expression::ExpressionPtr& state) const {
  std::vector<expression::ExpressionPtr> parts;
  add_conjuncts(state, parts);
  return std::ranges::all_of(parts, [this](const expression::ExpressionPtr& part) {
    const bool denied = !part->subject && part->primitive.type == "Not";
    const expression::ExpressionPtr& leaf = denied ? part->inputs.front().second : part;
    if (!leaf->subject) return false;
    const int of = tree_.find(leaf->subject);
    const bool fits = denied ? leaf->output == "cancelled" || leaf->output == "stopped" : leaf->output == "completed";
    const bool ends_by_itself = of >= 0 && (node(of).is_runtime() || (node(of).is_wait() && !node(of).until));
    return fits && ends_by_itself && !is_cut_short(of) && runs_for_certain(of);
  });
}

/// Some handler may cancel or stop it, or something around it.
bool StartPositions::is_cut_short(int i) const {
  return std::ranges::any_of(tree_.handlers(),
                             [&](const CommandTree::Handler& h) { return cuts_short(*h.handler, i); });
}

bool StartPositions::cuts_short(const EventHandler& handler, int i) const {
  if (handler.effect.kind != Kind::kCancel && handler.effect.kind != Kind::kStop) return false;
  const int target = tree_.find(handler.effect.target);
  return target >= 0 && tree_.is_inside(i, target);
}

void StartPositions::report_unknown(int i, const std::string& device, Diagnostics& diagnostics) const {
  std::string names;
  for (const int rival : rivals_before(i, device))
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", node(rival).name);
  diagnostics.error(
      Code::kUnknownPosition, {},
      fmt::format("the position of '{}' when '{}' begins is unknown before the run: it depends on where {} may have "
                  "been cut short",
                  device, node(i).name, names),
      "Start on the natural end of the motion before it (completed, and not cancelled where something may cancel it), "
      "or add a motion after all this");
}

}  // namespace takt::command
