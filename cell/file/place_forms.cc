#include "cell/file/forms.h"

#include <functional>

namespace takt::cell {

const NameRule kCellName{.pattern = R"(^(?!world$)[^/]+$)",
                         .allows =
                             [](std::string_view name) {
                               return !name.empty() && name != "world" && name.find('/') == std::string_view::npos;
                             },
                         .hint = "Choose a name without '/' that is not 'world'"};

const FormOf<Eigen::Isometry3d>& pose_form() {
  static const auto form = FormOf<Eigen::Isometry3d>().pose(std::identity());
  return form;
}

const FormOf<Placement>& place_form() {
  static const auto form =
      FormOf<Placement>("place", "A pose in a frame.")
          .add(text_key("in",
                        "Frame of the pose: a frame, a device, an object, ARM/flange, TOOL/TCP, OBJECT/GRASP or world; "
                        "what is placed on something that moves rides on it (docs/world.md).")
                   .optional(),
               &Placement::in)
          .pose(&Placement::X);
  return form;
}

const FormOf<Variation>& variation_form() {
  static const auto form =
      FormOf<Variation>("variation", "How far a pose may be drawn from the one that the file gives.")
          .add(number_key("radius_m", "m", kNotNegative, "Radius of a disc in the x-y plane.").optional("0"),
               &Variation::radius_m)
          .add(numbers_key("position_m", 3, "m", kNotNegative, "Largest deviation along x, y and z.").optional("none"),
               &Variation::position_m)
          .add(
              numbers_key("rpy_deg", 3, "degrees", {.low = 0, .high = 180}, "Largest deviation of roll, pitch and yaw.")
                  .optional("none"),
              &Variation::rpy_deg)
          .add(numbers_key("normal_m", 3, "m", kNotNegative,
                           "Standard deviation along x, y and z of a normal distribution, in addition.")
                   .optional("none"),
               &Variation::normal_m);
  return form;
}

const FormOf<FrameEntry>& frame_form() {
  static const auto form =
      FormOf<FrameEntry>("frame", "A pose in a frame, by its name.")
          .add(text_key("in",
                        "Frame of the pose: a frame, a device, an object, ARM/flange, TOOL/TCP, OBJECT/GRASP or world; "
                        "what is placed on something that moves rides on it (docs/world.md).")
                   .optional("world"),
               [](FormReader& from, FrameEntry& frame) {
                 if (from.has("in")) frame.at.in = from.text("in");
               })
          .pose([](FrameEntry& frame) -> Eigen::Isometry3d& { return frame.at.X; })
          .add(object_key("vary", variation_form(),
                          "Where it is drawn, from the seed and its name; the program knows the drawn pose.")
                   .optional("not at all"),
               &FrameEntry::vary);
  return form;
}

KeyOf<Eigen::Isometry3d> poses_key(std::string name, std::string doc) {
  return members_key(std::move(name), kCellName, pose_form(), std::move(doc)).optional();
}

Key friction_key(const std::string& whose) {
  return number_key(
             "friction", "", kNotNegative,
             "Coefficient of sliding (Coulomb) friction of " + whose + "'s. Of two surfaces the larger one counts.")
      .optional("that of the material");
}

}  // namespace takt::cell
