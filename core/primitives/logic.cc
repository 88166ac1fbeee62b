// Family "logic": three-valued, as Kleene's strong logic (row N2).
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

/// Two inputs "a" and "b" that handle null themselves, one output "value".
class TwoValued : public Primitive {
 protected:
  TwoValued(Setup& setup, OnNull on_null)
      : a_(setup.in<Boolean>("a", {.doc = "left side", .on_null = on_null})),
        b_(setup.in<Boolean>("b", {.doc = "right side", .on_null = on_null})),
        value_(setup.out<Boolean>("value", {.doc = "the result"})) {}
  [[nodiscard]] bool any_null() const { return a_.null() || b_.null(); }
  [[nodiscard]] bool any(bool value) const { return (!a_.null() && *a_ == value) || (!b_.null() && *b_ == value); }

  In<Boolean> a_, b_;
  Out<Boolean> value_;
};

class And final : public TwoValued {
 public:
  explicit And(Setup& setup) : TwoValued(setup, OnNull::kMayPass) {}
  void update(const Cycle&) override {
    if (any(false)) return value_.set(false);
    if (any_null()) return value_.set_null();
    value_.set(true);
  }
};

class Or final : public TwoValued {
 public:
  explicit Or(Setup& setup) : TwoValued(setup, OnNull::kMayPass) {}
  void update(const Cycle&) override {
    if (any(true)) return value_.set(true);
    if (any_null()) return value_.set_null();
    value_.set(false);
  }
};

class Xor final : public TwoValued {
 public:
  explicit Xor(Setup& setup) : TwoValued(setup, OnNull::kPropagate) {}
  void update(const Cycle&) override {
    if (any_null()) return value_.set_null();
    value_.set(*a_ != *b_);
  }
};

class Not final : public Primitive {
 public:
  explicit Not(Setup& setup)
      : input_(setup.in<Boolean>("input", {.doc = "what is turned round"})),
        value_(setup.out<Boolean>("value", {.doc = "the opposite"})) {}
  void update(const Cycle&) override {
    if (input_.null()) return value_.set_null();
    value_.set(!*input_);
  }

 private:
  In<Boolean> input_;
  Out<Boolean> value_;
};

TAKT_PRIMITIVE(And, "logic", "True if both are true; false if one is false, whatever the other; else null.");
TAKT_PRIMITIVE(Or, "logic", "True if one is true, whatever the other; false if both are false; else null.");
TAKT_PRIMITIVE(Xor, "logic", "True if exactly one is true; null if one is null.");
TAKT_PRIMITIVE(Not, "logic", "The opposite; null of null.");

TAKT_MEANING(And, "value", "a & b");
TAKT_MEANING(Or, "value", "a | b");
TAKT_MEANING(Xor, "value", "a ^ b");
TAKT_MEANING(Not, "value", "!input");

}  // namespace
}  // namespace takt::primitives
