// Family "geometry": vectors, rotations, frames, twists, wrenches. Names of frames: X_AB is the pose of B in A.
#include <cmath>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

/// What a function from two inputs says of its ports.
struct Names {
  const char *a, *b;
  PortSpec a_spec, b_spec, value_spec;
};

constexpr double kCost_ns = 20.0;  // a composition of two frames

/// value = F::of(a, b), null if one is null.
template <class F, class A, class B, class R>
class Function2 : public Primitive {
 public:
  explicit Function2(Setup& setup)
      : a_(setup.in<A>(F::kNames.a, F::kNames.a_spec)),
        b_(setup.in<B>(F::kNames.b, F::kNames.b_spec)),
        value_(setup.out<R>("value", F::kNames.value_spec)) {
    setup.costs(kCost_ns);
  }
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return value_.set_null();
    value_.set(F::of(*a_, *b_));
  }

 private:
  In<A> a_;
  In<B> b_;
  Out<R> value_;
};

/// value = F::of(input), null of null.
template <class F, class A, class R>
class Function1 : public Primitive {
 public:
  explicit Function1(Setup& setup) : input_(setup.in<A>("input", F::kInput)), value_(setup.out<R>("value", F::kValue)) {
    setup.costs(kCost_ns);
  }
  void update(const Cycle&) override {
    if (input_.null()) return value_.set_null();
    value_.set(F::of(*input_));
  }

 private:
  In<A> input_;
  Out<R> value_;
};

// -- Vectors ----------------------------------------------------------------------------------------------------------

struct AddVectorsOf {
  static constexpr Names kNames = {
      "a", "b", {.unit = "u", .doc = "left side"}, {.unit = "u", .doc = "right side"}, {.unit = "u", .doc = "a + b"}};
  static Vector of(const Vector& a, const Vector& b) { return a + b; }
};
struct SubtractVectorsOf {
  static constexpr Names kNames = {
      "a", "b", {.unit = "u", .doc = "left side"}, {.unit = "u", .doc = "right side"}, {.unit = "u", .doc = "a - b"}};
  static Vector of(const Vector& a, const Vector& b) { return a - b; }
};
struct ScaleVectorOf {
  static constexpr Names kNames = {"vector",
                                   "factor",
                                   {.unit = "u", .doc = "what is scaled"},
                                   {.unit = "v", .doc = "by how much"},
                                   {.unit = "u*v", .doc = "factor * vector"}};
  static Vector of(const Vector& a, double b) { return b * a; }
};
struct DotProductOf {
  static constexpr Names kNames = {"a",
                                   "b",
                                   {.unit = "u", .doc = "left side"},
                                   {.unit = "v", .doc = "right side"},
                                   {.unit = "u*v", .doc = "scalar product"}};
  static double of(const Vector& a, const Vector& b) { return a.dot(b); }
};
struct CrossProductOf {
  static constexpr Names kNames = {"a",
                                   "b",
                                   {.unit = "u", .doc = "left side"},
                                   {.unit = "v", .doc = "right side"},
                                   {.unit = "u*v", .doc = "vector product"}};
  static Vector of(const Vector& a, const Vector& b) { return a.cross(b); }
};
struct NormOf {
  static constexpr PortSpec kInput = {.unit = "u", .doc = "a vector"}, kValue = {.unit = "u", .doc = "its length"};
  static double of(const Vector& v) { return v.norm(); }
};

class VectorComponents final : public Primitive {
 public:
  explicit VectorComponents(Setup& setup)
      : input_(setup.in<Vector>("input", {.unit = "u", .doc = "a vector"})),
        out_{setup.out<Real>("x", {.unit = "u", .doc = "first component"}),
             setup.out<Real>("y", {.unit = "u", .doc = "second component"}),
             setup.out<Real>("z", {.unit = "u", .doc = "third component"})} {}
  void update(const Cycle&) override {
    for (int i = 0; i < 3; ++i) {
      if (input_.null()) {
        out_[i].set_null();
      } else {
        out_[i].set((*input_)[i]);
      }
    }
  }

 private:
  In<Vector> input_;
  Out<Real> out_[3];
};

class AssembleVector final : public Primitive {
 public:
  explicit AssembleVector(Setup& setup)
      : in_{setup.in<Real>("x", {.unit = "u", .doc = "first component"}),
            setup.in<Real>("y", {.unit = "u", .doc = "second component"}),
            setup.in<Real>("z", {.unit = "u", .doc = "third component"})},
        value_(setup.out<Vector>("value", {.unit = "u", .doc = "the vector"})) {}
  void update(const Cycle&) override {
    if (in_[0].null() || in_[1].null() || in_[2].null()) return value_.set_null();
    value_.set({*in_[0], *in_[1], *in_[2]});
  }

 private:
  In<Real> in_[3];
  Out<Vector> value_;
};

// -- Frames and rotations ---------------------------------------------------------------------------------------------

