#include "cell/run/run_recorder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "cell/build/command_tape.h"
#include "cell/build/site_devices.h"
#include "cell/build/topics.h"
#include "cell/run/recorded_models.h"
#include "cell/run/scene_message.h"
#include "record/recording.h"
#include "record/schemas.h"

namespace takt::cell {
namespace {

constexpr std::int64_t kPoseCycles = 20;  ///< poses change slowly against 1 kHz: fifty a second serve every viewer

/// Names of the positions in qpos, so that a recording can be drawn again with the model that it carries.
std::vector<std::string> position_names(const mjModel& model) {
  std::vector<std::string> names;
  for (int i = 0; i < model.nq; ++i) names.push_back(fmt::format("qpos{}", i));
  for (int j = 0; j < model.njnt; ++j) {
    const char* name = mj_id2name(&model, mjOBJ_JOINT, j);
    if (name && name[0]) names[static_cast<std::size_t>(model.jnt_qposadr[j])] = name;
  }
  return names;
}

constexpr std::array<const char*, 6> kContactFields = {"point.x", "point.y", "point.z",
                                                       "force.x", "force.y", "force.z"};

/// "1.point.x" ... "8.force.z".
std::vector<std::string> contact_columns() {
  std::vector<std::string> columns;
  for (std::size_t i = 1; i <= record::kMostContactForces; ++i)
    for (const char* field : kContactFields) columns.push_back(fmt::format("{}.{}", i, field));
  return columns;
}

std::vector<std::string> contact_units() {
  std::vector<std::string> units;
  for (std::size_t i = 0; i < record::kMostContactForces; ++i)
    for (std::size_t field = 0; field < kContactFields.size(); ++field) units.emplace_back(field < 3 ? "m" : "N");
  return units;
}

/// Names of the values of an enumeration that counts from 0 to `last`.
template <class Enum>
std::vector<std::string> words_of(Enum last) {
  std::vector<std::string> words;
  for (int value = 0; value <= static_cast<int>(last); ++value) words.emplace_back(name_of(static_cast<Enum>(value)));
  return words;
}

/// The frame of a sensor's readings as "/tf" names it: a link of the sensor, or for an arm's own forces its flange.
std::string wrench_frame(const BuiltCell& built, const std::string& name, const expression::MountedSensor& sensor) {
  std::string link = name + "/" + sensor.device->description().measuring_link;
  if (built.world->body(link) >= 0) return link;
  const auto arm = built.cell.arms.find(sensor.arm);
  return arm == built.cell.arms.end() ? name : arm->first + "/" + arm->second.device->description().flange_link;
}

}  // namespace

Result<std::unique_ptr<RunRecorder>> RunRecorder::open(const std::filesystem::path& path,
                                                       const Description& description, const BuiltCell& built,
                                                       const RunOptions& run) {
  record::RecorderOptions options;
  if (run.realtime) options.policy = record::FullPolicy::kDrop;
  options.keep_last = static_cast<Nanoseconds>(std::llround(1e9 * run.record_last));
  options.metadata = {{"scenario", description.file.filename().string()},
                      {"title", description.title},
                      {"seed", std::to_string(description.seed)},
                      {"devices", to_text(built.site->realities())}};
  if (!run.from.empty()) options.metadata["from"] = run.from;
  options.fingerprint = record::fingerprint({{"mujoco", mj_versionString()}});
  options.attachments.push_back({"scenario.json", "application/json", description.text});
  if (!description.site.text.empty())
    options.attachments.push_back({"site.json", "application/json", description.site.text});
  if (built.library) {
    for (record::Attachment& attachment : model_attachments(description, *built.library))
      options.attachments.push_back(std::move(attachment));
  }
  auto recorder = record::Recorder::open(path, std::move(options));
  if (!recorder) return std::unexpected(std::move(recorder.error()));
  return std::unique_ptr<RunRecorder>(
      new RunRecorder(std::move(*recorder), built, run.record_blocks, !description.expectations.empty()));
}

RunRecorder::RunRecorder(std::unique_ptr<record::Recorder> recorder, const BuiltCell& built, bool with_blocks,
                         bool expects)
    : recorder_(std::move(recorder)), built_(built), with_blocks_(with_blocks), contacts_since_(built) {
  add_channels(expects);
}

void RunRecorder::add_channels(bool expects) {
  for (const auto& [name, arm] : built_.cell.arms) {
    const auto& joints = arm.device->description().joint_names;
    arms_.push_back({&arm, recorder_->add_joint_states(device_topic(name) + "/joint_states", joints),
                     recorder_->add_joint_states(device_topic(name) + "/set_point", joints, {true, true, false}),
                     recorder_->add_samples(device_topic(name) + "/status",
                                            {"phase", "mode", "changing_mode", "braked", "fault"}, {"", "", "", "", ""},
                                            {{"phase", words_of(device::Arm::Phase::kChanging)},
                                             {"mode", words_of(device::ControlMode::kCartesianImpedance)},
                                             {"changing_mode", {"no", "yes"}},
                                             {"braked", {"no", "yes"}}})});
  }
  for (const auto& [name, sensor] : built_.cell.sensors) {
    const std::string frame = wrench_frame(built_, name, sensor);
    sensors_.push_back({&sensor, recorder_->add_wrench(device_topic(name) + "/wrench", frame),
                        recorder_->add_wrench(device_topic(name) + "/contact_wrench", frame),
                        expression::ContactWrenchReader(built_.cell, name)});
  }
  for (const auto& [name, gripper] : built_.cell.grippers) {
    grippers_.push_back(
        {&gripper, recorder_->add_samples(
                       device_topic(name) + "/gripper",
                       {"width", "speed", "force", "state", "wanted_width", "wanted_speed", "wanted_force"},
                       {"m", "m/s", "N", "", "m", "m/s", "N"}, {{"state", words_of(device::GripperState::kLost)}})});
  }
  add_signal_channel();
  add_command_channels();
  const mjModel& model = *built_.world->model();
  std::vector<std::pair<std::string, std::string>> frames;
  for (int body = 1; body < model.nbody; ++body) {
    frames.emplace_back("world", mj_id2name(&model, mjOBJ_BODY, body));
    bodies_.push_back(body);
  }
  poses_.resize(bodies_.size());
  transforms_ = recorder_->add_transforms("/tf", std::move(frames));
  add_object_channel(model);
  if (std::string scene = scene_message(model); !scene.empty())
    recorder_->add_constant("/scene", record::kSceneUpdateSchema, std::move(scene));
  digest_ = recorder_->add_digest("/digest");
  state_ = recorder_->add_state("/state", position_names(model));
  events_ = recorder_->add_events("/program");
  contacts_ = recorder_->add_events(std::string(record::kContactTopic));
  if (expects) expectations_ = recorder_->add_events(std::string(record::kExpectationTopic));
  forces_ = recorder_->add_samples(std::string(record::kContactForceTopic), contact_columns(), contact_units());
  add_object_force_channel();
  log_ = recorder_->add_log(std::string(record::kLogTopic));
  if (with_blocks_) blocks_ = recorder_->add_events(std::string(record::kBlockTopic));
}

void RunRecorder::add_object_force_channel() {
  std::vector<std::string> names = built_.world->body_names(), columns, units;
  if (!names.empty()) names.front() = "floor";
  std::map<std::string, std::vector<std::string>> words;
  for (std::size_t i = 1; i <= record::kMostContactForces; ++i) {
    for (const char* side : {"first", "second"}) {
      columns.push_back(fmt::format("{}.{}", i, side));
      units.emplace_back();
      words[columns.back()] = names;
    }
    for (std::size_t field = 0; field < kContactFields.size(); ++field) {
      columns.push_back(fmt::format("{}.{}", i, kContactFields[field]));
      units.emplace_back(field < 3 ? "m" : "N");
    }
  }
  object_row_.assign(columns.size(), std::numeric_limits<double>::quiet_NaN());
  object_forces_ = recorder_->add_samples(std::string(record::kObjectForceTopic), std::move(columns), std::move(units),
                                          std::move(words));
}

/// Parts that move by themselves have a topic of their own, which a golden holds.
void RunRecorder::add_object_channel(const mjModel& model) {
  std::vector<std::pair<std::string, std::string>> frames;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const int body = bodies_[i];
    if (model.body_jntnum[body] == 0 || model.jnt_type[model.body_jntadr[body]] != mjJNT_FREE) continue;
    frames.emplace_back("world", mj_id2name(&model, mjOBJ_BODY, body));
    free_bodies_.push_back(i);
  }
  free_poses_.resize(free_bodies_.size());
  if (!frames.empty()) objects_ = recorder_->add_transforms("/objects", std::move(frames));
}

