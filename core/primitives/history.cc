// Family "history": what was some cycles ago, at a trigger, or since a reset.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// The newest values of a signal, nulls included, in a ring that is allocated once.
template <class T>
class Ring {
 public:
  void allocate(std::int64_t capacity) { entries_.resize(static_cast<std::size_t>(capacity)); }
  void clear() { count_ = 0; }
  void push(const In<T>& in) {
    newest_ = newest_ + 1 < entries_.size() ? newest_ + 1 : 0;
    entries_[newest_] = {*in, in.null()};
    if (count_ < entries_.size()) ++count_;
  }
  /// The value of `ago` cycles ago (0 = the newest); nullptr if it was null or before the first.
  [[nodiscard]] const T* at(std::size_t ago) const {
    if (ago >= count_) return nullptr;
    const Entry& entry = entries_[ago <= newest_ ? newest_ - ago : newest_ + entries_.size() - ago];
    return entry.null ? nullptr : &entry.value;
  }
  [[nodiscard]] std::size_t capacity() const { return entries_.size(); }

 private:
  struct Entry {
    T value{};
    bool null = true;
  };
  std::vector<Entry> entries_;
  std::size_t newest_ = 0, count_ = 0;
};

template <class T>
class Delay final : public Primitive {
 public:
  explicit Delay(Setup& setup)
      : input_(setup.in<T>("input", free_spec<T>("value to delay", OnNull::kHandled))),
        value_(setup.out<T>("value", free_spec_may_be_null<T>("the input of that many cycles ago"))),
        cycles_(setup.parameter<Integer>("cycles", {.doc = "how many", .range = "[0,100000]", .example = "3"})) {
    setup.latency_by("input", "value", "cycles");
  }

  Diagnostics prepare() override {
    ring_.allocate(cycles_ + 1);
    return {};
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) ring_.clear();
    ring_.push(input_);
    const T* past = ring_.at(static_cast<std::size_t>(cycles_));
    if (past == nullptr) return value_.set_null();
    value_.set(*past);
  }

 private:
  In<T> input_;
  Out<T> value_;
  std::int64_t cycles_;
  Ring<T> ring_;
};

class ValueAgo final : public Primitive {
 public:
  explicit ValueAgo(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to store", .on_null = OnNull::kHandled})),
        ago_(setup.in<Real>("ago", {.unit = "s", .doc = "how long ago"})),
        value_(setup.out<Real>(
            "value", {.unit = "u", .doc = "the input at that time, linear between cycles", .may_be_null = true})),
        cycles_(setup.parameter<Integer>(
            "cycles", {.doc = "how many cycles are remembered", .range = "[1,100000]", .example = "100"})) {
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }

  Diagnostics prepare() override {
    ring_.allocate(cycles_ + 1);
    return {};
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) ring_.clear();
    ring_.push(input_);
    const double cycles_ago = *ago_ / cycle.dt;
    if (ago_.null() || !(cycles_ago >= 0.0 && cycles_ago <= static_cast<double>(cycles_))) return value_.set_null();
    const auto later = static_cast<std::size_t>(cycles_ago);
    const double share = cycles_ago - static_cast<double>(later);
    const Real* after = ring_.at(later);
    const Real* before = share > 0.0 ? ring_.at(later + 1) : after;
    if (after == nullptr || before == nullptr) return value_.set_null();
    value_.set(*after + share * (*before - *after));
  }

 private:
  In<Real> input_, ago_;
  Out<Real> value_;
  std::int64_t cycles_;
  Ring<Real> ring_;
};

template <class T>
class Snapshot final : public Primitive {
 public:
  explicit Snapshot(Setup& setup)
      : input_(setup.in<T>("input", free_spec<T>("value to store", OnNull::kHandled))),
        trigger_(setup.in<Boolean>("trigger", trigger_spec("remembers when it becomes true"))),
        value_(
            setup.out<T>("value", free_spec_may_be_null<T>("the input at the newest trigger; null before the first"))),
        taken_(setup.out<Boolean>("taken", {.doc = "a value was stored; never null"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first) taken_yet_ = kept_null_ = false;
    if (edge_.rises(cycle, trigger_)) take();
    taken_.set(taken_yet_);
    if (!taken_yet_ || kept_null_) return value_.set_null();
    value_.set(kept_);
  }

 private:
  void take() {
    taken_yet_ = true;
    kept_null_ = input_.null();
    kept_ = *input_;
  }

  In<T> input_;
  In<Boolean> trigger_;
  Out<T> value_;
  Out<Boolean> taken_;
  Trigger edge_;
  bool taken_yet_ = false, kept_null_ = false;
  T kept_{};
};

class Extremes final : public Primitive {
 public:
  explicit Extremes(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to watch", .on_null = OnNull::kHandled})),
        reset_(setup.in<Boolean>("reset", reset_spec("true: begins anew with this cycle's input"))),
        minimum_(setup.out<Real>(
            "minimum",
            {.unit = "u", .doc = "smallest since the reset; null before the first value", .may_be_null = true})),
        maximum_(setup.out<Real>(
            "maximum",
            {.unit = "u", .doc = "largest since the reset; null before the first value", .may_be_null = true})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first || reset_.value_or(false)) known_ = false;
    if (!input_.null()) {
      low_ = known_ ? std::min(low_, *input_) : *input_;
      high_ = known_ ? std::max(high_, *input_) : *input_;
      known_ = true;
    }
    if (!known_) {
      minimum_.set_null();
      return maximum_.set_null();
    }
    minimum_.set(low_);
    maximum_.set(high_);
  }

