// Family "net": how a net ends, is asked to end, and shows values.
#include <string>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

/// A Boolean that stops something: null counts as true unless the net says otherwise (row N3).
Flag stop_condition(Setup& setup) {
  return setup.flag("condition", {.doc = "true: it happens", .on_null = OnNull::kCountsAsTrue});
}

class Termination final : public Primitive {
 public:
  explicit Termination(Setup& setup) : condition_(stop_condition(setup)) { setup.is_termination(); }
  void update(const Cycle& cycle) override {
    if (condition_.holds()) cycle.signals->terminate = true;
  }

 private:
  Flag condition_;
};

class Error final : public Primitive {
 public:
  explicit Error(Setup& setup)
      : condition_(stop_condition(setup)),
        text_(setup.parameter<Text>("text", {.doc = "cause for people, at most 63 bytes", .example = R"("it broke")"})),
        conflict_(setup.parameter<std::string>("cause", "error",
                                               {.doc = "conflict: two want one device", .range = "error|conflict"}) ==
                  "conflict") {}
  void update(const Cycle& cycle) override {
    if (!condition_.holds()) return;
    cycle.signals->fail_with(conflict_ ? Cause::Code::kConflict : Cause::Code::kError, text_.view(), cycle.index);
  }

 private:
  Flag condition_;
  Text text_;
  bool conflict_;
};

class Cancel final : public Primitive {
 public:
  explicit Cancel(Setup& setup)
      : requested_(setup.out<Boolean>("requested", {.doc = "true from the first cycle after the cancel on"})) {
    setup.is_source();
    setup.is_cancel("bound");
    (void)setup.parameter<Real>("bound", 0.0,
                                {.unit = "s",
                                 .doc = "longest time from a cancel to the end of the net, which is aborted then; 0: "
                                        "computed from the net",
                                 .range = "[0,inf)"});
  }
  void update(const Cycle& cycle) override { requested_.set(cycle.cancel_requested); }

 private:
  Out<Boolean> requested_;
};

template <class T>
class Monitor final : public Primitive {
 public:
  explicit Monitor(Setup& setup) : value_(setup.in<T>("value", free_spec<T>("value to show", OnNull::kHandled))) {
    setup.is_monitor();
  }
  void update(const Cycle&) override {}

 private:
  In<T> value_;
};

TAKT_PRIMITIVE(Termination, "net", "Ends the net in the cycle in which its condition is true or null.");
TAKT_PRIMITIVE(Error, "net", "Ends the net with an error: its devices stop. Null counts as true.");
TAKT_PRIMITIVE(
    Cancel, "net",
    "Says that the net is asked to end; false in the first cycle, unless its cancel was posted with its start.");

TAKT_PRIMITIVE_FOR_ALL(Monitor, "net", "Shows a value outside the net under the primitive's id. Does nothing else.");

}  // namespace
}  // namespace takt::primitives
