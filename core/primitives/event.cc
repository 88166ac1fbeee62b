// Family "event": edges, latches, timers and counters over Booleans.
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

/// True in the cycle in which the input comes to `level`. What was before the first cycle counts as false, as in the
/// triggers of IEC 61131-3; null before an edge hides it.
template <bool level>
class Edge : public Primitive {
 public:
  explicit Edge(Setup& setup)
      : input_(setup.in<Boolean>("input", {.doc = "what is watched"})),
        value_(setup.out<Boolean>("value", {.doc = "true in the cycle of the edge"})) {
    setup.means("value", level ? "input & ?" : "!input & ?");
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) before_ = false;
    if (input_.null()) {
      before_ = level;
      return value_.set_null();
    }
    value_.set(*input_ == level && before_ != level);
    before_ = *input_;
  }

 private:
  In<Boolean> input_;
  Out<Boolean> value_;
  bool before_ = false;
};

using RisingEdge = Edge<true>;
using FallingEdge = Edge<false>;

class SetResetLatch final : public Primitive {
 public:
  explicit SetResetLatch(Setup& setup)
      : set_(setup.flag("set", {.doc = "true: becomes true", .on_null = OnNull::kCountsAsTrue})),
        reset_(setup.flag("reset", {.doc = "true: becomes false, unless set", .on_null = OnNull::kCountsAsFalse})),
        value_(setup.out<Boolean>("value", {.doc = "the state, never null"})),
        initial_(setup.parameter<Boolean>("initial", false, {.doc = "state before the first cycle"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first) state_ = initial_;
    if (reset_.holds()) state_ = false;
    if (set_.holds()) state_ = true;
    value_.set(state_);
  }

 private:
  Flag set_, reset_;
  Out<Boolean> value_;
  bool initial_;
  bool state_ = false;
};

/// Whole periods that last at least `seconds`; a hair less counts as reached (0.1 s are 100 cycles of 1 ms).
std::int64_t cycles_of(double seconds, double dt) { return static_cast<std::int64_t>(std::ceil(seconds / dt - 1e-9)); }

class OnDelay final : public Primitive {
 public:
  explicit OnDelay(Setup& setup)
      : input_(setup.in<Boolean>("input", {.doc = "what must last"})),
        value_(setup.out<Boolean>("value", {.doc = "the input has been true for the delay"})),
        delay_(setup.parameter<Real>("delay", {.unit = "s", .doc = "how long", .range = "[0,1e6]"})) {
    setup.means("value", "input & ?");
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) lasted_ = 0;
    if (input_.null()) {
      lasted_ = 0;
      return value_.set_null();
    }
    lasted_ = *input_ ? lasted_ + 1 : 0;
    value_.set(*input_ && lasted_ > cycles_of(delay_, cycle.dt));
  }

 private:
  In<Boolean> input_;
  Out<Boolean> value_;
  double delay_;
  std::int64_t lasted_ = 0;  ///< cycles, this one included
};

class Stopwatch final : public Primitive {
 public:
  explicit Stopwatch(Setup& setup)
      : running_(setup.in<Boolean>("running", {.doc = "time passes", .on_null = OnNull::kCountsAsFalse})),
        reset_(setup.in<Boolean>("reset",
                                 {.doc = "true: back to 0", .on_null = OnNull::kCountsAsFalse, .optional = true})),
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

class CycleCounter final : public Primitive {
 public:
  explicit CycleCounter(Setup& setup)
      : counted_(setup.in<Boolean>("counted", {.doc = "this cycle counts", .on_null = OnNull::kCountsAsFalse})),
        reset_(setup.in<Boolean>(
            "reset", {.doc = "true: back to 0 before counting", .on_null = OnNull::kCountsAsFalse, .optional = true})),
        count_(setup.out<Integer>("count", {.doc = "cycles counted, this one included; never null"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first || reset_.value_or(false)) cycles_ = 0;
    if (counted_.value_or(false)) ++cycles_;
    count_.set(cycles_);
  }

 private:
  In<Boolean> counted_, reset_;
  Out<Integer> count_;
  std::int64_t cycles_ = 0;
};

TAKT_PRIMITIVE(
    RisingEdge, "event",
    "True in the cycle in which the input becomes true. Before the first cycle it counts as false; from null "
    "to true is no edge.");
TAKT_PRIMITIVE(FallingEdge, "event",
               "True in the cycle in which the input becomes false. Before the first cycle it counts as false; from "
               "null to false is no edge.");
TAKT_PRIMITIVE(
    SetResetLatch, "event",
    "Remembers that it was set until it is reset; set wins. Null at set counts as true, so that a dead sensor "
    "does not hide a fault.");
TAKT_PRIMITIVE(OnDelay, "event",
               "True once the input has been true without a break for the delay; false in the first cycle unless the "
               "delay is 0. Null starts the delay anew.");
TAKT_PRIMITIVE(Stopwatch, "event", "Time for which it was running since the last reset; 0 in the first cycle.");
TAKT_PRIMITIVE(CycleCounter, "event", "How many cycles counted since the last reset.");

}  // namespace
}  // namespace takt::primitives