struct ComposeOf {
  static constexpr Names kNames = {"left",
                                   "right",
                                   {.unit = "m", .frame = "A>B", .doc = "X_AB"},
                                   {.unit = "m", .frame = "B>C", .doc = "X_BC"},
                                   {.unit = "m", .frame = "A>C", .doc = "X_AC = X_AB X_BC"}};
  static Frame of(const Frame& X_AB, const Frame& X_BC) { return X_AB * X_BC; }
};
struct InverseOf {
  static constexpr PortSpec kInput = {.unit = "m", .frame = "A>B", .doc = "X_AB"},
                            kValue = {.unit = "m", .frame = "B>A", .doc = "X_BA"};
  static Frame of(const Frame& X_AB) { return X_AB.inverse(); }
};
struct TransformPointOf {
  static constexpr Names kNames = {"frame",
                                   "point",
                                   {.unit = "m", .frame = "A>B", .doc = "X_AB"},
                                   {.unit = "m", .frame = "B", .doc = "a point seen from B"},
                                   {.unit = "m", .frame = "A", .doc = "the same point seen from A"}};
  static Vector of(const Frame& X_AB, const Vector& p_B) { return X_AB * p_B; }
};
struct RotateVectorOf {
  static constexpr Names kNames = {"frame",
                                   "vector",
                                   {.unit = "m", .frame = "A>B", .doc = "X_AB"},
                                   {.unit = "u", .frame = "B", .doc = "a vector in the axes of B"},
                                   {.unit = "u", .frame = "A", .doc = "the same in the axes of A"}};
  static Vector of(const Frame& X_AB, const Vector& v_B) { return X_AB.linear() * v_B; }
};
struct AssembleFrameOf {
  static constexpr Names kNames = {
      "position", "rotation", {.unit = "m", .doc = "origin"}, {.doc = "axes"}, {.unit = "m", .doc = "the frame"}};
  static Frame of(const Vector& p, const Rotation& R) {
    Frame frame = Frame::Identity();
    frame.linear() = R.toRotationMatrix();
    frame.translation() = p;
    return frame;
  }
};

class FrameComponents final : public Primitive {
 public:
  explicit FrameComponents(Setup& setup)
      : input_(setup.in<Frame>("input", {.unit = "m", .doc = "a frame"})),
        position_(setup.out<Vector>("position", {.unit = "m", .doc = "its origin"})),
        rotation_(setup.out<Rotation>("rotation", {.doc = "its axes, w >= 0"})) {}
  void update(const Cycle&) override {
    if (input_.null()) {
      position_.set_null();
      return rotation_.set_null();
    }
    Rotation R(input_->linear());
    if (R.w() < 0.0) R.coeffs() = -R.coeffs();
    position_.set(input_->translation());
    rotation_.set(R);
  }

 private:
  In<Frame> input_;
  Out<Vector> position_;
  Out<Rotation> rotation_;
};

// -- Twists and wrenches ----------------------------------------------------------------------------------------------

struct TransformWrenchOf {
  static constexpr Names kNames = {
      "frame",
      "wrench",
      {.unit = "m", .frame = "A>B", .doc = "X_AB"},
      {.unit = "N,N*m", .frame = "B", .doc = "about the origin of B, in its axes"},
      {.unit = "N,N*m", .frame = "A", .doc = "the same about the origin of A, in its axes"}};
  static Wrench of(const Frame& X_AB, const Wrench& w) {
    const Vector force = X_AB.linear() * w.force;
    return {.force = force, .torque = X_AB.linear() * w.torque + X_AB.translation().cross(force)};
  }
};
struct AddWrenchesOf {
  static constexpr Names kNames = {"a",
                                   "b",
                                   {.unit = "N,N*m", .doc = "left side"},
                                   {.unit = "N,N*m", .doc = "right side"},
                                   {.unit = "N,N*m", .doc = "a + b"}};
  static Wrench of(const Wrench& a, const Wrench& b) {
    return {.force = a.force + b.force, .torque = a.torque + b.torque};
  }
};
struct SubtractWrenchesOf {
  static constexpr Names kNames = {"a",
                                   "b",
                                   {.unit = "N,N*m", .doc = "left side"},
                                   {.unit = "N,N*m", .doc = "right side"},
                                   {.unit = "N,N*m", .doc = "a - b"}};
  static Wrench of(const Wrench& a, const Wrench& b) {
    return {.force = a.force - b.force, .torque = a.torque - b.torque};
  }
};
struct AssembleWrenchOf {
  static constexpr Names kNames = {"force",
                                   "torque",
                                   {.unit = "N", .doc = "force"},
                                   {.unit = "N*m", .doc = "torque"},
                                   {.unit = "N,N*m", .doc = "the wrench"}};
  static Wrench of(const Vector& force, const Vector& torque) { return {.force = force, .torque = torque}; }
};
struct AssembleTwistOf {
  static constexpr Names kNames = {"linear",
                                   "angular",
                                   {.unit = "m/s", .doc = "velocity of the origin"},
                                   {.unit = "rad/s", .doc = "angular velocity"},
                                   {.unit = "m/s,rad/s", .doc = "the twist"}};
  static Twist of(const Vector& linear, const Vector& angular) { return {.linear = linear, .angular = angular}; }
};

