#include "cell/file/description.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "cell/file/chart_files.h"
#include "cell/file/copies.h"
#include "cell/file/degrees.h"
#include "core/base/angles.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/base/random.h"
#include "core/device/channel_file.h"
#include "sim/film/film.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

Placement read_placement(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  Placement placement{reader.text("in", "world"), reader.pose()};
  reader.finish();
  return placement;
}

Placement read_placement(ObjectReader& reader, std::string_view key, bool required = true) {
  const Json* json = reader.object(key, required);
  return json ? read_placement(*json, reader.at(key), reader.diagnostics()) : Placement{};
}

Variation read_variation(ObjectReader& parent) {
  const Json* json = parent.object("vary", false);
  if (!json) return {};
  ObjectReader reader(*json, parent.at("vary"), parent.diagnostics());
  const std::vector<double> none{0, 0, 0};
  const Variation variation{reader.number("radius_m", 0.0, kNotNegative),
                            Eigen::Vector3d(reader.numbers("position_m", 3, none, kNotNegative).data()),
                            Eigen::Vector3d(reader.numbers("rpy_deg", 3, none, {.low = 0, .high = 180}).data())};
  reader.finish();
  return variation;
}

/// Calls `read(name, json, pointer)` for each member of an object that maps names to things.
template <class Read>
void for_each_member(ObjectReader& reader, std::string_view key, const Read& read) {
  const Json* members = reader.object(key, false);
  if (!members) return;
  for (const auto& [name, value] : members->items()) {
    const std::string pointer = reader.at(key) + pointer_segment(name);
    if (name.empty()) reader.diagnostics().error(Code::kInvalidName, pointer, "an empty name");
    if (name.find('/') != std::string::npos || name == "world") {
      reader.diagnostics().error(Code::kInvalidName, pointer, fmt::format("invalid name '{}'", name),
                                 "Choose a name without '/' that is not 'world'");
    }
    read(name, value, pointer);
  }
}

/// Named poses: {"top": {"position_m": [...], "rpy_deg": [...]}}.
std::map<std::string, Eigen::Isometry3d, std::less<>> read_poses(ObjectReader& parent, std::string_view key) {
  std::map<std::string, Eigen::Isometry3d, std::less<>> poses;
  for_each_member(parent, key, [&](const auto& name, const Json& json, const std::string& pointer) {
    ObjectReader reader(json, pointer, parent.diagnostics());
    poses[name] = reader.pose();
    reader.finish();
  });
  return poses;
}

DeviceEntry read_device(const std::string& name, const Json& json, const std::string& pointer,
                        Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  DeviceEntry device;
  device.name = name;
  device.model = reader.text("model");
  device.on = reader.text("on", "");
  if (reader.has("at")) device.at = read_placement(reader, "at");
  if (!device.on.empty() && device.at) {
    diagnostics.error(Code::kConflict, pointer, "both 'on' and 'at' are given",
                      "Mount it on a device, or place it in a frame");
  }
  if (const Json* mount = reader.object("mount", false)) {
    if (device.on.empty())
      diagnostics.error(Code::kInvalidValue, pointer + "/mount", "'mount' without 'on'",
                        "Give \"on\": NAME, or \"at\"");
    ObjectReader pose(*mount, pointer + "/mount", diagnostics);
    device.mount = pose.pose();
    pose.finish();
  }
  if (device.on.empty() && !device.at) device.at = Placement{};
  device.start_rad = reader.numbers("start_deg", 0, std::vector<double>{});
  warn_of_radians(device.start_rad, reader.at("start_deg"), diagnostics);
  for (double& q : device.start_rad) q *= kDegree;
  device.payload_error_kg = reader.number("payload_error_kg", 0.0);
  device.tool = reader.text("tool", "");
  device.tcp = reader.text("tcp", "");
  device.own_force = reader.text("own_force", "");
  device.material = reader.text("material", "");
  if (reader.has("friction")) device.friction = reader.number("friction", {}, kNotNegative);
  device.oiled = reader.boolean("oiled", false);
  device.tcps = read_poses(reader, "tcps");
  if (const Json* settings = reader.object("settings", false)) device.settings = *settings;
  reader.finish();
  return device;
}

