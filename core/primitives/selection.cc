// Family "selection": one of two values.
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

constexpr PortSpec spec(const char* unit, const char* doc) {
  return {.unit = unit, .doc = doc, .on_null = OnNull::kHandled};
}

/// Types that carry no unit may not name one.
template <class T>
constexpr const char* unit() {
  constexpr bool kHasUnit = !std::is_same_v<T, Boolean> && !std::is_same_v<T, Integer> && !std::is_same_v<T, Text> &&
                            !std::is_same_v<T, Rotation> && !std::is_same_v<T, Frame>;
  return kHasUnit ? "u" : "";
}

template <class T>
class Select final : public Primitive {
 public:
  explicit Select(Setup& setup)
      : condition_(setup.in<Boolean>("condition", {.doc = "which of the two"})),
        if_true_(setup.in<T>("if_true", spec(unit<T>(), "given while the condition is true"))),
        if_false_(setup.in<T>("if_false", spec(unit<T>(), "given while the condition is false"))),
        value_(setup.out<T>("value", {.unit = unit<T>(), .doc = "the chosen one"})) {}

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

using SelectBoolean = Select<Boolean>;
using SelectInteger = Select<Integer>;
using SelectReal = Select<Real>;
using SelectVector = Select<Vector>;
using SelectFrame = Select<Frame>;
using SelectTwist = Select<Twist>;
using SelectWrench = Select<Wrench>;
using SelectJoints = Select<JointArray>;

constexpr const char* kDoc = "One of two values; the one not chosen is ignored, also when it is null.";
TAKT_PRIMITIVE(SelectBoolean, "selection", kDoc);
TAKT_PRIMITIVE(SelectInteger, "selection", kDoc);
TAKT_PRIMITIVE(SelectReal, "selection", kDoc);
TAKT_PRIMITIVE(SelectVector, "selection", kDoc);
TAKT_PRIMITIVE(SelectFrame, "selection", kDoc);
TAKT_PRIMITIVE(SelectTwist, "selection", kDoc);
TAKT_PRIMITIVE(SelectWrench, "selection", kDoc);
TAKT_PRIMITIVE(SelectJoints, "selection", kDoc);

}  // namespace
}  // namespace takt::primitives
