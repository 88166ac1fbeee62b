// The words of an arm, each with its parameters as UR has them.
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "languages/urscript/arm_functions.h"
#include "languages/urscript/functions.h"
#include "languages/urscript/poses.h"

namespace takt::languages::urscript {

/// Adds functions that call an arm's.
class ArmLibrary {
 public:
  ArmLibrary(Library& library, ArmFunctions* arm) : library_(library), arm_(arm) {}

  void add_moves() {
    using Kind = MotionCommand::Kind;
    add("movej(q, a=1.4, v=1.05, t=0, r=0)", [](ArmFunctions& arm, const Arguments& a) {
      MotionCommand made = arm.command(a, Kind::kJoints, "movej", 1);
      made.goal = arm.goal(a, 0, true);
      return with_time_and_radius(arm, a, std::move(made), 3, 4);
    });
    add("movel(pose, a=1.2, v=0.25, t=0, r=0)", [](ArmFunctions& arm, const Arguments& a) {
      MotionCommand made = arm.command(a, Kind::kLine, "movel", 1);
      made.goal = arm.goal(a, 0, false);
      return with_time_and_radius(arm, a, std::move(made), 3, 4);
    });
    add("movep(pose, a=1.2, v=0.25, r=0)", [](ArmFunctions& arm, const Arguments& a) {
      MotionCommand made = arm.command(a, Kind::kLine, "movep", 1);
      made.goal = arm.goal(a, 0, false);
      return with_time_and_radius(arm, a, std::move(made), 99, 3);
    });
    add("movec(pose_via, pose_to, a=1.2, v=0.25, r=0, mode=0)", [](ArmFunctions& arm, const Arguments& a) {
      MotionCommand made = arm.command(a, Kind::kArc, "movec", 2);
      made.via = arm.goal(a, 0, false);
      made.goal = arm.goal(a, 1, false);
      made.tangential = a.integer(5, 0, 1) == 1;
      return with_time_and_radius(arm, a, std::move(made), 99, 4);
    });
    for (const char* signature : {"stopj(a=2)", "stopl(a=3, aRot=0)"})
      add(signature, [](ArmFunctions& arm, const Arguments& a) {
        if (a.real(0) <= 0.0) throw BadArgument{"the deceleration must be above 0"};
        return arm.stop(a.thread());
      });
  }

  void add_servoing() {
    using Kind = LastingCommand::Kind;
    const auto servo = [](ArmFunctions& arm, const Arguments& a, double seconds) {
      LastingCommand made{.kind = Kind::kServo, .at = {}};
      made.X_BF = arm.goal(a, 0, false).X_BF;
      return arm.last(a.thread(), made, std::max(seconds, arm.host_.cycle()));
    };
    add("servoj(q, a=0, v=0, t=0.008, lookahead_time=0.1, gain=300)",
        [servo](ArmFunctions& arm, const Arguments& a) { return servo(arm, a, a.real(3)); });
    add("servoc(pose, a=1.2, v=0.25, r=0)",
        [servo](ArmFunctions& arm, const Arguments& a) { return servo(arm, a, 0.0); });
    add("speedl(xd, a=1.2, t=0, aRot=0)", [](ArmFunctions& arm, const Arguments& a) {
      LastingCommand made{.kind = Kind::kSpeed, .at = {}};
      const auto numbers = a.numbers(0, 6);
      made.twist = Eigen::Map<const kinematics::Vector6>(numbers.data());
      return arm.last(a.thread(), made, std::max(a.real(2), arm.host_.cycle()));
    });
    for (const char* signature : {"freedrive_mode()", "teach_mode()"})
      add(signature, [](ArmFunctions& arm, const Arguments& a) {
        Outcome outcome = arm.last(a.thread(), {.kind = Kind::kFreedrive, .at = {}}, 0.0);
        arm.freedrive_ = true;
        return outcome;
      });
    for (const char* signature : {"end_freedrive_mode()", "end_teach_mode()"})
      add(signature, [](ArmFunctions& arm, const Arguments& a) {
        if (!std::exchange(arm.freedrive_, false)) return Outcome(Value());
        return arm.end_lasting(a.thread());
      });
    add("get_freedrive_status()",
        [](ArmFunctions& arm, const Arguments&) -> Outcome { return Value(arm.freedrive_ ? 0 : 2); });
  }