void RunRecorder::add_command_channels() {
  built_.commands->record();
  for (const auto& track : built_.commands->tracks()) {
    std::vector<std::string> columns{"what"};
    for (std::size_t i = 1; i < track->values(); ++i) columns.push_back(std::to_string(i));
    commands_.push_back(recorder_->add_samples(command_topic(track->device()), std::move(columns), {},
                                               {{"what", words_of(CommandKind::kOutput)}}));
  }
}

void RunRecorder::add_signal_channel() {
  std::vector<std::string> names, units;
  for (NamedSignal& signal : signals_of(built_.cell)) {
    names.push_back(std::move(signal.name));
    units.push_back(std::move(signal.unit));
    signal_readers_.push_back(std::move(signal.read));
  }
  if (names.empty()) return;
  signals_ = recorder_->add_samples("/signals", std::move(names), std::move(units));
  signal_row_.resize(signal_readers_.size());
}

void RunRecorder::write_devices() {
  constexpr double kNull = std::numeric_limits<double>::quiet_NaN();
  for (const GripperChannel& channel : grippers_) {
    const device::GripperSample& sample = channel.gripper->device->sample();
    const device::GripperSetPoint& sent = channel.gripper->device->set_point();
    const std::array<double, 7> row{sample.width, sample.speed, sample.force, static_cast<double>(sample.state),
                                    sent.width,   sent.speed,   sent.force};
    recorder_->write(channel.samples, row);
  }
  if (signal_row_.empty()) return;
  for (std::size_t i = 0; i < signal_row_.size(); ++i) signal_row_[i] = signal_readers_[i]().value_or(kNull);
  recorder_->write(signals_, signal_row_);
}

