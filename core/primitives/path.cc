// Family "path": geometry over the path parameter.
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/motion/path.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

/// The three inputs of every path: where on it, and how fast.
struct PathInputs {
  explicit PathInputs(Setup& setup)
      : s(setup.in<Real>("s", {.unit = "1", .doc = "path parameter in [0, 1]"})),
        ds(setup.in<Real>("ds", {.unit = "1/s", .doc = "its first derivative"})),
        dds(setup.in<Real>("dds", {.unit = "1/s^2", .doc = "its second derivative"})) {}
  [[nodiscard]] bool null() const { return s.null() || ds.null() || dds.null(); }
  [[nodiscard]] motion::PathPoint point() const { return {.s = *s, .ds = *ds, .dds = *dds}; }
  In<Real> s, ds, dds;
};

/// Positions of joints and their derivatives.
struct JointOutputs {
  JointOutputs(Setup& setup, const char* q_name, const char* dq_name, const char* ddq_name, const char* doc)
      : q(setup.out<JointArray>(q_name, {.unit = "rad", .doc = doc})),
        dq(setup.out<JointArray>(dq_name, {.unit = "rad/s", .doc = "first derivative"})),
        ddq(setup.out<JointArray>(ddq_name, {.unit = "rad/s^2", .doc = "second derivative"})) {}
  void set(const motion::JointSample& sample) {
    q.set(JointArray(sample.q));
    dq.set(JointArray(sample.dq));
    ddq.set(JointArray(sample.ddq));
  }
  void set_null() {
    q.set_null();
    dq.set_null();
    ddq.set_null();
  }
  Out<JointArray> q, dq, ddq;
};

/// Reads a path of kind P from parameter "path".
template <class P>
Findings read_path(const nlohmann::ordered_json& json, P& path) {
  auto read = motion::path_from_json(json, "/path");
  if (!read) return std::move(read.error());
  if (auto* wanted = std::get_if<P>(&*read)) {
    path = std::move(*wanted);
    return {};
  }
  Findings findings;
  findings.error("/path/kind", "this primitive follows another kind of path", "use the primitive of that kind");
  return findings;
}

class JointLine final : public Primitive {
 public:
  explicit JointLine(Setup& setup)
      : at_(setup),
        joints_(setup, "q", "dq", "ddq", "joint positions"),
        json_(setup.json("path", {.doc = "{\"kind\": \"joint_line\", \"start\": [...], \"goal\": [...]} in rad or m",
                                  .example = R"({"kind": "joint_line", "start": [0.0, 1.0], "goal": [1.0, 0.0]})"})) {}

  Findings prepare() override { return read_path(json_, line_); }

  void update(const Cycle&) override {
    if (at_.null()) return joints_.set_null();
    joints_.set(line_.sample(at_.point()));
  }

 private:
  PathInputs at_;
  JointOutputs joints_;
  nlohmann::ordered_json json_;
  motion::JointLine line_;
};

constexpr std::string_view kCartesianExample =
    R"({"kind": "cartesian_line", "start": [0.4, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0], )"
    R"("length_m": 0.1, "axis": [0.0, 0.0, 1.0], "angle_rad": 0.2, "held_start": [0.0], "held_goal": [0.1]})";

class CartesianLine final : public Primitive {
 public:
  explicit CartesianLine(Setup& setup)
      : at_(setup),
        frame_(setup.out<Frame>("frame", {.unit = "m", .doc = "pose of the moved frame M in base B"})),
        twist_(setup.out<Twist>("twist", {.unit = "m/s,rad/s", .doc = "velocity of M in B, expressed in B"})),
        acceleration_(
            setup.out<Twist>("acceleration", {.unit = "m/s^2,rad/s^2", .doc = "time derivative of the twist"})),
        held_(setup, "held", "held_velocity", "held_acceleration", "joints that the frame leaves free"),
        json_(setup.json("path",
                         {.doc = "{\"kind\": \"cartesian_line\", ...} from the plan", .example = kCartesianExample})) {}

  Findings prepare() override { return read_path(json_, line_); }

  void update(const Cycle&) override {
    if (at_.null()) {
      frame_.set_null();
      twist_.set_null();
      acceleration_.set_null();
      return held_.set_null();
    }
    const auto point = at_.point();
    const auto sample = line_.sample(point);
    frame_.set(sample.X_BM);
    twist_.set({.linear = sample.V_BM_B.head<3>(), .angular = sample.V_BM_B.tail<3>()});
    acceleration_.set({.linear = sample.A_BM_B.head<3>(), .angular = sample.A_BM_B.tail<3>()});
    held_.set(line_.held(point));
  }

 private:
  PathInputs at_;
  Out<Frame> frame_;
  Out<Twist> twist_, acceleration_;
  JointOutputs held_;
  nlohmann::ordered_json json_;
  motion::CartesianLine line_;
};

TAKT_PRIMITIVE(JointLine, "path",
               "All joints in proportion from start to goal: q = start + s (goal - start), and its derivatives. At "
               "s = 1 exactly the goal. The first cycle is like any other.");
TAKT_PRIMITIVE(CartesianLine, "path",
               "A frame on a straight line that turns about one fixed axis, with its twist and acceleration, and the "
               "joints that are held beside it. The first cycle is like any other.");

}  // namespace
}  // namespace takt::primitives
