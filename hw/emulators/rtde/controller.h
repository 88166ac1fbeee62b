#pragma once

#include <array>
#include <bitset>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/device/description.h"
#include "core/motion/path_sample.h"
#include "hw/emulators/rtde/events.h"
#include "hw/emulators/rtde/external_control.h"
#include "hw/emulators/rtde/io.h"
#include "hw/emulators/rtde/motion.h"
#include "hw/emulators/rtde/power.h"
#include "hw/emulators/rtde/programs.h"
#include "hw/emulators/rtde/script_sockets.h"
#include "hw/rtde/field.h"

namespace takt::hw::rtde {

/// Which controller is emulated.
struct ControllerOptions {
  Version version = {3, 15, 8, 106339};  ///< decides the series, and with it the cycle: 8 ms or 2 ms
  std::string model = "UR5";             ///< as "get robot model" answers
  std::string serial = "20225500001";
  bool running = true;                ///< begins with brakes open; else without power
  bool remote_control = true;         ///< e-Series accept programs only so
  Nanoseconds uptime = 60 * kSecond;  ///< what its clock shows at the beginning; clients take less for booting
  std::map<std::string, std::string> programs = {};   ///< installed ones: "/programs/NAME.urp", and their scripts
  std::optional<hw::Endpoint> external_control = {};  ///< client of the URCap; null: it is not installed
  int fresh_packages = 0;  ///< a fault: RTDE repeats a package after so many new ones; 0: never
};

/// What the joints do, as the controller measures it.
struct PlantSample {
  JointVector q, dq;
  JointVector tau_external;  ///< Nm; size 0: no estimate
  JointVector held;          ///< where the drives hold the joints; size 0: not known, then at `q`
  bool stopped = false;      ///< the machine has stopped by itself and follows nothing
};

/// What programs and clients set, beside terminals and registers.
struct ControllerSettings {
  double slider = 1.0;  ///< share of programmed speeds
  double payload = 0.0;
  Eigen::Vector3d payload_cog = Eigen::Vector3d::Zero();
  std::array<double, 6> payload_inertia{};
  bool freedrive = false;
  Vector6 wrench_offset = Vector6::Zero();  ///< of zero_ftsensor(), in the axes of the base
  double force_gain = 1.0;                  ///< of force_mode_set_gain_scaling()
  std::string popup;
  std::bitset<32> flags;  ///< of set_flag()
};

/// A UR controller: everything behind its interfaces. It runs in control cycles, called frames here: first what clients
/// have written counts, then programs run, then the motion goes on. One thread.
class Controller {
 public:
  /// @param network  for programs that open sockets; may be null, outlives the controller
  Controller(const ControllerOptions& options, std::shared_ptr<const device::ArmDescription> arm,
             hw::Network* network = nullptr);
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  [[nodiscard]] const ControllerOptions& options() const { return options_; }
  /// A fault: from now on RTDE sends the package that it sent last, over and over.
  void set_stuck(bool stuck) { stuck_ = stuck; }
  [[nodiscard]] bool stuck() const { return stuck_; }
  [[nodiscard]] bool is_e_series() const { return options_.version.major >= 5; }
  /// Of the control cycle.
  [[nodiscard]] Nanoseconds cycle() const { return kSecond / options_.version.frequency(); }
  /// What its clock shows at the newest frame; advances by exactly a cycle in each.
  [[nodiscard]] Nanoseconds time() const { return options_.uptime + static_cast<Nanoseconds>(frame_) * cycle(); }
  [[nodiscard]] std::uint64_t frame() const { return frame_; }

  /// The next frame.
  void run_frame(const PlantSample& plant);
  /// A frame in which nothing is known of the joints: its clock goes on, nothing else.
  void skip_frame() { ++frame_; }
  /// What the joints are told for the beginning of this frame, and for its end; between them they go by the polynomial
  /// of fifth degree.
  [[nodiscard]] const motion::JointSample& told() const { return told_; }
  [[nodiscard]] const motion::JointSample& told_next() const { return told_next_; }
  [[nodiscard]] const PlantSample& plant() const { return plant_; }