void RunRecorder::write_commands() {
  const auto& tracks = built_.commands->tracks();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const CommandTrack& track = *tracks[i];
    if (!track.changed()) continue;
    for (std::size_t row = 0; row < track.count(); ++row) recorder_->write(commands_[i], track.row(row));
    if (track.count() > 0) continue;
    nothing_.assign(track.values(), std::numeric_limits<double>::quiet_NaN());
    nothing_.front() = static_cast<double>(CommandKind::kNothing);
    recorder_->write(commands_[i], nothing_);
  }
}

void RunRecorder::write_blocks() {
  for (const rcc::Digest::BlockValue& block : built_.core->digest().blocks()) {
    recorder_->event(blocks_, "digest", built_.core->block_name(block.block), fmt::format("{:016x}", block.value));
  }
}

void RunRecorder::add_cycle() {
  const std::int64_t cycle = built_.core->cycle() - 1;
  recorder_->begin_cycle(cycle * built_.core->period(), static_cast<std::uint64_t>(cycle));
  for (const ArmChannels& channels : arms_) {
    const device::ArmSample& sample = channels.arm->device->sample();
    const device::ArmSetPoint& sent = channels.arm->device->set_point();
    const auto span = [](const kinematics::JointVector& v) {
      return std::span<const double>(v.data(), static_cast<std::size_t>(v.size()));
    };
    recorder_->write_joints(channels.joints, span(sample.q), span(sample.dq), span(sample.tau));
    recorder_->write_joints(channels.set_point, span(sent.q), span(sent.dq), {});
    const std::array<double, 5> status{static_cast<double>(channels.arm->device->phase()),
                                       static_cast<double>(sample.mode), sample.changing_mode ? 1.0 : 0.0,
                                       sample.braked ? 1.0 : 0.0, static_cast<double>(sample.fault)};
    recorder_->write(channels.status, status);
  }
  for (const SensorChannel& channel : sensors_) {
    const net::Wrench& wrench = channel.sensor->device->sample().wrench;
    const std::array<double, 6> row{wrench.force.x(),  wrench.force.y(),  wrench.force.z(),
                                    wrench.torque.x(), wrench.torque.y(), wrench.torque.z()};
    recorder_->write(channel.wrench, row);
  }
  write_devices();
  write_commands();
  if (with_blocks_) write_blocks();
  recorder_->digest(digest_, built_.core->digest().value().low);
  const mjData& data = *built_.world->data();
  recorder_->write(state_, {data.qpos, static_cast<std::size_t>(built_.world->model()->nq)});
  if (cycle % kPoseCycles != 0) return;
  for (std::size_t i = 0; i < bodies_.size(); ++i) poses_[i] = built_.world->body_pose(bodies_[i]);
  recorder_->write_transforms(transforms_, poses_);
  for (std::size_t i = 0; i < free_bodies_.size(); ++i) free_poses_[i] = poses_[free_bodies_[i]];
  if (!free_bodies_.empty()) recorder_->write_transforms(objects_, free_poses_);
}

