#include "hw/rtde/driver.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/kinematics/chain.h"
#include "core/motion/rotation_vector.h"

namespace takt::hw::rtde {

namespace {

using kinematics::JointVector;

constexpr std::uint16_t kDashboard = 29999, kSecondary = 30002, kRtde = 30004;
constexpr Nanoseconds kRetry = kSecond;              // between two attempts to connect
constexpr Nanoseconds kConnectTime = 5 * kSecond;    // in which connections and set-ups are done
constexpr Nanoseconds kStartTime = 5 * kSecond;      // in which an uploaded program runs
constexpr Nanoseconds kSilence = kSecond;            // without a package: the connection is given up
constexpr Nanoseconds kLinkGap = 50 * kMillisecond;  // without a package: the controller's watchdog may have stopped us
constexpr Nanoseconds kGapTime = 2 * kSecond;        // after a gap in which a stop is still taken for the watchdog's
constexpr Nanoseconds kPayloadTime = 2 * kSecond;    // in which the controller shows the payload that it was told
constexpr double kPayloadOpen = 1e-3;                // kg
constexpr Nanoseconds kEchoTime = 200 * kMillisecond;  // in which our program follows another package
constexpr Nanoseconds kBrakingTime = 3 * kSecond;      // the same, while it brakes
constexpr int kNever = 1'000'000;
constexpr int kMark = 0x7a61;  // of our program, in a register

/// Places of the outputs in the request.
enum OutputPlace : std::size_t {
  kTimestamp,
  kActualQ,
  kActualQd,
  kTargetQ,
  kRobotMode,
  kSafetyMode,
  kRuntimeState,
  kTcpPose,
  kTcpForce,
  kDigitalIn,
  kAnalogIn0,
  kAnalogIn1,
  kProgramState,
  kSequenceOut,
  kMarkOut,
  kPayloadMass  // the first optional one
};

JointVector joints(const FieldValue& value) {
  JointVector q(6);
  std::copy(value.begin(), value.end(), q.begin());
  return q;
}

/// Whether the controller's state is the cause, so that the fault ends with it.
bool is_state_fault(DriverFault fault) {
  return fault == DriverFault::kProtectiveStop || fault == DriverFault::kSafetyStop ||
         fault == DriverFault::kNotRunning;
}

struct FaultText {
  DriverFault fault;
  std::string_view text;
};
constexpr std::array<FaultText, 15> kFaultTexts = {
    {{DriverFault::kNotConnected, "the controller does not answer: check its address, the cable and its firewall"},
     {DriverFault::kRefused, "the controller is not the one that was expected"},
     {DriverFault::kNotRunning, "the robot has no power, or its brakes are closed: power it on and release the brakes"},
     {DriverFault::kProtectiveStop, "protective stop: find its cause, then unlock it on the pendant"},
     {DriverFault::kSafetyStop, "a safety stop: release the emergency stop or the safeguard, then power the robot on"},
     {DriverFault::kOtherProgram, "another program runs on the controller: stop it there"},
     {DriverFault::kProgramStopped,
      "the program was stopped at the controller: find out why, then reset the arm or run again"},
     {DriverFault::kProgramFailed,
      "the program did not start: is the controller in remote control, and is its log free of errors?"},
     {DriverFault::kPackagesMissing,
      "the controller heard nothing for too long and stopped the arm: reset the arm or run again"},
     {DriverFault::kPaused, "the program is paused at the controller: resume it there"},
     {DriverFault::kPayload, "the controller uses another payload than the one that was set: check the installation"},
     {DriverFault::kStarting, "the program is being started"},
     {DriverFault::kFreedrive, "the arm is led by hand"},
     {DriverFault::kConnectionLost,
      "the connection to the controller was lost: check the cable and the controller, then reset the arm or run again"},
     {DriverFault::kResetMissing, "the robot may move again: reset the arm or run again"}}};

}  // namespace

ClientRequest Driver::request_for(const DriverOptions& options, const TerminalBlock* block) {
  const RegisterLayout registers{options.registers};
  ClientRequest request;
  request.outputs = {"timestamp",
                     "actual_q",
                     "actual_qd",
                     "target_q",
                     "robot_mode",
                     "safety_mode",
                     "runtime_state",
                     "actual_TCP_pose",
                     "actual_TCP_force",
                     "actual_digital_input_bits",
                     "standard_analog_input0",
                     "standard_analog_input1",
                     registers.state_out(),
                     registers.sequence_out(),
                     registers.mark_out()};
  request.optional_outputs = {"payload"};
  std::vector<std::string> recipe = {registers.sequence_in(), registers.mode_in()};
  for (int i = 0; i < 6; ++i) recipe.push_back(registers.joint_in(i));
  request.inputs = {recipe};
  // Who writes an output keeps other clients from it: only what the block has.
  if (block != nullptr && !block->fields().empty()) request.inputs.push_back(block->fields());
  return request;
}

Driver::Driver(const DriverOptions& options, const device::DriverRequest& request, hw::Network& network,
               const Clock& clock)
    : options_(options),
      arm_(request.description),
      network_(network),
      clock_(clock),
      agent_(arm_->limits,
             {.core_period = request.core_period,
              .device_cycle = options.cycle(),
              .lead_cycles = kLeadCycles,
              .margin = options.margin,
              .padding = request.padding},
             clock),
      force_agent_(clock, options.cycle(), options.margin),
      block_(request.terminals == nullptr
                 ? nullptr
                 : std::make_unique<TerminalBlock>(*request.terminals,
                                                   [this](std::uint32_t fault) { return fault_text(fault); })),
      client_(request_for(options, block_.get())) {
  program_.registers.half = options.registers;
  program_.lookahead = options.lookahead;
  program_.gain = options.gain;
  program_.mark = kMark;
  program_.version.major = options.e_series ? 5 : 3;
  program_.deceleration = arm_->limits.acceleration.minCoeff();
}

Driver::~Driver() {
  // The program ends by itself; whatever is lost of this, the watchdog does.
  if (stage_ == Stage::kStreaming) send(ControlMode::kEnd, nullptr);
  rtde_link_.flush();
}

// -- The cycle
// ---------------------------------------------------------------------------------------------------------

void Driver::set_held(bool held) {
  held_.store(held);
  agent_.set_held(held);
}

bool Driver::read(device::ArmSample& sample) {
  const bool any = agent_.read(sample);
  if (const DriverFault fault = wire_fault_.load(); fault != DriverFault::kNone) {
    sample.ready = false;
    sample.fault = static_cast<std::uint32_t>(fault);
  }
  return any;
}

void Driver::set_payload(const device::PayloadSetting& payload) { payload_slot_.publish(payload); }

void Driver::brake() {
  brake_.store(true);
  agent_.brake();
}

std::string Driver::fault_text(std::uint32_t fault) const {
  if (fault == 0) fault = static_cast<std::uint32_t>(wire_fault_.load());
  if (fault == static_cast<std::uint32_t>(DriverFault::kRefused)) {
    if (std::string refused = refusal(); !refused.empty()) return refused;
  }
  const auto at = std::ranges::find(kFaultTexts, static_cast<DriverFault>(fault), &FaultText::fault);
  return at == kFaultTexts.end() ? device::ArmAgent::fault_text(fault) : std::string(at->text);
}

device::BackendTiming Driver::timing() const {
  const device::AgentTiming& agent = agent_.timing();
  return {.cycle = options_.cycle(),
          .sample_age = options_.cycle() + options_.transport + options_.margin + agent.core_period,
          .driver_delay = agent.driver_delay(),
          .dead_time = agent.dead_time()};
}

std::vector<std::string> Driver::news() {
  const std::scoped_lock lock(news_mutex_);
  return std::exchange(news_, {});
}

std::string Driver::refusal() const {
  const std::scoped_lock lock(news_mutex_);
  return refusal_;
}

void Driver::tell(std::string line) {
  static constexpr std::size_t kMostNews = 100;
  const std::scoped_lock lock(news_mutex_);
  if (news_.size() < kMostNews) news_.push_back(std::move(line));
}

// -- Connecting
// --------------------------------------------------------------------------------------------------------

void Driver::poll() {
  for (hw::ByteLink* link : {&rtde_link_, &dashboard_link_, &script_link_}) link->flush();
  // A category 0 stop waits for nothing.
  if (brake_.exchange(false)) dashboard_.ask("power off");
  step_dashboard();
  switch (stage_) {
    case Stage::kApart:
      if (counts_.connections == 0 || now() - stage_since_ >= kRetry) begin_connecting();
      break;
    case Stage::kConnecting:
      step_connecting();
      break;
    case Stage::kSettingUp:
    case Stage::kWaiting:
    case Stage::kUploading:
    case Stage::kStreaming:
      receive();
      break;
    case Stage::kRefused:
      break;
  }
}

void Driver::set_stage(Stage stage) {
  stage_ = stage;
  stage_since_ = now();
}

void Driver::begin_connecting() {
  ++counts_.connections;
  client_ = Client(request_for(options_, block_.get()));
  dashboard_.reset();
  model_known_ = payload_sent_ = false;
  timestamp_ = -1.0;
  set_stage(Stage::kConnecting);
  for (const auto& [link, port] :
       {std::pair{&rtde_link_, kRtde}, {&dashboard_link_, kDashboard}, {&script_link_, kSecondary}})
    if (auto tried = link->connect(network_, {options_.host, port}); !tried)
      return lose_connection(tried.error().to_string());
  dashboard_.ask("get robot model");
  if (options_.e_series) dashboard_.ask("is in remote control");
  if (options_.power_on) {
    dashboard_.ask("power on");
    dashboard_.ask("brake release");
  }
}

void Driver::lose_connection(const std::string& why) {
  const bool was_there = stage_ != Stage::kApart && stage_ != Stage::kConnecting;
  if (stage_ != Stage::kApart) tell((was_there ? "connection lost: " : "no connection: ") + why);
  if (was_there || wire_fault_ != DriverFault::kConnectionLost)
    wire_fault_ = was_there ? DriverFault::kConnectionLost : DriverFault::kNotConnected;
  fault_ = wire_fault_;
  for (hw::ByteLink* link : {&rtde_link_, &dashboard_link_, &script_link_}) link->close();
  if (block_) block_->lose(static_cast<std::uint32_t>(fault_));
  set_stage(Stage::kApart);
}

void Driver::step_connecting() {
  for (hw::ByteLink* link : {&rtde_link_, &dashboard_link_, &script_link_})
    if (link->state() == hw::ByteLink::State::kFailed || link->state() == hw::ByteLink::State::kEnded)
      return lose_connection(link->error());
  if (now() - stage_since_ > kConnectTime) return lose_connection("no answer");
  if (!rtde_link_.open() || !dashboard_link_.open() || !script_link_.open()) return;
  client_.begin();
  rtde_link_.send(std::exchange(client_.out(), {}));
  set_stage(Stage::kSettingUp);
  last_package_ = now();
  tell("connected to " + hw::to_string({options_.host, kRtde}));
}

void Driver::step_dashboard() {
  dashboard_link_.receive([this](std::string_view bytes) { dashboard_.receive(bytes); });
  while (const auto answer = dashboard_.next_answer()) check_answer(*answer);
  if (dashboard_link_.open()) dashboard_link_.send(dashboard_.take_out());
  script_link_.receive([](std::string_view) {});  // states that are read elsewhere
}

void Driver::check_answer(const DashboardClient::Answer& answer) {
  Diagnostics problems;
  if (answer.command == "get robot model") {
    // Old software does not know the question.
    const bool knows = !answer.text.starts_with("could not understand");
    if (knows && !answer.text.starts_with(options_.model))
      problems.error(
          Code::kIncompatible, {}, fmt::format("the robot is a {}", answer.text),
          fmt::format("Give the address of a {}, or put the model of this robot into the scenario", options_.model));
    model_known_ = true;
  } else if (answer.command == "is in remote control" && answer.text == "false") {
    problems.error(Code::kNotPossibleNow, {}, "the controller is not in remote control",
                   "Switch it to remote control on the pendant, upper right");
  }
  if (problems.has_errors()) refuse(problems);
}

void Driver::refuse(const Diagnostics& problems) {
  problems_.append(problems);
  wire_fault_ = fault_ = DriverFault::kRefused;
  {
    const std::scoped_lock lock(news_mutex_);
    refusal_ = fmt::format("{} ({})", problems_.list().front().message, problems_.list().front().hint);
  }
  if (block_) block_->lose(static_cast<std::uint32_t>(DriverFault::kRefused));
  tell("refused: " + problems.to_string());
  for (hw::ByteLink* link : {&rtde_link_, &dashboard_link_, &script_link_}) link->close();
  set_stage(Stage::kRefused);
}

// -- Packages
// ----------------------------------------------------------------------------------------------------------

void Driver::receive() {
  int packages = 0;
  rtde_link_.receive([&](std::string_view bytes) { packages += client_.receive(bytes); });
  rtde_link_.send(std::exchange(client_.out(), {}));
  counts_.misshapen = client_.misshapen();
  for (const TextMessage& message : client_.take_messages()) tell("controller: " + message.text);
  if (client_.state() == Client::State::kRefused) return refuse(client_.problems());
  if (client_.state() == Client::State::kRunning && stage_ == Stage::kSettingUp && model_known_) {
    const bool series = client_.version().major == (options_.e_series ? 5u : 3u);
    if (!series) {
      Diagnostics problems;
      problems.error(
          Code::kIncompatible, {}, fmt::format("the controller has software {}", to_string(client_.version())),
          options_.e_series ? "Leave series=e out for a CB3 controller" : "Say series=e for an e-Series controller");
      return refuse(problems);
    }
    program_.version = client_.version();
    set_stage(Stage::kWaiting);
  }
  // Of a burst only the newest package is answered.
  if (packages > 0) {
    counts_.packages += static_cast<std::uint64_t>(packages);
    if (is_new_package()) {
      if (now() - last_package_ > kLinkGap) last_gap_ = now();
      take_package();
      last_package_ = now();
    }
  }
  const auto state = rtde_link_.state();
  if (state != hw::ByteLink::State::kOpen) return lose_connection(rtde_link_.error());
  if (stage_ != Stage::kRefused && now() - last_package_ > kSilence) lose_connection("no packages");
}

/// A package with the time of the one before is a repetition. It is neither answered nor a sign of life, since a
/// controller that hangs may send its last state for ever.
bool Driver::is_new_package() {
  const double timestamp = value(kTimestamp)[0];
  if (timestamp != timestamp_) {
    timestamp_ = timestamp;
    return true;
  }
  if (counts_.repeated++ == 0) tell("the controller repeats packages; repetitions are ignored");
  return false;
}

void Driver::take_package() {
  if (stage_ == Stage::kSettingUp) return;
  step_program();
  take_terminals();
  send_payload();
  check_payload();
  answer_package();
}

/// Registers keep what an old program wrote, so only a number that goes on tells that ours runs.
void Driver::watch_echo() {
  const int echo = integer(kSequenceOut);
  echo_age_ = echo != echo_ ? 0 : std::min(echo_age_ + 1, kNever);
  echo_ = echo;
}

bool Driver::alive() const {
  if (client_.state() != Client::State::kRunning || integer(kMarkOut) != kMark) return false;
  const bool braking = integer(kProgramState) == static_cast<int>(ProgramState::kStopped);
  return Nanoseconds{echo_age_} * options_.cycle() < (braking ? kBrakingTime : kEchoTime);
}

bool Driver::running() const {
  return integer(kRobotMode) == static_cast<int>(RobotMode::kRunning) &&
         allows_motion(static_cast<SafetyMode>(integer(kSafetyMode)));
}

/// Why the arm cannot move, as far as the controller's state tells.
DriverFault Driver::state_fault() const {
  const auto safety = static_cast<SafetyMode>(integer(kSafetyMode));
  if (safety == SafetyMode::kProtectiveStop) return DriverFault::kProtectiveStop;
  if (!allows_motion(safety)) return DriverFault::kSafetyStop;
  if (integer(kRobotMode) != static_cast<int>(RobotMode::kRunning)) return DriverFault::kNotRunning;
  return DriverFault::kNone;
}

/// Follows the program on the controller, and uploads it where that is allowed.
void Driver::step_program() {
  watch_echo();
  const auto runtime = static_cast<RuntimeState>(integer(kRuntimeState));
  if (reset_.exchange(false)) may_upload_ = true;
  if (runtime == RuntimeState::kStopped && stage_ != Stage::kStreaming) uploaded_ = false;
  if (const DriverFault fault = state_fault(); fault != DriverFault::kNone) {
    fault_ = fault;
    return set_stage(Stage::kWaiting);
  }
  if (stage_ == Stage::kStreaming) return step_streaming(runtime);
  if (stage_ == Stage::kWaiting) return step_waiting(runtime);
  if (runtime == RuntimeState::kPlaying && alive() && echo_age_ == 0) {
    uploaded_ = true;
    may_upload_ = false;  // what ends it from now on is looked into first
    set_stage(Stage::kStreaming);
  } else if (now() - stage_since_ > kStartTime) {
    fault_ = DriverFault::kProgramFailed;
    may_upload_ = false;
    set_stage(Stage::kWaiting);
  }
}

void Driver::step_streaming(RuntimeState runtime) {
  const auto state = static_cast<ProgramState>(integer(kProgramState));
  if (runtime == RuntimeState::kPaused) {
    fault_ = DriverFault::kPaused;
  } else if (runtime != RuntimeState::kPlaying || !alive()) {
    note_stop();
  } else if (state == ProgramState::kStopped) {
    fault_ = DriverFault::kPackagesMissing;
  } else {
    fault_ = state == ProgramState::kFreedrive ? DriverFault::kFreedrive : DriverFault::kNone;
  }
}

void Driver::step_waiting(RuntimeState runtime) {
  const bool plays = runtime == RuntimeState::kPlaying, paused = runtime == RuntimeState::kPaused;
  if ((plays && !alive()) || (paused && !uploaded_)) {
    fault_ = DriverFault::kOtherProgram;
  } else if (fault_ == DriverFault::kOtherProgram) {
    fault_ = may_upload_ ? DriverFault::kStarting : DriverFault::kProgramStopped;  // it has ended
  } else if (may_upload_ && !held_.load()) {
    upload();
  } else if (!may_upload_ && is_state_fault(fault_)) {
    fault_ = DriverFault::kResetMissing;  // the state that was the cause is over
  }
}

/// Our program is gone. If the wire was silent before, the controller's watchdog did it; else somebody at the
/// controller.
void Driver::note_stop() {
  const bool silent = now() - last_gap_ < kGapTime;
  const bool other = static_cast<RuntimeState>(integer(kRuntimeState)) == RuntimeState::kPlaying;
  fault_ = other ? DriverFault::kOtherProgram : silent ? DriverFault::kPackagesMissing : DriverFault::kProgramStopped;
  uploaded_ = false;
  tell(fault_text(static_cast<std::uint32_t>(fault_)));
  set_stage(Stage::kWaiting);
}

void Driver::upload() {
  ++counts_.uploads;
  fault_ = DriverFault::kStarting;
  send(ControlMode::kIdle, nullptr);
  script_link_.send(program_.text());
  tell("program uploaded");
  set_stage(Stage::kUploading);
}

void Driver::answer_package() {
  // The controller's uptime in whole cycles is the number of the package.
  const double cycles = std::round(value(kTimestamp)[0] / to_seconds(options_.cycle()));
  device::ArmPacket packet;
  packet.sample.sequence = static_cast<std::uint64_t>(std::max(1.0, cycles));
  packet.instant = static_cast<Nanoseconds>(packet.sample.sequence) * options_.cycle();
  packet.sample.stamp = packet.instant;
  packet.sample.q = joints(value(kActualQ));
  packet.sample.dq = joints(value(kActualQd));
  packet.sample.commanded = joints(value(kTargetQ));
  packet.sample.braked = integer(kRobotMode) != static_cast<int>(RobotMode::kRunning);
  packet.sample.ready = stage_ == Stage::kStreaming && fault_ == DriverFault::kNone;
  packet.sample.fault = static_cast<std::uint32_t>(fault_);
  take_force(packet.sample.sequence, packet.instant);
  const auto answer = agent_.answer(packet);
  wire_fault_ = DriverFault::kNone;
  const bool leads = freedrive_wanted_.load() && !held_.load();
  if (stage_ == Stage::kUploading) {
    send(ControlMode::kIdle, nullptr);
  } else if (leads && stage_ == Stage::kStreaming) {
    send(ControlMode::kFreedrive, nullptr);
  } else {
    const bool moves = packet.sample.ready && answer.has_value();
    send(moves ? ControlMode::kPosition : ControlMode::kIdle, moves ? &answer->state : nullptr);
  }
  counts_.loop_delay = sequence_ - integer(kSequenceOut);
}

/// What servoj() must be told so that it is at `state` at the end of its cycle: it covers only a share of the distance.
void Driver::send(ControlMode mode, const motion::JointSample* state) {
  sequence_ = sequence_ == std::numeric_limits<std::int32_t>::max() ? 1 : sequence_ + 1;
  package_.assign(8, FieldValue{});
  package_[0][0] = sequence_;
  package_[1][0] = static_cast<double>(mode);
  if (state != nullptr) {
    const double h = to_seconds(options_.cycle()), lead = 1.0 / program_.share() - 1.0;
    const kinematics::JointVector step = h * state->dq - 0.5 * h * h * state->ddq;
    for (int i = 0; i < 6; ++i) package_[static_cast<std::size_t>(i) + 2][0] = state->q[i] + lead * step[i];
  }
  client_.send(0, package_);
  if (block_ && block_->take_outputs()) client_.send(1, block_->outputs());
  rtde_link_.send(std::exchange(client_.out(), {}));
  ++counts_.sent;
}

/// actual_TCP_force: what the surroundings exert, its torque about the tool centre point of the controller, in axes of
/// the base. Here about the origin of the flange and in its axes, as a sensor that is mounted there has it.
void Driver::take_force(std::uint64_t sequence, Nanoseconds instant) {
  const FieldValue &pose = value(kTcpPose), &wrench = value(kTcpForce);
  const Eigen::Isometry3d X_BF = arm_->chain->forward(joints(value(kActualQ)));
  const Eigen::Vector3d p_FT_B = Eigen::Vector3d(pose[0], pose[1], pose[2]) - X_BF.translation();
  const Eigen::Vector3d force_B(wrench[0], wrench[1], wrench[2]), torque_B(wrench[3], wrench[4], wrench[5]);
  device::WrenchSample sample;
  sample.sequence = sequence;
  sample.stamp = instant;
  sample.wrench.force = X_BF.linear().transpose() * force_B;
  sample.wrench.torque = X_BF.linear().transpose() * (torque_B + p_FT_B.cross(force_B));
  force_agent_.take(sample, instant);
}

void Driver::take_terminals() {
  if (block_ == nullptr) return;
  block_->take(static_cast<std::uint64_t>(value(kDigitalIn)[0]), {value(kAnalogIn0)[0], value(kAnalogIn1)[0]},
               clock_.now() - options_.transport);
}

// -- Payload
// -----------------------------------------------------------------------------------------------------------

void Driver::send_payload() {
  if (payload_slot_.take()) {
    payload_told_ = true;
    payload_sent_ = false;
  }
  if (!payload_told_ || payload_sent_ || !running()) return;
  const device::PayloadSetting& payload = payload_slot_.value();
  script_link_.send(fmt::format("sec takt_payload():\n  set_payload({}, [{}, {}, {}])\nend\n", payload.mass,
                                payload.p_FC.x(), payload.p_FC.y(), payload.p_FC.z()));
  payload_sent_ = true;
  payload_since_ = now();
}

void Driver::check_payload() {
  if (!payload_sent_ || !client_.has_optional(0) || now() - payload_since_ < kPayloadTime) return;
  if (std::abs(value(kPayloadMass)[0] - payload_slot_.value().mass) > kPayloadOpen && fault_ == DriverFault::kNone)
    fault_ = DriverFault::kPayload;
}

std::uint64_t Driver::hash() const {
  emulation::StateHash hash;
  hash.begin();
  hash.add(static_cast<std::uint64_t>(stage_));
  hash.add(static_cast<std::uint64_t>(fault_));
  hash.add(static_cast<std::uint64_t>(sequence_));
  hash.add(counts_.packages);
  if (block_) block_->add_to(hash);
  return hash.value();
}

}  // namespace takt::hw::rtde
