// Forces: measured ones, compliance, freedrive.
#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

using urscript::Failed;
using urscript::Library;
using urscript::Outcome;
using urscript::Value;

constexpr double kContactForce = 15.0;  // N, that tool_contact() takes for a contact
// force_mode(): kinds of frames. Only 2, the frame as it is given, is told apart here.
constexpr int kFirstKind = 1, kLastKind = 3;

/// Compliance belongs to no thread: another one may move meanwhile.
Outcome force_mode(Controller& c, const Arguments& a) {
  if (a.thread() >= Programs::kFirstSecondary) return Failed{"a secondary program cannot move the robot"};
  ForceTask task;
  task.X_BTask = to_isometry(a.pose(0));
  const auto selection = a.numbers(1, 6), wrench = a.numbers(2, 6), limits = a.numbers(4, 6);
  (void)a.integer(3, kFirstKind, kLastKind);
  for (std::size_t i = 0; i < 6; ++i) {
    task.compliant[i] = selection[i] != 0.0;
    task.wrench[static_cast<Eigen::Index>(i)] = wrench[i];
    task.limits[static_cast<Eigen::Index>(i)] = std::abs(limits[i]);
  }
  task.gain = c.settings().force_gain;
  c.motion().set_force_task(task);
  return Value();
}

ForceTask freedrive_task(const Arguments& a, std::size_t axes) {
  ForceTask task = led_by_hand();
  if (!a.none(axes)) {
    const auto selection = a.numbers(axes, 6);
    for (std::size_t i = 0; i < 6; ++i) task.compliant[i] = selection[i] != 0.0;
  }
  return task;
}

Outcome begin_freedrive(Controller& c, const Arguments& a) {
  if (!c.take_motion(a.thread())) return Failed{"another thread is already controlling the robot"};
  c.settings().freedrive = true;
  c.motion().set_force_task(freedrive_task(a, 0));
  return Value();
}

Outcome end_force(Controller& c) {
  c.settings().freedrive = false;
  c.motion().set_force_task({});
  return Value();
}

void accept(Library& library, std::string_view signature) {
  library.add(signature, [](const urscript::Call&) -> Outcome { return Value(true); });
}

}  // namespace

void add_force_functions(Library& library, Controller& c) {
  library.add("force_mode(task_frame, selection_vector, wrench, type, limits)",
              checked([&c](const Arguments& a) { return force_mode(c, a); }));
  library.add("end_force_mode()", [&c](const urscript::Call&) { return end_force(c); });
  accept(library, "force_mode_set_damping(damping)");
  library.add("force_mode_set_gain_scaling(scaling)", checked([&c](const Arguments& a) -> Outcome {
                c.settings().force_gain = std::clamp(a.real(0), 0.0, 2.0);
                return Value();
              }));
  library.add("freedrive_mode(freeAxes=None, feature=None)",
              checked([&c](const Arguments& a) { return begin_freedrive(c, a); }));
  library.add("teach_mode()", checked([&c](const Arguments& a) { return begin_freedrive(c, a); }));
  for (const char* signature : {"end_freedrive_mode()", "end_teach_mode()"})
    library.add(signature, [&c](const urscript::Call&) { return end_force(c); });
  // 0: on; 2: the arm cannot be led there.
  library.add("get_freedrive_status()",
              [&c](const urscript::Call&) -> Outcome { return Value(c.settings().freedrive ? 0 : 2); });
  library.add("zero_ftsensor()", [&c](const urscript::Call&) -> Outcome {
    c.settings().wrench_offset += c.tcp_force();
    return Value();
  });
  library.add("get_tcp_force()", [&c](const urscript::Call&) -> Outcome { return to_value(c.tcp_force()); });
  library.add("force()", [&c](const urscript::Call&) -> Outcome { return Value(c.tcp_force().head<3>().norm()); });
  library.add("tool_contact(direction=None)", checked([&c](const Arguments& a) -> Outcome {
                Eigen::Vector3d way = c.motion().kinematics().twist(c.motion().q(), c.motion().dq()).head<3>();
                if (!a.none(0)) {
                  const auto given = a.numbers(0, 6);
                  if (given[0] != 0.0 || given[1] != 0.0 || given[2] != 0.0)
                    way = Eigen::Vector3d(given[0], given[1], given[2]);
                }
                const double against = way.norm() > 1e-9 ? -c.tcp_force().head<3>().dot(way.normalized()) : 0.0;
                return Value(against > kContactForce ? 1 : 0);
              }));
  accept(library, "enable_external_ft_sensor(enable, sensor_mass=0, sensor_measuring_offset=None, sensor_cog=None)");
  accept(library, "ft_rtde_input_enable(enable, sensor_mass=0, sensor_measuring_offset=None, sensor_cog=None)");
}

}  // namespace takt::hw::rtde
