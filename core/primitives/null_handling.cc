// Family "null": where null is expected and what is made of it; constants and memories of any type.
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

template <class T>
class IsNull final : public Primitive {
 public:
  explicit IsNull(Setup& setup)
      : input_(setup.in<T>("input", {.unit = free_unit<T>(), .doc = "what is looked at", .on_null = OnNull::kHandled})),
        value_(setup.out<Boolean>("value", {.doc = "true if the input is null; never null"})) {
    setup.means("value", "null(input)");
  }
  void update(const Cycle&) override { value_.set(input_.null()); }

 private:
  In<T> input_;
  Out<Boolean> value_;
};

template <class T>
class DefaultTo final : public Primitive {
 public:
  explicit DefaultTo(Setup& setup)
      : input_(setup.in<T>("input", {.unit = free_unit<T>(), .doc = "preferred", .on_null = OnNull::kHandled})),
        fallback_(setup.in<T>(
            "fallback", {.unit = free_unit<T>(), .doc = "taken where the input is null", .on_null = OnNull::kMayPass})),
        value_(setup.out<T>("value", {.unit = free_unit<T>(), .doc = "the input, else the fallback"})) {
    if constexpr (std::is_same_v<T, Boolean>) setup.means("value", "input ?? fallback");
  }
  void update(const Cycle&) override {
    const In<T>& chosen = input_.null() ? fallback_ : input_;
    if (chosen.null()) return value_.set_null();
    value_.set(*chosen);
  }

 private:
  In<T> input_, fallback_;
  Out<T> value_;
};

template <class T>
class HoldLast final : public Primitive {
 public:
  explicit HoldLast(Setup& setup)
      : input_(setup.in<T>("input", {.unit = free_unit<T>(), .doc = "what is held", .on_null = OnNull::kHandled})),
        value_(setup.out<T>("value", {.unit = free_unit<T>(), .doc = "the newest value", .may_be_null = true})),
        cycles_(
            setup.parameter<Integer>("cycles", {.doc = "most cycles of null that are bridged", .range = "[0,1e9]"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first) left_ = 0;
    if (!input_.null()) {
      last_ = *input_;
      left_ = cycles_;
      return value_.set(last_);
    }
    if (left_ == 0) return value_.set_null();
    --left_;
    value_.set(last_);
  }

 private:
  In<T> input_;
  Out<T> value_;
  std::int64_t cycles_;
  std::int64_t left_ = 0;
  T last_{};
};

template <class T>
class Constant final : public Primitive {
 public:
  explicit Constant(Setup& setup)
      : value_(setup.out<T>("value", {.unit = free_unit<T>(), .doc = "always the same"})),
        constant_(setup.parameter<T>("value", {.doc = "what is given"})) {}
  void update(const Cycle&) override { value_.set(constant_); }

 private:
  Out<T> value_;
  T constant_;
};

template <class T>
class Snapshot final : public Primitive {
 public:
  explicit Snapshot(Setup& setup)
      : input_(
            setup.in<T>("input", {.unit = free_unit<T>(), .doc = "what is remembered", .on_null = OnNull::kHandled})),
        trigger_(
            setup.in<Boolean>("trigger", {.doc = "remembers when it becomes true", .on_null = OnNull::kCountsAsFalse})),
        value_(setup.out<T>("value", {.unit = free_unit<T>(),
                                      .doc = "the input at the newest trigger; null before the first",
                                      .may_be_null = true})),
        taken_(setup.out<Boolean>("taken", {.doc = "a value was taken; never null"})) {}

  void update(const Cycle& cycle) override {
    if (cycle.first) before_ = taken_yet_ = kept_null_ = false;
    const bool now = trigger_.value_or(false);
    if (now && !before_) take();
    before_ = now;
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
  bool before_ = false, taken_yet_ = false, kept_null_ = false;
  T kept_{};
};

TAKT_PRIMITIVE_FOR_ALL(IsNull, "null", "True if the input is null.");
TAKT_PRIMITIVE_FOR_ALL(DefaultTo, "null", "The input, or the fallback where the input is null.");
TAKT_PRIMITIVE_FOR_ALL(HoldLast, "null",
                       "The newest value that was not null, for at most the given number of cycles; then null. Null in "
                       "the first cycle if the input is.");
TAKT_PRIMITIVE_FOR_ALL(Constant, "null", "A value that never changes.");
TAKT_PRIMITIVE_FOR_ALL(Snapshot, "null",
                       "Remembers the input of the cycle in which the trigger became true; true in the first cycle "
                       "counts as such.");

}  // namespace
}  // namespace takt::primitives
