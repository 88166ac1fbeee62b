// Family "null": where null is expected and what is made of it.
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
      : input_(setup.in<T>("input", free_spec<T>("value to check", OnNull::kHandled))),
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
      : input_(setup.in<T>("input", free_spec<T>("preferred", OnNull::kHandled))),
        fallback_(setup.in<T>("fallback", free_spec<T>("value where the input is null", OnNull::kMayPass))),
        value_(setup.out<T>("value", free_spec<T>("the input, else the fallback"))) {
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
      : input_(setup.in<T>("input", free_spec<T>("what is held", OnNull::kHandled))),
        value_(setup.out<T>("value", free_spec_may_be_null<T>("the newest value"))),
        cycles_(setup.parameter<Integer>(
            "cycles", {.doc = "most cycles of null that are bridged", .range = "[0,1e9]", .example = "2"})) {}

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
class Gate final : public Primitive {
 public:
  explicit Gate(Setup& setup)
      : input_(setup.in<T>("input", free_spec<T>("value to pass on"))),
        open_(setup.in<Boolean>("open", {.doc = "true: let through", .on_null = OnNull::kCountsAsFalse})),
        value_(setup.out<T>("value", free_spec_may_be_null<T>("the input while the gate is open"))) {
    if constexpr (std::is_same_v<T, Boolean>) setup.means("value", "input & open");
  }
  void update(const Cycle&) override {
    if (input_.null() || !open_.value_or(false)) return value_.set_null();
    value_.set(*input_);
  }

 private:
  In<T> input_;
  In<Boolean> open_;
  Out<T> value_;
};

TAKT_PRIMITIVE_FOR_ALL(IsNull, "null", "True if the input is null.");
TAKT_PRIMITIVE_FOR_ALL(DefaultTo, "null", "The input, or the fallback where the input is null.");
TAKT_PRIMITIVE_FOR_ALL(HoldLast, "null",
                       "The newest value that was not null, for at most the given number of cycles; then null. Null in "
                       "the first cycle if the input is.");
TAKT_PRIMITIVE_FOR_ALL(Gate, "null", "The input while the gate is open, else null.");

}  // namespace
}  // namespace takt::primitives