/// "mass_kg", or the sum of the parts' masses; "centre_m" and "inertia_kg_m2" together instead of what the shapes give.
void read_mass(ObjectReader& reader, ObjectEntry& object) {
  Diagnostics& diagnostics = reader.diagnostics();
  double sum = 0.0;
  for (const double mass : object.part_masses_kg) sum += mass;
  if (sum > 0.0 && reader.has("mass_kg")) {
    diagnostics.error(Code::kConflict, reader.at("mass_kg"), "both the object and its parts have a mass",
                      "Remove one of them: the mass of the object is the sum");
  }
  object.mass_given = sum > 0.0 || reader.has("mass_kg");
  object.mass_kg = reader.number("mass_kg", sum > 0.0 ? sum : 1.0, kPositive);
  if (reader.has("centre_m")) object.centre_m = reader.vector("centre_m");
  if (reader.has("inertia_kg_m2")) {
    const auto values = reader.numbers("inertia_kg_m2", 0, {});
    Eigen::Matrix3d& I = object.inertia_kg_m2.emplace(Eigen::Matrix3d::Zero());
    if (values.size() == 3) {
      I.diagonal() << values[0], values[1], values[2];
    } else if (values.size() == 6) {
      I << values[0], values[3], values[4], values[3], values[1], values[5], values[4], values[5], values[2];
    } else {
      diagnostics.error(Code::kWrongSize, reader.at("inertia_kg_m2"), fmt::format("{} numbers", values.size()),
                        "Give [ixx, iyy, izz] or [ixx, iyy, izz, ixy, ixz, iyz]");
    }
  }
  if (object.centre_m && !object.inertia_kg_m2) {
    diagnostics.error(Code::kMissing, reader.at("inertia_kg_m2"), "'centre_m' without 'inertia_kg_m2'",
                      "Give both, or neither: then the shapes decide");
  }
  if (object.inertia_kg_m2 && !object.part_masses_kg.empty()) {
    diagnostics.error(Code::kConflict, reader.at("inertia_kg_m2"), "both an inertia and masses of parts are given",
                      "Remove one of them");
  }
}

void read_parts(ObjectReader& reader, ObjectEntry& object) {
  ShapeList shapes = read_shapes(reader);
  object.parts = std::move(shapes.parts);
  object.part_pointers = std::move(shapes.pointers);
  object.part_masses_kg = std::move(shapes.masses);
}

ObjectEntry read_object(const std::string& name, const Json& json, const std::string& pointer,
                        Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  ObjectEntry object;
  object.name = name;
  object.model = reader.text("model", "");
  if (object.model.empty()) {
    object.screw = read_screw(reader);
    if (!object.screw) read_parts(reader, object);
    if (object.screw && (reader.has("shape") || reader.has("parts"))) {
      diagnostics.error(Code::kConflict, pointer, "both a screw and shapes are given", "Remove one of them");
      read_parts(reader, object);
    }
  } else if (reader.has("shape") || reader.has("parts") || reader.has("screw")) {
    diagnostics.error(Code::kConflict, pointer, "both a model and shapes are given",
                      "Give \"model\", \"shape\" or \"parts\"");
    for (const char* key : {"parts", "screw", "shape", "size_m", "radius_m", "length_m", "inner_radius_m", "wall_m",
                            "floor_m", "chamfer_m", "inner_chamfer_m", "bores"})
      (void)reader.child(key);
  }
  object.at = read_placement(reader, "at");
  object.vary = read_variation(reader);
  object.fixed = reader.boolean("fixed", !object.screw);
  read_mass(reader, object);
  object.grasps = read_poses(reader, "grasps");
  const auto rgba = reader.numbers("rgba", 4, std::vector<double>{0.6, 0.6, 0.62, 1.0}, {.low = 0, .high = 1});
  object.rgba = Eigen::Vector4d(rgba.data());
  object.material = reader.text("material", "");
  const auto optional = [&](const char* key, const Range& range) {
    return reader.has(key) ? std::optional(reader.number(key, 1.0, range)) : std::nullopt;
  };
  object.friction = optional("friction", kNotNegative);
  object.oiled = reader.boolean("oiled", false);
  object.stiffness_N_m = optional("stiffness_N_m", kPositive);
  object.damping_N_s_m = optional("damping_N_s_m", kNotNegative);
  if (object.damping_N_s_m && !object.stiffness_N_m) {
    diagnostics.error(Code::kMissing, pointer + "/damping_N_s_m", "'damping_N_s_m' without 'stiffness_N_m'",
                      "Give both, or only 'stiffness_N_m', or a 'material'");
  }
  object.lit_by = reader.text("lit_by", "");
  reader.finish();
  return object;
}

