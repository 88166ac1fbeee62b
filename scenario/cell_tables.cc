#include "scenario/cell_tables.h"

#include <nlohmann/json.hpp>

#include "scenario/copies.h"

namespace takt::scenario {

const table::Table<Placement>& placement_table() {
  static const auto table = [] {
    table::Table<Placement> place;
    place
        .named("in", table::NameOf::kFrame, &Placement::in,
               "Frame of the pose: a frame, a device, an object, ARM/flange, TOOL/TCP, OBJECT/GRASP or world; what is "
               "placed on something that moves rides on it (docs/world.md).")
        .pose(&Placement::X);
    return place;
  }();
  return table;
}

const table::Table<Eigen::Isometry3d>& pose_table() {
  static const auto table = [] {
    table::Table<Eigen::Isometry3d> pose;
    pose.pose([](Eigen::Isometry3d & X) -> auto& { return X; });
    return pose;
  }();
  return table;
}

const table::Table<FrameEntry>& frame_table() {
  static const auto table = [] {
    table::Table<FrameEntry> frame;
    frame.inlined(placement_table(), &FrameEntry::at);
    return frame;
  }();
  return table;
}

const table::Table<DeviceEntry>& device_entry_table() {
  using D = DeviceEntry;
  static const auto table = [] {
    table::Table<D> device;
    device
        .named("model", table::NameOf::kModel, &D::model,
               "Folder in models/ (see 'takt list'), which says what kind of device it is.")
        .required()
        .part("at", "place", placement_table(), &D::at, "Pose of the device's base.")
        .fallback("origin of the world")
        .named("on", table::NameOf::kDevice, &D::on, "Device on which this one is mounted; instead of 'at'.")
        .part("mount", "pose", pose_table(), &D::mount,
              "With 'on': pose of the device's base in the mounting frame of what carries it (a flange: z out of its "
              "face), for example to turn a range finder along the flange.")
        .fallback("face to face")
        .value("start_deg", table::numbers_type("deg", {}), &D::start_rad,
               "Joint positions at the start, one per joint, inside the joint range.")
        .fallback("the home posture of the model")
        .number("payload_error_kg", "kg", &D::payload_error_kg, kAnyNumber,
                "Load that the controller assumes in addition to the true load.")
        .named("tool", table::NameOf::kDevice, &D::tool,
               "Of an arm: the tool on it that counts where a step names none.")
        .fallback("the only one")
        .text("own_force", &D::own_force,
              "Of an arm: name of a force/torque sensor in its flange, made of the external torques that it estimates; "
              "usable wherever a sensor is; of an arm that has torque sensors, or whose driver reads them.")
        .fallback("none");
    add_surface(device,
                "Material of its surfaces, pads of a gripper apart: a name of models/materials.json or of 'materials' "
                "(docs/contacts.md).",
                "the model's");
    device.text("tcp", &D::tcp, "Of a tool: its tool centre point where a step names none.")
        .fallback("that of its model, 'tcp'")
        .mapped("tcps", "pose", pose_table(), &D::tcps,
                "Of a device on an arm: more tool centre points by name, each a pose in its mount frame; a device "
                "without one becomes a tool by them.")
        .value("settings", table::json_type(table::any_object()), &D::settings,
               "Settings of this device; which ones depends on its kind (docs/how-to/cell.md#settings-by-kind, "
               "docs/plugins.md).")
        .rule({.kind = table::Rule::Kind::kNotTogether,
               .groups = {{"on"}, {"at"}},
               .hint = "Mount it on a device, or place it in a frame"})
        .rule({.kind = table::Rule::Kind::kNeeds,
               .groups = {{"mount"}, {"on"}},
               .hint = "Add \"on\": NAME, or use \"at\"",
               .at = "mount",
               .code = Code::kInvalidValue})
        .rule([](D& entry, const table::Context&) {
          if (entry.on.empty() && !entry.at) entry.at = Placement{};
        });
    return device;
  }();
  return table;
}

const table::Table<CameraEntry>& camera_table() {
  static const auto table = [] {
    table::Table<CameraEntry> camera;
    camera
        .part("at", "place", placement_table(), &CameraEntry::at,
              "Pose of the camera. Without 'look_at' it looks along -z of this pose, and y is up in the picture.")
        .required()
        .part("look_at", "place", placement_table(), &CameraEntry::look_at, "Pose that the camera looks at, upright.")
        .number("fovy_deg", "deg", &CameraEntry::field_of_view, {.low = 5, .high = 120}, "Vertical field of view.")
        .rule([](CameraEntry& entry, const table::Context& from) {
          if (entry.look_at && entry.look_at->in == entry.at.in &&
              (entry.look_at->X.translation() - entry.at.X.translation()).norm() < 1e-6) {
            from.reader.diagnostics().error(Code::kInvalidValue, from.reader.at("look_at"),
                                            "the camera is at the point that it looks at", "Choose another point");
          }
        });
    return camera;
  }();
  return table;
}

const table::Table<CollisionsEntry>& collisions_table() {
  using Allowed = CollisionsEntry::Allowed;
  static const auto allowed = [] {
    table::Table<Allowed> pair;
    pair.value("between", table::texts_type({.min = 2, .max = 2}), &Allowed::between,
               "Two devices, objects or bodies (`arm/link_3`).")
        .required()
        .text("reason", &Allowed::reason, "Why they may meet, for who reads the file.")
        .required()
        .rule([](Allowed& entry, const table::Context& from) { entry.pointer = from.reader.pointer(); });
    return pair;
  }();
  static const auto table = [] {
    table::Table<CollisionsEntry> collisions;
    collisions
        .number("margin_m", "m", &CollisionsEntry::margin_m, {.low = 1e-5, .high = 0.1},
                "Bodies that come nearer to each other collide.")
        .elements("allow", "allowed_contact", allowed, &CollisionsEntry::allow, "Pairs that may meet.")
        .text("off", &CollisionsEntry::off, "Nothing is checked, for this reason.")
        .not_empty()
        .rule([](CollisionsEntry& entry, const table::Context&) {
          std::erase_if(entry.allow, [](const Allowed& pair) { return pair.between.size() != 2; });
        });
    return collisions;
  }();
  return table;
}

}  // namespace takt::scenario
