#include "cell/file/description.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "cell/file/chart_files.h"
#include "cell/file/copies.h"
#include "cell/file/degrees.h"
#include "cell/file/forms.h"
#include "cell/file/robot_programs.h"
#include "core/base/json.h"
#include "core/base/random.h"
#include "sim/film/film.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

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

/// Of frames, which the program knows as they were drawn, and of mounts, which it does not know.
void draw_places(Description& description) {
  for (FrameEntry& frame : description.frames)
    frame.at.X = drawn_pose(frame.at.X, frame.vary, description.seed, frame.name);
  for (DeviceEntry& device : description.devices)
    device.true_mount = drawn_pose(device.mount, device.vary, description.seed, device.name);
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
  read_charts(*document, folder, diagnostics);
  read_robot_programs(*document, folder, diagnostics);
  Description description = scenario_form(purpose).read(*document, "", diagnostics);
  check_names(description, diagnostics);
  check_film(description, diagnostics);
  description.nets = std::move(nets);
  description.text = document->dump(2) + "\n";
  if (seed) description.seed = *seed;
  draw_places(description);
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
  return drawn_pose(object.at.X, object.vary, seed, object.name);
}

Eigen::Isometry3d drawn_pose(const Eigen::Isometry3d& nominal, const Variation& vary, std::uint64_t seed,
                             std::string_view name) {
  Random random(seed, name);
  const double radius = vary.radius_m * std::sqrt(random.unit());
  const double direction = random.uniform(0.0, 2.0 * std::numbers::pi);
  Eigen::Isometry3d X = nominal;
  X.translation() += radius * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
  for (int axis = 0; axis < 3; ++axis) X.translation()[axis] += vary.position_m[axis] * random.uniform(-1, 1);
  for (int axis = 2; axis >= 0; --axis) {
    X.linear() = X.linear() *
                 Eigen::AngleAxisd(vary.rpy_deg[axis] * kDegree * random.uniform(-1, 1), Eigen::Vector3d::Unit(axis))
                     .toRotationMatrix();
  }
  for (int axis = 0; axis < 3; ++axis)
    X.translation()[axis] += vary.normal_m[axis] > 0.0 ? vary.normal_m[axis] * random.normal() : 0.0;
  return X;
}

}  // namespace takt::cell
