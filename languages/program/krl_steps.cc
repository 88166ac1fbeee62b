#include "languages/program/krl_steps.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "languages/krl/lexer.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using krl::Live;
using krl::MotionCommand;
using krl::TriggerCommand;

/// One motion as a step.
class StepOfMotion {
 public:
  StepOfMotion(const MotionCommand& motion, const KrlMap& map, const expression::Cell& cell,
               const krl::Program& program, Diagnostics& diagnostics)
      : motion_(motion), map_(map), cell_(cell), program_(program), diagnostics_(diagnostics) {}

  Json make() {
    constexpr std::string_view kWords[] = {"ptp", "lin", "circ", "spline"};
    Json step{{"do", kWords[static_cast<std::size_t>(motion_.kind)]},
              {"name", step_name(motion_.at, motion_.label)},
              {"arm", map_.arm}};
    set_tool(step);
    if (motion_.kind == MotionCommand::Kind::kSpline) {
      step["through"] = Json::array();
      for (const auto& point : motion_.points) step["through"].push_back(goal(point));
    } else {
      step["to"] = goal(motion_.points.back());
      if (motion_.kind == MotionCommand::Kind::kCirc) step["via"] = goal(motion_.points.front());
    }
    if (motion_.speed < 1.0) step["speed"] = motion_.speed;
    if (motion_.acceleration < 1.0) step["acceleration"] = motion_.acceleration;
    if (motion_.velocity) step["velocity_m_s"] = *motion_.velocity;
    if (motion_.blend_distance) step["blend_m"] = *motion_.blend_distance;
    if (motion_.blend_fraction) step["blend_fraction"] = *motion_.blend_fraction;
    return step;
  }

 private:
  /// The path that a tool centre point takes is that of one that the cell has; where the tool does not turn any will
  /// do.
  void set_tool(Json& step) {
    auto tool = map_.find_tool(cell_, motion_.X_FT);
    if (!tool) {
      tool = map_.find_tool(cell_, map_.usual_tool(cell_));
      if (motion_.kind != MotionCommand::Kind::kPtp && motion_.turns)
        krl::error_at(diagnostics_, program_.modules[static_cast<std::size_t>(motion_.module)].file, motion_.at,
                      Code::kUnsupported, "$TOOL is no tool centre point of the cell, and the tool turns",
                      "Set $TOOL to a tool of the map, or declare the tool centre point in the cell");
    }
    if (!tool) return;
    X_FT_ = tool->X_FT;
    if (!tool->tool.empty()) step["tool"] = tool->tool;
    if (!tool->tcp.empty()) step["tcp"] = tool->tcp;
  }

  [[nodiscard]] Json goal(const MotionCommand::Point& point) const {
    if (point.axes.empty()) return pose_goal(point.X_BF * X_FT_, map_.arm);
    Json joints = Json::array();
    for (std::size_t i = 0; i < point.axes.size(); ++i) joints.push_back(point.axes[i] - map_.offsets[i]);
    return {{"joints_deg", std::move(joints)}};
  }

  const MotionCommand& motion_;
  const KrlMap& map_;
  const expression::Cell& cell_;
  const krl::Program& program_;
  Diagnostics& diagnostics_;
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
};

/// Motions with triggers are a transaction: the outputs are written in the cycle in which the path comes to the point.
class TriggeredMotions {
 public:
  TriggeredMotions(const KrlGroup& group, const KrlMap& map, const krl::Program& program, Diagnostics& diagnostics)
      : group_(group), map_(map), program_(program), diagnostics_(diagnostics) {}

  Json make(Json steps) {
    Json& last = steps.back();
    last.erase("blend_m");
    last.erase("blend_fraction");
    const std::string name = steps.front().at("name");
    Json move = steps.size() == 1 ? std::move(steps.front())
                                  : Json{{"do", "motions"}, {"name", name}, {"steps", std::move(steps)}};
    move.erase("name");
    move["start"] = true;
    commands_["move"] = std::move(move);
    for (std::size_t i = 0; i < group_.items.size(); ++i)
      for (const TriggerCommand& one : group_.items[i].motion->triggers) add(i, one);
    return {{"do", "transaction"}, {"name", name}, {"commands", std::move(commands_)}, {"on", std::move(handlers_)}};
  }

 private:
  void error(const TriggerCommand& one, std::string message, std::string hint) {
    const int module = group_.items.front().motion->module;
    krl::error_at(diagnostics_, program_.modules[static_cast<std::size_t>(module)].file, one.at, Code::kUnsupported,
                  std::move(message), std::move(hint));
  }

  void add(std::size_t at, const TriggerCommand& one) {
    const Json step = output_step(map_, one.output, one.number, one.value, std::nullopt);
    if (step.is_null() || step.value("do", "") != "set")
      return error(one, fmt::format("a trigger for output {}, which is no output of the cell", one.number),
                   "Name an output in the map");
    const std::string name = fmt::format("trigger {}", commands_.size());
    commands_[name] = step;
    const Json state = state_at(at, one);
    if (!state.is_null()) handle(state, name, one.delay);
    if (!one.pulse) return;
    const std::string back = fmt::format("trigger {}", commands_.size());
    commands_[back] = output_step(map_, one.output, one.number, 1.0 - one.value, std::nullopt);
    handle({{"completed", name}}, back, *one.pulse);
  }

