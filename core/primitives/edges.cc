// Family "edge": the cycle in which something changes.
#include <type_traits>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

enum class Way { kRising, kFalling, kAny };

/// True in the cycle of the edge. What was before the first cycle counts as false, as in the triggers of IEC 61131-3;
/// null before an edge hides it.
template <Way way>
class Edge : public Primitive {
 public:
  explicit Edge(Setup& setup)
      : input_(setup.in<Boolean>("input", {.doc = "value to watch"})),
        value_(setup.out<Boolean>("value", {.doc = "true in the cycle of the edge"})) {
    if (way != Way::kAny) setup.means("value", way == Way::kRising ? "input & ?" : "!input & ?");
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) {
      before_ = false;
      known_ = true;
    }
    if (input_.null()) {
      known_ = false;
      return value_.set_null();
    }
    const bool changed = known_ && *input_ != before_;
    value_.set(changed && (way == Way::kAny || *input_ == (way == Way::kRising)));
    before_ = *input_;
    known_ = true;
  }

 private:
  In<Boolean> input_;
  Out<Boolean> value_;
  bool before_ = false, known_ = true;
};

using RisingEdge = Edge<Way::kRising>;
using FallingEdge = Edge<Way::kFalling>;
using AnyEdge = Edge<Way::kAny>;

/// True where the value is another than that of the last cycle.
template <class T>
class Changed : public Primitive {
 public:
  explicit Changed(Setup& setup)
      : input_(setup.in<T>("input", {.doc = "value to watch"})),
        value_(setup.out<Boolean>("value", {.doc = "true in the cycle of the change"})) {}

  void update(const Cycle& cycle) override {
    const bool known = known_ && !cycle.first;
    known_ = !input_.null();
    if (!known_) return value_.set_null();
    value_.set(known && !same(*input_, before_));
    before_ = *input_;
  }

 private:
  static bool same(const T& a, const T& b) {
    if constexpr (std::is_same_v<T, Text>) {
      return a.view() == b.view();
    } else {
      return a == b;
    }
  }

  In<T> input_;
  Out<Boolean> value_;
  T before_{};
  bool known_ = false;
};

using ChangedInteger = Changed<Integer>;
using ChangedString = Changed<Text>;

TAKT_PRIMITIVE(
    RisingEdge, "edge",
    "True in the cycle in which the input becomes true. Before the first cycle it counts as false; from null "
    "to true is not an edge.");
TAKT_PRIMITIVE(FallingEdge, "edge",
               "True in the cycle in which the input becomes false. Before the first cycle it counts as false; from "
               "null to false is not an edge.");
TAKT_PRIMITIVE(AnyEdge, "edge",
               "True in the cycle in which the input changes. Before the first cycle it counts as false; from null to "
               "anything is not an edge.");
TAKT_PRIMITIVE(
    ChangedInteger, "edge",
    "True in the cycle in which the number is another than before; false in the first cycle and after null.");
TAKT_PRIMITIVE(ChangedString, "edge",
               "True in the cycle in which the text is another than before; false in the first cycle and after null.");

}  // namespace
}  // namespace takt::primitives
