// Family "latch": what was, until it is taken back.
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// Null at `set` counts as true, unless the net says otherwise: a dead sensor does not hide a fault. Null at `reset`
/// counts as false.
template <bool set_wins>
class Latch final : public Primitive {
 public:
  explicit Latch(Setup& setup)
      : set_(setup.flag("set", {.doc = set_wins ? "true: becomes true" : "true: becomes true, unless reset",
                                .on_null = OnNull::kCountsAsTrue})),
        reset_(setup.flag("reset", trigger_spec(set_wins ? "true: becomes false, unless set" : "true: becomes false"))),
        value_(setup.out<Boolean>("value", {.doc = "the state, never null"})),
        initial_(setup.parameter<Boolean>("initial", false, {.doc = "state before the first cycle"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first) state_ = initial_;
    const bool set = set_.holds(), reset = reset_.holds();
    if (set || reset) state_ = set_wins ? set : !reset;
    value_.set(state_);
  }

 private:
  Flag set_, reset_;
  Out<Boolean> value_;
  bool initial_;
  bool state_ = false;
};

using SetResetLatch = Latch<true>;
using ResetSetLatch = Latch<false>;

class Toggle final : public Primitive {
 public:
  explicit Toggle(Setup& setup)
      : trigger_(setup.in<Boolean>("trigger", trigger_spec("turns the state round when it becomes true"))),
        reset_(setup.in<Boolean>("reset", reset_spec("true: back to `initial`, whatever the trigger"))),
        value_(setup.out<Boolean>("value", {.doc = "the state, never null"})),
        initial_(setup.parameter<Boolean>("initial", false, {.doc = "state before the first cycle"})) {}

  void update(const Cycle& cycle) override {
    const bool turn = edge_.rises(cycle, trigger_);
    if (cycle.first) state_ = initial_;
    if (turn) state_ = !state_;
    if (reset_.value_or(false)) state_ = initial_;
    value_.set(state_);
  }

 private:
  In<Boolean> trigger_, reset_;
  Out<Boolean> value_;
  bool initial_;
  bool state_ = false;
  Trigger edge_;
};

TAKT_PRIMITIVE(SetResetLatch, "latch",
               "Remembers that it was set until it is reset; set wins. Null at set counts as true, so that a dead "
               "sensor does not hide a fault.");
TAKT_PRIMITIVE(ResetSetLatch, "latch",
               "Remembers that it was set until it is reset; reset wins. Null at set counts as true, so that a dead "
               "sensor does not hide a fault.");
TAKT_PRIMITIVE(Toggle, "latch", "Turns round with each rising edge; true in the first cycle counts as one.");

}  // namespace
}  // namespace takt::primitives
