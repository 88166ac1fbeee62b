// Family "selection": one of several values, by a condition or by number.
#include <array>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

template <class T>
In<T> choice(Setup& setup, std::string_view name, std::string_view doc, bool optional = false) {
  PortSpec spec = free_spec<T>(doc, OnNull::kMayPass);
  spec.optional = optional;
  return setup.in<T>(name, spec);
}

template <class T>
void hand_on(const In<T>& chosen, Out<T>& out) {
  if (chosen.null()) return out.set_null();
  out.set(*chosen);
}

template <class T>
class Select final : public Primitive {
 public:
  explicit Select(Setup& setup)
      : condition_(setup.in<Boolean>("condition", {.doc = "which of the two"})),
        if_true_(choice<T>(setup, "if_true", "given while the condition is true")),
        if_false_(choice<T>(setup, "if_false", "given while the condition is false")),
        value_(setup.out<T>("value", free_spec<T>("the chosen one"))) {
    if constexpr (std::is_same_v<T, Boolean>) setup.means("value", "condition & if_true | !condition & if_false");
  }

  void update(const Cycle&) override {
    if (condition_.null()) return value_.set_null();
    hand_on(*condition_ ? if_true_ : if_false_, value_);
  }

 private:
  In<Boolean> condition_;
  In<T> if_true_, if_false_;
  Out<T> value_;
};

template <class T>
class SelectByIndex final : public Primitive {
 public:
  explicit SelectByIndex(Setup& setup)
      : index_(setup.in<Integer>("index", {.doc = "which case", .on_null = OnNull::kHandled})),
        cases_{choice<T>(setup, "case_0", "given for index 0", true), choice<T>(setup, "case_1", "for index 1", true),
               choice<T>(setup, "case_2", "for index 2", true),       choice<T>(setup, "case_3", "for index 3", true),
               choice<T>(setup, "case_4", "for index 4", true),       choice<T>(setup, "case_5", "for index 5", true),
               choice<T>(setup, "case_6", "for index 6", true),       choice<T>(setup, "case_7", "for index 7", true)},
        otherwise_(choice<T>(setup, "otherwise", "for any other index and for null", true)),
        value_(setup.out<T>("value", free_spec_may_be_null<T>("the chosen one"))) {}

  void update(const Cycle&) override {
    const bool known = !index_.null() && *index_ >= 0 && *index_ < static_cast<Integer>(cases_.size());
    hand_on(known ? cases_[static_cast<std::size_t>(*index_)] : otherwise_, value_);
  }

 private:
  In<Integer> index_;
  std::array<In<T>, 8> cases_;
  In<T> otherwise_;
  Out<T> value_;
};

TAKT_PRIMITIVE_FOR_ALL(Select, "selection",
                       "One of two values; the one not chosen is ignored, also when it is null. A condition of null "
                       "gives null.");
TAKT_PRIMITIVE_FOR_ALL(SelectByIndex, "selection",
                       "One of up to eight values by number; those not chosen are ignored, also when they are null. A "
                       "case without a link is null.");

}  // namespace
}  // namespace takt::primitives
