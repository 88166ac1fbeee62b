#pragma once

#include <cmath>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "languages/urscript/poses.h"
#include "languages/urscript/session.h"

namespace takt::languages::urscript::test {

/// An arm of six joints that takes half a second for each motion, with signals, on a clock of its own. It writes down
/// what happens. Its flange is at (q0, q1, q2) m and turned by q5 about z.
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
  [[nodiscard]] double cycle() const override { return kCycle; }
  [[nodiscard]] bool settled() override { return queue_.empty(); }
  [[nodiscard]] int unfinished() override {
    int count = 0;
    for (const Item& one : queue_) count += one.is_motion ? 1 : 0;
    return count;
  }
  [[nodiscard]] std::string move(MotionCommand motion) override {
    if (motion.goal.X_BF.translation().norm() > 9.0) return "the pose is out of reach";
    tell("plan " + describe(motion));
    lasts_ = false;
    Item item{.is_motion = true, .text = fmt::format("{}:{}", motion.at.line, motion.word), .left = kMotion};
    item.q = motion.goal.q.size() > 0 ? motion.goal.q : *solve(motion.goal.X_BF, q_);
    queue_.push_back(std::move(item));
    return {};
  }
  [[nodiscard]] std::string last(const LastingCommand& command) override {
    constexpr const char* kWords[] = {"servo", "speed", "freedrive", "force"};
    std::string text = kWords[static_cast<int>(command.kind)];
    if (command.kind == LastingCommand::Kind::kServo) text += " " + describe(command.X_BF * command.X_FT);
    if (command.kind == LastingCommand::Kind::kSpeed)
      text += fmt::format(" {:g} {:g} {:g}", command.twist[0], command.twist[1], command.twist[2]);
    if (command.kind == LastingCommand::Kind::kForce) text += describe(command.force);
    tell(text);
    lasts_ = true;
    return {};
  }
  [[nodiscard]] bool lasts() const override { return lasts_; }
  void stop() override {
    tell("stop");
    queue_.clear();
    lasts_ = false;
  }
  [[nodiscard]] std::string write(Signal output, int number, double value, bool beside, const TextLocation&) override {
    outputs_[{output, number}] = value;
    tell(fmt::format("{} {} = {:g}{}", output == Signal::kDigitalOut ? "out" : "anout", number, value,
                     beside ? " beside" : ""));
    return {};
  }
  [[nodiscard]] std::optional<double> read(Signal signal, int number) override {
    if (signal == Signal::kDigitalOut || signal == Signal::kAnalogOut) return outputs_[{signal, number}];
    if (signal == Signal::kDigitalIn && number == 17) return std::nullopt;
    return inputs_[number];
  }
  void call(const std::string& name, const TextLocation&) override { tell("call " + name); }
  [[nodiscard]] std::string tare(const TextLocation&) override {
    tell("tare");
    return {};
  }
  void message(const std::string& title, const std::string& text, const TextLocation&) override {
    tell(title + " " + text);
  }
  [[nodiscard]] kinematics::JointVector joints(bool) override { return q_; }
  [[nodiscard]] Eigen::Isometry3d flange(const kinematics::JointVector& q) override {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = q.head<3>();
    X.linear() = Eigen::AngleAxisd(q[5], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return X;
  }
  [[nodiscard]] std::optional<kinematics::JointVector> solve(const Eigen::Isometry3d& X_BF,
                                                             const kinematics::JointVector& near) override {
    if (X_BF.translation().norm() > 9.0) return std::nullopt;
    kinematics::JointVector q = near;
    q.head<3>() = X_BF.translation();
    q[5] = std::atan2(X_BF.linear()(1, 0), X_BF.linear()(0, 0));
    return q;
  }
  [[nodiscard]] Eigen::Isometry3d tool() const override { return Eigen::Isometry3d::Identity(); }

  /// Until the program has ended and its motions are over, or so many seconds have passed.
  Session::Progress run(Session& session, double seconds = 20.0) {
    Session::Progress progress = Session::Progress::kRunning;
    while (now_ < seconds) {
      for (const Change& one : changes_)
        if (one.at <= now_ + 1e-9) inputs_[one.input] = one.value;
      progress = session.advance();
      if (progress != Session::Progress::kRunning && queue_.empty()) break;
      now_ += kCycle;
      if (queue_.empty()) continue;
      queue_.front().left -= kCycle;
      if (queue_.front().left > 1e-9) continue;
      tell("done " + queue_.front().text);
      q_ = queue_.front().q;
      queue_.pop_front();
    }
    return progress;
  }

  [[nodiscard]] const std::vector<std::string>& trace() const { return trace_; }
  bool with_times = false;

 private:
  struct Item {
    bool is_motion = false;
    std::string text = {};
    double left = 0.0;
    kinematics::JointVector q = {};
  };

  void tell(const std::string& text) { trace_.push_back(with_times ? fmt::format("{:.2f} {}", now_, text) : text); }

  static double tidy(double value) { return std::abs(value) < 5e-7 ? 0.0 : value; }

  static std::string describe(const Eigen::Isometry3d& X) {
    const Eigen::Vector3d p = X.translation();
    std::string text = fmt::format("p({:.6g} {:.6g} {:.6g}", tidy(p.x()), tidy(p.y()), tidy(p.z()));
    const Eigen::AngleAxisd turn(X.linear());
    if (std::abs(turn.angle()) > 1e-6) {
      const Eigen::Vector3d r = turn.angle() * turn.axis();
      text += fmt::format(", {:.4g} {:.4g} {:.4g}", tidy(r.x()), tidy(r.y()), tidy(r.z()));
    }
    return text + ")";
  }
  static std::string describe(const ForceCommand& force) {
    return fmt::format(" {:g} N along ({:g} {:g} {:g}), {:g} m/s", force.force, tidy(force.direction.x()),
                       tidy(force.direction.y()), tidy(force.direction.z()), force.velocity);
  }
  static std::string describe(const MotionCommand& motion) {
    std::string text = motion.word;
    const auto goal = [&](const MotionGoal& one) {
      if (one.q.size() == 0) return describe(one.X_BF * motion.X_FT);
      std::string joints;
      for (const double q : one.q) joints += fmt::format("{}{:.6g}", joints.empty() ? "" : " ", tidy(q));
      return "q(" + joints + ")";
    };
    if (motion.kind == MotionCommand::Kind::kArc) text += " by " + goal(motion.via);
    text += " " + goal(motion.goal) + fmt::format(" a {:g} v {:g}", motion.acceleration, motion.velocity);
    if (motion.time > 0.0) text += fmt::format(" t {:g}", motion.time);
    if (motion.radius > 0.0) text += fmt::format(" r {:g}", motion.radius);
    if (motion.tangential) text += " tangential";
    if (motion.force) text += " with" + describe(*motion.force);
    return text;
  }

  std::vector<Change> changes_;
  std::deque<Item> queue_;
  std::map<std::pair<Signal, int>, double> outputs_;
  std::map<int, double> inputs_;
  std::vector<std::string> trace_;
  kinematics::JointVector q_ = kinematics::JointVector::Zero(6);
  double now_ = 0.0;
  bool lasts_ = false;
};

}  // namespace takt::languages::urscript::test
