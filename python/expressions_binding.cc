// Sensors and states with Python's operators. What an operator gives is a formula that the net evaluates in each cycle.
#include <optional>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "python/bindings.h"
#include "python/errors.h"
#include "python/expressions.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using expression::RealTerm;

/// A formula over a sensor, of the same cell.
template <class T, class Other>
Owned<T> over(const Owned<Other>& operand, T formula) {
  return {operand.cell, std::move(formula)};
}

template <class S>
auto value_now(const S& sensor) {
  (void)sensor.cell->get();
  return sensor.value.now();
}

[[noreturn]] void refuse_bool() {
  raise_error("UsageError", Code::kUnsupported, "",
              "a state has no truth value in Python: it holds or not in each cycle",
              "Combine states with & | ~ in place of and, or, not; ask for the value of now with .now()");
}
[[noreturn]] void refuse_equality() {
  raise_error("UsageError", Code::kUnsupported, "", "numbers of sensors are never compared for equality",
              "Use a.near(b, tolerance)");
}

void bind_real(nb::module_& module) {
  using R = const Real&;
  nb::class_<Real>(module, "Real", "A number that changes: a reading, or a formula over others.")
      .def(
          "now", [](R a) { return value_now(a); }, "The value of now; None while there is none.")
      .def(
          "__add__", [](R a, R b) { return over(a, a.value + b.value); }, nb::is_operator())
      .def(
          "__add__", [](R a, double b) { return over(a, a.value + b); }, nb::is_operator())
      .def(
          "__radd__", [](R a, double b) { return over(a, b + a.value); }, nb::is_operator())
      .def(
          "__sub__", [](R a, R b) { return over(a, a.value - b.value); }, nb::is_operator())
      .def(
          "__sub__", [](R a, double b) { return over(a, a.value - b); }, nb::is_operator())
      .def(
          "__rsub__", [](R a, double b) { return over(a, b - a.value); }, nb::is_operator())
      .def(
          "__mul__", [](R a, R b) { return over(a, a.value * b.value); }, nb::is_operator())
      .def(
          "__mul__", [](R a, double b) { return over(a, RealTerm(a.value) * b); }, nb::is_operator())
      .def(
          "__rmul__", [](R a, double b) { return over(a, RealTerm(b) * a.value); }, nb::is_operator())
      .def(
          "__truediv__", [](R a, R b) { return over(a, a.value / b.value); }, nb::is_operator())
      .def(
          "__truediv__", [](R a, double b) { return over(a, a.value / b); }, nb::is_operator())
      .def(
          "__rtruediv__", [](R a, double b) { return over(a, b / a.value); }, nb::is_operator())
      .def("__neg__", [](R a) { return over(a, -a.value); })
      .def("__abs__", [](R a) { return over(a, expression::abs(a.value)); })
      .def(
          "__gt__", [](R a, R b) { return over(a, is_greater(a.value, b.value)); }, nb::is_operator())
      .def(
          "__gt__", [](R a, double b) { return over(a, is_greater(a.value, b)); }, nb::is_operator())
      .def(
          "__lt__", [](R a, R b) { return over(a, is_less(a.value, b.value)); }, nb::is_operator())
      .def(
          "__lt__", [](R a, double b) { return over(a, is_less(a.value, b)); }, nb::is_operator())
      .def(
          "__ge__", [](R a, R b) { return over(a, !is_less(a.value, b.value)); }, nb::is_operator())
      .def(
          "__ge__", [](R a, double b) { return over(a, !is_less(a.value, b)); }, nb::is_operator())
      .def(
          "__le__", [](R a, R b) { return over(a, !is_greater(a.value, b.value)); }, nb::is_operator())
      .def(
          "__le__", [](R a, double b) { return over(a, !is_greater(a.value, b)); }, nb::is_operator())
      .def("__eq__", [](R, const nb::object&) -> bool { refuse_equality(); })
      .def("__ne__", [](R, const nb::object&) -> bool { refuse_equality(); })
      .def("__bool__", [](R) -> bool { refuse_bool(); })
      .def(
          "near", [](R a, double b, double tolerance) { return over(a, equals(a.value, b, tolerance)); },
          nb::arg("value"), nb::arg("tolerance"), "Differs by at most the tolerance, in the unit of both.")
      .def(
          "in_range", [](R a, double low, double high) { return over(a, expression::in_range(a.value, low, high)); },
          nb::arg("low"), nb::arg("high"))
      .def(
          "low_pass", [](R a, double cutoff) { return over(a, low_pass(a.value, cutoff)); }, nb::arg("cutoff_Hz"),
          "First-order low pass, cutoff at -3 dB.")
      .def(
          "derivative", [](R a, double cutoff) { return over(a, derivative(a.value, cutoff)); }, nb::arg("cutoff_Hz"),
          "Change per second, smoothed.")
      .def("sqrt", [](R a) { return over(a, expression::sqrt(a.value)); })
      .def(
          "is_silent", [](R a) { return over(a, is_null(a.value)); }, "The sensor does not answer.");
}

