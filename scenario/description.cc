#include "scenario/description.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "core/base/json.h"
#include "core/base/random.h"
#include "core/device/channel_file.h"
#include "core/device/material.h"
#include "scenario/cell_tables.h"
#include "scenario/copies.h"
#include "scenario/degrees.h"
#include "scenario/fault.h"
#include "sim/film.h"

namespace takt::scenario {
namespace {

using Json = nlohmann::ordered_json;

void read_expectations(ObjectReader& reader, Description& description) {
  const Json* list = reader.array("expectations", false);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string pointer = reader.at("expectations") + pointer_segment(i);
    if (!(*list)[i].is_object()) {
      reader.diagnostics().error(Code::kWrongType, pointer, "unexpected value " + short_dump((*list)[i]),
                                 "an object {...}");
      continue;
    }
    Diagnostics unread;  // the fields of each kind are read, and reported, where the kind is known
    ObjectReader entry((*list)[i], pointer, unread);
    const std::string kind = entry.text("kind", "");
    description.expectations.push_back({entry.text("name", kind), kind, pointer, (*list)[i]});
  }
}

/// Frames, devices, objects and channels share one name space, so that "in" is never ambiguous.
void check_names(const Description& description, Diagnostics& diagnostics) {
  std::set<std::string> names;
  const auto once = [&](const std::string& name, const std::string& place) {
    if (!names.insert(name).second) {
      diagnostics.error(Code::kDuplicate, place + pointer_segment(name),
                        fmt::format("the name '{}' is used twice in this cell", name),
                        "frames, devices, objects and channels share one name space");
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

using DescriptionTable = table::Table<Description>;

constexpr Range kTimeLimit{.low = 0.0, .high = 3600.0, .low_open = true};

/// Something with a definition of its own that other layers read.
table::Field defined(std::string_view key, table::Field::Type type, std::string_view definition, std::string_view doc) {
  table::Field row = table::field(key, type, doc);
  if (type == table::Field::Type::kObject) {
    row.definition = definition;
  } else {
    row.items = {table::field({}, table::Field::Type::kObject, {})};
    row.items.front().definition = definition;
  }
  return row;
}

void add_figures(DescriptionTable& file) {
  using D = Description;
  file.text("title", &D::title, "Title in the film and in reports.")
      .fallback("name of the file")
      .object(table::field("description", table::Field::Type::kText, "Text for readers of the file."),
              [](const table::Field& row, const table::Context& from, D&) { (void)from.reader.text(row.key, ""); })
      .integer("seed", &D::seed, {.low = 0, .high = 9223372036854775807.0},
               "Seed of all random draws: object poses, sensor noise, sensor offsets.")
      .number("time_limit_s", "s", &D::time_limit_s, kTimeLimit, "Simulated time; a run that takes longer is an error.")
      .integer("program_latency_cycles", &D::program_latency_cycles, {.low = 0, .high = 1000},
               "Cycles between a command of the program and its effect.")
      .number("plant_mass_scale", "", &D::plant_mass_scale, {.low = 0.5, .high = 2.0},
              "Factor on the masses of the simulated machines; their controllers keep the nominal masses.");
}

/// Names of devices to hold as a whole.
void read_composed(const table::Field& row, const table::Context& from, Description& description) {
  table::for_each_key(
      row.key, from.reader, [&](const std::string& name, const Json& parts, const std::string& pointer) {
        // A reader of this member alone: it searches, and there may be many.
        const Json one = Json::object({{name, parts}});
        ObjectReader whole(one, from.reader.at(row.key), from.reader.diagnostics());
        description.composed.push_back({name, pointer, whole.texts(name)});
        if (description.composed.back().parts.empty())
          from.reader.diagnostics().error(Code::kMissing, pointer, "no part is given", "Name at least one device");
      });
}

void read_channels(const table::Field& row, const table::Context& from, Description& description) {
  table::for_each_key(row.key, from.reader, [&](const std::string& name, const Json& json, const std::string& pointer) {
    description.channels.push_back(device::channel_from_json(name, json, pointer, from.reader.diagnostics()));
  });
}

void add_cell(DescriptionTable& file) {
  using D = Description;
  table::Field parts = table::field({}, table::Field::Type::kTexts, {});
  parts.count.min = 1;
  for (table::Field& one : parameter_fields()) file.object(std::move(one), {});
  file.members("frames", "place", frame_table(), &D::frames, "Poses by name, to be used as 'in'.")
      .members("devices", "device", device_entry_table(), &D::devices,
               "Arms, bases, sensors, tools, grippers and I/O blocks by name.")
      .object(table::map_field("composed", std::move(parts),
                               "Composed devices: name to the names of its devices, signals or other composed devices. "
                               "A net can hold it as one device (docs/devices/composed.md)."),
              read_composed)
      .members("objects", "object", object_table(), &D::objects, "Physical objects by name.")
      .value("materials", table::json_type(device::materials_field()), &D::materials,
             "Surfaces beyond those of models/materials.json, by name; a known name is replaced (docs/contacts.md).")
      .value("contacts", table::json_type(device::contacts_field()), &D::contacts,
             "What two materials do together where it is not what follows from the two.")
      .part("collisions", "collisions", collisions_table(), &D::collisions,
            "Checks of collisions, in the rehearsal and in the run (docs/world.md).")
      .fallback("on, with the defaults")
      .members("cameras", "camera", camera_table(), &D::cameras, "Cameras by name.")
      .part("film", "film", film_table(), &D::film, "What the film shows.");
}

table::Field nets_field() {
  table::Field file = table::field({}, table::Field::Type::kText, {});
  file.count.min = 1;
  table::Field net = table::field({}, table::Field::Type::kEither, {});
  net.items = {std::move(file), table::any_object()};
  table::Field nets = table::field("nets", table::Field::Type::kMap,
                                   "Nets written by hand, by name, for the step 'net': the net itself, or its file in "
                                   "the folder of the scenario or below (docs/nets.md).");
  nets.items = {std::move(net)};
  return nets;
}

table::Field faults_field() {
  table::Field faults = table::field("faults", table::Field::Type::kList,
                                     "Faults and actions at the cabinet during the run, at given times.");
  faults.items = {fault_form()};
  return faults;
}

void add_program(DescriptionTable& file) {
  using D = Description;
  table::Field program =
      defined("program", table::Field::Type::kObject, "step", "What the cell does: one step, usually a sequence.");
  program.required = true;  // read_document() asks for it where a scenario is read
  file.object(table::map_field("channels", device::channel_table().form("channel"),
                               "Values that nets exchange with each other and with the outside, by name "
                               "(docs/channels.md)."),
              read_channels)
      .object(nets_field(),  // read_nets() has read them
              [](const table::Field& row, const table::Context& from, D&) { (void)from.reader.object(row.key, false); })
      .object(faults_field(), [](const table::Field&, const table::Context& from,
                                 D& description) { description.faults = read_faults(from.reader); })
      .object(std::move(program),
              [](const table::Field& row, const table::Context& from, D& description) {
                if (const Json* json = from.reader.object(row.key, false)) description.program = *json;
              })
      .value("programs", table::json_type(defined({}, table::Field::Type::kMap, "sub_program", {})), &D::programs,
             "Programs that the step 'call' runs, by name (docs/programs.md).")
      .elements("operator", "operator_action", operator_table(), &D::operator_script,
                "What an operator does at the panel while the program runs.")
      .object(defined("expectations", table::Field::Type::kList, "expectation",
                      "Statements about the run; the verdict is 'passed' if all are true."),
              [](const table::Field&, const table::Context& from, D& description) {
                read_expectations(from.reader, description);
              });
}

const DescriptionTable& golden_table() {
  static const auto table = [] {
    DescriptionTable golden;
    golden
        .elements("tolerances", "tolerance", tolerance_table(), &Description::tolerances,
                  "The first one that fits a column counts; without one the unit of the column decides "
                  "(docs/recording.md#comparing).")
        .required();
    return golden;
  }();
  return table;
}

Description read_document(const Json& document, ReadFor purpose, Diagnostics& diagnostics) {
  Description description;
  ObjectReader reader(document, "", diagnostics);
  description_table().read_into(description, {reader});
  if (purpose == ReadFor::kScenario && !reader.has("program")) (void)reader.object("program");
  for (DeviceEntry& device : description.devices)
    device.may_fail = std::ranges::any_of(description.faults, [&](const auto& fault) {
      const std::string_view failing = fault->failing_device();  // "BLOCK/TERMINAL" too
      return failing.substr(0, failing.find('/')) == device.name;
    });
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
                        "the JSON pointer of an existing object");
      return;
    }
    const auto value = parse_json(change.value);
    document[pointer] = value ? *value : Json(change.value);
  } catch (const Json::exception&) {
    diagnostics.error(Code::kMissing, change.pointer, "--set needs a JSON pointer", "/devices/arm/model=NAME");
  }
}

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
  Description description = read_document(*document, purpose, diagnostics);
  description.nets = std::move(nets);
  description.text = document->dump(2) + "\n";
  if (seed) description.seed = *seed;
  return description;
}

}  // namespace

const table::Table<Description>& description_table() {
  static const auto table = [] {
    DescriptionTable file;
    add_figures(file);
    add_cell(file);
    add_program(file);
    file.part(
        "golden", {}, golden_table(), [](Description & description) -> auto& { return description; },
        "How closely runs have to follow the golden of this scenario (takt bless), and its recordings each other "
        "(takt compare).");
    return file;
  }();
  return table;
}

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

}  // namespace takt::scenario
