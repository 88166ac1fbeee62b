// Family "counter": cycles and events in whole numbers.
#include <limits>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

class CycleCounter final : public Primitive {
 public:
  explicit CycleCounter(Setup& setup)
      : counted_(setup.in<Boolean>("counted", trigger_spec("this cycle counts"))),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to 0 before counting"))),
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

class UpDownCounter final : public Primitive {
 public:
  explicit UpDownCounter(Setup& setup)
      : up_(setup.in<Boolean>("up", trigger_spec("counts up when it becomes true"))),
        down_(setup.in<Boolean>("down", reset_spec("counts down when it becomes true"))),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to `initial` before counting"))),
        count_(setup.out<Integer>("count", {.doc = "this cycle's events included; never null"})),
        at_upper_(setup.out<Boolean>("at_upper", {.doc = "the count is `upper`; never null"})),
        at_lower_(setup.out<Boolean>("at_lower", {.doc = "the count is `lower`; never null"})),
        initial_(setup.parameter<Integer>("initial", 0, {.doc = "count after a reset"})),
        lower_(setup.parameter<Integer>("lower", 0, {.doc = "never below"})),
        upper_(setup.parameter<Integer>("upper", std::numeric_limits<Integer>::max(), {.doc = "never above"})) {}

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (lower_ > upper_) diagnostics.error(Code::kOutOfRange, "/lower", "lower is above upper", "Keep lower <= upper");
    if (initial_ < lower_ || initial_ > upper_)
      diagnostics.error(Code::kOutOfRange, "/initial", "initial is outside [lower, upper]",
                        "Choose a count that can be reached");
    return diagnostics;
  }

  void update(const Cycle& cycle) override {
    const bool up = up_edge_.rises(cycle, up_), down = down_edge_.rises(cycle, down_);
    if (cycle.first || reset_.value_or(false)) state_ = initial_;
    if (up && !down && state_ < upper_) ++state_;
    if (down && !up && state_ > lower_) --state_;
    count_.set(state_);
    at_upper_.set(state_ == upper_);
    at_lower_.set(state_ == lower_);
  }

 private:
  In<Boolean> up_, down_, reset_;
  Out<Integer> count_;
  Out<Boolean> at_upper_, at_lower_;
  std::int64_t initial_, lower_, upper_;
  std::int64_t state_ = 0;
  Trigger up_edge_, down_edge_;
};

TAKT_PRIMITIVE(CycleCounter, "counter", "How many cycles counted since the last reset.");
TAKT_PRIMITIVE(
    UpDownCounter, "counter",
    "Counts rising edges up and down, within bounds; both at once cancel out. True in the first cycle counts "
    "as an edge.");

}  // namespace
}  // namespace takt::primitives
