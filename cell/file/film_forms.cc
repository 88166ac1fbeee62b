#include <algorithm>

#include <fmt/format.h>

#include "cell/file/forms.h"

namespace takt::cell {
namespace {

struct Mark {
  const char* name;
  bool FilmShow::*shown;
};
constexpr Mark kMarks[] = {{"traces", &FilmShow::traces},
                           {"beams", &FilmShow::beams},
                           {"forces", &FilmShow::forces},
                           {"commanded", &FilmShow::commanded},
                           {"frames", &FilmShow::frames}};

/// Their names; of those that a film shows unless something else is said, or of all.
std::vector<std::string> mark_names(bool all) {
  std::vector<std::string> names;
  for (const Mark& mark : kMarks)
    if (all || FilmShow{}.*mark.shown) names.emplace_back(mark.name);
  return names;
}

}  // namespace

void choose_marks(const std::vector<std::string>& names, const std::string& pointer, FilmShow& show,
                  Diagnostics& diagnostics) {
  for (const Mark& mark : kMarks) show.*mark.shown = std::ranges::find(names, mark.name) != names.end();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(kMarks, names[i], &Mark::name) != std::end(kMarks)) continue;
    diagnostics.error(Code::kUnknownName, pointer + (pointer.starts_with('/') ? pointer_segment(i) : ""),
                      fmt::format("a film shows no '{}'", names[i]), nearest_choice(names[i], mark_names(true)));
  }
}

const FormOf<CameraEntry>& camera_form() {
  static const auto form =
      FormOf<CameraEntry>("camera")
          .add(object_key("at", place_form(),
                          "Pose of the camera. Without 'look_at' it looks along -z of this pose, and y is up in the "
                          "picture."),
               &CameraEntry::at)
          .add(object_key("look_at", place_form(), "Pose that the camera looks at, upright.").optional(),
               &CameraEntry::look_at)
          .add(number_key("fovy_deg", "degrees", {.low = 5, .high = 120}, "Vertical field of view.").optional(),
               &CameraEntry::fovy_deg)
          .then([](FormReader& from, CameraEntry& camera) {
            if (camera.look_at && camera.look_at->in == camera.at.in &&
                (camera.look_at->X.translation() - camera.at.X.translation()).norm() < 1e-6) {
              from.diagnostics().error(Code::kInvalidValue, from.at("look_at"),
                                       "the camera is at the point that it looks at", "Choose another point");
            }
          });
  return form;
}

const FormOf<FilmEntry>& film_form() {
  static const auto cut =
      FormOf<FilmEntry::Cut>()
          .add(text_key("step",
                        "Name of the step; OUTER / STEP is one in another node, NAME (2) in its second round. Of "
                        "several cuts that fit the first counts."),
               &FilmEntry::Cut::step)
          .add(text_key("camera", "Camera from then on."), &FilmEntry::Cut::camera);
  static const auto form =
      FormOf<FilmEntry>("film", "What the film shows.")
          .add(text_key("camera",
                        "Camera at the start. `fit`: one that fits the cell, also the default of a file without "
                        "cameras.")
                   .optional("the first one"),
               &FilmEntry::camera)
          .add(text_key("inset", "Second camera, shown small in the upper right corner.").optional(), &FilmEntry::inset)
          .add(text_key("force_sensor", "Force/torque sensor whose contact force is shown.").optional(),
               &FilmEntry::force_sensor)
          .add(number_key("force_limit_N", "N", kPositive, "Force that is marked in the bar.").optional(),
               &FilmEntry::force_limit_N)
          .add(
              list_key("show", 0, choice_key("", mark_names(true), ""),
                       "Marks beside the scene: paths of the tool centre points, beams of sensors, contact forces on "
                       "machines as arrows, machines where they are commanded to be (where they are not there), frames "
                       "of the file and tool centre points.")
                  .by_default(mark_names(false)),
              [](FormReader& from, FilmEntry& film) {
                if (from.has("show")) choose_marks(from.texts("show"), from.at("show"), film.show, from.diagnostics());
              })
          .add(number_key("trace_s", "s", {.low = 0.0, .high = 1e6}, "How long a path stays.").optional(),
               [](FilmEntry& film) -> double& { return film.show.trace_s; })
          .add(objects_key("cuts", 0, cut, "Changes of camera: each takes effect when a step of that name starts.")
                   .optional(),
               &FilmEntry::cuts);
  return form;
}

}  // namespace takt::cell
