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
          .add(text_key("thread", "Size, a name of models/threads.json: M3 to M8, M16."), &ScrewEntry::thread)
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

/// A path on the surface of a workpiece, along which something is done: a seam, a bead of glue.
struct LineEntry {
  struct Point {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::optional<Eigen::Vector3d> inward, via;
  };
  Eigen::Vector3d inward = -Eigen::Vector3d::UnitZ();
  std::vector<Point> points;
};

const FormOf<LineEntry::Point>& line_point_form() {
  using Point = LineEntry::Point;
  static const auto form =
      FormOf<Point>()
          .add(vector_key("position_m", "m", "In the object's frame."), &Point::position)
          .add(vector_key("inward", "", "Direction into the workpiece here; any length but 0.").optional("the line's"),
               &Point::inward)
          .add(vector_key("via_m", "m", "An arc leads here, through this point; else a straight line.").optional(),
               &Point::via);
  return form;
}

const FormOf<LineEntry>& line_form() {
  static const auto form =
      FormOf<LineEntry>()
          .add(vector_key("inward", "", "Direction into the workpiece, from where a tool comes; any length but 0.")
                   .optional("0, 0, -1"),
               &LineEntry::inward)
          .add(objects_key("points", 2, line_point_form(), "At least two, in their order."), &LineEntry::points);
  return form;
}

/// Frames of the object, "LINE/1" and on: z into the workpiece, x along the beginning of the line; and "LINE/2/via".
void add_line(const std::string& name, const LineEntry& line, const std::string& pointer, Diagnostics& diagnostics,
              ObjectEntry& object) {
  constexpr double kSame_m = 1e-6;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const LineEntry::Point& point = line.points[i];
    const std::string at = pointer + "/points" + pointer_segment(i);
    const Eigen::Vector3d inward = point.inward.value_or(line.inward);
    if (inward.norm() < kSame_m) {
      diagnostics.error(Code::kInvalidValue, (point.inward ? at : pointer) + "/inward", "a direction of length 0",
                        "Choose any other length");
      return;
    }
    if (i > 0 && (point.position - line.points[i - 1].position).norm() < kSame_m) {
      diagnostics.error(Code::kInvalidValue, at + "/position_m", "the point before is in the same place",
                        "Give each point a place of its own");
      return;
    }
    if (i == 0 && point.via) {
      diagnostics.error(Code::kConflict, at + "/via_m", "nothing leads to the first point",
                        "Remove it, or add the point from which the arc comes");
    }
    const Eigen::Vector3d z = inward.normalized();
    const Eigen::Vector3d begin = line.points.size() > 1
                                      ? Eigen::Vector3d(line.points[1].position - line.points[0].position)
                                      : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d across =
        z.cross(begin).norm() > kSame_m * begin.norm() ? Eigen::Vector3d(z.cross(begin)) : z.unitOrthogonal();
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear().col(1) = across.normalized();
    X.linear().col(0) = across.normalized().cross(z);
    X.linear().col(2) = z;
    X.translation() = point.position;
    const std::string frame = fmt::format("{}/{}", name, i + 1);
    object.grasps[frame] = X;
    if (!point.via) continue;
    X.translation() = *point.via;
    object.grasps[frame + "/via"] = X;
  }
}

/// What it looks like, and how its surface answers a touch.
void add_surface(FormOf<ObjectEntry>& form) {
  using Object = ObjectEntry;
  form.add(poses_key("grasps",
                     "Named frames of the object, such as places to grip it: frames OBJECT/NAME of the cell that move "
                     "with it."),
           &Object::grasps)
      .add(members_key("lines", kCellName, line_form(),
                       "Paths on its surface, by name, along which something is done: weld (docs/welding.md). Their "
                       "points are frames OBJECT/LINE/1 and on, z into the workpiece.")
               .key.optional(),
           [](FormReader& from, Object& object) {
             from.members("lines", [&](const std::string& name, const auto& json, const std::string& pointer) {
               add_line(name, line_form().read(json, pointer, from.diagnostics()), pointer, from.diagnostics(), object);
             });
           })
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