void bind_state(nb::module_& module) {
  using S = const State&;
  nb::class_<State>(module, "State", "Something that holds or does not hold in each cycle.")
      .def(
          "now", [](S a) { return value_now(a); }, "Whether it holds now; None where that is not known.")
      .def(
          "__and__", [](S a, S b) { return over(a, a.value && b.value); }, nb::is_operator())
      .def(
          "__or__", [](S a, S b) { return over(a, a.value || b.value); }, nb::is_operator())
      .def("__invert__", [](S a) { return over(a, !a.value); })
      .def("__bool__", [](S) -> bool { refuse_bool(); })
      .def(
          "held_for", [](S a, double seconds) { return over(a, a.value.held_for(seconds)); }, nb::arg("seconds"),
          "Holds once this has held so long without a break.")
      .def(
          "once", [](S a) { return over(a, a.value.once()); }, "Holds from the first cycle on in which this did.");
}

void bind_vector(nb::module_& module) {
  using V = const Vector&;
  nb::class_<Vector>(module, "Vector", "Three numbers that change.")
      .def("now", [](V a) { return value_now(a); })
      .def(
          "__add__", [](V a, V b) { return over(a, a.value + b.value); }, nb::is_operator())
      .def(
          "__sub__", [](V a, V b) { return over(a, a.value - b.value); }, nb::is_operator())
      .def(
          "__rmul__", [](V a, double b) { return over(a, RealTerm(b) * a.value); }, nb::is_operator())
      .def("norm", [](V a) { return over(a, norm(a.value)); })
      .def(
          "dot", [](V a, const Triple& b) { return over(a, dot(a.value, vector_from(b))); }, nb::arg("direction"))
      .def(
          "distance", [](V a, const Triple& b) { return over(a, expression::distance(a.value, vector_from(b))); },
          nb::arg("point"))
      .def(
          "distance", [](V a, V b) { return over(a, expression::distance(a.value, b.value)); }, nb::arg("point"))
      .def(
          "low_pass", [](V a, double cutoff) { return over(a, low_pass(a.value, cutoff)); }, nb::arg("cutoff_Hz"))
      .def("__getitem__", [](V a, int axis) {
        if (axis < 0 || axis > 2) throw nb::index_error("0, 1 or 2: x, y or z");
        return over(a, component(a.value, axis));
      });
}

void bind_frame(nb::module_& module) {
  using F = const Frame&;
  nb::class_<Frame>(module, "Pose", "A pose that changes.")
      .def(
          "now",
          [](F a) -> std::optional<Eigen::Matrix4d> {
            const auto X = value_now(a);
            return X ? std::optional<Eigen::Matrix4d>(X->matrix()) : std::nullopt;
          },
          "4x4, m; None while it is not known.")
      .def(
          "__matmul__", [](F a, F b) { return over(a, a.value * b.value); }, nb::is_operator())
      .def("inverse", [](F a) { return over(a, inverse(a.value)); })
      .def_prop_ro("position", [](F a) { return over(a, position(a.value)); })
      .def(
          "distance", [](F a, F b) { return over(a, expression::distance(a.value, b.value)); }, nb::arg("other"))
      .def(
          "angle", [](F a, F b) { return over(a, angle(a.value, b.value)); }, nb::arg("other"));
}

void bind_twist_and_wrench(nb::module_& module) {
  nb::class_<Twist>(module, "Twist", "A velocity that changes.")
      .def_prop_ro(
          "linear", [](const Twist& a) { return over(a, linear(a.value)); }, "m/s")
      .def_prop_ro(
          "angular", [](const Twist& a) { return over(a, angular(a.value)); }, "rad/s");
  nb::class_<Wrench>(module, "Wrench", "Force and torque that change.")
      .def_prop_ro(
          "force", [](const Wrench& a) { return over(a, expression::force(a.value)); }, "N")
      .def_prop_ro(
          "torque", [](const Wrench& a) { return over(a, expression::torque(a.value)); }, "Nm")
      .def(
          "low_pass", [](const Wrench& a, double cutoff) { return over(a, low_pass(a.value, cutoff)); },
          nb::arg("cutoff_Hz"));
}

void bind_joints(nb::module_& module) {
  using J = const Joints&;
  nb::class_<Joints>(module, "Joints", "One number per joint, which change.")
      .def("now",
           [](J a) -> std::optional<Eigen::VectorXd> {
             const auto q = value_now(a);
             return q ? std::optional<Eigen::VectorXd>(q->map()) : std::nullopt;
           })
      .def("__getitem__", [](J a, int index) { return over(a, element(a.value, index)); })
      .def(
          "__sub__", [](J a, const Eigen::VectorXd& b) { return over(a, a.value - net::JointArray(b)); },
          nb::is_operator())
      .def(
          "largest", [](J a) { return over(a, largest(a.value)); }, "The largest size of an element.");
}

}  // namespace

Eigen::Isometry3d pose_from(const Eigen::Matrix4d& matrix, const char* key) {
  Eigen::Isometry3d X;
  X.matrix() = matrix;
  constexpr double kSlack = 1e-6;
  const Eigen::Matrix3d R = X.linear();
  const bool is_pose = matrix.allFinite() && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1) &&
                       (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kSlack &&
                       R.determinant() > 0.0;
  if (!is_pose)
    raise_error("UsageError", Code::kInvalidValue, pointer_segment(key), "the 4x4 array is not a pose",
                "Give a rotation (orthogonal, right-handed) and a position in m, with 0 0 0 1 in the last row");
  return X;
}

void bind_expressions(nb::module_& module) {
  bind_state(module);
  bind_real(module);
  bind_vector(module);
  bind_frame(module);
  bind_twist_and_wrench(module);
  bind_joints(module);
}

}  // namespace takt::python