CameraEntry read_camera(const std::string& name, const Json& json, const std::string& pointer,
                        Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  CameraEntry camera;
  camera.name = name;
  camera.at = read_placement(reader, "at");
  if (reader.has("look_at")) camera.look_at = read_placement(reader, "look_at");
  camera.fovy_deg = reader.number("fovy_deg", 45.0, {.low = 5, .high = 120});
  reader.finish();
  if (camera.look_at && camera.look_at->in == camera.at.in &&
      (camera.look_at->X.translation() - camera.at.X.translation()).norm() < 1e-6) {
    diagnostics.error(Code::kInvalidValue, pointer + "/look_at", "the camera is at the point that it looks at",
                      "Choose another point");
  }
  return camera;
}

FilmEntry read_film(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  FilmEntry film;
  film.camera = reader.text("camera", "");
  film.inset = reader.text("inset", "");
  film.force_sensor = reader.text("force_sensor", "");
  film.force_limit_N = reader.number("force_limit_N", 15.0, kPositive);
  if (reader.has("show")) choose_marks(reader.texts("show"), reader.at("show"), film.show, diagnostics);
  film.show.trace_s = reader.number("trace_s", film.show.trace_s, {.low = 0.0, .high = 1e6});
  if (const Json* cuts = reader.array("cuts", false)) {
    for (std::size_t i = 0; i < cuts->size(); ++i) {
      ObjectReader cut((*cuts)[i], reader.at("cuts") + pointer_segment(i), diagnostics);
      film.cuts.push_back({cut.text("step"), cut.text("camera")});
      cut.finish();
    }
  }
  reader.finish();
  return film;
}

}  // namespace

void choose_marks(const std::vector<std::string>& names, const std::string& pointer, FilmShow& show,
                  Diagnostics& diagnostics) {
  static const std::vector<std::pair<std::string, bool FilmShow::*>> kMarks = {{"traces", &FilmShow::traces},
                                                                               {"beams", &FilmShow::beams},
                                                                               {"forces", &FilmShow::forces},
                                                                               {"commanded", &FilmShow::commanded},
                                                                               {"frames", &FilmShow::frames}};
  for (const auto& [name, shown] : kMarks) show.*shown = std::ranges::find(names, name) != names.end();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(kMarks, names[i], &decltype(kMarks)::value_type::first) != kMarks.end()) continue;
    std::vector<std::string> known;
    for (const auto& mark : kMarks) known.push_back(mark.first);
    diagnostics.error(Code::kUnknownName, pointer + (pointer.starts_with('/') ? pointer_segment(i) : ""),
                      fmt::format("a film shows no '{}'", names[i]), nearest_choice(names[i], known));
  }
}

namespace {

CollisionsEntry read_collisions(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  CollisionsEntry collisions;
  collisions.margin_m = reader.number("margin_m", collisions.margin_m, {.low = 1e-5, .high = 0.1});
  if (reader.has("off")) collisions.off = reader.text("off");
  const Json* list = reader.array("allow", false);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    ObjectReader entry((*list)[i], reader.at("allow") + pointer_segment(i), diagnostics);
    CollisionsEntry::Allowed allowed{entry.texts("between"), entry.text("reason"), entry.pointer()};
    if (allowed.between.size() != 2) {
      diagnostics.error(Code::kWrongSize, entry.at("between"), fmt::format("{} names", allowed.between.size()),
                        "Name two devices, objects or bodies");
    } else {
      collisions.allow.push_back(std::move(allowed));
    }
    entry.finish();
  }
  reader.finish();
  return collisions;
}

/// Calls `read(entry, json, pointer)` for each object of a list whose entries have kinds: what `entry` finds is
/// reported where the kind is known.
template <class Read>
void for_each_entry(ObjectReader& reader, std::string_view key, const Read& read) {
  const Json* list = reader.array(key, false);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const Json& json = (*list)[i];
    const std::string pointer = reader.at(key) + pointer_segment(i);
    if (!json.is_object()) {
      reader.diagnostics().error(Code::kWrongType, pointer, "unexpected value " + short_dump(json),
                                 "Give an object {...}");
      continue;
    }
    Diagnostics unread;
    ObjectReader entry(json, pointer, unread);
    read(entry, json, pointer);
  }
}

