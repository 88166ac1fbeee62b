// A cell and its devices.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <nlohmann/json.hpp>

#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "python/bindings.h"
#include "python/cell_handle.h"
#include "python/errors.h"
#include "python/expressions.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;
using CellFrame = Owned<app::Frame>;
using Matrix = Eigen::Matrix4d;
using C = const CellPtr&;
using Name = const std::string&;

template <class Map>
Json names_in(const Map& map) {
  Json names = Json::array();
  for (const auto& [name, one] : map) names.push_back(name);
  return names;
}

/// Names of all that the cell has, by kind, as JSON.
std::string names_of(C cell) {
  const expression::Cell& model = cell->get().model();
  Json outputs = names_in(model.digital_outputs);
  for (const auto& [name, one] : model.analog_outputs) outputs.push_back(name);
  Json names{{"arm", names_in(model.arms)},
             {"gripper", names_in(model.grippers)},
             {"sensor", names_in(model.sensors)},
             {"tool_changer", names_in(model.changers)},
             {"output", std::move(outputs)},
             {"input", names_in(model.digital_inputs)},
             {"analog_input", names_in(model.analog_inputs)},
             {"channel", names_in(model.channels)},
             {"tool", names_in(model.tools)},
             {"net", names_in(model.nets)}};
  names["frame"] = model.frames.names();
  return names.dump();
}

/// The name of a device; the only one of its kind if none is given. Raises OperationError with the nearest name.
std::string device_name(C cell, Name kind, Name name) {
  app::Cell& open = cell->get();
  if (kind == "gripper") return open.gripper(name).name();
  if (kind == "tool_changer") return open.tool_changer(name).name();
  if (kind == "output") return open.output(name).name();
  return open.arm(name).name();
}

/// Steps the run until `over` says so. It is called before each cycle, with Python's lock; what it raises comes out.
void drive(C cell, const std::function<bool()>& over) {
  app::Cell& open = cell->get();
  std::exception_ptr raised;
  cell->unlocked([&] {
    open.runtime().run_until([&] {
      const nb::gil_scoped_acquire lock;
      try {
        return over();
      } catch (...) {
        raised = std::current_exception();
        return true;
      }
    });
  });
  if (raised) std::rethrow_exception(raised);
}

void bind_time(nb::class_<CellHandle>& cell) {
  cell.def_prop_ro(
          "time", [](C c) { return c->get().time(); }, "s, simulated")
      .def_prop_ro("cycle", [](C c) { return c->get().core().cycle(); })
      .def_prop_ro("title", [](C c) { return c->get().title(); })
      .def("wait_seconds",
           [](C c, double seconds) {
             app::Cell& open = c->get();
             c->unlocked([&] { open.wait(seconds); });
           })
      .def("wait_for_all",
           [](C c) {
             app::Cell& open = c->get();
             c->unlocked([&] { open.wait_for_all(); });
           })
      .def("wait_until",
           [](C c, const State& state, double timeout) {
             app::Cell& open = c->get();
             return c->unlocked([&] { return open.wait_until(state.value, timeout); });
           })
      .def("drive", drive)
      .def("spend_step",
           [](C c) {
             app::Cell& open = c->get();
             c->unlocked([&] { open.runtime().step(); });
           })
      .def("cancel", [](C c) { c->get().runtime().cancel(); });
}

void bind_people(nb::class_<CellHandle>& cell) {
  cell.def("step", [](C c, Name name) { c->get().step(name); })
      .def("print", [](C c, Name line) { c->get().print(line); })
      .def("expect", [](C c, Name name, bool passed, Name measured) { c->get().expect(name, passed, measured); })
      .def(
          "finish",
          [](C c, Name why, const std::optional<std::function<std::string()>>& run_again) {
            std::function<std::string()> again;
            if (run_again)
              again = [&] {
                const nb::gil_scoped_acquire lock;
                return (*run_again)();
              };
            return c->finish(why, again);
          },
          nb::arg("why"), nb::arg("run_again").none());
}

void bind_sensors(nb::class_<CellHandle>& cell) {
  using expression::Cell;
  cell.def("force",
           [](C c, Name sensor) {
             return Real{c, c->get().force(sensor)};
           })
      .def("wrench",
           [](C c, Name sensor) {
             return Wrench{c, c->get().wrench(sensor)};
           })
      .def("pressing",
           [](C c, const Triple& direction, Name sensor) {
             return Real{c, c->get().pressing(vector_from(direction), sensor)};
           })
      .def("input",
           [](C c, Name name) {
             return State{c, c->get().input(name)};
           })
      .def("analog_input",
           [](C c, Name name) {
             return Real{c, c->get().analog_input(name)};
           })
      .def("distance",
           [](C c, const std::vector<std::string>& a, const std::vector<std::string>& b) {
             return Real{c, c->get().distance(a, b)};
           })
      .def("gripper_is",
           [](C c, Name state, Name gripper) {
             return State{c, c->get().gripper_is(state, gripper)};
           })
      .def("gripper_width",
           [](C c, Name name) {
             return Real{c, expression::gripper_width(c->get().model(), name)};
           })
      .def("tool_pose",
           [](C c, Name arm) {
             return Frame{c, expression::tool_pose(c->get().model(), arm)};
           })
      .def("commanded_tool_pose",
           [](C c, Name arm) {
             return Frame{c, expression::commanded_tool_pose(c->get().model(), arm)};
           })
      .def("tool_twist",
           [](C c, Name arm) {
             return Twist{c, expression::tool_twist(c->get().model(), arm)};
           })
      .def("measured_joints",
           [](C c, Name arm) {
             return Joints{c, expression::measured_joints(c->get().model(), arm)};
           })
      .def("measured_velocities",
           [](C c, Name arm) {
             return Joints{c, expression::measured_velocities(c->get().model(), arm)};
           })
      .def("measured_torques", [](C c, Name arm) {
        return Joints{c, expression::measured_torques(c->get().model(), arm)};
      });
}