 private:
  In<Real> input_;
  In<Boolean> reset_;
  Out<Real> minimum_, maximum_;
  bool known_ = false;
  double low_ = 0.0, high_ = 0.0;
};

class Trace final : public Primitive {
 public:
  explicit Trace(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "value to record", .on_null = OnNull::kHandled})),
        record_(setup.in<Boolean>("record", trigger_spec("true: this cycle's input is recorded; a rising edge begins "
                                                         "a new recording"))),
        time_(setup.in<Real>("time", {.unit = "s",
                                      .doc = "time to read, 0 = the first recorded value",
                                      .on_null = OnNull::kHandled,
                                      .optional = true})),
        value_(setup.out<Real>(
            "value", {.unit = "u", .doc = "the recording at that time, linear between cycles", .may_be_null = true})),
        length_(setup.out<Real>("length", {.unit = "s", .doc = "time of the newest entry; never null"})),
        full_(setup.out<Boolean>("full", {.doc = "nothing more is recorded; never null"})),
        cycles_(setup.parameter<Integer>(
            "cycles", {.doc = "how many are recorded at most", .range = "[1,100000]", .example = "100"})) {
    setup.latency("input", "value", {.cycles = 0, .data_dependent = true});
  }

  Diagnostics prepare() override {
    entries_.resize(static_cast<std::size_t>(cycles_));
    return {};
  }

  void update(const Cycle& cycle) override {
    const bool begins = edge_.rises(cycle, record_);
    if (cycle.first || begins) count_ = 0;
    if (record_.value_or(false) && count_ < entries_.size()) entries_[count_++] = {*input_, input_.null()};
    length_.set(count_ == 0 ? 0.0 : static_cast<double>(count_ - 1) * cycle.dt);
    full_.set(count_ == entries_.size());
    read(cycle.dt);
  }

 private:
  void read(double dt) {
    const double place = *time_ / dt;
    if (time_.null() || count_ == 0 || !(place >= 0.0 && place <= static_cast<double>(count_ - 1)))
      return value_.set_null();
    const auto before = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(before);
    const Entry &a = entries_[before], &b = entries_[share > 0.0 ? before + 1 : before];
    if (a.null || b.null) return value_.set_null();
    value_.set(a.value + share * (b.value - a.value));
  }

  struct Entry {
    double value = 0.0;
    bool null = true;
  };
  In<Real> input_;
  In<Boolean> record_;
  In<Real> time_;
  Out<Real> value_, length_;
  Out<Boolean> full_;
  std::int64_t cycles_;
  Trigger edge_;
  std::vector<Entry> entries_;
  std::size_t count_ = 0;
};

TAKT_PRIMITIVE_FOR_ALL(Delay, "history",
                       "The value of a number of cycles ago, null as it was; null in as many first cycles. Unlike a "
                       "delayed link it breaks no cycle of links.");
TAKT_PRIMITIVE(ValueAgo, "history",
               "The value of some time ago, linear between two cycles. Null where one of the two was null, before the "
               "first cycle, for times in the future and for times longer ago than is remembered.");
TAKT_PRIMITIVE_FOR_ALL(Snapshot, "history",
                       "Remembers the input of the cycle in which the trigger became true; true in the first cycle "
                       "counts as such.");
TAKT_PRIMITIVE(Extremes, "history",
               "Smallest and largest value since the reset or the first cycle; null does not count.");
TAKT_PRIMITIVE(Trace, "history",
               "Records a signal on request, and plays back its value at any time of the recording. Null outside of "
               "the recording, and where null was recorded.");

}  // namespace
}  // namespace takt::primitives
