// A plug-in of a few lines; definitions make it a good or a faulty one (CMakeLists.txt beside the tests).
#include "core/plugin/plugin.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace {

using namespace takt::net;

/// One input, one output, the factor between them as a parameter.
class SampleGain final : public Primitive {
 public:
  explicit SampleGain(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u", .doc = "signal"})),
        out_(setup.out<Real>("out", {.unit = "u", .doc = "factor * in"})),
        factor_(setup.parameter<Real>("factor", {.unit = "1", .doc = "factor", .range = "(0,inf)"})) {}
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(*in_ * factor_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  double factor_;
};

using SampleOther = SampleGain;

/// Its unit is none.
class SampleBroken final : public Primitive {
 public:
  explicit SampleBroken(Setup& setup) : out_(setup.out<Real>("out", {.unit = "furlong//", .doc = "nothing"})) {}
  void update(const Cycle&) override { out_.set_null(); }

 private:
  Out<Real> out_;
};

#ifdef SAMPLE_GAIN
TAKT_PRIMITIVE(SampleGain, "sample", "A signal times a factor.");
#endif
#ifdef SAMPLE_OTHER
TAKT_PRIMITIVE(SampleOther, "sample", "A signal times a factor.");
#endif
#ifdef SAMPLE_BROKEN
TAKT_PRIMITIVE(SampleBroken, "sample", "Nothing.");
#endif

}  // namespace

#ifdef SAMPLE_OTHER_AGAIN
namespace again {
namespace {
using SampleOther = ::SampleBroken;
TAKT_PRIMITIVE(SampleOther, "sample", "The name of the other.");
}  // namespace
}  // namespace again
#endif

#ifdef SAMPLE_LACKS_SYMBOL
namespace takt::net {
double a_function_of_another_takt(double value);
}
extern "C" double sample_call(double value) { return takt::net::a_function_of_another_takt(value); }
#endif

#ifndef SAMPLE_NO_PLUGIN
TAKT_PLUGIN(SAMPLE_NAME, "1.2.3");
#endif
