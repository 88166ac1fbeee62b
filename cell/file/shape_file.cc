#include "cell/file/shape_file.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

namespace takt::cell {
namespace {

using Part = world::Object::Part;

constexpr double kSteel = 7850.0;  // kg/m^3
/// A chamfer of a thread is so much wider than the thread is deep, so that the tip of a screw finds it.
constexpr double kChamferOfThread = 0.6;  // of the difference of the diameters; 0.5 would just clear the flanks

void add(std::vector<Part>& parts, Part part, const Eigen::Vector3d& middle = Eigen::Vector3d::Zero()) {
  part.X_OS.translation() = middle;
  parts.push_back(std::move(part));
}

}  // namespace

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
