// Edges, latches, timers, counters, snapshots: logic with memory. All state begins in the first cycle.
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using net::Boolean;
using net::Cycle;
using net::In;
using net::Integer;
using net::OnNull;
using net::Out;
using net::Real;
using net::Setup;

/// Null counts as false for edges: what is not known is no event.
class RisingEdge final : public net::Primitive {
 public:
  explicit RisingEdge(Setup& s)
      : value_(s.in<Boolean>("value", {.on_null = OnNull::kCountsAsFalse})),
        edge_(s.out<Boolean>("edge", {.doc = "true for one cycle; in the first cycle if the value is true then"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) before_ = false;
    const bool now = value_.value_or(false);
    edge_.set(now && !before_);
    before_ = now;
  }

 private:
  In<Boolean> value_;
  Out<Boolean> edge_;
  bool before_ = false;
};
TAKT_PRIMITIVE(RisingEdge, "edges", "True in the cycle in which a value becomes true. Null counts as false.");

class FallingEdge final : public net::Primitive {
 public:
  explicit FallingEdge(Setup& s)
      : value_(s.in<Boolean>("value", {.on_null = OnNull::kCountsAsFalse})),
        edge_(s.out<Boolean>("edge", {.doc = "true for one cycle; never in the first"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) before_ = false;
    const bool now = value_.value_or(false);
    edge_.set(!now && before_);
    before_ = now;
  }

 private:
  In<Boolean> value_;
  Out<Boolean> edge_;
  bool before_ = false;
};
TAKT_PRIMITIVE(FallingEdge, "edges", "True in the cycle in which a value becomes false. Null counts as false.");

class SetResetLatch final : public net::Primitive {
 public:
  explicit SetResetLatch(Setup& s)
      : set_(s.in<Boolean>("set", {.on_null = OnNull::kCountsAsTrue})),
        reset_(s.in<Boolean>("reset", {.on_null = OnNull::kCountsAsFalse, .optional = true})),
        value_(s.out<Boolean>("value", {.doc = "true from the cycle of set to the cycle of reset; set wins"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) latched_ = false;
    if (reset_.value_or(false)) latched_ = false;
    if (set_.value_or(true)) latched_ = true;
    value_.set(latched_);
  }

 private:
  In<Boolean> set_, reset_;
  Out<Boolean> value_;
  bool latched_ = false;
};
TAKT_PRIMITIVE(SetResetLatch, "latches",
               "Remembers that something was true. Null at set counts as true (row N3), null at reset as false.");

class OnDelay final : public net::Primitive {
 public:
  explicit OnDelay(Setup& s)
      : value_(s.in<Boolean>("value", {.on_null = OnNull::kCountsAsFalse})),
        delayed_(s.out<Boolean>("delayed", {.doc = "true once the value has been true for `cycles` cycles in a row"})),
        cycles_(s.parameter<Integer>("cycles", {.range = "[1,1000000]"})) {
    s.latency("value", "delayed", {.cycles = cycles_ - 1, .data_dependent = true});
  }
  void update(const Cycle& cycle) override {
    if (cycle.first) count_ = 0;
    count_ = value_.value_or(false) ? count_ + (count_ < cycles_ ? 1 : 0) : 0;
    delayed_.set(count_ >= cycles_);
  }

 private:
  In<Boolean> value_;
  Out<Boolean> delayed_;
  Integer cycles_;
  Integer count_ = 0;
};
TAKT_PRIMITIVE(OnDelay, "timers", "Debounces: true once a value has been true for some cycles in a row.");

class CycleCounter final : public net::Primitive {
 public:
  explicit CycleCounter(Setup& s) : count_(s.out<Integer>("count", {.doc = "0 in the first cycle"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) next_ = 0;
    count_.set(next_++);
  }

 private:
  Out<Integer> count_;
  Integer next_ = 0;
};
TAKT_PRIMITIVE(CycleCounter, "counters", "Number of cycles since the net (or its fragment) became active.");

class Stopwatch final : public net::Primitive {
 public:
  explicit Stopwatch(Setup& s)
      : running_(s.in<Boolean>("running", {.on_null = OnNull::kCountsAsFalse})),
        time_(s.out<Real>("time", {.unit = "s", .doc = "time for which `running` has been true; 0 before"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) elapsed_ = 0;
    if (running_.value_or(false)) elapsed_ += cycle.period;
    time_.set(to_seconds(elapsed_));
  }

 private:
  In<Boolean> running_;
  Out<Real> time_;
  Nanoseconds elapsed_ = 0;
};
TAKT_PRIMITIVE(Stopwatch, "timers", "Sums up the time for which a value is true.");

class ElapsedCycles final : public net::Primitive {
 public:
  explicit ElapsedCycles(Setup& s)
      : elapsed_(s.out<Boolean>("elapsed", {.doc = "true from cycle number `cycles` on, counted from 0"})),
        cycles_(s.parameter<Integer>("cycles", {.range = "[0,1000000000]"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) count_ = 0;
    elapsed_.set(count_ >= cycles_);
    if (count_ < cycles_) ++count_;
  }

 private:
  Out<Boolean> elapsed_;
  Integer cycles_;
  Integer count_ = 0;
};
TAKT_PRIMITIVE(ElapsedCycles, "timers", "True once a number of cycles has passed.");

/// One class for each type of port; they differ in nothing else.
template <class T>
class Snapshot : public net::Primitive {
 public:
  explicit Snapshot(Setup& s)
      : value_(s.in<T>("value", {.unit = unit(), .on_null = OnNull::kHandled})),
        take_(s.in<Boolean>("take", {.on_null = OnNull::kCountsAsFalse})),
        taken_(s.out<T>("value",
                        {.unit = unit(), .doc = "null before the first rising edge of take", .may_be_null = true})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) {
      before_ = false;
      taken_.set_null();
    }
    const bool now = take_.value_or(false);
    if (now && !before_) {
      if (value_.null()) {
        taken_.set_null();
      } else {
        taken_.set(*value_);
      }
    }
    before_ = now;
  }

 private:
  static constexpr std::string_view unit() { return std::is_same_v<T, net::Frame> ? "" : "u"; }
  In<T> value_;
  In<Boolean> take_;
  Out<T> taken_;
  bool before_ = false;
};

class SnapshotReal final : public Snapshot<Real> {
  using Snapshot::Snapshot;
};
TAKT_PRIMITIVE(SnapshotReal, "snapshots", "Keeps the value of the cycle in which `take` becomes true.");
class SnapshotFrame final : public Snapshot<net::Frame> {
  using Snapshot::Snapshot;
};
TAKT_PRIMITIVE(SnapshotFrame, "snapshots", "Keeps the frame of the cycle in which `take` becomes true.");
class SnapshotJoints final : public Snapshot<net::JointArray> {
  using Snapshot::Snapshot;
};
TAKT_PRIMITIVE(SnapshotJoints, "snapshots", "Keeps the joint array of the cycle in which `take` becomes true.");

}  // namespace
}  // namespace takt::primitives
