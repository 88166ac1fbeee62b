#include <fmt/format.h>

#include "cell/file/copies.h"
#include "cell/file/forms.h"
#include "cell/file/shape_kind.h"

namespace takt::cell {
namespace {

using Parts = std::vector<world::Object::Part>;

/// One of several shapes, made of one or several parts about its own frame.
struct PartEntry {
  Eigen::Isometry3d X_OE = Eigen::Isometry3d::Identity();
  std::optional<double> mass;  ///< kg
  Parts made;
  std::string pointer;
};

Kinds shapes(Key key) {
  return {.key = std::move(key), .forms = [] { return ShapeKind::registry().forms(); }};
}

Parts make_shape(FormReader& from) {
  const auto kind = from.kind();
  if (!kind) return {};
  FormReader sizes(kind->form, from.object());
  return ShapeKind::registry().find(kind->name)->make(sizes);
}

const FormOf<PartEntry>& part_form() {
  static const auto form =
      FormOf<PartEntry>("part", "A shape with a pose in the object's frame.")
          .add(number_key("mass_kg", "kg", kPositive, "Mass of this part; of all parts or of none.").optional(),
               &PartEntry::mass)
          .pose(&PartEntry::X_OE)
          .kinds(shapes(choice_key("shape", {}, "Its kind.")), [](FormReader& from, PartEntry& part) {
            part.made = make_shape(from);
            part.pointer = from.pointer();
          });
  return form;
}

/// A mass belongs to an entry; its parts share it by their volumes.
void add_part(const PartEntry& entry, ObjectEntry& object) {
  double whole = 0.0;
  for (const world::Object::Part& part : entry.made) whole += volume(part);
  for (const world::Object::Part& part : entry.made) {
    object.parts.push_back(part);
    object.parts.back().X_OS = entry.X_OE * part.X_OS;
    object.part_pointers.push_back(entry.pointer);
    if (entry.mass) object.part_masses_kg.push_back(*entry.mass * volume(part) / whole);
  }
}

void read_parts(FormReader& from, ObjectEntry& object) {
  std::size_t heavy = 0, count = 0;
  from.elements("parts", [&](const nlohmann::ordered_json& json, const std::string& pointer) {
    const PartEntry part = part_form().read(json, pointer, from.diagnostics());
    heavy += part.mass ? 1 : 0;
    ++count;
    add_part(part, object);
  });
  if (heavy > 0 && heavy != count) {
    from.diagnostics().error(Code::kWrongSize, from.at("parts"),
                             fmt::format("{} of {} parts have a mass", heavy, count), "Give all of them one, or none");
  }
}

void read_shape(FormReader& from, ObjectEntry& object) {
  Parts made = make_shape(from);
  if (!object.parts.empty() || made.empty()) return;
  object.parts = std::move(made);
  object.part_pointers.assign(object.parts.size(), from.pointer());
}

/// "mass_kg", or the sum of the parts' masses.
void read_mass(FormReader& from, ObjectEntry& object) {
  double sum = 0.0;
  for (const double mass : object.part_masses_kg) sum += mass;
  if (sum > 0.0 && from.has("mass_kg")) {
    from.diagnostics().error(Code::kConflict, from.at("mass_kg"), "both the object and its parts have a mass",
                             "Remove one of them: the mass of the object is the sum");
  }
  object.mass_given = sum > 0.0 || from.has("mass_kg");
  object.mass_kg = from.number("mass_kg", sum > 0.0 ? sum : 1.0);
}

void read_inertia(FormReader& from, ObjectEntry& object) {
  if (!from.has("inertia_kg_m2")) return;
  const auto values = from.numbers("inertia_kg_m2");
  Eigen::Matrix3d& I = object.inertia_kg_m2.emplace(Eigen::Matrix3d::Zero());
  if (values.size() == 3) {
    I.diagonal() << values[0], values[1], values[2];
  } else if (values.size() == 6) {
    I << values[0], values[3], values[4], values[3], values[1], values[5], values[4], values[5], values[2];
  } else {
    from.diagnostics().error(Code::kWrongSize, from.at("inertia_kg_m2"), fmt::format("{} numbers", values.size()),
                             "Give [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]");
  }
  if (!object.part_masses_kg.empty()) {
    from.diagnostics().error(Code::kConflict, from.at("inertia_kg_m2"), "both an inertia and masses of parts are given",
                             "Remove one of them");
  }
}

const FormOf<ScrewEntry>& screw_form() {
  static const auto form =
      FormOf<ScrewEntry>()
          .add(text_key("thread", "Size, a name of models/threads.json: M3 to M8."), &ScrewEntry::thread)
          .add(body_key("length_m", "Length of the shank."), &ScrewEntry::length_m);
  return form;
}

FormOf<ObjectEntry> form_of_object() {
  using Object = ObjectEntry;
  FormOf<Object> form("object");
  form.add(object_key("at", place_form(), "Nominal pose of the object's frame."), &Object::at)
      .add(object_key("copies", copies_form(),
                      "The object stands for as many, one step further each; its name needs a '#', which is the number "
                      "of the copy, from 1, in all its texts.")
               .key.optional())
      .add(text_key("model", "Folder in models/, instead of a shape; with 'fixed': false its URDF needs a mass.")
               .optional(),
           &Object::model)
      .add(objects_key("parts", 1, part_form().form(),
                       "Several shapes, each with a pose in the object's frame; instead of one shape.")
               .optional(),
           read_parts)
      .add(object_key("screw", screw_form(),
                      "A socket head cap screw instead of shapes: the origin is at the end of its shank, z towards its "
                      "head. It is free, of the material 'fastener' and weighs what steel weighs, unless the object "
                      "says otherwise (docs/threads.md).")
               .optional(),
           &Object::screw)
      .kinds(shapes(choice_key("shape", {}, "One shape, centred on the object's frame.").optional()), read_shape)
      .rule(exactly_one({"model", "parts", "screw", "shape"}))
      .add(object_key("vary", variation_form(),
                      "How far the true pose may differ from the nominal one; drawn uniformly from the seed and the "
                      "object's name.")
               .optional("not at all"),
           &Object::vary)
      .add(boolean_key("fixed", "false: the object can be pushed and falls.").optional("true, of a screw false"),
           [](FormReader& from, Object& object) { object.fixed = from.boolean("fixed", !object.screw); })
      .add(number_key("mass_kg", "kg", kPositive,
                      "Mass of an object that is not fixed, spread over its shapes by volume.")
               .optional("the sum of the parts' masses, else 1"),
           read_mass)
      .add(vector_key("centre_m", "m", "Centre of mass in the object's frame; only with 'inertia_kg_m2'.")
               .optional("the frame's origin"),
           &Object::centre_m)
      .add(
          numbers_key("inertia_kg_m2", 0, "kg m2", kAnyNumber,
                      "Inertia about the centre of mass, in the object's axes: [ixx, iyy, izz] or [ixx, iyy, izz, ixy, "
                      "ixz, iyz].")
              .optional("that of the shapes"),
          read_inertia)
      .rule(needs("centre_m", "inertia_kg_m2", "Give both, or neither: then the shapes decide"));
  return form;
}

/// What it looks like, and how its surface answers a touch.
void add_surface(FormOf<ObjectEntry>& form) {
  using Object = ObjectEntry;
  form.add(poses_key("grasps",
                     "Named frames of the object, such as places to grip it: frames OBJECT/NAME of the cell that move "
                     "with it."),
           &Object::grasps)
      .add(numbers_key("rgba", 4, "", {.low = 0, .high = 1}, "Colour: red, green, blue, opacity.").optional("grey"),
           &Object::rgba)
      .add(text_key("material",
                    "Material of the surface: a name of models/materials.json or of 'materials' (docs/contacts.md).")
               .optional("steel, or the model's"),
           &Object::material)
      .add(friction_key("this surface instead of its material"), &Object::friction)
      .add(boolean_key("oiled",
                       "There is oil on this surface: every contact with it has the oiled friction of the two "
                       "materials, if that is less.")
               .optional(),
           &Object::oiled)
      .add(number_key("stiffness_N_m", "N/m", kPositive,
                      "Stiffness of the contacts of this object, whatever touches it; of two such objects the softer "
                      "counts.")
               .optional("that of the two materials in series"),
           &Object::stiffness_N_m)
      .add(number_key("damping_N_s_m", "N s/m", kNotNegative, "Damping of these contacts; only with 'stiffness_N_m'.")
               .optional("as much in proportion as the material has"),
           &Object::damping_N_s_m)
      .rule(needs("damping_N_s_m", "stiffness_N_m", "Give both, or only 'stiffness_N_m', or a 'material'"))
      .add(text_key("lit_by",
                    "Makes the object a lamp that lights up in pictures while this digital output (BLOCK/TERMINAL) or "
                    "light barrier is true; of a model: its shapes of the material 'light' (docs/simulation.md).")
               .optional(),
           &Object::lit_by);
}

}  // namespace

const FormOf<ObjectEntry>& object_form() {
  static const auto form = [] {
    FormOf<ObjectEntry> made = form_of_object();
    add_surface(made);
    return made;
  }();
  return form;
}

}  // namespace takt::cell