class WrenchComponents final : public Primitive {
 public:
  explicit WrenchComponents(Setup& setup)
      : input_(setup.in<Wrench>("input", {.unit = "N,N*m", .doc = "a wrench"})),
        force_(setup.out<Vector>("force", {.unit = "N", .doc = "its force"})),
        torque_(setup.out<Vector>("torque", {.unit = "N*m", .doc = "its torque"})) {}
  void update(const Cycle&) override {
    if (input_.null()) {
      force_.set_null();
      return torque_.set_null();
    }
    force_.set(input_->force);
    torque_.set(input_->torque);
  }

 private:
  In<Wrench> input_;
  Out<Vector> force_, torque_;
};

class TwistComponents final : public Primitive {
 public:
  explicit TwistComponents(Setup& setup)
      : input_(setup.in<Twist>("input", {.unit = "m/s,rad/s", .doc = "a twist"})),
        linear_(setup.out<Vector>("linear", {.unit = "m/s", .doc = "velocity of the origin"})),
        angular_(setup.out<Vector>("angular", {.unit = "rad/s", .doc = "angular velocity"})) {}
  void update(const Cycle&) override {
    if (input_.null()) {
      linear_.set_null();
      return angular_.set_null();
    }
    linear_.set(input_->linear);
    angular_.set(input_->angular);
  }

 private:
  In<Twist> input_;
  Out<Vector> linear_, angular_;
};

using AddVectors = Function2<AddVectorsOf, Vector, Vector, Vector>;
using SubtractVectors = Function2<SubtractVectorsOf, Vector, Vector, Vector>;
using ScaleVector = Function2<ScaleVectorOf, Vector, Real, Vector>;
using DotProduct = Function2<DotProductOf, Vector, Vector, Real>;
using CrossProduct = Function2<CrossProductOf, Vector, Vector, Vector>;
using Norm = Function1<NormOf, Vector, Real>;
using Compose = Function2<ComposeOf, Frame, Frame, Frame>;
using Inverse = Function1<InverseOf, Frame, Frame>;
using TransformPoint = Function2<TransformPointOf, Frame, Vector, Vector>;
using RotateVector = Function2<RotateVectorOf, Frame, Vector, Vector>;
using AssembleFrame = Function2<AssembleFrameOf, Vector, Rotation, Frame>;
using TransformWrench = Function2<TransformWrenchOf, Frame, Wrench, Wrench>;
using AddWrenches = Function2<AddWrenchesOf, Wrench, Wrench, Wrench>;
using SubtractWrenches = Function2<SubtractWrenchesOf, Wrench, Wrench, Wrench>;
using AssembleWrench = Function2<AssembleWrenchOf, Vector, Vector, Wrench>;
using AssembleTwist = Function2<AssembleTwistOf, Vector, Vector, Twist>;

TAKT_PRIMITIVE(AddVectors, "geometry", "a + b.");
TAKT_PRIMITIVE(SubtractVectors, "geometry", "a - b.");
TAKT_PRIMITIVE(ScaleVector, "geometry", "factor * vector.");
TAKT_PRIMITIVE(DotProduct, "geometry", "Scalar product of two vectors.");
TAKT_PRIMITIVE(CrossProduct, "geometry", "Vector product of two vectors.");
TAKT_PRIMITIVE(Norm, "geometry", "Length of a vector.");
TAKT_PRIMITIVE(VectorComponents, "geometry", "The three numbers of a vector.");
TAKT_PRIMITIVE(AssembleVector, "geometry", "A vector from three numbers.");
TAKT_PRIMITIVE(Compose, "geometry", "Two poses one after the other: X_AC = X_AB X_BC.");
TAKT_PRIMITIVE(Inverse, "geometry", "The pose the other way round: X_BA from X_AB.");
TAKT_PRIMITIVE(TransformPoint, "geometry", "A point seen from another frame.");
TAKT_PRIMITIVE(RotateVector, "geometry", "A free vector in the axes of another frame.");
TAKT_PRIMITIVE(AssembleFrame, "geometry", "A frame from origin and axes.");
TAKT_PRIMITIVE(FrameComponents, "geometry", "Origin and axes of a frame.");
TAKT_PRIMITIVE(TransformWrench, "geometry", "A wrench about another origin and in other axes.");
TAKT_PRIMITIVE(AddWrenches, "geometry", "a + b, both about one origin and in the same axes.");
TAKT_PRIMITIVE(SubtractWrenches, "geometry", "a - b, both about one origin and in the same axes.");
TAKT_PRIMITIVE(AssembleWrench, "geometry", "A wrench from force and torque.");
TAKT_PRIMITIVE(WrenchComponents, "geometry", "Force and torque of a wrench.");
TAKT_PRIMITIVE(AssembleTwist, "geometry", "A twist from linear and angular velocity.");
TAKT_PRIMITIVE(TwistComponents, "geometry", "Linear and angular velocity of a twist.");

}  // namespace
}  // namespace takt::primitives
