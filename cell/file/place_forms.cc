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