  void add_force() {
    add("force_mode(task_frame, selection_vector, wrench, type, limits)", [](ArmFunctions& arm, const Arguments& a) {
      const ForceCommand force = arm.force(a);
      Outcome outcome = arm.last(a.thread(), {.kind = LastingCommand::Kind::kForce, .force = force, .at = {}}, 0.0);
      arm.force_ = force;
      return outcome;
    });
    add("end_force_mode()", [](ArmFunctions& arm, const Arguments& a) {
      const bool on = std::exchange(arm.force_, std::nullopt).has_value();
      return on ? arm.end_lasting(a.thread()) : Outcome(Value());
    });
    add("zero_ftsensor()", [](ArmFunctions& arm, const Arguments& a) {
      return arm.at_rest(a.thread(), [&arm, at = arm.at(), begun = false]() mutable -> std::optional<Value> {
        if (!std::exchange(begun, true))
          if (std::string problem = arm.host_.tare(at); !problem.empty()) throw BadArgument{std::move(problem)};
        return arm.host_.settled() ? std::optional<Value>(Value()) : std::nullopt;
      });
    });
  }

  void add_state() {
    const auto joints = [this](const char* signature, bool measured) {
      add(signature, [measured](ArmFunctions& arm, const Arguments& a) {
        return arm.at_rest(a.thread(),
                           [&arm, measured]() -> std::optional<Value> { return to_value(arm.host_.joints(measured)); });
      });
    };
    joints("get_actual_joint_positions()", true);
    joints("get_joint_positions()", true);
    joints("get_target_joint_positions()", false);
    const auto pose = [this](const char* signature, bool measured, bool with_tool) {
      add(signature, [measured, with_tool](ArmFunctions& arm, const Arguments& a) {
        return arm.at_rest(a.thread(), [&arm, measured, with_tool]() -> std::optional<Value> {
          const Eigen::Isometry3d X_BF = arm.host_.flange(arm.host_.joints(measured));
          return Value(to_pose(with_tool ? X_BF * arm.X_FT_ : X_BF));
        });
      });
    };
    pose("get_actual_tcp_pose()", true, true);
    pose("get_target_tcp_pose()", false, true);
    pose("get_actual_tool_flange_pose()", true, false);
    add("get_tcp_offset()", [](ArmFunctions& arm, const Arguments&) -> Outcome { return Value(to_pose(arm.X_FT_)); });
    add("is_steady()", [](ArmFunctions& arm, const Arguments&) -> Outcome {
      return Value(arm.host_.settled() && !arm.host_.lasts());
    });
  }

  void add_kinematics() {
    add("get_forward_kin(q=None, tcp=None)", [](ArmFunctions& arm, const Arguments& a) -> Outcome {
      const Eigen::Isometry3d X_FT = arm.tool(a, 1);
      if (!a.none(0)) return Value(to_pose(arm.host_.flange(arm.joints(a, 0)) * X_FT));
      return arm.at_rest(a.thread(), [&arm, X_FT]() -> std::optional<Value> {
        return Value(to_pose(arm.host_.flange(arm.host_.joints(false)) * X_FT));
      });
    });
    inverse("get_inverse_kin(x, qnear=None, maxPositionError=1e-10, maxOrientationError=1e-10, tcp=None)", false);
    inverse(
        "get_inverse_kin_has_solution(pose, qnear=None, maxPositionError=1e-10, maxOrientationError=1e-10, tcp=None)",
        true);
  }

