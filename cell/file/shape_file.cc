#include "cell/file/shape_file.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::cell {
namespace {

/// Of a body that one can handle, m: contacts are stiff, and a thinner one would be jumped over in one step.
constexpr Range kBodySize{.low = 1e-5, .high = 1e3};

using Json = nlohmann::ordered_json;
using Part = world::Object::Part;

constexpr double kSteel = 7850.0;  // kg/m^3
/// A chamfer of a thread is so much wider than the thread is deep, so that the tip of a screw finds it.
constexpr double kChamferOfThread = 0.6;          // of the difference of the diameters; 0.5 would just clear the flanks
constexpr const char* kClearance = "clearance ";  // in Bore::thread until the size is known

world::Bore read_bore(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  world::Bore bore;
  bore.X_SB = reader.pose();
  const int sizes = static_cast<int>(reader.has("radius_m")) + static_cast<int>(reader.has("thread")) +
                    static_cast<int>(reader.has("clearance_for"));
  if (sizes != 1) {
    diagnostics.error(sizes == 0 ? Code::kMissing : Code::kConflict, pointer,
                      fmt::format("{} of 'radius_m', 'thread' and 'clearance_for' are given", sizes), "one of them");
  }
  bore.radius = reader.number("radius_m", 0.001, kPositive);
  bore.thread = reader.text("thread", "");
  if (const std::string size = reader.text("clearance_for", ""); !size.empty()) bore.thread = kClearance + size;
  if (reader.has("depth_m")) bore.depth = reader.number("depth_m", 0.001, kPositive);
  bore.chamfer = reader.number("chamfer_m", bore.thread.empty() ? 0.0 : -1.0, kNotNegative);
  reader.finish();
  return bore;
}

std::vector<world::Bore> read_bores(ObjectReader& reader) {
  std::vector<world::Bore> bores;
  const Json* list = reader.array("bores", false);
  for (std::size_t i = 0; list && i < list->size(); ++i)
    bores.push_back(read_bore((*list)[i], reader.at("bores") + pointer_segment(i), reader.diagnostics()));
  return bores;
}

void add(std::vector<Part>& parts, Part part, const Eigen::Vector3d& middle = Eigen::Vector3d::Zero()) {
  part.X_OS.translation() = middle;
  parts.push_back(std::move(part));
}

/// A cylinder with a bore from end to end.
std::vector<Part> read_tube(ObjectReader& reader) {
  const double radius = reader.number("radius_m", {}, kBodySize), length = reader.number("length_m", {}, kBodySize);
  Part tube{.shape = world::Cylinder{radius, length}};
  world::Bore bore;
  bore.radius = reader.number("inner_radius_m", {}, kBodySize);
  bore.chamfer = reader.number("inner_chamfer_m", 0.0, kNotNegative);
  bore.X_SB.translation().z() = 0.5 * length;
  tube.chamfer = reader.number("chamfer_m", 0.0, kNotNegative);
  if (bore.radius >= radius) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("inner_radius_m"),
                               fmt::format("{:g} m inside {:g} m", bore.radius, radius),
                               "Make it less than 'radius_m'");
  }
  tube.bores.push_back(std::move(bore));
  return {std::move(tube)};
}

/// A box without a lid: a floor and four walls, of which the two along x stand between the others.
std::vector<Part> read_container(ObjectReader& reader) {
  const Eigen::Vector3d size(reader.numbers("size_m", 3, {}, kBodySize).data());
  const double wall = reader.number("wall_m", {}, kBodySize);
  const double floor = reader.number("floor_m", wall, kBodySize);
  std::vector<Part> parts;
  if (2.0 * wall >= std::min(size.x(), size.y()) || floor >= size.z()) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("wall_m"), "walls and floor leave no room",
                               "Make walls thinner than half the width, and the floor lower than the walls");
    return parts;
  }
  add(parts, {.shape = world::Box{{size.x(), size.y(), floor}}}, {0.0, 0.0, 0.5 * (floor - size.z())});
  const double height = size.z() - floor, middle = 0.5 * floor;
  for (const double side : {-1.0, 1.0}) {
    add(parts, {.shape = world::Box{{wall, size.y(), height}}}, {0.5 * side * (size.x() - wall), 0.0, middle});
    add(parts, {.shape = world::Box{{size.x() - 2.0 * wall, wall, height}}},
        {0.0, 0.5 * side * (size.y() - wall), middle});
  }
  return parts;
}

std::vector<Part> read_cylinder(ObjectReader& reader) {
  const double radius = reader.number("radius_m", {}, kBodySize);
  Part part{.shape = world::Cylinder{radius, reader.number("length_m", {}, kBodySize)}};
  part.chamfer = reader.number("chamfer_m", 0.0, kNotNegative);
  part.bores = read_bores(reader);
  return {std::move(part)};
}

std::vector<Part> read_box(ObjectReader& reader) {
  Part part{.shape = world::Box{Eigen::Vector3d(reader.numbers("size_m", 3, {}, kBodySize).data())}};
  part.bores = read_bores(reader);
  return {std::move(part)};
}

std::vector<Part> read_sphere(ObjectReader& reader) {
  return {{.shape = world::Sphere{reader.number("radius_m", {}, kBodySize)}}};
}

std::vector<Part> read_capsule(ObjectReader& reader) {
  const double radius = reader.number("radius_m", {}, kBodySize);
  return {{.shape = world::Capsule{radius, reader.number("length_m", {}, kBodySize)}}};
}

struct ShapeKind {
  const char* name;
  std::vector<Part> (*read)(ObjectReader& reader);
};
constexpr ShapeKind kShapes[] = {{"box", read_box},         {"cylinder", read_cylinder}, {"sphere", read_sphere},
                                 {"capsule", read_capsule}, {"tube", read_tube},         {"container", read_container}};

