#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/device_file_impl.h"
#include "core/device/tool_changer.h"

namespace takt::device {

namespace {

constexpr double kDegreeOfFile = std::numbers::pi / 180.0;
constexpr double kMostAngle_deg = 10.0;  ///< more is no misalignment

/// A size is compared as it stands.
std::string read_size(ObjectReader& reader) {
  std::string size = reader.text("size");
  if (reader.has("size") && size.empty())
    reader.diagnostics().error(Code::kMissing, reader.at("size"), "an empty text", "Give the name of both halves");
  return size;
}

CouplingTolerance read_tolerance(ObjectReader& reader) {
  return {.offset = reader.number("offset_max_m", {}, kPositive),
          .gap = reader.number("gap_max_m", {}, kPositive),
          .angle = kDegreeOfFile *
                   reader.number("angle_max_deg", {}, {.low = 0.0, .high = kMostAngle_deg, .low_open = true})};
}

/// All of it is one rigid body: nothing moves against anything else but the lock, which no URDF has.
void check_rigid(DeviceFile& file) {
  if (file.robot() == nullptr) return;
  for (const kinematics::Joint& joint : file.robot()->joints) {
    if (joint.type == kinematics::JointType::kFixed) continue;
    file.diagnostics().error(Code::kInvalidModel, "/urdf", fmt::format("joint '{}' moves", joint.name),
                             "Use fixed joints only");
  }
}

}  // namespace

bool CouplingTolerance::holds(const Eigen::Isometry3d& X_CS) const {
  const Eigen::Vector3d p = X_CS.translation();
  // The angle of a rotation from its trace; at the tolerance the cosine is far enough from 1.
  const double cosine = 0.5 * (X_CS.linear().trace() - 1.0);
  return p.head<2>().norm() <= offset && std::abs(p.z()) <= gap && cosine >= std::cos(angle);
}

Result<std::shared_ptr<const ToolChangerDescription>> read_tool_changer(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "tool_changer");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ToolChangerDescription changer;
  changer.mount_link = file->read_common(reader, changer);
  changer.coupling_link = file->link(reader, "flange");
  changer.size = read_size(reader);
  changer.tolerance = read_tolerance(reader);
  changer.lock_time = reader.number("lock_time_s", {}, {.low = 0.0, .high = 10.0, .low_open = true});
  changer.cycle = read_cycle(reader);
  changer.sample_age_max = kSampleCyclesMax * changer.cycle;
  check_rigid(*file);
  if (file->robot() != nullptr && !file->diagnostics().has_errors())
    changer.X_MC = pose_between(*file->robot(), changer.mount_link, changer.coupling_link);
  return file->finish(reader, std::move(changer));
}

Result<std::shared_ptr<const ToolSideDescription>> read_tool_side(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "tool_side");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ToolSideDescription side;
  side.coupling_link = file->read_common(reader, side);
  side.tool_link = file->link(reader, "flange");
  side.size = read_size(reader);
  check_rigid(*file);
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    // It moves freely: its root is what the physics and the belief know.
    if (side.coupling_link != file->robot()->root().name)
      file->diagnostics().error(Code::kInvalidModel, "/base",
                                fmt::format("'{}' is not the root of the URDF", side.coupling_link),
                                fmt::format("Name '{}'", file->robot()->root().name));
    side.X_ST = pose_between(*file->robot(), side.coupling_link, side.tool_link);
  }
  return file->finish(reader, std::move(side));
}

}  // namespace takt::device
