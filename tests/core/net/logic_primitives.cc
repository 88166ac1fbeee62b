// Logic for the tests of core/net: what activates fragments, and what joins them again.
#include <array>

#include <fmt/format.h>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::net {
namespace {

/// Runs through all combinations of true, false and null with its neighbours: one digit of the cycle's number.
class TestTernary : public Primitive {
 public:
  explicit TestTernary(Setup& setup)
      : weight_(setup.parameter<Integer>("weight", 1, {.range = "[1,1000000]"})),
        out_(setup.out<Boolean>("out", {.may_be_null = true})) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override {
    const std::int64_t digit = cycle.index / weight_ % 3;
    if (digit == 2) return out_.set_null();
    out_.set(digit == 0);
  }

 private:
  Integer weight_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestTernary, "test", "True, false or null by the cycle's number.");

class TestNot : public Primitive {
 public:
  explicit TestNot(Setup& setup) : in_(setup.in<Boolean>("in")), out_(setup.out<Boolean>("out")) {
    setup.means("out", "!in");
  }
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(!*in_);
  }

 private:
  In<Boolean> in_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestNot, "test", "Not.");

/// Kleene's And; Or by turning everything round.
template <bool is_and>
class TestJunction : public Primitive {
 public:
  explicit TestJunction(Setup& setup)
      : a_(setup.in<Boolean>("a", {.on_null = OnNull::kMayPass})),
        b_(setup.in<Boolean>("b", {.on_null = OnNull::kMayPass})),
        out_(setup.out<Boolean>("out")) {
    setup.means("out", is_and ? "a & b" : "a | b");
  }
  void update(const Cycle&) override {
    const bool decides = !is_and;
    if ((!a_.null() && *a_ == decides) || (!b_.null() && *b_ == decides)) return out_.set(decides);
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(!decides);
  }

 private:
  In<Boolean> a_, b_;
  Out<Boolean> out_;
};
using TestAnd = TestJunction<true>;
using TestOr = TestJunction<false>;
TAKT_PRIMITIVE(TestAnd, "test", "And.");
TAKT_PRIMITIVE(TestOr, "test", "Or.");

class TestElse : public Primitive {
 public:
  explicit TestElse(Setup& setup)
      : a_(setup.in<Boolean>("a", {.on_null = OnNull::kHandled})),
        b_(setup.in<Boolean>("b", {.on_null = OnNull::kMayPass})),
        out_(setup.out<Boolean>("out")) {}
  void update(const Cycle&) override {
    const In<Boolean>& chosen = a_.null() ? b_ : a_;
    if (chosen.null()) return out_.set_null();
    out_.set(*chosen);
  }

 private:
  In<Boolean> a_, b_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestElse, "test", "b where a is null.");
TAKT_MEANING(TestElse, "out", "a ?? b");

class TestIsNull : public Primitive {
 public:
  explicit TestIsNull(Setup& setup)
      : in_(setup.in<Boolean>("in", {.on_null = OnNull::kHandled})), out_(setup.out<Boolean>("out")) {
    setup.means("out", "null(in)");
  }
  void update(const Cycle&) override { out_.set(in_.null()); }

 private:
  In<Boolean> in_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestIsNull, "test", "Whether the input is null.");

class TestSame : public Primitive {
 public:
  explicit TestSame(Setup& setup)
      : a_(setup.in<Integer>("a")), b_(setup.in<Integer>("b")), out_(setup.out<Boolean>("out")) {
    setup.means("out", "a = b");
  }
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ == *b_);
  }

 private:
  In<Integer> a_, b_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestSame, "test", "a = b.");

class TestLess : public Primitive {
 public:
  explicit TestLess(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Boolean>("out")),
        or_equal_(setup.out<Boolean>("or_equal")) {
    setup.means("out", "a < b");
    setup.means("or_equal", "a <= b");
  }
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) {
      out_.set_null();
      return or_equal_.set_null();
    }
    out_.set(*a_ < *b_);
    or_equal_.set(*a_ <= *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> out_, or_equal_;
};
TAKT_PRIMITIVE(TestLess, "test", "a < b, a <= b.");

