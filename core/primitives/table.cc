// Family "table": curves through given points.
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/motion/curve.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;
using motion::Curve;
using Json = nlohmann::ordered_json;

/// The parameters "points" and "form" of every table.
class Points {
 public:
  Points(Setup& setup, const char* doc, const char* example)
      : json_(setup.json("points", {.doc = doc, .example = example})),
        form_(setup.parameter<std::string>(
            "form", "linear",
            {.doc = "linear: straight lines; natural: cubic spline; rest: cubic spline with slope 0 at both ends",
             .range = "linear|natural|rest"})) {}

  Diagnostics read(Curve& curve) const {
    using enum Curve::Form;
    auto read = Curve::from_json(json_, form_ == "linear" ? kLinear : form_ == "rest" ? kRest : kNatural, "/points");
    if (!read) return std::move(read.error());
    curve = std::move(*read);
    return {};
  }

 private:
  Json json_;
  std::string form_;
};

class Table final : public Primitive {
 public:
  explicit Table(Setup& setup)
      : input_(setup.in<Real>("input", {.unit = "u", .doc = "where"})),
        value_(setup.out<Real>("value", {.unit = "v", .doc = "the curve there"})),
        slope_(setup.out<Real>("slope", {.unit = "v/u", .doc = "its slope there"})),
        inside_(setup.out<Boolean>("inside", {.doc = "the input lies between the first and the last point"})),
        points_(setup, "[[input, value], ...], input ascending", "[[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]]") {}

  Diagnostics prepare() override {
    Diagnostics diagnostics = points_.read(curve_);
    if (!diagnostics.has_errors() && curve_.dimension() != 1)
      diagnostics.error(Code::kWrongSize, "/points/0", "more than one value", "Give one pair [input, value]");
    return diagnostics;
  }

  void update(const Cycle&) override {
    if (input_.null()) {
      slope_.set_null();
      inside_.set_null();
      return value_.set_null();
    }
    const Curve::Sample sample = curve_.at(*input_);
    value_.set(sample.y[0]);
    slope_.set(sample.dy[0]);
    inside_.set(sample.inside);
  }

 private:
  In<Real> input_;
  Out<Real> value_, slope_;
  Out<Boolean> inside_;
  Points points_;
  Curve curve_;
};

class JointTable final : public Primitive {
 public:
  explicit JointTable(Setup& setup)
      : time_(setup.in<Real>("time", {.unit = "s", .doc = "path time, as a PathClock gives it"})),
        rate_(setup.in<Real>("rate", {.unit = "1", .doc = "path time per time"})),
        rate_derivative_(setup.in<Real>("rate_derivative", {.unit = "1/s", .doc = "change of the rate"})),
        q_(setup.out<JointArray>("q", {.unit = "rad", .doc = "joint positions"})),
        dq_(setup.out<JointArray>("dq", {.unit = "rad/s", .doc = "their velocities"})),
        ddq_(setup.out<JointArray>("ddq", {.unit = "rad/s^2", .doc = "their accelerations"})),
        inside_(setup.out<Boolean>("inside", {.doc = "the time lies between the first and the last point"})),
        points_(setup, "[[time in s, positions in rad ...], ...], time ascending",
                "[[0.0, 0.0, 0.5], [1.0, 1.0, 0.2], [2.0, 0.5, 0.0]]") {}

  Diagnostics prepare() override { return points_.read(curve_); }

  void update(const Cycle&) override {
    if (time_.null() || rate_.null() || rate_derivative_.null()) {
      q_.set_null();
      dq_.set_null();
      ddq_.set_null();
      return inside_.set_null();
    }
    const Curve::Sample sample = curve_.at(*time_);
    q_.set(JointArray(sample.y));
    dq_.set(JointArray(*rate_ * sample.dy));
    ddq_.set(JointArray(*rate_ * *rate_ * sample.ddy + *rate_derivative_ * sample.dy));
    inside_.set(sample.inside);
  }

 private:
  In<Real> time_, rate_, rate_derivative_;
  Out<JointArray> q_, dq_, ddq_;
  Out<Boolean> inside_;
  Points points_;
  Curve curve_;
};

TAKT_PRIMITIVE(Table, "table",
               "The value of a curve through given points, such as a characteristic; outside of them the first or last "
               "value, with slope 0.");
TAKT_PRIMITIVE(
    JointTable, "table",
    "Joint positions over path time, through given points, with their derivatives with respect to real time; "
    "outside of the points the first or last positions, at rest.");

}  // namespace
}  // namespace takt::primitives