  // -- Parts ---------------------------------------------------------------------------------------------------------
  PowerState& power() { return power_; }
  Motion& motion() { return motion_; }
  Programs& programs() { return programs_; }
  Terminals& io() { return io_; }
  Registers& inputs() { return inputs_; }
  Registers& outputs() { return outputs_; }
  ControllerSettings& settings() { return settings_; }
  EventLog& events() { return events_; }
  ScriptSockets& sockets() { return sockets_; }
  /// Every output field of this frame.
  [[nodiscard]] const std::vector<FieldValue>& fields() const { return fields_; }
  /// What the surroundings exert on the tool, less what zero_ftsensor() took: N and Nm, at the tool centre point, axes
  /// of the base.
  [[nodiscard]] Vector6 tcp_force() const { return wrench_ - settings_.wrench_offset; }

  // -- What several interfaces can ask for
  // -----------------------------------------------------------------------------
  /// Starts the program that is loaded, or goes on with a paused one. @return false: it cannot now
  bool play();
  void stop_program();
  void protective_stop(const std::string& why, int code = 209, int level = 2);
  void emergency_stop(bool pressed);
  void power_off();
  /// The arm goes where a hand leads it, until a program begins, the robot stops, or end_freedrive(). Nothing happens
  /// while a program runs, or while the robot may not move.
  void begin_freedrive();
  void end_freedrive();
  /// True if a thread may command the motion: none does, or this one. It does from here on.
  bool take_motion(int thread);
  /// The values of one input package, field by field; then what masks say is done.
  void apply_inputs(const std::vector<std::pair<FieldTable::Id, FieldValue>>& values);

 private:
  void release_motion(int thread);
  void poll_external_control();
  void step_motion();
  void follow_plant();
  void update_knots();
  void apply_input(FieldTable::Id id, const FieldValue& value);
  void apply_masks();
  void set_input(std::string_view name, double value);
  [[nodiscard]] double input(std::string_view name) const;
  void fill_fields();
  void fill_motion_fields();
  void fill_mode_fields();
  void fill_io_fields();
  void fill_register_fields(std::string_view direction, const Registers& registers);
  void set_field(std::string_view name, const FieldValue& value);
  void set_field(std::string_view name, double value) { set_field(name, FieldValue{value}); }
  void set_joints(std::string_view name, const JointVector& values);

  ControllerOptions options_;
  bool stuck_ = false;
  PowerState power_;
  Motion motion_;
  Terminals io_;
  Registers inputs_, outputs_;
  ControllerSettings settings_;
  EventLog events_;
  ScriptSockets sockets_;
  urscript::Library library_;
  Programs programs_;
  ExternalControl external_control_;
  PlantSample plant_;
  Vector6 wrench_ = Vector6::Zero();
  std::uint64_t frame_ = 0;
  int motion_thread_ = 0;
  SafetyMode safety_told_ = SafetyMode::kNormal;
  bool program_began_ = false;        // outputs follow it
  bool freed_ = false;                // by begin_freedrive()
  std::array<JointVector, 4> knots_;  // q of the frame before this one, of this one, and of the two after
  motion::JointSample told_, told_next_;
  std::vector<FieldValue> fields_, input_values_;
};

/// All built-in functions of a controller. It outlives the library.
void add_register_functions(urscript::Library& library, Controller& controller);
void add_io_functions(urscript::Library& library, Controller& controller);
void add_installation_functions(urscript::Library& library, Controller& controller);
void add_motion_functions(urscript::Library& library, Controller& controller);
void add_kinematics_functions(urscript::Library& library, Controller& controller);
void add_force_functions(urscript::Library& library, Controller& controller);
void add_system_functions(urscript::Library& library, Controller& controller);
void add_socket_functions(urscript::Library& library, Controller& controller);

}  // namespace takt::hw::rtde
