// An object of a scenario file: a model, one shape, several shapes, or a screw.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenario/cell_tables.h"
#include "scenario/copies.h"
#include "scenario/degrees.h"
#include "scenario/shape_kind.h"

namespace takt::scenario {
namespace {

using O = ObjectEntry;
using ObjectPart = world::Object::Part;

/// One of "parts": a shape with a pose, made of one or several parts about its own frame.
struct PartEntry {
  std::string pointer = {};
  Eigen::Isometry3d X_OE = Eigen::Isometry3d::Identity();
  std::optional<double> mass_kg = {};
  std::vector<ObjectPart> made = {};
};

const table::Table<PartEntry>& part_table() {
  static const auto table = [] {
    table::Table<PartEntry> part;
    part.number("mass_kg", "kg", &PartEntry::mass_kg, kPositive, "Mass of this part; of all parts or of none.")
        .kind("shape", shape_kinds(), "Shape of the part, about its own pose.",
              [](PartEntry& entry, std::vector<ObjectPart> made) { entry.made = std::move(made); })
        .required()
        .pose(&PartEntry::X_OE)
        .rule([](PartEntry& entry, const table::Context& from) { entry.pointer = from.reader.pointer(); });
    return part;
  }();
  return table;
}

/// A mass belongs to an entry; its parts share it by their volumes.
void add_part(const PartEntry& entry, O& object) {
  double whole = 0.0;
  for (const ObjectPart& part : entry.made) whole += volume(part);
  for (const ObjectPart& part : entry.made) {
    object.parts.push_back(part);
    object.parts.back().X_OS = entry.X_OE * part.X_OS;
    object.part_pointers.push_back(entry.pointer);
    if (entry.mass_kg) object.part_masses_kg.push_back(*entry.mass_kg * volume(part) / whole);
  }
}

void read_parts(const table::Field& row, const table::Context& from, O& object) {
  std::size_t heavy = 0, count = 0;
  table::for_each_element(row, from.reader, [&](ObjectReader& reader) {
    PartEntry entry;
    part_table().read_into(entry, {reader});
    add_part(entry, object);
    heavy += entry.mass_kg ? 1 : 0;
    ++count;
  });
  if (heavy > 0 && heavy != count)
    from.reader.diagnostics().error(Code::kWrongSize, from.reader.at(row.key),
                                    fmt::format("{} of {} parts have a mass", heavy, count),
                                    "Give all parts a mass, or none");
}

void read_inertia(const table::Field& row, const table::Context& from, O& object) {
  if (!from.reader.has(row.key)) return;
  const auto v = from.reader.numbers(row.key, 0, {});
  Eigen::Matrix3d& I = object.inertia_kg_m2.emplace(Eigen::Matrix3d::Zero());
  if (v.size() == 3) {
    I.diagonal() << v[0], v[1], v[2];
  } else if (v.size() == 6) {
    I << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  } else {
    from.reader.diagnostics().error(Code::kWrongSize, from.reader.at(row.key), fmt::format("{} numbers", v.size()),
                                    "Give [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]");
  }
}

table::Field inertia_field() {
  table::Field inertia = table::field(
      "inertia_kg_m2", table::Field::Type::kEither,
      "Inertia about the centre of mass, in the object's axes: [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz].");
  inertia.fallback = "that of the shapes";
  for (const std::size_t count : {3U, 6U}) {
    inertia.items.push_back(table::field({}, table::Field::Type::kNumbers, {}));
    inertia.items.back().unit = "kg*m^2";
    inertia.items.back().count = {.min = count, .max = count};
  }
  return inertia;
}

/// The mass, or the sum of the parts' masses.
void settle_mass(O& object, const table::Context& from) {
  double sum = 0.0;
  for (const double mass : object.part_masses_kg) sum += mass;
  const bool given = from.reader.has("mass_kg");
  if (sum > 0.0 && given)
    from.reader.diagnostics().error(Code::kConflict, from.reader.at("mass_kg"),
                                    "both the object and its parts have a mass",
                                    "Remove one of them: the mass of the object is the sum");
  if (object.inertia_kg_m2 && !object.part_masses_kg.empty())
    from.reader.diagnostics().error(Code::kConflict, from.reader.at("inertia_kg_m2"),
                                    "both an inertia and masses of parts are given", "Remove one of them");
  object.mass_given = sum > 0.0 || given;
  if (sum > 0.0 && !given) object.mass_kg = sum;
}

const table::Table<ScrewEntry>& screw_table() {
  static const auto table = [] {
    table::Table<ScrewEntry> screw;
    screw.named("thread", table::NameOf::kThread, &ScrewEntry::thread, "Size, a name of models/threads.json: M3 to M8.")
        .required()
        .number("length_m", "m", &ScrewEntry::length_m, kBodySize, "Length of the shank.")
        .required();
    return screw;
  }();
  return table;
}

const table::Table<Variation>& variation_table() {
  static const auto table = [] {
    table::Table<Variation> vary;
    vary.number("radius_m", "m", &Variation::radius_m, kNotNegative, "Radius of a disc in the x-y plane.")
        .value("position_m", table::vector_type("m", kNotNegative), &Variation::position_m,
               "Largest deviation along x, y and z.")
        .value("rpy_deg", table::kept(table::vector_type("", {.low = 0, .high = 180}), "deg"), &Variation::rpy_deg,
               "Largest deviation of roll, pitch and yaw.");
    return vary;
  }();
  return table;
}

/// What it is made of.
void add_body(table::Table<O>& object) {
  table::Field parts = table::field("parts", table::Field::Type::kList,
                                    "Several shapes, each with a pose in the object's frame; instead of one shape.");
  parts.items = {part_table().form("part")};
  parts.count.min = 1;
  object
      .named("model", table::NameOf::kModel, &O::model,
             "Folder in models/, instead of a shape; with 'fixed': false its URDF needs a mass.")
      .object(std::move(parts), read_parts)
      .kind("shape", shape_kinds(), "One shape, centred on the object's frame.",
            [](O& entry, std::vector<ObjectPart> made) { entry.parts = std::move(made); })
      .part(
          "screw", {}, screw_table(), &O::screw,
          "A socket head cap screw instead of shapes: the origin is at the end of its shank, z towards its head. It is "
          "free, of the material 'fastener' and weighs what steel weighs, unless the object says otherwise "
          "(docs/threads.md).")
      .rule({.kind = table::Rule::Kind::kOneOf,
             .groups = {{"model"}, {"parts"}, {"shape"}, {"screw"}},
             .hint = "Give one of 'model', 'parts', 'shape' and 'screw'"});
}

void add_mass(table::Table<O>& object) {
  object.boolean("fixed", &O::fixed, "false: the object can be pushed and falls.")
      .fallback("true; of a screw false")
      .number("mass_kg", "kg", &O::mass_kg, kPositive,
              "Mass of an object that is not fixed, spread over its shapes by volume.")
      .fallback("the sum of the parts' masses, else 1")
      .vector("centre_m", "m", &O::centre_m, "Centre of mass in the object's frame; only with 'inertia_kg_m2'.")
      .fallback("the frame's origin")
      .object(inertia_field(), read_inertia)
      .rule({.kind = table::Rule::Kind::kNeeds,
             .groups = {{"centre_m"}, {"inertia_kg_m2"}},
             .hint = "Give both, or neither: then the shapes decide",
             .at = "inertia_kg_m2",
             .code = Code::kMissing});
}

void add_looks(table::Table<O>& object) {
  object
      .mapped(
          "grasps", "pose", pose_table(), &O::grasps,
          "Named frames of the object, such as places to grip it: frames OBJECT/NAME of the cell that move with it.")
      .value("rgba", table::fixed_type<Eigen::Vector4d>("", {.low = 0, .high = 1}), &O::rgba,
             "Colour: red, green, blue, opacity.")
      .fallback("grey");
  add_surface(object, "Material of its surfaces: a name of models/materials.json or of 'materials' (docs/contacts.md).",
              "the model's, else steel");
  object
      .number("stiffness_N_m", "N/m", &O::stiffness_N_m, kPositive,
              "Stiffness of the contacts of this object, whatever touches it; of two such objects the softer counts.")
      .fallback("that of the two materials in series")
      .number("damping_N_s_m", "N*s/m", &O::damping_N_s_m, kNotNegative,
              "Damping of these contacts; only with 'stiffness_N_m'.")
      .fallback("as much in proportion as the material has")
      .rule({.kind = table::Rule::Kind::kNeeds,
             .groups = {{"damping_N_s_m"}, {"stiffness_N_m"}},
             .hint = "Give both, or only 'stiffness_N_m', or a 'material'",
             .at = "damping_N_s_m",
             .code = Code::kMissing})
      .text("lit_by", &O::lit_by,
            "Makes the object a lamp that lights up in pictures while this digital output (BLOCK/TERMINAL) or light "
            "barrier is true; of a model: its shapes of the material 'light' (docs/simulation.md).");
}

}  // namespace

const table::Table<O>& object_table() {
  static const auto table = [] {
    table::Table<O> object;
    object.part("at", "place", placement_table(), &O::at, "Nominal pose of the object's frame.")
        .required()
        .object(copies_field(), {});
    add_body(object);
    object
        .part("vary", {}, variation_table(), &O::vary,
              "How far the true pose may differ from the nominal one; drawn uniformly from the seed and the object's "
              "name.")
        .fallback("not at all");
    add_mass(object);
    add_looks(object);
    object.rule([](O& entry, const table::Context& from) {
      if (entry.screw && !from.reader.has("fixed")) entry.fixed = false;
      if (entry.part_pointers.empty()) entry.part_pointers.assign(entry.parts.size(), from.reader.pointer());
      settle_mass(entry, from);
    });
    return object;
  }();
  return table;
}

}  // namespace takt::scenario