  void add_tool_and_load() {
    add("set_tcp(pose, tcp_name='')", [](ArmFunctions& arm, const Arguments& a) -> Outcome {
      const Pose pose = a.pose(0);
      for (const double one : pose)
        if (!std::isfinite(one)) throw BadArgument{"argument 1 is not finite"};
      arm.X_FT_ = to_isometry(pose);
      return Value();
    });
    for (const char* signature :
         {"set_payload(m|mass, cog|CoG=None)", "set_target_payload(m|mass, cog=None, inertia=None, transition_time=0)"})
      add(signature, [](ArmFunctions& arm, const Arguments& a) -> Outcome {
        set_mass(arm, a);
        if (!a.none(1)) arm.cog_ = a.numbers(1, 3);
        return Value();
      });
    add("set_payload_mass(m|mass)", [](ArmFunctions& arm, const Arguments& a) -> Outcome {
      set_mass(arm, a);
      return Value();
    });
    add("set_payload_cog(cog|CoG)", [](ArmFunctions& arm, const Arguments& a) -> Outcome {
      arm.cog_ = a.numbers(0, 3);
      return Value();
    });
    for (const char* signature : {"get_target_payload()", "get_target_payload_mass()"})
      add(signature, [](ArmFunctions& arm, const Arguments&) -> Outcome { return Value(arm.payload_); });
    add("get_target_payload_cog()", [](ArmFunctions& arm, const Arguments&) -> Outcome { return to_list(arm.cog_); });
  }

  void add_signals() {
    digital("standard_", 8, [](int n) { return n; });
    digital("configurable_", 8, [](int n) { return 8 + n; });
    digital("tool_", 2, [](int n) { return 16 + n; });
    // As before there were configurable terminals: 8 and 9 are the tool's.
    digital("", 10, [](int n) { return n < 8 ? n : 8 + n; });
    analog_in("get_standard_analog_in(n)", 2, 0);
    analog_in("get_analog_in(n)", 4, 0);
    analog_in("get_tool_analog_in(n)", 2, 2);
    for (const char* prefix : {"standard_", ""}) {
      add(fmt::format("set_{}analog_out(n, f)", prefix), [](ArmFunctions& arm, const Arguments& a) {
        return arm.write(a.thread(), Signal::kAnalogOut, a.integer(0, 0, 1), a.real(1));
      });
      add(fmt::format("get_{}analog_out(n)", prefix), [](ArmFunctions& arm, const Arguments& a) {
        return arm.read(a.thread(), Signal::kAnalogOut, a.integer(0, 0, 1));
      });
    }
  }

  void add_system(const std::set<std::string>& calls) {
    add("sync()", [](ArmFunctions& arm, const Arguments& a) { return arm.wait_for(a.thread(), 0.0); });
    add("sleep(t)", [](ArmFunctions& arm, const Arguments& a) { return arm.wait_for(a.thread(), a.real(0)); });
    add("get_steptime()", [](ArmFunctions& arm, const Arguments&) -> Outcome { return Value(arm.host_.cycle()); });
    add("time(mode=0)", [](ArmFunctions& arm, const Arguments&) -> Outcome { return Value(arm.host_.now()); });
    add("textmsg(s1, s2='')", [](ArmFunctions& arm, const Arguments& a) -> Outcome {
      arm.host_.message("textmsg", a.text(0) + a.text(1), arm.at());
      return Value();
    });
    add("popup(s, title='Popup', warning=False, error=False, blocking=False)",
        [](ArmFunctions& arm, const Arguments& a) -> Outcome {
          if (a.boolean(4)) throw BadArgument{"a popup that waits for a person: there is none who answers it"};
          arm.host_.message("popup", a.text(1) + ": " + a.text(0), arm.at());
          return Value();
        });
    for (const std::string& name : calls)
      add(name + "()", [name](ArmFunctions& arm, const Arguments& a) {
        arm.take(a.thread());
        return arm.at_rest(a.thread(), [&arm, name, at = arm.at(), begun = false]() mutable -> std::optional<Value> {
          if (!std::exchange(begun, true)) arm.host_.call(name, at);
          return arm.host_.settled() ? std::optional<Value>(Value()) : std::nullopt;
        });
      });
  }

