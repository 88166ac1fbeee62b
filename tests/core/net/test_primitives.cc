// A few small primitives for the tests of core/net; the real library is core/primitives and no test here needs it.
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::net {
namespace {

class TestAdd : public Primitive {
 public:
  explicit TestAdd(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Real>("out", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ + *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestAdd, "test", "Sum.");

class TestMultiply : public Primitive {
 public:
  explicit TestMultiply(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "v"})),
        out_(setup.out<Real>("out", {.unit = "u*v"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ * *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestMultiply, "test", "Product.");

/// Division, which makes null of its own.
class TestDivide : public Primitive {
 public:
  explicit TestDivide(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "v"})),
        out_(setup.out<Real>("out", {.unit = "u/v", .may_be_null = true})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ / *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestDivide, "test", "Quotient; null where it is not finite.");

/// State that begins at the first cycle: sum of all values so far.
class TestSum : public Primitive {
 public:
  explicit TestSum(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u", .on_null = OnNull::kHandled})),
        out_(setup.out<Real>("out", {.unit = "u"})),
        start_(setup.parameter<Real>("start", 0.0, {.unit = "u"})) {}
  void update(const Cycle& cycle) override {
    if (cycle.first) sum_ = start_;
    sum_ += in_.value_or(0.0);
    out_.set(sum_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  double start_, sum_ = 0.0;
};
TAKT_PRIMITIVE(TestSum, "test", "Sum over the cycles; null counts as 0.");

class TestConstant : public Primitive {
 public:
  explicit TestConstant(Setup& setup)
      : value_(setup.parameter<Real>("value")), out_(setup.out<Real>("out", {.unit = "u"})) {}
  void update(const Cycle&) override { out_.set(value_); }

 private:
  double value_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestConstant, "test", "A number.");

/// A source in metres, one in newtons.
class TestMetres : public Primitive {
 public:
  explicit TestMetres(Setup& setup) : out_(setup.out<Real>("out", {.unit = "m"})) {}
  void update(const Cycle& cycle) override { out_.set(static_cast<double>(cycle.index)); }

 private:
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestMetres, "test", "The cycle's number in metres.");

class TestNewtons : public Primitive {
 public:
  explicit TestNewtons(Setup& setup) : out_(setup.out<Real>("out", {.unit = "N"})) {}
  void update(const Cycle&) override { out_.set(1.0); }

 private:
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestNewtons, "test", "One newton.");

class TestForceSink : public Primitive {
 public:
  explicit TestForceSink(Setup& setup) : in_(setup.in<Real>("in", {.unit = "N", .on_null = OnNull::kStop})) {}
  void update(const Cycle& cycle) override {
    if (in_.null()) cycle.signals->fail_with(Cause::Code::kNullInput, "force is null", cycle.index);
  }

 private:
  In<Real> in_;
};
TAKT_PRIMITIVE(TestForceSink, "test", "Takes newtons; null stops the net.");

/// Counts cycles; null in every `null_every`-th.
class TestCounter : public Primitive {
 public:
  explicit TestCounter(Setup& setup)
      : out_(setup.out<Integer>("out", {.may_be_null = true})),
        null_every_(setup.parameter<Integer>("null_every", 1000000, {.range = "[1,1000000]"})) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override {
    if ((cycle.index_in_net + 1) % null_every_ == 0) return out_.set_null();
    out_.set(cycle.index_in_net);
  }

 private:
  Out<Integer> out_;
  Integer null_every_;
};
TAKT_PRIMITIVE(TestCounter, "test", "Cycle in the net.");

/// Values at the edges of what a number can be, one after the other; what is not finite becomes null at the port.
class TestExtremes : public Primitive {
 public:
  explicit TestExtremes(Setup& setup) : out_(setup.out<Real>("out", {.unit = "u", .may_be_null = true})) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override {
    using Limits = std::numeric_limits<double>;
    static constexpr std::array<double, 10> kValues = {
        -0.0, Limits::quiet_NaN(), Limits::denorm_min(), Limits::infinity(),     Limits::max(), -Limits::infinity(),
        1.0,  -Limits::min(),      Limits::lowest(),     Limits::signaling_NaN()};
    out_.set(kValues[static_cast<std::size_t>(cycle.index) % kValues.size()]);
  }

 private:
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestExtremes, "test", "NaN, infinities, denormals and the like by turns.");

/// A Boolean that changes all the time and is null now and then: what switches a fragment in random nets.
class TestBlink : public Primitive {
 public:
  explicit TestBlink(Setup& setup)
      : out_(setup.out<Boolean>("out", {.may_be_null = true})),
        on_(setup.parameter<Integer>("on", 1, {.doc = "cycles true", .range = "[1,100]"})),
        off_(setup.parameter<Integer>("off", 1, {.doc = "cycles false; the last of them null", .range = "[1,100]"})) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override {
    const std::int64_t at = cycle.index_in_net % (on_ + off_);
    if (at + 1 == on_ + off_) return out_.set_null();
    out_.set(at < on_);
  }

 private:
  Out<Boolean> out_;
  Integer on_, off_;
};
TAKT_PRIMITIVE(TestBlink, "test", "True for some cycles, then false, then null, and again.");

class TestToReal : public Primitive {
 public:
  explicit TestToReal(Setup& setup) : in_(setup.in<Integer>("in")), out_(setup.out<Real>("out", {.unit = "1"})) {}
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(static_cast<double>(*in_));
  }

 private:
  In<Integer> in_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestToReal, "test", "Integer to Real.");

class TestGreater : public Primitive {
 public:
  explicit TestGreater(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Boolean>("out")) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ > *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(TestGreater, "test", "a > b.");

/// Its input breaks loops: the value of the cycle before.
class TestPrevious : public Primitive {
 public:
  explicit TestPrevious(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u"})), out_(setup.out<Real>("out", {.unit = "u"})) {
    setup.breaks_loop("in");
  }
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestPrevious, "test", "One cycle ago.");

class TestThrow : public Primitive {
 public:
  explicit TestThrow(Setup& setup) : at_(setup.parameter<Integer>("at", 3)) {}
  void update(const Cycle& cycle) override {
    if (cycle.index_in_net == at_) throw std::runtime_error("broken on purpose");
  }

 private:
  Integer at_;
};
TAKT_PRIMITIVE(TestThrow, "test", "Throws in one cycle.");

class TestEnd : public Primitive {
 public:
  explicit TestEnd(Setup& setup) : in_(setup.in<Boolean>("in", {.on_null = OnNull::kCountsAsTrue, .optional = true})) {
    setup.is_termination();
  }
  void update(const Cycle& cycle) override {
    if (!in_.null() && *in_) cycle.signals->terminate = true;
  }

 private:
  In<Boolean> in_;
};
TAKT_PRIMITIVE(TestEnd, "test", "Ends the net.");

class TestMonitor : public Primitive {
 public:
  explicit TestMonitor(Setup& setup) : in_(setup.in<Real>("in", {.on_null = OnNull::kHandled})) { setup.is_monitor(); }
  void update(const Cycle&) override {}

 private:
  In<Real> in_;
};
TAKT_PRIMITIVE(TestMonitor, "test", "Shows a value.");

class TestDrive : public Primitive {
 public:
  explicit TestDrive(Setup& setup)
      : in_(setup.in<Real>("in", {.on_null = OnNull::kStop})),
        device_(setup.device<Resource>("device", "drive", "what moves")),
        speed_(setup.parameter<Real>("speed", {.unit = "m/s", .doc = "how fast", .range = "(0,inf)"})),
        mode_(setup.parameter<std::string>("mode", "slow", {.range = "slow|fast"})) {
    setup.claims("device");
  }
  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (mode_ == "fast" && speed_ < 1.0) diagnostics.error(Code::kOutOfRange, "/speed", "fast is at least 1 m/s");
    return diagnostics;
  }
  void update(const Cycle&) override {}

 private:
  In<Real> in_;
  Resource* device_;
  double speed_;
  std::string mode_;
};
TAKT_PRIMITIVE(TestDrive, "test", "Drives a device.");

/// One port of every type, passed through.
class TestAllTypes : public Primitive {
 public:
  explicit TestAllTypes(Setup& setup)
      : boolean_(setup, "boolean"),
        integer_(setup, "integer"),
        real_(setup, "real"),
        text_(setup, "text"),
        vector_(setup, "vector"),
        rotation_(setup, "rotation"),
        frame_(setup, "frame"),
        twist_(setup, "twist"),
        wrench_(setup, "wrench"),
        joints_(setup, "joints") {}
  void update(const Cycle&) override {
    boolean_.pass();
    integer_.pass();
    real_.pass();
    text_.pass();
    vector_.pass();
    rotation_.pass();
    frame_.pass();
    twist_.pass();
    wrench_.pass();
    joints_.pass();
  }

 private:
  template <class T>
  struct Pass {
    Pass(Setup& setup, const std::string& name)
        : in(setup.in<T>(name, {.on_null = OnNull::kMayPass, .optional = true})), out(setup.out<T>(name + "_out")) {}
    void pass() {
      if (in.null()) return out.set_null();
      out.set(*in);
    }
    In<T> in;
    Out<T> out;
  };
  Pass<Boolean> boolean_;
  Pass<Integer> integer_;
  Pass<Real> real_;
  Pass<Text> text_;
  Pass<Vector> vector_;
  Pass<Rotation> rotation_;
  Pass<Frame> frame_;
  Pass<Twist> twist_;
  Pass<Wrench> wrench_;
  Pass<JointArray> joints_;
};
TAKT_PRIMITIVE(TestAllTypes, "test", "Every type, passed through.");

class TestPose : public Primitive {
 public:
  explicit TestPose(Setup& setup)
      : in_(setup.parameter<std::string>("in", "")),
        of_(setup.parameter<std::string>("of", "")),
        out_(setup.out<Frame>("out", {.frame = "@in>@of"})) {}
  void update(const Cycle&) override { out_.set(Frame::Identity()); }

 private:
  std::string in_, of_;
  Out<Frame> out_;
};
TAKT_PRIMITIVE(TestPose, "test", "An identity with names.");

class TestCompose : public Primitive {
 public:
  explicit TestCompose(Setup& setup)
      : ab_(setup.in<Frame>("ab", {.frame = "A>B"})),
        bc_(setup.in<Frame>("bc", {.frame = "B>C"})),
        out_(setup.out<Frame>("out", {.frame = "A>C"})) {}
  void update(const Cycle&) override {
    if (ab_.null() || bc_.null()) return out_.set_null();
    out_.set(*ab_ * *bc_);
  }

 private:
  In<Frame> ab_, bc_;
  Out<Frame> out_;
};
TAKT_PRIMITIVE(TestCompose, "test", "Product of poses.");

class TestArmPose : public Primitive {
 public:
  explicit TestArmPose(Setup& setup) : flange_(setup.in<Frame>("flange", {.frame = "world>flange"})) {}
  void update(const Cycle&) override {}

 private:
  In<Frame> flange_;
};
TAKT_PRIMITIVE(TestArmPose, "test", "Takes the pose of the flange in the world.");

}  // namespace
}  // namespace takt::net