// -- Arms ------------------------------------------------------------------------------------------------------------

/// Without a look at what else the device offers: programs ask for states in loops.
const expression::MountedArm& mounted(C cell, Name name) {
  const auto& arms = cell->get().model().arms;
  const auto found = arms.find(name);
  return found != arms.end() ? found->second : arms.at(cell->get().arm(name).name());
}
Eigen::Isometry3d flange_of(const expression::MountedArm& arm) {
  return arm.device->description().chain->forward(arm.device->set_point().q);
}

void bind_arms(nb::class_<CellHandle>& cell) {
  cell.def("q", [](C c, Name arm) -> Eigen::VectorXd { return mounted(c, arm).device->set_point().q; })
      .def("measured_q", [](C c, Name arm) -> Eigen::VectorXd { return c->get().arm(arm).measured_q(); })
      .def("home", [](C c, Name arm) -> Eigen::VectorXd { return mounted(c, arm).device->description().home; })
      .def("flange", [](C c, Name arm) -> Matrix { return flange_of(mounted(c, arm)).matrix(); })
      .def("tool", [](C c, Name arm) -> Matrix { return (flange_of(mounted(c, arm)) * mounted(c, arm).X_FT).matrix(); })
      .def("measured_tool", [](C c, Name arm) -> Matrix { return c->get().arm(arm).measured_tool().matrix(); })
      .def("frame_of", [](C c, Name arm, Name frame) -> Matrix { return c->get().arm(arm).frame(frame).matrix(); })
      .def("above",
           [](C c, Name arm, Name frame, double height) -> Matrix {
             return c->get().arm(arm).above(frame, height).matrix();
           })
      .def("tcp",
           [](C c, Name arm, Name tool, Name tcp) -> Matrix { return c->get().arm(arm).tcp(tool, tcp).matrix(); })
      .def("use_tool", [](C c, Name arm, Name tool, Name tcp) { c->get().arm(arm).use_tool(tool, tcp); })
      .def("carry", [](C c, Name arm, double mass) { c->get().arm(arm).carry(mass); })
      .def("set_speed", [](C c, Name arm, double rate) { c->get().arm(arm).set_speed(rate); })
      .def("pause", [](C c, Name arm) { c->get().arm(arm).pause(); })
      .def("resume", [](C c, Name arm) { c->get().arm(arm).resume(); })
      .def("mode",
           [](C c, Name arm) {
             return std::string(device::name_of(c->get().model().arms.at(c->get().arm(arm).name()).device->mode()));
           })
      .def("interfaces", [](C c, Name device) { return app::Actuator(c->get().runtime(), device).interfaces(); });
}

void bind_frames(nb::module_& module, nb::class_<CellHandle>& cell) {
  using F = const CellFrame&;
  nb::class_<CellFrame>(module, "Frame", "A frame of the cell, where the program believes it to be.")
      .def(
          "offset",
          [](F f, double x, double y, double z) {
            return CellFrame{f.cell, f.value.offset(x, y, z)};
          },
          nb::arg("x"), nb::arg("y"), nb::arg("z"), "The frame beside this one: so far along its axes, m.")
      .def(
          "turned",
          [](F f, double roll, double pitch, double yaw) {
            return CellFrame{f.cell, f.value.turned(roll, pitch, yaw)};
          },
          nb::arg("roll"), nb::arg("pitch"), nb::arg("yaw"), "The frame turned about its own axes, rad.")
      .def(
          "then",
          [](F f, const Matrix& X) {
            return CellFrame{f.cell, f.value.then(pose_from(X, "X"))};
          },
          nb::arg("X"))
      .def(
          "pose",
          [](F f, Name other) -> Matrix {
            (void)f.cell->get();
            return f.value.in(other).matrix();
          },
          nb::arg("in_") = "world", "Where it is now in another frame, 4x4, m.")
      .def(
          "pose_in",
          [](F f, Name other) {
            return Frame{f.cell, f.value.pose_in(other)};
          },
          nb::arg("other"), "The same as a sensor.")
      .def(
          "velocity_in",
          [](F f, Name other) {
            return Twist{f.cell, f.value.velocity_in(other)};
          },
          nb::arg("other"))
      .def(
          "keep_as",
          [](F f, Name name) {
            return CellFrame{f.cell, f.value.keep_as(name)};
          },
          nb::arg("name"), "Makes it a frame of the cell that rides on what this one rides on.");
  cell.def("frame", [](C c, Name name) { return CellFrame{c, c->get().frame(name)}; });
}

}  // namespace

void bind_cell(nb::module_& module) {
  nb::class_<CellHandle> cell(module, "Cell");
  module.def("open_cell", [](Name file, Name options) { return std::make_shared<CellHandle>(file, options); });
  cell.def("names", names_of).def("device_name", device_name);
  bind_time(cell);
  bind_people(cell);
  bind_sensors(cell);
  bind_arms(cell);
  bind_frames(module, cell);
  bind_channels(cell);
}

}  // namespace takt::python
