// Family "path": geometry over the path parameter.
#include <string>
#include <string_view>
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
  JointOutputs(Setup& setup, const char* q_name, const char* dq_name, const char* ddq_name, const char* doc,
               bool may_be_null = false)
      : q(setup.out<JointArray>(q_name, {.unit = "rad", .doc = doc, .may_be_null = may_be_null})),
        dq(setup.out<JointArray>(dq_name, {.unit = "rad/s", .doc = "first derivative", .may_be_null = may_be_null})),
        ddq(setup.out<JointArray>(ddq_name,
                                  {.unit = "rad/s^2", .doc = "second derivative", .may_be_null = may_be_null})) {}
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
Diagnostics read_path(const nlohmann::ordered_json& json, P& path) {
  auto read = motion::path_from_json(json, "/path");
  if (!read) return std::move(read.error());
  if (auto* wanted = std::get_if<P>(&*read)) {
    path = std::move(*wanted);
    return {};
  }
  Diagnostics diagnostics;
  diagnostics.error(Code::kInvalidValue, "/path/kind", "this primitive follows another kind of path",
                    "Use the primitive of that kind");
  return diagnostics;
}

class JointLine final : public Primitive {
 public:
  explicit JointLine(Setup& setup)
      : at_(setup),
        joints_(setup, "q", "dq", "ddq", "joint positions"),
        json_(setup.json("path", {.doc = "{\"kind\": \"joint_line\", \"start\": [...], \"goal\": [...]} in rad or m",
                                  .example = R"({"kind": "joint_line", "start": [0.0, 1.0], "goal": [1.0, 0.0]})"})) {
    setup.costs(60.0);
  }

  Diagnostics prepare() override { return read_path(json_, line_); }

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

/// A frame in motion, and the joints that it leaves free.
struct FrameOutputs {
  FrameOutputs(Setup& setup, bool may_be_null)
      : frame(setup.out<Frame>(
            "frame", {.unit = "m", .doc = "pose of the moved frame M in base B", .may_be_null = may_be_null})),
        twist(setup.out<Twist>(
            "twist", {.unit = "m/s,rad/s", .doc = "velocity of M in B, expressed in B", .may_be_null = may_be_null})),
        acceleration(setup.out<Twist>(
            "acceleration",
            {.unit = "m/s^2,rad/s^2", .doc = "time derivative of the twist", .may_be_null = may_be_null})),
        held(setup, "held", "held_velocity", "held_acceleration", "joints that the frame leaves free", may_be_null) {}
  void set(const motion::FrameSample& sample, const motion::JointSample& held_joints) {
    frame.set(sample.X_BM);
    twist.set({.linear = sample.V_BM_B.head<3>(), .angular = sample.V_BM_B.tail<3>()});
    acceleration.set({.linear = sample.A_BM_B.head<3>(), .angular = sample.A_BM_B.tail<3>()});
    held.set(held_joints);
  }
  void set_null() {
    frame.set_null();
    twist.set_null();
    acceleration.set_null();
    held.set_null();
  }
  Out<Frame> frame;
  Out<Twist> twist, acceleration;
  JointOutputs held;
};

constexpr std::string_view kLineExample =
    R"({"kind": "cartesian_line", "start": [0.4, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0], )"
    R"("length_m": 0.1, "axis": [0.0, 0.0, 1.0], "angle_rad": 0.2, "held_start": [0.0], "held_goal": [0.1]})";
constexpr std::string_view kArcExample =
    R"({"kind": "cartesian_arc", "start": [0.4, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], "centre": [0.3, 0.0, 0.5], )"
    R"("normal": [0.0, 0.0, 1.0], "arc_rad": 1.0, "axis": [0.0, 0.0, 1.0], "angle_rad": 0.2, "held_start": [0.0], )"
    R"("held_goal": [0.1]})";
constexpr std::string_view kCompositeExample =
    R"({"kind": "composite", "pieces": [{"s": [0.0, 0.5], "own": [0.0, 1.0], "geometry": )"
    R"({"kind": "joint_line", "start": [0.0, 1.0], "goal": [1.0, 0.0]}}, {"s": [0.5, 1.0], "own": [0.0, 0.5], )"
    R"("geometry": {"kind": "cartesian_line", "start": [0.4, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], )"
    R"("direction": [1.0, 0.0, 0.0], "length_m": 0.1, "held_start": [0.0], "held_goal": [0.1]}}]})";

/// A path of one geometry P for a frame.
template <class P, const std::string_view& kExample>
class FramePath final : public Primitive {
 public:
  explicit FramePath(Setup& setup)
      : at_(setup),
        frame_(setup, false),
        json_(setup.json("path", {.doc = "{\"kind\": ..., ...} from the plan", .example = kExample})) {
    setup.costs(150.0);
  }

  Diagnostics prepare() override { return read_path(json_, path_); }

  void update(const Cycle&) override {
    if (at_.null()) return frame_.set_null();
    const auto point = at_.point();
    frame_.set(path_.sample(point), path_.held(point));
  }

 private:
  PathInputs at_;
  FrameOutputs frame_;
  nlohmann::ordered_json json_;
  P path_;
};
using CartesianLine = FramePath<motion::CartesianLine, kLineExample>;
using CartesianArc = FramePath<motion::CartesianArc, kArcExample>;

class CompositePath final : public Primitive {
 public:
  explicit CompositePath(Setup& setup)
      : at_(setup),
        joints_(setup, "q", "dq", "ddq", "joint positions; null on Cartesian pieces", true),
        frame_(setup, true),
        cartesian_(setup.out<Boolean>("cartesian", {.doc = "s lies in a Cartesian piece"})),
        json_(setup.json("path", {.doc = "{\"kind\": \"composite\", \"pieces\": [...]} from the plan",
                                  .example = kCompositeExample})) {}

  Diagnostics prepare() override { return read_path(json_, path_); }

  void update(const Cycle&) override {
    if (at_.null()) {
      joints_.set_null();
      frame_.set_null();
      return cartesian_.set_null();
    }
    const auto sample = path_.sample(at_.point());
    cartesian_.set(sample.cartesian);
    if (sample.cartesian) {
      joints_.set_null();
      frame_.set(sample.frame, sample.held);
    } else {
      joints_.set(sample.joints);
      frame_.set_null();
    }
  }

 private:
  PathInputs at_;
  JointOutputs joints_;
  FrameOutputs frame_;
  Out<Boolean> cartesian_;
  nlohmann::ordered_json json_;
  motion::CompositePath path_;
};

TAKT_PRIMITIVE(JointLine, "path",
               "All joints in proportion from start to goal: q = start + s (goal - start), and its derivatives. At "
               "s = 1 exactly the goal. The first cycle is like any other.");
TAKT_PRIMITIVE(CartesianLine, "path",
               "A frame on a straight line that turns about one fixed axis, with its twist and acceleration, and the "
               "joints that are held beside it. The first cycle is like any other.");
TAKT_PRIMITIVE(CartesianArc, "path",
               "A frame on a circle that turns about one fixed axis, with its twist and acceleration, and the joints "
               "that are held beside it. The first cycle is like any other.");
TAKT_PRIMITIVE(CompositePath, "path",
               "Pieces of lines, arcs, splines and blends one after the other: joints on joint pieces, a frame and its "
               "held joints on Cartesian ones, null instead of the other. The first cycle is like any other.");

}  // namespace
}  // namespace takt::primitives
