#include "cell/file/degrees.h"
#include "cell/file/forms.h"
#include "core/base/angles.h"

namespace takt::cell {

const FormOf<DeviceEntry>& device_form() {
  static const auto form =
      FormOf<DeviceEntry>("device")
          .add(text_key("model",
                        "Folder in models/ (see 'takt list'). Its kind is arm, base, force_torque_sensor, gripper, io, "
                        "light_barrier, range_finder, tool, or one of a plug-in."),
               &DeviceEntry::model)
          .add(object_key("at", place_form(), "Pose of the device's base.").optional("origin of the world"),
               &DeviceEntry::at)
          .add(text_key("on", "Arm, base or sensor on which this device is mounted; instead of 'at'.").optional(),
               &DeviceEntry::on)
          .rule(at_most_one({"on", "at"}, "Mount it on a device, or place it in a frame"))
          .add(object_key("mount", pose_form(),
                          "With 'on': pose of the device's base in the mounting frame of what carries it (a flange: z "
                          "out of its face), for example to turn a range finder along the flange.")
                   .optional("face to face"),
               &DeviceEntry::mount)
          .rule(needs("mount", "on", "Give \"on\": NAME, or \"at\""))
          .add(object_key("vary", variation_form(),
                          "With 'on': how far its true mount may differ from 'mount', which the program goes by; drawn "
                          "from the seed and the device's name. So a part is held in a hand that does not know where.")
                   .optional("not at all"),
               &DeviceEntry::vary)
          .rule(needs("vary", "on", "Give \"on\": NAME; a device of its own varies with the frame that it stands in"))
          .add(numbers_key("start_deg", 0, "degrees", kAnyNumber,
                           "Joint positions at the start, one per joint, inside the joint range.")
                   .optional("the home posture of the model"),
               [](FormReader& from, DeviceEntry& device) {
                 device.start_rad = from.numbers("start_deg", std::vector<double>());
                 warn_of_radians(device.start_rad, from.at("start_deg"), from.diagnostics());
                 for (double& q : device.start_rad) q *= kDegree;
               })
          .add(number_key("payload_error_kg", "kg", kAnyNumber,
                          "Load that the controller assumes in addition to the true load.")
                   .optional(),
               &DeviceEntry::payload_error_kg)
          .add(text_key("tool", "Of an arm: the tool on it that counts where a step names none.")
                   .optional("the only one"),
               &DeviceEntry::tool)
          .add(text_key("own_force",
                        "Of an arm: name of a force/torque sensor in its flange, made of the external torques that it "
                        "estimates; usable wherever a sensor is; of an arm that has torque sensors, or whose driver "
                        "reads them.")
                   .optional("none"),
               &DeviceEntry::own_force)
          .add(text_key("material",
                        "Material of its surfaces, pads of a gripper apart: a name of models/materials.json or of "
                        "'materials' (docs/contacts.md).")
                   .optional("the model's"),
               &DeviceEntry::material)
          .add(friction_key("these surfaces instead of their material"), &DeviceEntry::friction)
          .add(boolean_key("oiled",
                           "There is oil on these surfaces: every contact with them has the oiled friction of the two "
                           "materials, if that is less.")
                   .optional(),
               &DeviceEntry::oiled)
          .add(text_key("tcp", "Of a tool: its tool centre point where a step names none.")
                   .optional("that of its model, 'tcp'"),
               &DeviceEntry::tcp)
          .add(poses_key("tcps",
                         "Of a device on an arm: more tool centre points by name, each a pose in its mount frame; a "
                         "device without one becomes a tool by them."),
               &DeviceEntry::tcps)
          .add(any_key("settings", "device_settings", "Settings of this device; which ones depends on its kind.")
                   .optional(),
               [](FormReader& from, DeviceEntry& device) {
                 if (const auto* settings = from.object().object("settings", false)) device.settings = *settings;
               })
          .then([](FormReader&, DeviceEntry& device) {
            if (device.on.empty() && !device.at) device.at = Placement{};
          });
  return form;
}

}  // namespace takt::cell