/// Three phases, one after the other.
class TestPhases : public Primitive {
 public:
  explicit TestPhases(Setup& setup)
      : phases_{setup.out<Boolean>("one"), setup.out<Boolean>("two"), setup.out<Boolean>("three")} {
    setup.exclusive({"one", "two", "three"});
    setup.is_source();
  }
  void update(const Cycle& cycle) override {
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      phases_[i].set(cycle.index_in_net % 3 == static_cast<std::int64_t>(i));
    }
  }

 private:
  std::array<Out<Boolean>, 3> phases_;
};
TAKT_PRIMITIVE(TestPhases, "test", "One phase after the other.");

class TestMerge : public Primitive {
 public:
  explicit TestMerge(Setup& setup)
      : in_{setup.in<Real>("input_1", {.unit = "u", .on_null = OnNull::kMayPass}),
            setup.in<Real>("input_2", {.unit = "u", .on_null = OnNull::kMayPass}),
            setup.in<Real>("input_3", {.unit = "u", .on_null = OnNull::kMayPass, .optional = true})},
        out_(setup.out<Real>("out", {.unit = "u"})) {
    setup.is_merge();
  }
  void update(const Cycle& cycle) override {
    out_.set_null();
    int values = 0;
    for (const In<Real>& in : in_) {
      if (in.null()) continue;
      if (++values > 1) cycle.signals->fail_with(Cause::Code::kConflict, "two at once", cycle.index);
      out_.set(*in);
    }
  }

 private:
  std::array<In<Real>, 3> in_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestMerge, "test", "The input that is not null.");

/// A stop whose null the net may declare.
class TestStop : public Primitive {
 public:
  explicit TestStop(Setup& setup)
      : condition_(setup.flag("condition", {.on_null = OnNull::kCountsAsTrue})),
        unless_(setup.flag("unless", {.on_null = OnNull::kCountsAsFalse, .optional = true})) {}
  void update(const Cycle& cycle) override {
    if (condition_.holds() && !unless_.holds()) cycle.signals->fail_with(Cause::Code::kError, "stopped", cycle.index);
  }

 private:
  Flag condition_, unless_;
};
TAKT_PRIMITIVE(TestStop, "test", "Stops the net.");

/// The net may declare what null means at both inputs.
class TestLatch : public Primitive {
 public:
  explicit TestLatch(Setup& setup)
      : set_(setup.flag("set", {.on_null = OnNull::kCountsAsTrue})),
        reset_(setup.flag("reset", {.on_null = OnNull::kCountsAsFalse, .optional = true})),
        out_(setup.out<Boolean>("out")) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) state_ = false;
    if (reset_.holds()) state_ = false;
    if (set_.holds()) state_ = true;
    out_.set(state_);
  }

 private:
  Flag set_, reset_;
  Out<Boolean> out_;
  bool state_ = false;
};
TAKT_PRIMITIVE(TestLatch, "test", "Stays true.");

/// A sink that can bridge.
class TestBridge : public Primitive {
 public:
  explicit TestBridge(Setup& setup)
      : in_(setup.in<Real>("in", {.on_null = OnNull::kStop})), most_(setup.bridge_cycles("in")) {}
  void update(const Cycle& cycle) override {
    bridged_ = cycle.first || !in_.null() ? 0 : bridged_;
    if (in_.null() && bridged_++ >= most_) cycle.signals->fail_with(Cause::Code::kNullInput, "null", cycle.index);
  }

 private:
  In<Real> in_;
  Integer most_;
  Integer bridged_ = 0;
};
TAKT_PRIMITIVE(TestBridge, "test", "Bridges null.");

/// An output that lags by 3 cycles, one that lags as long as it likes.
class TestLags : public Primitive {
 public:
  explicit TestLags(Setup& setup)
      : in_(setup.in<Real>("in", {.on_null = OnNull::kHandled})),
        fixed_(setup.out<Real>("fixed", {.may_be_null = true})),
        some_day_(setup.out<Real>("some_day", {.may_be_null = true})) {
    setup.latency("in", "fixed", {.cycles = 3});
    setup.latency("in", "some_day", {.cycles = 0, .data_dependent = true});
  }
  void update(const Cycle&) override {
    fixed_.set_null();
    some_day_.set_null();
  }

 private:
  In<Real> in_;
  Out<Real> fixed_, some_day_;
};
TAKT_PRIMITIVE(TestLags, "test", "Lags.");

}  // namespace
}  // namespace takt::net