void RunRecorder::add_contacts(std::span<const sim::BodyContact> contacts, const expression::Biases& biases) {
  contacts_since_.add(contacts);
  const std::int64_t cycle = built_.core->cycle();
  if (cycle - contacts_cycle_ < kPoseCycles) return;
  contacts_cycle_ = cycle;
  recorder_->begin_cycle(built_.core->time(), static_cast<std::uint64_t>(cycle));
  write_object_forces();
  write_contacts();
  write_contact_wrenches(biases);
}

/// Most objects stand: a row is written where another pair is in it, or a force has changed by more than a hundredth.
void RunRecorder::write_object_forces() {
  constexpr double kChange = 0.01;
  constexpr std::size_t kFields = 8, kForce = 5;
  const auto contacts = contacts_since_.between_objects();
  std::vector<double> row(object_row_.size(), std::numeric_limits<double>::quiet_NaN());
  bool changed = false;
  for (std::size_t i = 0; i < record::kMostContactForces; ++i) {
    const std::span<double> now = std::span(row).subspan(kFields * i, kFields);
    const std::span<const double> before = std::span(object_row_).subspan(kFields * i, kFields);
    if (i >= contacts.size()) {
      changed = changed || !std::isnan(before[0]);
      continue;
    }
    const sim::BodyContact& contact = contacts[i];
    now[0] = contact.a;
    now[1] = contact.b;
    std::copy_n(contact.point_W.data(), 3, now.begin() + 2);
    std::copy_n(contact.force_W.data(), 3, now.begin() + kForce);
    const Eigen::Vector3d old(before[kForce], before[kForce + 1], before[kForce + 2]);
    const bool same = now[0] == before[0] && now[1] == before[1] &&
                      (contact.force_W - old).norm() <= kChange * contact.force_W.norm();
    changed = changed || !same;
  }
  if (!changed) return;
  object_row_ = std::move(row);
  recorder_->write(object_forces_, object_row_);
}

void RunRecorder::write_contact_wrenches(const expression::Biases& biases) {
  constexpr double kNull = std::numeric_limits<double>::quiet_NaN();
  for (SensorChannel& channel : sensors_) {
    std::array<double, 6> row{kNull, kNull, kNull, kNull, kNull, kNull};
    if (const auto felt = channel.felt.now(biases)) {
      std::copy_n(felt->force.data(), 3, row.begin());
      std::copy_n(felt->torque.data(), 3, row.begin() + 3);
    }
    recorder_->write(channel.contact, row);
  }
}

void RunRecorder::write_contacts() {
  const auto forces = contacts_since_.take();
  std::array<double, 6 * record::kMostContactForces> row;
  row.fill(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < std::min(forces.size(), record::kMostContactForces); ++i) {
    std::copy_n(forces[i].point_W.data(), 3, row.begin() + static_cast<std::ptrdiff_t>(6 * i));
    std::copy_n(forces[i].force_W.data(), 3, row.begin() + static_cast<std::ptrdiff_t>(6 * i + 3));
  }
  recorder_->write(forces_, row);
}

/// What touches is the simulation's truth, and no part of what a golden holds of a program.
void RunRecorder::add_event(const LogEntry& entry) {
  recorder_->begin_cycle(entry.time, entry.cycle);  // events of the program come before their cycle
  record::ChannelId channel = entry.source == "contact" ? contacts_ : events_;
  if (entry.source == kExpectationSource) channel = expectations_;
  recorder_->event(channel, entry.source, entry.name, entry.text, entry.step);
  std::string line = fmt::format("{}{}{}", entry.name, entry.text.empty() ? "" : ": ", entry.text);
  if (!entry.step.empty()) line += fmt::format(" [{}]", entry.step);
  recorder_->log(log_, entry.level, entry.source, line);
  if (entry.level >= LogLevel::kError) recorder_->keep();
}

}  // namespace takt::cell
