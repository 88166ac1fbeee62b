#pragma once

#include <span>
#include <string>

#include "core/base/object_reader.h"
#include "core/base/time.h"
#include "core/device/description.h"
#include "core/device/device_file_impl.h"

namespace takt::device {

/// Reads the parts of the file of an arm, or of another device that is driven like one, one function a part.
/// Realtime: setup.
class ArmReader {
 public:
  ArmReader(DeviceFile& file, ObjectReader& reader, ArmDescription& arm) : file_(file), reader_(reader), arm_(arm) {}

  /// A whole arm.
  void read();

  /// Title, URDF and the two links.
  void read_names();
  /// The chain between them, with its limits. @param rolling  joints beside it, as Chain::create has them
  void read_chain(std::span<const std::string> rolling = {});
  /// Key "control": modes, their changes, impedance, gains.
  void read_control();
  /// Key "cycle_ms", and from it how old a sample may be.
  void read_times();

 private:
  JointVector joints(ObjectReader& reader, const char* key, const Range& range, bool required = true);
  void check_home();
  void read_held_joints();
  void read_limits();
  void read_sensors();

  DeviceFile& file_;
  ObjectReader& reader_;
  ArmDescription& arm_;
  int joint_count_ = 0;
};

}  // namespace takt::device
