#include "hw/emulators/fri/krl_program.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "hw/fri/protocol/krl_words.h"

namespace takt::hw::fri {
namespace {

std::int32_t from(const KrlInterface& krl, std::size_t word) { return krl.from_remote().integer[word]; }
std::int32_t& to(KrlInterface& krl, std::size_t word) { return krl.to_remote().integer[word]; }

bool asks(const KrlInterface& krl, std::uint16_t bit) { return (krl.from_remote().boolean & bit) != 0; }
void show(KrlInterface& krl, std::uint16_t bit, bool value) {
  std::uint16_t& shown = krl.to_remote().boolean;
  shown = static_cast<std::uint16_t>(value ? shown | bit : shown & ~bit);
}

/// A bit that the remote side holds until it sees an answer: each time that it is raised it is one request.
class RaisedBit {
 public:
  explicit RaisedBit(std::uint16_t bit) : bit_(bit) {}
  /// @return true once for each request
  bool take(const KrlInterface& krl) {
    const bool before = std::exchange(raised_, asks(krl, bit_));
    return raised_ && !before;
  }

 private:
  std::uint16_t bit_;
  bool raised_ = false;
};

/// Opens once. @return false in the cycle in which it does
bool opened(KrlInterface& krl) {
  if (krl.fri_state() != State::kOff) return true;
  krl.fri_open();
  return false;
}

class TaktProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace takt_words;
    if (!opened(krl)) return;
    const std::int32_t request = from(krl, kRequest);
    if (request != to(krl, kRequest)) {
      serve(krl);
      to(krl, kRequest) = request;
    }
    to(krl, kWanted) = static_cast<std::int32_t>(krl.fri_state());
  }

 private:
  static void serve(KrlInterface& krl) {
    using namespace takt_words;
    const bool command = from(krl, kWanted) == static_cast<std::int32_t>(State::kCommand);
    if (!command) return krl.fri_stop();
    if (krl.fri_state() != State::kMonitor) return;
    krl.set_strategy(from(krl, kStrategy));
    to(krl, kStrategy) = from(krl, kStrategy);
    krl.fri_start(1.0);
  }
};

class FriControlProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace fri_control_words;
    if (!opened(krl)) {
      to(krl, kCommand) = kOpened;
      to(krl, kStrategy) = kClose;  // the code with which this run can be ended
      return;
    }
    if (was_starting_ && !krl.starting()) to(krl, kCommand) = kStarted;  // whether it got there or not
    was_starting_ = krl.starting();
    if (was_starting_) return;
    const std::int32_t command = from(krl, kCommand);
    if (command == kStart && to(krl, kCommand) != kStarted) {
      krl.set_strategy(from(krl, kStrategy));
      krl.fri_start(1.0);
      was_starting_ = true;
    } else if (command == kStop && to(krl, kCommand) != kOpened) {
      krl.fri_stop();
      to(krl, kCommand) = kOpened;
    }
  }

 private:
  bool was_starting_ = false;
};

class RosControlProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace ros_control_words;
    if (!opened(krl)) {
      to(krl, kCommand) = kInitialised;
      return;
    }
    if (was_starting_ && !krl.starting()) to(krl, kCommand) = kStart;
    was_starting_ = krl.starting();
    // The program waits for the best quality before it does anything.
    if (was_starting_ || (to(krl, kCommand) == kInitialised && krl.fri_quality() != Quality::kPerfect)) return;
    const std::int32_t command = from(krl, kCommand);
    if (command == kStart && to(krl, kCommand) != kStart) {
      // The strategy of the first start is preset.
      krl.set_strategy(first_ ? strategy_of(Control::kPosition) : from(krl, kStrategy));
      first_ = false;
      krl.fri_start(1.0);
      was_starting_ = true;
    } else if (command == kStop && to(krl, kCommand) == kStart) {
      krl.fri_stop();
      to(krl, kCommand) = kStop;
    }
  }

 private:
  bool was_starting_ = false, first_ = true;
};

/// Starts once when the client is ready. What runs is ended by the client when it is not ready any more, or by the
/// controller: then the program is over, and it asks the client to leave.
class KukaSampleProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace kuka_sample_words;
    if (!opened(krl)) return;
    krl.to_remote().real[kProbe] += 1.0F;
    const bool ready = from(krl, kCommand) == kReady;
    const bool commands = krl.fri_state() == State::kCommand;
    if (ready && !was_ready_) {
      to(krl, kCommand) = 0;
      krl.fri_start(1.0);
    } else if (!ready && commands) {
      krl.fri_stop();
    } else if (ready && !commands && !krl.starting()) {
      to(krl, kCommand) = kLeave;
    }
    was_ready_ = ready;
  }

 private:
  bool was_ready_ = false;
};

class RcprgProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace rcprg_words;
    if (!opened(krl)) return;
    if (request_.take(krl)) {
      serve(krl);
      return show(krl, kRequest, true);
    }
    if (!krl.starting()) show(krl, kRequest, false);
  }

 private:
  /// The cycle with which it is opened again is the one that the emulator has.
  static void serve(KrlInterface& krl) {
    using namespace rcprg_words;
    switch (from(krl, kCommand)) {
      case kStart:
        krl.set_strategy(kStrategy);
        return krl.fri_start(1.0);
      case kStop:
        return krl.fri_stop();
      case kReopen:
        return krl.fri_close();
      default:
        return;
    }
  }

  RaisedBit request_{rcprg_words::kRequest};
};