void read_expectations(ObjectReader& reader, std::vector<ExpectationEntry>& expectations) {
  for_each_entry(reader, "expectations", [&](ObjectReader& entry, const Json& json, const std::string& pointer) {
    const std::string kind = entry.text("kind", "");
    expectations.push_back({entry.text("name", kind), kind, pointer, json});
  });
}

/// In the order of their times.
void read_faults(ObjectReader& reader, std::vector<FaultEntry>& faults) {
  for_each_entry(reader, "faults", [&](ObjectReader& entry, const Json& json, const std::string& pointer) {
    const double seconds = std::clamp(entry.number("at_s", 0.0), 0.0, kLongestRun);
    const std::string sensor = entry.text("sensor", "");
    faults.push_back({.at = static_cast<Nanoseconds>(std::llround(1e9 * seconds)),
                      .kind = entry.text("do", FaultEntry::kDefaultKind),
                      .device = sensor.empty() ? entry.text("device", "") : sensor,
                      .pointer = pointer,
                      .json = json});
  });
  std::ranges::stable_sort(faults, {}, &FaultEntry::at);
}

/// "golden": how closely runs have to follow the golden, by topic and column.
std::vector<record::ToleranceRule> read_golden(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  using Kind = record::ToleranceKind;
  static const std::vector<std::string> kKinds{"exact", "tube", "features", "report_only"};  // in the order of Kind
  std::vector<record::ToleranceRule> rules;
  ObjectReader golden(json, pointer, diagnostics);
  const Json* list = golden.array("tolerances");
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader reader((*list)[i], golden.at("tolerances") + pointer_segment(i), diagnostics);
    record::ToleranceRule rule{
        .topic = reader.text("topic", "*"), .column = reader.text("column", "*"), .tolerance = {}};
    const std::string kind = reader.choice("kind", kKinds, "tube");
    rule.tolerance.kind = static_cast<Kind>(std::ranges::find(kKinds, kind) - kKinds.begin());
    const bool has_width = rule.tolerance.kind == Kind::kTube || rule.tolerance.kind == Kind::kFeatures;
    if (has_width) {
      rule.tolerance.dv = reader.number("dv", {}, kNotNegative);
      const double window = reader.number("dt_s", to_seconds(rule.tolerance.dt), {.low = 0.0, .high = 10.0});
      rule.tolerance.dt = static_cast<Nanoseconds>(std::llround(1e9 * window));
    }
    if (rule.tolerance.kind == Kind::kFeatures && reader.has("features")) {
      rule.tolerance.features.reset();
      const std::vector<std::string> names = reader.texts("features");
      for (std::size_t k = 0; k < names.size(); ++k)
        record::judge_feature(names[k], reader.at("features") + pointer_segment(k), rule.tolerance.features,
                              diagnostics);
    }
    reader.finish();
    rules.push_back(std::move(rule));
  }
  golden.finish();
  return rules;
}

/// Frames, devices, objects and channels share one name space, so that "in" is never ambiguous.
void check_names(const Description& description, Diagnostics& diagnostics) {
  std::set<std::string> names;
  const auto once = [&](const std::string& name, const std::string& place) {
    if (!names.insert(name).second) {
      diagnostics.error(Code::kDuplicate, place + pointer_segment(name),
                        fmt::format("the name '{}' is used twice in this cell", name),
                        "Choose another name: frames, devices, objects and channels share one name space");
    }
  };
  for (const auto& frame : description.frames) once(frame.name, "/frames");
  for (const auto& device : description.devices) {
    once(device.name, "/devices");
    if (!device.own_force.empty()) once(device.own_force, "/devices" + pointer_segment(device.name) + "/own_force");
  }
  for (const auto& whole : description.composed) once(whole.name, "/composed");
  for (const auto& object : description.objects) once(object.name, "/objects");
  for (const auto& channel : description.channels) once(channel.name, "/channels");
}

