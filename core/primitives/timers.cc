// Family "timer": delays, pulses and stop watches. Times become whole cycles, rounded up.
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// A Boolean that goes through a timer: value = after(input, cycles of the parameter). Null is handed on and ends what
/// is under way.
class Timer : public Primitive {
 protected:
  Timer(Setup& setup, const char* input, const char* value, const char* parameter, const char* doc)
      : input_(setup.in<Boolean>("input", {.doc = input})),
        value_(setup.out<Boolean>("value", {.doc = value})),
        time_(setup.parameter<Real>(parameter, {.unit = "s", .doc = doc, .range = "[0,1e6]", .example = "0.003"})) {
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }
  /// Back to how it was before the first cycle.
  virtual void begin() = 0;
  virtual bool after(bool input, std::int64_t cycles) = 0;

 public:
  void update(const Cycle& cycle) final {
    if (cycle.first) begin();
    if (input_.null()) {
      begin();
      return value_.set_null();
    }
    value_.set(after(*input_, cycles_of(time_, cycle.dt)));
  }

 private:
  In<Boolean> input_;
  Out<Boolean> value_;
  double time_;
};

class OnDelay final : public Timer {
 public:
  explicit OnDelay(Setup& setup)
      : Timer(setup, "what must last", "the input has been true for the delay", "delay", "how long") {
    setup.means("value", "input & ?");
  }

 private:
  void begin() override { lasted_ = 0; }
  bool after(bool input, std::int64_t cycles) override {
    lasted_ = input ? lasted_ + 1 : 0;
    return input && lasted_ > cycles;
  }
  std::int64_t lasted_ = 0;  ///< cycles, this one included
};

class OffDelay final : public Timer {
 public:
  explicit OffDelay(Setup& setup)
      : Timer(setup, "signal to prolong", "the input is true or was within the delay", "delay", "how long") {}

 private:
  void begin() override { left_ = 0; }
  bool after(bool input, std::int64_t cycles) override {
    if (input) {
      left_ = cycles;
      return true;
    }
    return left_ > 0 && --left_ > 0;
  }
  std::int64_t left_ = 0;
};

class Pulse final : public Timer {
 public:
  explicit Pulse(Setup& setup)
      : Timer(setup, "begins a pulse when it becomes true", "true during the pulse", "duration", "of the pulse") {}

 private:
  void begin() override {
    left_ = 0;
    before_ = false;
  }
  bool after(bool input, std::int64_t cycles) override {
    if (input && !before_ && left_ == 0) left_ = cycles;
    before_ = input;
    return left_ > 0 && left_-- > 0;
  }
  std::int64_t left_ = 0;
  bool before_ = false;
};

class Debounce final : public Timer {
 public:
  explicit Debounce(Setup& setup)
      : Timer(setup, "what chatters", "the input once it has been steady", "time", "how long it must be steady") {}

 private:
  void begin() override { known_ = false; }
  bool after(bool input, std::int64_t cycles) override {
    if (!known_) value_ = input;
    known_ = true;
    other_for_ = input == value_ ? 0 : other_for_ + 1;
    if (other_for_ > cycles) {
      value_ = input;
      other_for_ = 0;
    }
    return value_;
  }
  bool known_ = false, value_ = false;
  std::int64_t other_for_ = 0;  ///< cycles in a row in which the input differed from the value
};

class Stopwatch final : public Primitive {
 public:
  explicit Stopwatch(Setup& setup)
      : running_(setup.in<Boolean>("running", trigger_spec("time passes"))),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to 0"))),
        elapsed_(setup.out<Real>("elapsed", {.unit = "s", .doc = "time, this cycle not counted; never null"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first || reset_.value_or(false)) cycles_ = 0;
    elapsed_.set(static_cast<double>(cycles_) * cycle.dt);
    if (running_.value_or(false)) ++cycles_;
  }

 private:
  In<Boolean> running_, reset_;
  Out<Real> elapsed_;
  std::int64_t cycles_ = 0;
};

TAKT_PRIMITIVE(OnDelay, "timer",
               "True once the input has been true without a break for the delay; false in the first cycle unless the "
               "delay is 0. Null starts the delay anew.");
TAKT_PRIMITIVE(OffDelay, "timer",
               "True while the input is true and for the delay after. The first cycle gives the input. Null ends it.");
TAKT_PRIMITIVE(Pulse, "timer",
               "True for the duration from the cycle on in which the input becomes true (true in the first cycle "
               "counts); further edges meanwhile do nothing. Null ends the pulse.");
TAKT_PRIMITIVE(
    Debounce, "timer",
    "Follows the input once it has kept its new value for more than the time. The first cycle, and the first "
    "after null, gives the input.");
TAKT_PRIMITIVE(Stopwatch, "timer", "Time for which it was running since the last reset; 0 in the first cycle.");

}  // namespace
}  // namespace takt::primitives
