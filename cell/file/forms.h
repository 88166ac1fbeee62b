#pragma once

#include "cell/file/description.h"
#include "core/base/form_of.h"

/// Forms of the objects of a scenario file: each is read, and printed in its schema, by the same rows (docs/tables.md).
/// Realtime: setup.
namespace takt::cell {

/// Of frames, devices, objects, cameras and channels.
extern const NameRule kCellName;

/// The poses of a frame without "in", m.
[[nodiscard]] const FormOf<Eigen::Isometry3d>& pose_form();
[[nodiscard]] const FormOf<Placement>& place_form();
/// "vary".
[[nodiscard]] const FormOf<Variation>& variation_form();
/// One of "frames", without its name.
[[nodiscard]] const FormOf<FrameEntry>& frame_form();
/// Poses by name. @param name  of the key
[[nodiscard]] KeyOf<Eigen::Isometry3d> poses_key(std::string name, std::string doc);
/// @param whose  "this surface instead of its material": whose friction it is
[[nodiscard]] Key friction_key(const std::string& whose);
[[nodiscard]] const FormOf<DeviceEntry>& device_form();
[[nodiscard]] const FormOf<ObjectEntry>& object_form();
[[nodiscard]] const FormOf<CameraEntry>& camera_form();
[[nodiscard]] const FormOf<FilmEntry>& film_form();
[[nodiscard]] const FormOf<CollisionsEntry>& collisions_form();
/// "golden": how closely runs have to follow the golden, by topic and column.
[[nodiscard]] const FormOf<std::vector<record::ToleranceRule>>& golden_form();
/// The whole file.
[[nodiscard]] const FormOf<Description>& scenario_form(ReadFor purpose = ReadFor::kScenario);

}  // namespace takt::cell