/// One entry: a shape with its sizes, made of one or several parts about its own frame.
std::vector<Part> read_shape(ObjectReader& reader) {
  std::vector<std::string> names;
  for (const ShapeKind& kind : kShapes) names.emplace_back(kind.name);
  const auto found = std::ranges::find(kShapes, reader.choice("shape", names), &ShapeKind::name);
  return found == std::end(kShapes) ? std::vector<Part>() : found->read(reader);
}

/// A mass belongs to an entry; its parts share it by their volumes.
void read_entry(ObjectReader& reader, ShapeList& list) {
  const Eigen::Isometry3d X_OE = reader.pose();
  std::optional<double> mass;
  if (reader.has("mass_kg")) mass = reader.number("mass_kg", 1.0, kPositive);
  const std::vector<Part> made = read_shape(reader);
  double whole = 0.0;
  for (const Part& part : made) whole += volume(part);
  for (const Part& part : made) {
    list.parts.push_back(part);
    list.parts.back().X_OS = X_OE * part.X_OS;
    list.pointers.push_back(reader.pointer());
    if (mass) list.masses.push_back(*mass * volume(part) / whole);
  }
}

}  // namespace

ShapeList read_shapes(ObjectReader& reader) {
  const Json* entries = reader.array("parts", false);
  ShapeList list;
  if (!entries) {
    list.parts = read_shape(reader);
    list.pointers.assign(list.parts.size(), reader.pointer());
    return list;
  }
  std::size_t heavy = 0;
  for (std::size_t i = 0; i < entries->size(); ++i) {
    ObjectReader entry((*entries)[i], reader.at("parts") + pointer_segment(i), reader.diagnostics());
    heavy += entry.has("mass_kg") ? 1 : 0;
    read_entry(entry, list);
    entry.finish();
  }
  if (heavy > 0 && heavy != entries->size()) {
    reader.diagnostics().error(Code::kWrongSize, reader.at("parts"),
                               fmt::format("{} of {} parts have a mass", heavy, entries->size()),
                               "Give all of them one, or none");
  }
  if (entries->empty())
    reader.diagnostics().error(Code::kMissing, reader.at("parts"), "no part is given", "Give at least one shape");
  return list;
}

std::optional<ScrewEntry> read_screw(ObjectReader& parent) {
  const Json* json = parent.object("screw", false);
  if (!json) return std::nullopt;
  ObjectReader reader(*json, parent.at("screw"), parent.diagnostics());
  ScrewEntry screw{reader.text("thread"), reader.number("length_m", {}, kBodySize)};
  reader.finish();
  return screw;
}

const device::ScrewThread* find_thread(const device::ScrewThreadTable& threads, const std::string& size,
                                       const std::string& pointer, Diagnostics& diagnostics) {
  const auto found = threads.find(size);
  if (found != threads.end()) return &found->second;
  std::vector<std::string> sizes;
  for (const auto& [name, thread] : threads) sizes.push_back(name);
  diagnostics.error(Code::kUnknownName, pointer, fmt::format("there is no thread '{}'", size),
                    nearest_choice(size, sizes));
  return nullptr;
}

void set_threads(std::vector<Part>& parts, const std::vector<std::string>& pointers,
                 const device::ScrewThreadTable& threads, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t k = 0; k < parts[i].bores.size(); ++k) {
      world::Bore& bore = parts[i].bores[k];
      if (bore.thread.empty()) continue;
      const bool clearance = bore.thread.starts_with(kClearance);
      const std::string size = clearance ? bore.thread.substr(std::string_view(kClearance).size()) : bore.thread;
      const std::string pointer =
          pointers[i] + "/bores" + pointer_segment(k) + (clearance ? "/clearance_for" : "/thread");
      const device::ScrewThread* thread = find_thread(threads, size, pointer, diagnostics);
      if (clearance) bore.thread.clear();
      if (!thread) continue;
      bore.radius = 0.5 * (clearance ? thread->clearance : thread->minor);
      if (bore.chamfer < 0.0) bore.chamfer = clearance ? 0.0 : kChamferOfThread * (thread->major - thread->minor);
    }
  }
}

ScrewShapes shapes_of(const ScrewEntry& screw, const device::ScrewThread& thread) {
  constexpr double kPlay = 1.02;  // of the socket: a key has to go in
  world::Bore socket;
  socket.radius = 0.5 * kPlay * thread.socket_width;
  socket.depth = thread.socket_depth;
  socket.chamfer = 0.1 * thread.socket_width;
  socket.X_SB.translation().z() = 0.5 * thread.head_height;
  ScrewShapes made;
  add(made.parts,
      {.shape = world::Cylinder{0.5 * thread.major, screw.length_m},
       .chamfer = kChamferOfThread * (thread.major - thread.minor)},
      {0.0, 0.0, 0.5 * screw.length_m});
  add(made.parts,
      {.shape = world::Cylinder{0.5 * thread.head_diameter, thread.head_height}, .bores = {std::move(socket)}},
      {0.0, 0.0, screw.length_m + 0.5 * thread.head_height});
  // Flanks weigh as a cylinder of the pitch diameter does.
  const double shank = 0.25 * std::numbers::pi * thread.pitch_diameter * thread.pitch_diameter * screw.length_m;
  made.mass = kSteel * (shank + volume(made.parts[1]));
  made.X_OS.translation().z() = screw.length_m + thread.head_height - thread.socket_depth;
  made.X_OS.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return made;
}

}  // namespace takt::cell