  void handle(const Json& state, const std::string& start, double delay) {
    Json handler{{"entered", state}, {"start", start}};
    if (delay > 0.0) handler["after_s"] = delay;
    handlers_.push_back(std::move(handler));
  }

  Json state_at(std::size_t at, const TriggerCommand& one) {
    if (one.where == TriggerCommand::Where::kStart)
      return at == 0 ? Json{{"started", "move"}} : Json{{"action", "move"}, {"via_passed", at - 1}};
    if (one.where == TriggerCommand::Where::kEnd)
      return at + 1 == group_.items.size() ? Json{{"completed", "move"}} : Json{{"action", "move"}, {"via_passed", at}};
    const MotionCommand& motion = *group_.items[at].motion;
    const double share = motion.length > 0.0 ? (one.from_start ? 0.0 : 1.0) + one.path / motion.length : -1.0;
    if (motion.kind != MotionCommand::Kind::kLin || !(share >= 0.0 && share <= 1.0)) {
      error(one,
            motion.kind == MotionCommand::Kind::kLin
                ? fmt::format("PATH={:g} is not on the line of {:g} mm", one.path * 1e3, motion.length * 1e3)
                : "PATH of a motion that is no line",
            "Use a point between start and goal of LIN or SLIN, or DISTANCE");
      return nullptr;
    }
    return {{"action", "move"}, {"at_path", share}};
  }

  const KrlGroup& group_;
  const KrlMap& map_;
  const krl::Program& program_;
  Diagnostics& diagnostics_;
  Json commands_ = Json::object(), handlers_ = Json::array();
};

bool has_path_trigger(const MotionCommand& motion) {
  return std::ranges::any_of(motion.triggers,
                             [](const TriggerCommand& one) { return one.where == TriggerCommand::Where::kPath; });
}

}  // namespace

std::string step_name(const TextLocation& at, const std::string& text) {
  constexpr std::size_t kMost = 40;
  return fmt::format("{}: {}", at.line, text.substr(0, kMost));
}

KrlGroup take_group(std::deque<KrlItem>& queue) {
  KrlGroup group;
  std::set<std::string> names;
  while (!queue.empty()) {
    KrlItem& next = queue.front();
    if (!group.items.empty()) {
      if (!next.motion || has_path_trigger(*next.motion)) break;
      if (!names.insert(step_name(next.at, next.motion->label)).second) break;
    } else if (next.motion) {
      names.insert(step_name(next.at, next.motion->label));
    }
    group.items.push_back(std::move(next));
    queue.pop_front();
    const auto& motion = group.items.back().motion;
    const bool blends = motion && (motion->blend_distance || motion->blend_fraction);
    if (!blends || has_path_trigger(*motion)) break;
  }
  return group;
}

Json to_step(const KrlGroup& group, const KrlMap& map, const expression::Cell& cell, const krl::Program& program,
             Diagnostics& diagnostics) {
  if (!group.moves()) {
    auto steps = parse_json(group.items.front().steps);
    if (!steps) return nullptr;
    if (!steps->is_array()) return *steps;
    return {{"do", "sequence"}, {"name", group.items.front().name}, {"steps", std::move(*steps)}};
  }
  Diagnostics own;
  Json steps = Json::array();
  bool triggers = false;
  for (const KrlItem& one : group.items) {
    steps.push_back(StepOfMotion(*one.motion, map, cell, program, own).make());
    triggers = triggers || !one.motion->triggers.empty();
  }
  Json step = triggers            ? TriggeredMotions(group, map, program, own).make(std::move(steps))
              : steps.size() == 1 ? std::move(steps.front())
                                  : Json{{"do", "sequence"}, {"steps", std::move(steps)}};
  diagnostics.append(own);
  return own.has_errors() ? Json() : step;
}

Json output_step(const KrlMap& map, Live output, int number, double value, std::optional<double> pulse) {
  const bool analog = output == Live::kAnalogOut;
  Json step = output_step(map, analog, number, value);
  if (analog || !pulse || step.is_null()) return step;
  Json steps = Json::array();
  steps.push_back(std::move(step));
  steps.push_back({{"do", "wait"}, {"seconds", *pulse}});
  steps.push_back(output_step(map, analog, number, 1.0 - value));
  return {{"do", "sequence"}, {"name", fmt::format("PULSE {}", number)}, {"steps", std::move(steps)}};
}

void locate(Diagnostics& diagnostics, const KrlGroup& group, const krl::Program& program) {
  for (Diagnostic& one : diagnostics.list()) {
    if (!one.file.empty()) continue;
    std::size_t index = 0;
    if (const std::size_t at = one.pointer.rfind("/steps/"); at != std::string::npos) {
      const std::string_view digits = std::string_view(one.pointer).substr(at + 7);
      (void)std::from_chars(digits.data(), digits.data() + digits.size(), index);
    }
    const KrlItem& item = group.items[std::min(index, group.items.size() - 1)];
    one.file = program.modules[static_cast<std::size_t>(item.module)].file;
    one.line = item.at.line;
    one.column = item.at.column;
    one.pointer.clear();
  }
}

}  // namespace takt::languages
