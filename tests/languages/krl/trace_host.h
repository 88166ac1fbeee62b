#pragma once

#include <cmath>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "languages/krl/machine.h"

namespace takt::languages::krl::test {

/// An arm of six axes that takes half a second for each motion, with signals, on a clock of its own. It writes down
/// what happens. Its flange is at (A1 + 1000, A2, A3) mm, turned by A6 about z.
class TraceHost final : public Host {
 public:
  /// An input that changes at a time, s.
  struct Change {
    double at = 0.0;
    int input = 0;
    double value = 0.0;
  };
  explicit TraceHost(std::vector<Change> changes = {}) : changes_(std::move(changes)) {}

  static constexpr double kMotion = 0.5, kCycle = 0.01;

  [[nodiscard]] double now() const override { return now_; }
  [[nodiscard]] bool settled() override { return queue_.empty(); }
  [[nodiscard]] int unfinished() override {
    int count = 0;
    for (const Item& one : queue_) count += one.is_motion ? 1 : 0;
    return count;
  }
  void move(MotionCommand motion) override {
    tell("plan " + describe(motion));
    const std::string label = motion.label;
    queue_.push_back({.is_motion = true, .text = label, .left = kMotion, .motion = std::move(motion)});
  }
  [[nodiscard]] std::string write(Live output, int number, double value, std::optional<double> pulse,
                                  bool beside) override {
    if (number < 1 || number > 100) return fmt::format("there is no signal {} here", number);
    outputs_[{output, number}] = value;
    tell(fmt::format("{} {} = {:g}{}{}", output == Live::kOut ? "out" : "anout", number, value,
                     pulse ? fmt::format(" for {:g} s", *pulse) : "", beside ? " beside" : ""));
    return {};
  }
  [[nodiscard]] std::optional<double> read(Live signal, int number) override {
    if (number < 1 || number > 100) return std::nullopt;
    if (signal == Live::kOut || signal == Live::kAnalogOut) return outputs_[{signal, number}];
    return inputs_[number];
  }
  void call(const std::string& name, int, const TextLocation&) override { tell("call " + name); }
  [[nodiscard]] const std::vector<std::string>& axis_names() const override {
    static const std::vector<std::string> kNames{"A1", "A2", "A3", "A4", "A5", "A6"};
    return kNames;
  }
  [[nodiscard]] std::vector<double> axes() override { return axes_; }
  [[nodiscard]] Eigen::Isometry3d flange(const std::vector<double>& axes) override {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = Eigen::Vector3d(1.0 + axes[0] * 1e-3, axes[1] * 1e-3, axes[2] * 1e-3);
    X.linear() = Eigen::AngleAxisd(axes[5] * M_PI / 180.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return X;
  }
  [[nodiscard]] bool skips_wait(std::optional<double>) override { return false; }
  void brake() override {
    tell("brake");
    kept_ = std::move(queue_);
    queue_.clear();
  }
  void go_on() override {
    tell("go on");
    queue_ = std::move(kept_);
    kept_.clear();
  }
  void forget() override {
    tell("forget");
    queue_.clear();
    kept_.clear();
  }

  /// Until the machine ends, or so many seconds have passed.
  Machine::Progress run(Machine& machine, double seconds = 20.0) {
    while (now_ < seconds) {
      for (const Change& one : changes_)
        if (one.at <= now_) inputs_[one.input] = one.value;
      const Machine::Progress progress = machine.advance();
      if (progress != Machine::Progress::kRunning) return progress;
      now_ += kCycle;
      if (queue_.empty()) continue;
      queue_.front().left -= kCycle;
      if (queue_.front().left > 1e-9) continue;
      tell("done " + queue_.front().text);
      const auto& last = queue_.front().motion.points.back();
      if (!last.axes.empty()) axes_ = last.axes;
      queue_.pop_front();
    }
    return Machine::Progress::kRunning;
  }

  [[nodiscard]] const std::vector<std::string>& trace() const { return trace_; }
  bool with_times = false;

 private:
  struct Item {
    bool is_motion = false;
    std::string text;
    double left = 0.0;
    MotionCommand motion = {};
  };

  void tell(const std::string& text) { trace_.push_back(with_times ? fmt::format("{:.2f} {}", now_, text) : text); }

  static double tidy(double value) { return std::abs(value) < 5e-7 ? 0.0 : value; }

  static std::string describe(const MotionCommand& motion) {
    constexpr const char* kKinds[] = {"ptp", "lin", "circ", "spline"};
    std::string text = kKinds[static_cast<int>(motion.kind)];
    for (const auto& point : motion.points) {
      std::string inside;
      for (const double axis : point.axes) inside += fmt::format("{}{:g}", inside.empty() ? "" : " ", tidy(axis));
      if (point.axes.empty()) {
        const Eigen::Isometry3d X = point.X_BF * motion.X_FT;
        const Eigen::Vector3d rpy = X.linear().eulerAngles(2, 1, 0) * 180.0 / M_PI;
        const double a = std::atan2(X.linear()(1, 0), X.linear()(0, 0)) * 180.0 / M_PI;
        inside = fmt::format("{:.6g} {:.6g} {:.6g} mm", tidy(X.translation().x() * 1e3),
                             tidy(X.translation().y() * 1e3), tidy(X.translation().z() * 1e3));
        if (std::abs(a) > 1e-6 && rpy.allFinite()) inside += fmt::format(" A {:.6g}", a);
      }
      text += " (" + inside + ")";
    }
    if (motion.velocity) text += fmt::format(" {:g} m/s", *motion.velocity);
    if (motion.speed != 1.0) text += fmt::format(" speed {:g}", motion.speed);
    if (motion.acceleration != 1.0) text += fmt::format(" acceleration {:g}", motion.acceleration);
    if (motion.blend_distance) text += fmt::format(" blend {:g} mm", *motion.blend_distance * 1e3);
    if (motion.blend_fraction) text += fmt::format(" blend {:g}", *motion.blend_fraction);
    for (const TriggerCommand& one : motion.triggers) {
      constexpr const char* kWhere[] = {"start", "end", "path"};
      text += fmt::format(" [{}{} +{:g} s: {} {} = {:g}]", kWhere[static_cast<int>(one.where)],
                          one.where == TriggerCommand::Where::kPath ? fmt::format(" {:g} mm", one.path * 1e3) : "",
                          one.delay, one.output == Live::kOut ? "out" : "anout", one.number, one.value);
    }
    return text;
  }

  std::vector<Change> changes_;
  std::deque<Item> queue_, kept_;
  std::map<std::pair<Live, int>, double> outputs_;
  std::map<int, double> inputs_;
  std::vector<std::string> trace_;
  std::vector<double> axes_ = std::vector<double>(6, 0.0);
  double now_ = 0.0;
};

}  // namespace takt::languages::krl::test
