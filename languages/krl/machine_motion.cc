// From a motion statement and the variables of the machine to a complete motion.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/machine.h"

namespace takt::languages::krl {
namespace {

constexpr double kToMetres = 1e-3;
constexpr double kPercent = 0.01;

bool is_axes(const Value& value) { return value.structure != nullptr && value.structure->find("A1") >= 0; }
bool is_pose(const Value& value) { return value.structure != nullptr && value.structure->find("X") >= 0; }

bool is_whole_pose(const Value& value) {
  return std::ranges::all_of(std::array{"X", "Y", "Z", "A", "B", "C"}, [&](const char* one) { return value.has(one); });
}

}  // namespace

Eigen::Isometry3d Machine::last_flange() {
  if (!last_flange_) last_flange_ = host_.flange(last_axes_ ? *last_axes_ : host_.axes());
  return *last_flange_;
}

bool Machine::needs_place(const Statement& one) {
  const bool relative = one.word.ends_with("_REL");
  for (const ExpressionPtr& goal : one.goals) {
    const Value value = evaluate(*goal);
    if (failed()) return false;
    if (is_axes(value)) {
      const bool whole =
          std::ranges::all_of(host_.axis_names(), [&](const std::string& axis) { return value.has(axis); });
      if ((relative || !whole) && !last_axes_) return true;
    } else if (is_pose(value)) {
      if ((relative || !is_whole_pose(value)) && !last_axes_ && !last_flange_) return true;
    }
  }
  return false;
}

Machine::Step Machine::move(const Statement& one) {
  if (in_interrupt() && !braked_) {
    fail(one.at, Code::kNotPossibleNow, "a motion in an interrupt program that has not stopped the arm",
         "Write BRAKE before");
    return Step::kStay;
  }
  std::vector<std::pair<Value*, Value>> before;
  for (const auto& [target, value] : one.with) {
    Value* const found = place(*target, nullptr);
    if (found == nullptr) return Step::kStay;
    before.emplace_back(found, *found);
    assign_place(*target, evaluate(*value, found->structure));
  }
  auto made = failed() ? std::nullopt : motion(one);
  for (auto& [target, value] : before) *target = std::move(value);
  if (!made || failed()) return Step::kStay;
  made->triggers = std::exchange(triggers_, {});
  host_.move(std::move(*made));
  return Step::kNext;
}

std::optional<MotionCommand> Machine::motion(const Statement& one) {
  MotionCommand command;
  command.at = one.at;
  command.label = one.text;
  command.module = module_;
  const Eigen::Isometry3d before = last_flange();
  if (one.kind == Statement::Kind::kSpline) {
    command.kind = MotionCommand::Kind::kSpline;
    for (const Statement& segment : one.body)
      if (!set_points(segment, command)) return std::nullopt;
    if (command.points.size() < 2) {
      fail(one.at, Code::kWrongSize, fmt::format("a spline through {} points", command.points.size()),
           "Give at least two");
      return std::nullopt;
    }
  } else {
    command.kind = one.word.find("PTP") != std::string::npos   ? MotionCommand::Kind::kPtp
                   : one.word.find("LIN") != std::string::npos ? MotionCommand::Kind::kLin
                                                               : MotionCommand::Kind::kCirc;
    if (!set_points(one, command)) return std::nullopt;
  }
  if (shared("$IPO_MODE").text == "TCP" || shared("$ORI_TYPE").text == "JOINT") {
    fail(one.at, Code::kUnsupported, "$IPO_MODE=#TCP and $ORI_TYPE=#JOINT are not supported",
         "Use #BASE, and #VAR or #CONSTANT");
    return std::nullopt;
  }
  for (const MotionCommand::Point& point : command.points) {
    const Eigen::Isometry3d X_BF = point.axes.empty() ? point.X_BF : host_.flange(point.axes);
    command.turns = command.turns || Eigen::AngleAxisd(before.linear().transpose() * X_BF.linear()).angle() > 1e-6;
    command.length = ((X_BF * command.X_FT).translation() - (before * command.X_FT).translation()).norm();
  }
  set_dynamics(command);
  set_blend(one.approximation, before, command);
  return command;
}

bool Machine::set_points(const Statement& one, MotionCommand& command) {
  if (one.c) fail(one.at, Code::kUnsupported, "CA of a circle is not supported", "Give the goal of the arc");
  command.X_FT = to_pose(shared("$TOOL"), Eigen::Isometry3d::Identity());
  const std::optional<Eigen::Isometry3d> flange = last_flange();
  for (const ExpressionPtr& goal : one.goals)
    if (failed() || !set_point(one, *goal, command)) return false;
  // The point on the way is not where the motion ends.
  if (one.goals.size() == 2 && command.points.back().axes.empty()) last_flange_ = command.points.back().X_BF;
  return flange.has_value() && !failed();
}

bool Machine::set_point(const Statement& one, const Expression& goal, MotionCommand& command) {
  const Value value = evaluate(goal);
  if (failed()) return false;
  const bool relative = one.word.ends_with("_REL");
  MotionCommand::Point point;
  if (is_axes(value)) {
    if (command.kind != MotionCommand::Kind::kPtp) {
      fail(one.at, Code::kWrongType, fmt::format("{} to positions of axes", one.word), "Give a pose, or use PTP");
      return false;
    }
    const std::vector<double> last = last_axes_ ? *last_axes_ : host_.axes();
    for (std::size_t i = 0; i < last.size(); ++i) {
      const std::string& axis = host_.axis_names()[i];
      point.axes.push_back(relative ? last[i] + value.number_at(axis, 0.0) : value.number_at(axis, last[i]));
    }
    last_axes_ = point.axes;
    last_flange_.reset();
    command.points.push_back(std::move(point));
    return true;
  }
  if (!is_pose(value)) {
    fail(goal.at, Code::kWrongType, fmt::format("{} is no point", to_string(value)),
         "Give a FRAME, POS, E6POS, AXIS or E6AXIS");
    return false;
  }
  const Eigen::Isometry3d none = Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d X_RB = to_pose(shared("$BASE"), none);
  const Eigen::Isometry3d last = X_RB.inverse() * last_flange() * command.X_FT;
  Eigen::Isometry3d X = to_pose(value, relative ? none : last);
  if (relative && one.flag) {
    X = last * X;
  } else if (relative) {
    const Eigen::Isometry3d step = X;
    X.translation() = last.translation() + step.translation();
    X.linear() = step.linear() * last.linear();
  }
  const bool path = command.kind != MotionCommand::Kind::kPtp;
  if (path && shared("$ORI_TYPE").text == "CONSTANT") X.linear() = last.linear();
  point.X_BF = X_RB * X * command.X_FT.inverse();
  last_flange_ = point.X_BF;
  last_axes_.reset();
  command.points.push_back(std::move(point));
  return true;
}

void Machine::set_dynamics(MotionCommand& command) {
  const double override = std::clamp(shared("$OV_PRO").number() * kPercent, 0.01, 1.0);
  const auto least = [&](std::string_view name) {
    const Value& all = shared(name);
    double share = 1.0;
    for (std::size_t i = 0; i < host_.axis_names().size() && i < all.parts.size(); ++i)
      if (all.parts[i].is_number()) share = std::min(share, all.parts[i].number() * kPercent);
    return std::max(share, 0.01);
  };
  if (command.kind == MotionCommand::Kind::kPtp) {
    command.speed = least("$VEL_AXIS") * override;
    command.acceleration = least("$ACC_AXIS");
    return;
  }
  command.velocity = std::max(shared("$VEL").number_at("CP", 2.0), 1e-4) * override;
  const double full = std::max(shared("DEF_ACC_CP").number(), 1e-3);
  command.acceleration = std::clamp(shared("$ACC").number_at("CP", full) / full, 0.01, 1.0);
}

void Machine::set_blend(const std::vector<std::string>& words, const Eigen::Isometry3d& before,
                        MotionCommand& command) {
  if (words.empty()) return;
  constexpr double kHalf = 0.5;
  constexpr double kLeast = 1e-4;
  const Value& apo = shared("$APO");
  const auto fraction = [&](double share) {
    if (share >= kLeast) command.blend_fraction = std::min(share, kHalf);
  };
  const std::string& word = words.front();
  if (word == "C_DIS" || word == "C_SPL") {
    const double distance = apo.number_at("CDIS", 0.0) * kToMetres;
    if (distance >= 1e-5) command.blend_distance = distance;
  } else if (word == "C_PTP") {
    fraction(kHalf * std::clamp(apo.number_at("CPTP", 0.0) * kPercent, 0.0, 1.0));
  } else if (word == "C_VEL") {
    fraction(kHalf * (1.0 - std::clamp(apo.number_at("CVEL", 100.0) * kPercent, 0.0, 1.0)));
  } else if (command.points.back().axes.empty()) {
    const double angle = Eigen::AngleAxisd(before.linear().transpose() * command.points.back().X_BF.linear()).angle() *
                         180.0 / std::numbers::pi;
    fraction(angle < 1e-6 ? kHalf : apo.number_at("CORI", 0.0) / angle);
  }
}

void Machine::pend_trigger(const Statement& one) {
  constexpr std::size_t kMost = 8;
  TriggerCommand made;
  made.at = one.at;
  const double where = number(*one.a);
  made.delay = number(*one.b) * 1e-3;
  if (failed()) return;
  if (made.delay < 0.0 || triggers_.size() >= kMost) {
    fail(one.at, Code::kUnsupported,
         made.delay < 0.0 ? "a trigger with a negative DELAY" : "more than 8 triggers of one motion",
         made.delay < 0.0 ? "Use PATH with a negative distance" : "Use fewer");
    return;
  }
  if (one.word == "PATH") {
    made.where = TriggerCommand::Where::kPath;
    made.path = where * kToMetres;
    made.from_start = one.flag;
  } else if (where == 0.0 || where == 1.0) {
    made.where = where == 0.0 ? TriggerCommand::Where::kStart : TriggerCommand::Where::kEnd;
  } else {
    fail(one.at, Code::kOutOfRange, fmt::format("DISTANCE={:g}", where), "Use 0 for the start, 1 for the goal");
    return;
  }
  const Statement& action = one.body.front();
  const Expression& target = *action.a;
  if (target.kind != Expression::Kind::kIndex || target.parts.size() != 2) {
    fail(action.at, Code::kWrongType, "a signal without a number", "Give its number in [ ]");
    return;
  }
  made.output = static_cast<Live>(target.parts[0]->live);
  made.number = static_cast<int>(std::clamp(number(*target.parts[1]), -1.0, 1e6));
  made.value = made.output == Live::kAnalogOut ? number(*action.b) : truth(*action.b) ? 1.0 : 0.0;
  if (action.kind == Statement::Kind::kPulse) made.pulse = std::clamp(number(*action.c), 0.001, 3600.0);
  if (!failed()) triggers_.push_back(made);
}

}  // namespace takt::languages::krl
