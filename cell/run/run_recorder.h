#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/description.h"
#include "cell/judge/contact_forces.h"
#include "cell/judge/run_log.h"
#include "cell/judge/run_report.h"
#include "cell/judge/signal_reader.h"
#include "core/expression/contact_reader.h"
#include "record/recorder.h"

namespace takt::cell {

/// What a run leaves in its recording: per arm measured joints, set points and frames; per sensor the raw wrench; the
/// digest and the simulation's state of every cycle; what the program did, and what touched.
///   /NAME/joint_states, /NAME/set_point, /tf, /objects, /NAME/wrench, /NAME/gripper, /signals, /digest, /state,
///   /program, /contacts, /expectations, /log (those before it as other tools show them), /contact_forces: the greatest
///   ones, /object_forces: those between objects
/// With blocks, which the core has to keep: the digest of each block of each cycle too, in record::kBlockTopic.
class RunRecorder {
 public:
  /// In real time a cycle for which the writer has no room is left out; in lock-step the run waits for it.
  [[nodiscard]] static Result<std::unique_ptr<RunRecorder>> open(const std::filesystem::path& path,
                                                                 const Description& description, const BuiltCell& built,
                                                                 const RunOptions& run);

  /// After each cycle. Realtime: cyclic.
  void add_cycle();
  void add_event(const LogEntry& entry);
  /// Between cycles: what touched since the last call, of which the greatest forces on machines, and those between
  /// objects where they have changed, are recorded fifty times a second; and as often the wrenches without weight and
  /// tared bias.
  void add_contacts(std::span<const sim::BodyContact> contacts, const expression::Biases& biases);
  /// With RunOptions::record_last: what was recorded last is to be written.
  void keep() { recorder_->keep(); }
  [[nodiscard]] record::RecorderStatus close() { return recorder_->close(); }

 private:
  struct ArmChannels {
    const expression::MountedArm* arm;
    record::ChannelId joints, set_point, status;
  };
  struct SensorChannel {
    const expression::MountedSensor* sensor;
    record::ChannelId wrench, contact;
    expression::ContactWrenchReader felt;
  };
  struct GripperChannel {
    const expression::MountedGripper* gripper;
    record::ChannelId samples;
  };
  RunRecorder(std::unique_ptr<record::Recorder> recorder, const BuiltCell& built, bool with_blocks, bool expects);
  void add_channels(bool expects);
  void add_object_channel(const mjModel_& model);
  void add_signal_channel();
  void add_command_channels();
  void write_devices();
  void write_commands();
  void write_contacts();
  void add_object_force_channel();
  void write_object_forces();
  void write_contact_wrenches(const expression::Biases& biases);
  void write_blocks();

  std::unique_ptr<record::Recorder> recorder_;
  const BuiltCell& built_;
  bool with_blocks_;
  std::vector<ArmChannels> arms_;
  std::vector<SensorChannel> sensors_;
  std::vector<GripperChannel> grippers_;
  std::vector<record::ChannelId> commands_;  ///< one per track of the cell
  std::vector<double> nothing_;              ///< scratch
  record::ChannelId signals_;
  std::vector<SignalReader> signal_readers_;  ///< one per column of /signals
  std::vector<double> signal_row_;
  std::vector<int> bodies_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<std::size_t> free_bodies_;  ///< of bodies_: parts that move by themselves
  std::vector<Eigen::Isometry3d> free_poses_;
  ContactForces contacts_since_;     ///< the last row of them
  std::int64_t contacts_cycle_ = 0;  ///< of that row
  std::vector<double> object_row_;   ///< of forces between objects, as it was written last
  record::ChannelId transforms_, objects_, digest_, state_, events_, contacts_, expectations_, forces_, log_, blocks_;
  record::ChannelId object_forces_;
};

}  // namespace takt::cell
