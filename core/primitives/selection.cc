// Family "selection": one of two values.
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr PortSpec spec(const char* unit, const char* doc) {
  return {.unit = unit, .doc = doc, .on_null = OnNull::kMayPass};
}

template <class T>
class Select final : public Primitive {
 public:
  explicit Select(Setup& setup)
      : condition_(setup.in<Boolean>("condition", {.doc = "which of the two"})),
        if_true_(setup.in<T>("if_true", spec(free_unit<T>(), "given while the condition is true"))),
        if_false_(setup.in<T>("if_false", spec(free_unit<T>(), "given while the condition is false"))),
        value_(setup.out<T>("value", {.unit = free_unit<T>(), .doc = "the chosen one"})) {
    if constexpr (std::is_same_v<T, Boolean>) setup.means("value", "condition & if_true | !condition & if_false");
  }

  void update(const Cycle&) override {
    if (condition_.null()) return value_.set_null();
    const In<T>& chosen = *condition_ ? if_true_ : if_false_;
    if (chosen.null()) return value_.set_null();
    value_.set(*chosen);
  }

 private:
  In<Boolean> condition_;
  In<T> if_true_, if_false_;
  Out<T> value_;
};

TAKT_PRIMITIVE_FOR_ALL(Select, "selection",
                       "One of two values; the one not chosen is ignored, also when it is null. A condition of null "
                       "gives null.");

}  // namespace
}  // namespace takt::primitives
