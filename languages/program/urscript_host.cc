#include "languages/program/urscript_host.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/kinematics/solutions.h"
#include "languages/program/urscript_steps.h"

namespace takt::languages {

using Json = nlohmann::ordered_json;
using urscript::Signal;

ScriptGroup::ScriptGroup(std::deque<ScriptItem>& queue, const std::string& file) : file_(file) {
  std::set<std::string> names;
  while (!queue.empty()) {
    if (!items.empty() && !queue.front().moves) break;
    if (!names.insert(queue.front().name).second) break;
    items.push_back(std::move(queue.front()));
    queue.pop_front();
    if (!items.back().blends) break;
  }
}

Json ScriptGroup::to_step(Diagnostics&) const {
  if (items.size() == 1) return *items.front().step;
  Json steps = Json::array();
  for (const ScriptItem& one : items) steps.push_back(*one.step);
  return {{"do", "sequence"}, {"steps", std::move(steps)}};
}

void ScriptGroup::locate(Diagnostics& diagnostics) const {
  for (Diagnostic& one : diagnostics.list()) {
    if (!one.file.empty()) continue;
    std::size_t index = 0;
    if (const std::size_t at = one.pointer.rfind("/steps/"); at != std::string::npos) {
      const std::string_view digits = std::string_view(one.pointer).substr(at + 7);
      (void)std::from_chars(digits.data(), digits.data() + digits.size(), index);
    }
    const ScriptItem& item = items[std::min(index, items.size() - 1)];
    one.file = file_;
    one.line = item.at.line;
    one.column = item.at.column;
    one.pointer.clear();
  }
}

std::string UrscriptHost::move(urscript::MotionCommand motion) {
  if (settled()) last_flange_.reset();
  constexpr double kTurn = 1e-6;  // rad
  const Eigen::Isometry3d before = last_flange_ ? *last_flange_ : flange(joints(false));
  const Eigen::Isometry3d goal = motion.goal.q.size() > 0 ? flange(motion.goal.q) : motion.goal.X_BF;
  const bool turns = Eigen::AngleAxisd(before.linear().transpose() * goal.linear()).angle() > kTurn;
  std::string problem;
  Json step = motion_step(motion, turns, map_, cell_, problem);
  if (problem.empty() && motion.time > 0.0) problem = fit_time(step, motion.time);
  if (!problem.empty()) return problem;
  last_flange_ = goal;
  ScriptItem item{.step = {}, .name = script_step_name(motion.at, motion.word), .at = motion.at};
  item.moves = true;
  item.blends = step.contains("blend_m");
  item.step = std::make_shared<const Json>(std::move(step));
  give(std::move(item));
  return {};
}

/// Changes the speed of a motion that begins where the arm is, so that it takes so long: the slower, the longer.
std::string UrscriptHost::fit_time(Json& step, double seconds) {
  constexpr int kMostTrials = 40;
  constexpr double kClose = 5e-4;  // s
  const bool of_tool = step.contains("velocity_m_s");
  const char* const key = of_tool ? "velocity_m_s" : "speed";
  step.erase("acceleration");
  Json trial_step = step;
  trial_step.erase("blend_m");
  double high = of_tool ? 10.0 : 1.0, low = high * 1e-6, speed = high;
  std::string problem;
  for (int i = 0; i < kMostTrials; ++i) {
    trial_step[key] = speed;
    const double takes = duration_of(trial_step, problem);
    if (!problem.empty()) return problem;
    if (i == 0 && takes > seconds + kClose)
      return fmt::format("the motion takes {:.3f} s at least, more than {:g} s", takes, seconds);
    if (std::abs(takes - seconds) < kClose) break;
    (takes < seconds ? high : low) = speed;
    speed = std::sqrt(high * low);
  }
  step[key] = speed;
  return {};
}

double UrscriptHost::duration_of(const Json& step, std::string& problem) {
  operations::Rehearsal rehearsal = trial();
  rehearsal.duration = 0.0;
  Diagnostics diagnostics;
  program::NodeParser parser(cell_, nullptr, diagnostics);
  const program::NodeParser::Inner inner(parser, false);
  const auto node = parser.node(step, "");
  program::Scope scope;
  if (!diagnostics.has_errors()) node->rehearse(rehearsal, scope, diagnostics);
  for (const Diagnostic& one : diagnostics.list())
    if (one.severity == Severity::kError && problem.empty()) problem = one.message;
  return rehearsal.duration;
}

std::string UrscriptHost::write(Signal output, int number, double value, bool beside, const TextLocation& at) {
  Json step = output_step(map_, output == Signal::kAnalogOut, number, value);
  if (step.is_null()) return fmt::format("number {} is no output of this cell", number);
  written_[{output, number}] = value;
  ScriptItem item{.step = std::make_shared<const Json>(std::move(step)),
                  .name = fmt::format("{}: output {}", at.line, number),
                  .at = at};
  if (beside) {
    run_beside(std::move(item));
  } else {
    give(std::move(item));
  }
  return {};
}

std::optional<double> UrscriptHost::written(Signal output, int number) const {
  const bool known =
      output == Signal::kDigitalOut ? map_.outputs.contains(number) : map_.analog_outputs.contains(number);
  if (!known) return std::nullopt;
  const auto found = written_.find({output, number});
  return found == written_.end() ? 0.0 : found->second;
}

void UrscriptHost::call(const std::string& name, const TextLocation& at) {
  ScriptItem item{.step = {}, .name = script_step_name(at, name), .at = at};
  Json steps = parse_json(map_.calls.at(name)).value_or(Json::array());
  if (steps.is_array()) steps = {{"do", "sequence"}, {"name", item.name}, {"steps", std::move(steps)}};
  item.step = std::make_shared<const Json>(std::move(steps));
  forget_goal();
  give(std::move(item));
}

std::string UrscriptHost::tare(const TextLocation& at) {
  const std::string name = script_step_name(at, "zero_ftsensor");
  Json step{{"do", "tare"}, {"name", name}};
  if (!map_.sensor.empty()) step["sensor"] = map_.sensor;
  give({.step = std::make_shared<const Json>(std::move(step)), .name = name, .at = at});
  return {};
}

Eigen::Isometry3d UrscriptHost::flange(const kinematics::JointVector& q) {
  return arm().device->description().chain->forward(q);
}

std::optional<kinematics::JointVector> UrscriptHost::solve(const Eigen::Isometry3d& X_BF,
                                                           const kinematics::JointVector& near) {
  kinematics::SolutionOptions options;
  options.reference = near;
  options.turns = false;
  options.most = 1;
  const auto solutions = kinematics::inverse_solutions(*arm().device->description().chain, X_BF, options);
  if (solutions.empty()) return std::nullopt;
  return solutions.front();
}

}  // namespace takt::languages