/// A command is answered when it is done or refused; none is served before.
class OpenKcProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace openkc_words;
    if (!opened(krl)) return;
    if (was_starting_) {
      if (krl.starting()) return;
      was_starting_ = false;
      answer(krl, kStart, krl.fri_state() == State::kCommand);
    }
    if (!request_.take(krl)) return;
    const std::int32_t command = from(krl, kCommand);
    if (command != kStart || krl.fri_state() != State::kMonitor) return answer(krl, command, serve(krl, command));
    krl.fri_start(1.0);
    was_starting_ = true;
  }

 private:
  static void answer(KrlInterface& krl, std::int32_t command, bool done) {
    using namespace openkc_words;
    to(krl, kEcho) = command;
    to(krl, kAnswer) = done ? kDone : kRefused;
    ++to(krl, kCount);
  }

  /// Strategies are changed in monitor state. Stiffness and damping come with each command of the interface; what 4 and
  /// 5 set are KRL's defaults for those who command none, which are the model's.
  static bool serve(KrlInterface& krl, std::int32_t command) {
    using namespace openkc_words;
    switch (command) {
      case kStop:
      case kReset:
        krl.fri_stop();
        return true;
      case kSetCartesian:
      case kSetAxis:
        return krl.fri_state() == State::kMonitor;
      case kToCartesian:
        return krl.set_strategy(strategy_of(Control::kCartesianImpedance));
      case kToAxis:
        return krl.set_strategy(strategy_of(Control::kJointImpedance));
      case kToPosition:
        return krl.set_strategy(strategy_of(Control::kPosition));
      case kSetStrategy:
        return krl.set_strategy(from(krl, kStrategy));
      default:
        return false;
    }
  }

  RaisedBit request_{openkc_words::kRequest};
  bool was_starting_ = false;
};

/// Strategy and tool come in 17 steps, each of which is acknowledged; then it starts. The request counts as done when
/// command state is there.
class IsseProgram final : public KrlProgram {
 public:
  void poll(KrlInterface& krl) override {
    using namespace isse_words;
    if (!opened(krl)) return;
    const bool asked = asks(krl, kRequest);
    if (asked && step_ < kSteps) {
      accept(krl);
    } else if (!asked || (step_ == kSteps && krl.fri_state() == State::kCommand)) {
      show(krl, kRequest, false);
      if (!asked) step_ = 0;
    }
  }

 private:
  /// A step is accepted after the one before it; a value that is no number, or a mass below nothing, is not.
  void accept(KrlInterface& krl) {
    using namespace isse_words;
    const auto value = static_cast<double>(krl.from_remote().real[kValue]);
    if (from(krl, kStep) != step_ + 1 || (step_ > 0 && !fits(step_ + 1, value))) return;
    ++step_;
    if (step_ == 1) {
      krl.fri_stop();
      strategy_ = from(krl, kStrategy);
    }
    values_[static_cast<std::size_t>(step_)] = value;
    to(krl, kStep) = step_;
    show(krl, kRequest, true);
    if (step_ < kSteps) return;
    krl.set_strategy(strategy_);
    krl.set_tool(tool());
    krl.fri_start(1.0);
  }

  [[nodiscard]] static bool fits(int step, double value) {
    using namespace isse_words;
    return std::isfinite(value) && (value >= 0.0 || (step != kMass && step < kInertia));
  }
  [[nodiscard]] Eigen::Vector3d three(int first) const {
    return Eigen::Vector3d(&values_[static_cast<std::size_t>(first)]);
  }
  /// A about z, then B about the new y, then C about the new x.
  [[nodiscard]] Eigen::Matrix3d rotation(int first) const {
    const Eigen::Vector3d abc = three(first) * (std::numbers::pi / 180.0);
    return (Eigen::AngleAxisd(abc[0], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(abc[1], Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(abc[2], Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
  }
  [[nodiscard]] device::ToolSetting tool() const {
    using namespace isse_words;
    device::ToolSetting tool;
    tool.X_FT.linear() = rotation(kTcp + 3);
    tool.X_FT.translation() = 1e-3 * three(kTcp);
    tool.payload.mass = values_[kMass];
    tool.payload.p_FC = 1e-3 * three(kCentre);
    const Eigen::Matrix3d R = rotation(kInertiaAxes);
    tool.payload.I_C = R * three(kInertia).asDiagonal() * R.transpose();
    return tool;
  }

  int step_ = 0;  // accepted last
  int strategy_ = 0;
  std::array<double, isse_words::kSteps + 1> values_{};  // by step
};

}  // namespace

const std::vector<std::string>& krl_conventions() {
  static const std::vector<std::string> names{"takt",  "fri_control", "ros_control", "kuka_sample",
                                              "rcprg", "openkc",      "isse"};
  return names;
}

std::unique_ptr<KrlProgram> make_krl_program(std::string_view convention) {
  if (convention == "takt") return std::make_unique<TaktProgram>();
  if (convention == "fri_control") return std::make_unique<FriControlProgram>();
  if (convention == "ros_control") return std::make_unique<RosControlProgram>();
  if (convention == "kuka_sample") return std::make_unique<KukaSampleProgram>();
  if (convention == "rcprg") return std::make_unique<RcprgProgram>();
  if (convention == "openkc") return std::make_unique<OpenKcProgram>();
  if (convention == "isse") return std::make_unique<IsseProgram>();
  return nullptr;
}

}  // namespace takt::hw::fri