void check_film(const Description& description, Diagnostics& diagnostics) {
  std::vector<std::string> cameras;
  for (const auto& camera : description.cameras) cameras.push_back(camera.name);
  const auto known = [&](const std::string& camera, const std::string& pointer) {
    if (camera.empty() || camera == sim::kFittingCamera || std::ranges::find(cameras, camera) != cameras.end()) return;
    diagnostics.error(Code::kUnknownName, pointer, fmt::format("there is no camera '{}'", camera),
                      nearest_choice(camera, cameras));
  };
  known(description.film.camera, "/film/camera");
  known(description.film.inset, "/film/inset");
  for (std::size_t i = 0; i < description.film.cuts.size(); ++i) {
    known(description.film.cuts[i].camera, fmt::format("/film/cuts/{}/camera", i));
  }
}

/// A cycle of 1 ms has whole steps.
Nanoseconds read_physics_step(ObjectReader& reader, Diagnostics& diagnostics) {
  const double step_ms = reader.number("physics_step_ms", 1.0);
  if (step_ms != 1.0 && step_ms != 0.5 && step_ms != 0.25) {
    diagnostics.error(Code::kOutOfRange, reader.at("physics_step_ms"), fmt::format("the step is {} ms", step_ms),
                      "Choose 1, 0.5 or 0.25");
    return kMillisecond;
  }
  return static_cast<Nanoseconds>(step_ms * static_cast<double>(kMillisecond));
}

Description read_document(const Json& document, ReadFor purpose, Diagnostics& diagnostics) {
  Description description;
  ObjectReader reader(document, "", diagnostics);
  description.title = reader.text("title", "");
  (void)reader.text("description", "");
  description.seed = static_cast<std::uint64_t>(reader.integer("seed", 1, kNotNegative));
  description.time_limit_s = reader.number("time_limit_s", 120.0, {.low = 0.0, .high = kLongestRun, .low_open = true});
  description.program_latency_cycles = reader.integer("program_latency_cycles", 2, {.low = 0, .high = 1000});
  description.plant_mass_scale = reader.number("plant_mass_scale", 1.0, {.low = 0.5, .high = 2.0});
  description.physics_step = read_physics_step(reader, diagnostics);
  for_each_member(reader, "frames", [&](const auto& name, const Json& json, const std::string& pointer) {
    description.frames.push_back({name, read_placement(json, pointer, diagnostics)});
  });
  for_each_member(reader, "devices", [&](const auto& name, const Json& json, const std::string& pointer) {
    description.devices.push_back(read_device(name, json, pointer, diagnostics));
  });
  for_each_member(reader, "composed", [&](const auto& name, const Json& parts, const std::string& pointer) {
    // A reader of this member alone: it searches, and there may be many.
    const Json one = Json::object({{name, parts}});
    ObjectReader wholes(one, reader.at("composed"), diagnostics);
    description.composed.push_back({name, pointer, wholes.texts(name)});
    if (description.composed.back().parts.empty())
      diagnostics.error(Code::kMissing, pointer, "no part is given", "Name at least one device");
  });
  for_each_member(reader, "objects", [&](const auto& name, const Json& json, const std::string& pointer) {
    description.objects.push_back(read_object(name, json, pointer, diagnostics));
  });
  if (const Json* materials = reader.object("materials", false)) description.materials = *materials;
  if (const Json* contacts = reader.array("contacts", false)) description.contacts = *contacts;
  for_each_member(reader, "cameras", [&](const auto& name, const Json& json, const std::string& pointer) {
    description.cameras.push_back(read_camera(name, json, pointer, diagnostics));
  });
  if (const Json* film = reader.object("film", false)) description.film = read_film(*film, "/film", diagnostics);
  for_each_member(reader, "channels", [&](const auto& name, const Json& json, const std::string& pointer) {
    description.channels.push_back(device::channel_from_json(name, json, pointer, diagnostics));
  });
  (void)reader.object("nets", false);  // read by read_nets()
  read_faults(reader, description.faults);
  for (DeviceEntry& device : description.devices)
    device.may_fail = std::ranges::any_of(description.faults, [&](const FaultEntry& fault) {
      return fault.device.substr(0, fault.device.find('/')) == device.name;  // "BLOCK/TERMINAL" too
    });
  if (const Json* collisions = reader.object("collisions", false))
    description.collisions = read_collisions(*collisions, "/collisions", diagnostics);
  const bool required = purpose == ReadFor::kScenario;
  if (const Json* program = reader.object("program", required)) description.program = *program;
  if (const Json* programs = reader.object("programs", false)) description.programs = *programs;
  if (const Json* script = reader.array("operator", false)) {
    description.operator_script = read_operator(*script, "/operator", diagnostics);
  }
  read_expectations(reader, description.expectations);
  if (const Json* golden = reader.object("golden", false))
    description.tolerances = read_golden(*golden, "/golden", diagnostics);
  reader.finish();
  check_names(description, diagnostics);
  check_film(description, diagnostics);
  return description;
}