 private:
  template <class Run>
  void add(std::string_view signature, Run run) {
    library_.add(signature, checked([arm = arm_, run](const Arguments& a) -> Outcome { return run(*arm, a); }));
  }

  static Outcome with_time_and_radius(ArmFunctions& arm, const Arguments& a, MotionCommand made, std::size_t time,
                                      std::size_t radius) {
    made.time = time < a.size() ? a.real(time) : 0.0;
    made.radius = a.real(radius);
    if (made.time < 0.0 || made.radius < 0.0) throw BadArgument{"time and blend radius must not be below 0"};
    return arm.move(a.thread(), std::move(made));
  }

  static void set_mass(ArmFunctions& arm, const Arguments& a) {
    if (a.real(0) < 0.0) throw BadArgument{"a mass must not be below 0 kg"};
    arm.payload_ = a.real(0);
  }

  void inverse(const char* signature, bool asks) {
    add(signature, [asks](ArmFunctions& arm, const Arguments& a) -> Outcome {
      const Eigen::Isometry3d X_BF = to_isometry(a.pose(0)) * arm.tool(a, 4).inverse();
      if (!X_BF.matrix().allFinite()) throw BadArgument{"argument 1 is not finite"};
      const auto solve = [&arm, X_BF, asks](const kinematics::JointVector& near) -> std::optional<Value> {
        const auto q = arm.host_.solve(X_BF, near);
        if (asks) return Value(q.has_value());
        if (!q) throw BadArgument{"the pose is out of reach"};
        return to_value(*q);
      };
      if (!a.none(1) && !a[1].number()) return *solve(arm.joints(a, 1));
      return arm.at_rest(a.thread(), [&arm, solve] { return solve(arm.host_.joints(false)); });
    });
  }

  void digital(const std::string& group, int count, int (*number)(int)) {
    const auto bit = [=](const Arguments& a) { return number(a.integer(0, 0, count - 1)); };
    add(fmt::format("set_{}digital_out(n, b)", group), [bit](ArmFunctions& arm, const Arguments& a) {
      return arm.write(a.thread(), Signal::kDigitalOut, bit(a), a.boolean(1) ? 1.0 : 0.0);
    });
    add(fmt::format("get_{}digital_out(n)", group),
        [bit](ArmFunctions& arm, const Arguments& a) { return arm.read(a.thread(), Signal::kDigitalOut, bit(a)); });
    add(fmt::format("get_{}digital_in(n)", group),
        [bit](ArmFunctions& arm, const Arguments& a) { return arm.read(a.thread(), Signal::kDigitalIn, bit(a)); });
  }

  void analog_in(const char* signature, int count, int first) {
    add(signature, [count, first](ArmFunctions& arm, const Arguments& a) {
      return arm.read(a.thread(), Signal::kAnalogIn, first + a.integer(0, 0, count - 1));
    });
  }

  Library& library_;
  ArmFunctions* arm_;
};

void add_arm_functions(Library& library, ArmFunctions* arm, const std::set<std::string>& calls) {
  ArmLibrary words(library, arm);
  words.add_moves();
  words.add_servoing();
  words.add_force();
  words.add_state();
  words.add_kinematics();
  words.add_tool_and_load();
  words.add_signals();
  words.add_system(calls);
}

Library arm_library(ArmFunctions* arm, const std::set<std::string>& calls) {
  Library library;
  add_math_functions(library);
  add_pose_functions(library);
  library.mark_pure();
  add_arm_functions(library, arm, calls);
  return library;
}

}  // namespace takt::languages::urscript
