#include "hw/emulators/rtde/controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "languages/urscript/functions.h"

namespace takt::hw::rtde {

namespace {

/// The state of motion in the middle of three positions, a period apart.
motion::JointSample state_between(const JointVector& before, const JointVector& here, const JointVector& after,
                                  double period) {
  return {here, (after - before) / (2.0 * period), (after - 2.0 * here + before) / (period * period)};
}

/// A share that counts; one that is out of range, or no number, counts as not written.
bool is_share(double value) { return value >= 0.0 && value <= 1.0; }

/// What an installed program does that has nothing to do.
constexpr std::string_view kWaiting = "def takt():\n  while True:\n    sync()\n  end\nend\n";

}  // namespace

Controller::Controller(const ControllerOptions& options, std::shared_ptr<const device::ArmDescription> arm,
                       hw::Network* network)
    : options_(options),
      power_(options.running),
      motion_(arm, to_seconds(kSecond / options.version.frequency())),
      sockets_(network),
      programs_(library_, events_, [this](int thread) { release_motion(thread); }),
      external_control_(network, options.external_control),
      fields_(output_fields().size()),
      input_values_(input_fields().size()) {
  add_register_functions(library_, *this);
  add_io_functions(library_, *this);
  add_installation_functions(library_, *this);
  add_motion_functions(library_, *this);
  add_kinematics_functions(library_, *this);
  add_force_functions(library_, *this);
  urscript::add_math_functions(library_);
  urscript::add_pose_functions(library_);
  add_system_functions(library_, *this);
  add_socket_functions(library_, *this);
  programs_.installed = options_.programs;
  programs_.installed["/programs/takt.urp"] = kWaiting;
  if (external_control_.installed()) programs_.installed[std::string(ExternalControl::kPath)] = kWaiting;
  (void)programs_.load("/programs/takt.urp");
  power_.step(time());
  plant_.q = arm->home;
  plant_.dq = JointVector::Zero(arm->home.size());
  knots_.fill(arm->home);
  update_knots();
  told_ = told_next_;
  fill_fields();  // what programs read in their first frame
}

void Controller::run_frame(const PlantSample& plant) {
  ++frame_;
  plant_ = plant;
  wrench_ = motion_.kinematics().wrench(plant.q, plant.tau_external);
  power_.step(time());
  if (programs_.running() || !power_.can_move()) end_freedrive();
  poll_external_control();
  if (programs_.running() && !std::exchange(program_began_, true)) io_.follow_program(true);
  programs_.run_frame(time(), power_.can_move());
  step_motion();
  if (power_.safety() != safety_told_) {
    safety_told_ = power_.safety();
    events_.add({.kind = ControllerEvent::Kind::kSafetyMode,
                 .argument = static_cast<std::int32_t>(safety_told_),
                 .title = {},
                 .text = {},
                 .time = time()});
  }
  fill_fields();
}

void Controller::step_motion() {
  if (!power_.drives_on() || plant_.stopped) return follow_plant();
  const bool halted = !power_.can_move() || programs_.state() == RuntimeState::kPaused;
  motion_.halt(halted);
  if (const auto problem = motion_.step(settings_.slider, tcp_force())) protective_stop(*problem, 204, 3);
  std::ranges::rotate(knots_, knots_.begin() + 1);
  knots_.back() = motion_.q();
  update_knots();
}

/// Without the drives the arm stands where its brakes hold it, and so does a machine that has stopped by itself.
void Controller::follow_plant() {
  const JointVector& held = plant_.held.size() > 0 ? plant_.held : plant_.q;
  motion_.rest_at(held);
  knots_.fill(held);
  update_knots();
  told_ = told_next_;
}

void Controller::update_knots() {
  const double period = to_seconds(cycle());
  told_ = std::exchange(told_next_, state_between(knots_[1], knots_[2], knots_[3], period));
}

// -- What several interfaces can ask for
// -------------------------------------------------------------------------------

bool Controller::play() {
  if (!power_.can_move() || !options_.remote_control) return false;
  const bool external = external_control_.installed() && programs_.loaded() == ExternalControl::kPath;
  return external && !programs_.running() ? external_control_.begin(time()) : programs_.play();
}

void Controller::stop_program() {
  external_control_.cancel();
  programs_.stop();
}

void Controller::poll_external_control() {
  const auto script = external_control_.poll(time());
  if (!script) return;
  if (*script) {
    (void)programs_.start(**script);
  } else {
    events_.add({.kind = ControllerEvent::Kind::kError,
                 .level = 2,
                 .title = {},
                 .text = script->error().list().front().message,
                 .time = time()});
  }
}

void Controller::protective_stop(const std::string& why, int code, int level) {
  power_.protective_stop();
  programs_.pause();
  events_.add(
      {.kind = ControllerEvent::Kind::kError, .code = code, .level = level, .title = {}, .text = why, .time = time()});
}

void Controller::emergency_stop(bool pressed) {
  power_.emergency_stop(pressed);
  if (pressed) stop_program();
}

void Controller::power_off() {
  stop_program();
  power_.power_off();
}

void Controller::begin_freedrive() {
  if (programs_.running() || !power_.can_move()) return;
  freed_ = settings_.freedrive = true;
  motion_.set_force_task(led_by_hand());
}

void Controller::end_freedrive() {
  if (!std::exchange(freed_, false)) return;
  settings_.freedrive = false;
  motion_.set_force_task({});
}

bool Controller::take_motion(int thread) {
  if (thread >= Programs::kFirstSecondary) return false;
  if (motion_thread_ != 0 && motion_thread_ != thread && programs_.alive(motion_thread_) &&
      !(motion_.commands_rest() && motion_.move_done()))
    return false;
  motion_thread_ = thread;
  return true;
}

void Controller::release_motion(int thread) {
  if (thread != 0 && thread != motion_thread_) return;
  motion_thread_ = 0;
  if (thread == 0) {
    motion_.set_force_task({});
    settings_.freedrive = false;
    sockets_.close_all();
    program_began_ = false;
    io_.follow_program(false);
  }
  motion_.stop(Motion::kDeceleration);
}

// -- Inputs
// ------------------------------------------------------------------------------------------------------------

void Controller::apply_inputs(const std::vector<std::pair<FieldTable::Id, FieldValue>>& values) {
  for (const auto& [id, value] : values) apply_input(id, value);
  apply_masks();
}

void Controller::apply_input(FieldTable::Id id, const FieldValue& value) {
  static const FieldTable::Id kInts = input_fields().at("input_int_register_0"),
                              kReals = input_fields().at("input_double_register_0"),
                              kBits = input_fields().at("input_bit_register_64"),
                              kFirstWord = input_fields().at("input_bit_registers0_to_31"),
                              kSecondWord = input_fields().at("input_bit_registers32_to_63");
  programs_.fed(id);
  input_values_[id] = value;
  if (id >= kInts && id < kInts + Registers::kCount) {
    inputs_.ints[id - kInts] = static_cast<std::int32_t>(value[0]);
  } else if (id >= kReals && id < kReals + Registers::kCount) {
    if (std::isfinite(value[0])) inputs_.reals[id - kReals] = value[0];
  } else if (id >= kBits && id < kBits + 64u) {
    inputs_.bits[64u + id - kBits] = value[0] != 0.0;
  } else if (id == kFirstWord || id == kSecondWord) {
    inputs_.set_word(id == kFirstWord ? 0 : 32, static_cast<std::uint32_t>(value[0]));
  }
}

double Controller::input(std::string_view name) const { return input_values_[input_fields().at(name)][0]; }
void Controller::set_input(std::string_view name, double value) { input_values_[input_fields().at(name)][0] = value; }

/// A mask counts once, in the frame of its package.
void Controller::apply_masks() {
  static constexpr std::array<std::pair<std::string_view, int>, 3> kDigital = {
      {{"standard", 0}, {"configurable", Terminals::kConfigurable}, {"tool", Terminals::kTool}}};
  for (const auto& [group, first] : kDigital) {
    const std::string name = fmt::format("{}_digital_output", group);
    const auto most = static_cast<std::uint8_t>(first == Terminals::kTool ? 0b11 : 0xff);
    const auto mask = static_cast<std::uint8_t>(static_cast<std::uint8_t>(input(name + "_mask")) & most);
    io_.set_digital_out(mask, static_cast<std::uint8_t>(input(name)), first);
    set_input(name + "_mask", 0.0);
  }
  const auto analog = static_cast<unsigned>(input("standard_analog_output_mask"));
  const auto types = static_cast<unsigned>(input("standard_analog_output_type"));
  for (unsigned i = 0; i < 2; ++i) {
    const double level = input(fmt::format("standard_analog_output_{}", i));
    if ((analog >> i & 1u) == 0 || !is_share(level)) continue;
    io_.analog_out[i] = level;
    Terminals::set_type(io_.analog_types, Terminals::kAnalogOut + i, (types >> i & 1u) != 0);
  }
  set_input("standard_analog_output_mask", 0.0);
  const double slider = input("speed_slider_fraction");
  if (input("speed_slider_mask") == 1.0 && is_share(slider)) settings_.slider = slider;
  set_input("speed_slider_mask", 0.0);
}

}  // namespace takt::hw::rtde