void apply(const Override& change, Json& document, Diagnostics& diagnostics) {
  try {
    const Json::json_pointer pointer(change.pointer);
    const Json::json_pointer parent = pointer.parent_pointer();
    if (pointer.empty() || !document.contains(parent)) {
      diagnostics.error(Code::kUnknownName, change.pointer, "--set names an element that is not in the file",
                        "Give the JSON pointer of an existing object");
      return;
    }
    const auto value = parse_json(change.value);
    document[pointer] = value ? *value : Json(change.value);
  } catch (const Json::exception&) {
    diagnostics.error(Code::kMissing, change.pointer, "--set needs a JSON pointer",
                      "Write it as in /devices/arm/model=NAME");
  }
}

}  // namespace

namespace {

/// @param folder  of the files that the text names; none are found below an empty one
std::optional<Description> parse(std::string_view text, const std::filesystem::path& folder,
                                 const std::vector<Override>& overrides, std::optional<std::uint64_t> seed,
                                 ReadFor purpose, Diagnostics& diagnostics) {
  auto document = parse_json(text);
  if (!document) {
    diagnostics.append(document.error());
    return std::nullopt;
  }
  for (const Override& change : overrides) apply(change, *document, diagnostics);
  write_out_copies(*document, diagnostics);
  std::vector<NetEntry> nets = read_nets(*document, folder, diagnostics);
  read_charts(*document, folder, diagnostics);
  Description description = read_document(*document, purpose, diagnostics);
  description.nets = std::move(nets);
  description.text = document->dump(2) + "\n";
  if (seed) description.seed = *seed;
  return description;
}

}  // namespace

Result<Description> parse_description(std::string_view text, const std::vector<Override>& overrides,
                                      std::optional<std::uint64_t> seed) {
  Diagnostics diagnostics;
  auto description = parse(text, {}, overrides, seed, ReadFor::kScenario, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return std::move(*description);
}

std::optional<Description> read_description(const std::filesystem::path& file, const std::vector<Override>& overrides,
                                            std::optional<std::uint64_t> seed, Diagnostics& diagnostics,
                                            ReadFor purpose) {
  const auto text = read_file(file, InputLimits{}.bytes);
  if (!text) {
    diagnostics.append(text.error());
    return std::nullopt;
  }
  auto description = parse(*text, file.parent_path(), overrides, seed, purpose, diagnostics);
  diagnostics.set_file(file.string());
  if (!description) return std::nullopt;
  description->file = file;
  if (description->title.empty()) description->title = file.stem().string();
  return description;
}

Result<Description> read_description(const std::filesystem::path& file, const std::vector<Override>& overrides,
                                     std::optional<std::uint64_t> seed) {
  Diagnostics diagnostics;
  auto description = read_description(file, overrides, seed, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return std::move(*description);
}

Eigen::Isometry3d drawn_pose(const ObjectEntry& object, std::uint64_t seed) {
  Random random(seed, object.name);
  const double radius = object.vary.radius_m * std::sqrt(random.unit());
  const double direction = random.uniform(0.0, 2.0 * std::numbers::pi);
  Eigen::Isometry3d X = object.at.X;
  X.translation() += radius * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
  for (int axis = 0; axis < 3; ++axis) X.translation()[axis] += object.vary.position_m[axis] * random.uniform(-1, 1);
  for (int axis = 2; axis >= 0; --axis) {
    X.linear() = X.linear() * Eigen::AngleAxisd(object.vary.rpy_deg[axis] * kDegree * random.uniform(-1, 1),
                                                Eigen::Vector3d::Unit(axis))
                                  .toRotationMatrix();
  }
  return X;
}

}  // namespace takt::cell
