#include "hw/fri/emulator/krl_program.h"

#include "hw/fri/protocol/krl_words.h"

namespace takt::hw::fri {
namespace {

std::int32_t from(const KrlInterface& krl, std::size_t word) { return krl.from_remote().integer[word]; }
std::int32_t& to(KrlInterface& krl, std::size_t word) { return krl.to_remote().integer[word]; }

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

}  // namespace

const std::vector<std::string>& krl_conventions() {
  static const std::vector<std::string> names{"takt", "fri_control", "ros_control"};
  return names;
}

std::unique_ptr<KrlProgram> make_krl_program(std::string_view convention) {
  if (convention == "takt") return std::make_unique<TaktProgram>();
  if (convention == "fri_control") return std::make_unique<FriControlProgram>();
  if (convention == "ros_control") return std::make_unique<RosControlProgram>();
  return nullptr;
}

}  // namespace takt::hw::fri
