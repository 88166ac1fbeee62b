#include "cell/file/threaded_objects.h"

namespace takt::cell {
namespace {

std::string pointer_of(const ObjectEntry& object) { return "/objects" + pointer_segment(object.name); }

void complete_screw(ObjectEntry& object, const device::ScrewThread& thread) {
  ScrewShapes shapes = shapes_of(*object.screw, thread);
  object.screw->figures = thread;
  object.parts = std::move(shapes.parts);
  object.part_pointers.assign(object.parts.size(), pointer_of(object) + "/screw");
  object.grasps.try_emplace("socket", shapes.X_OS);
  if (!object.mass_given) object.mass_kg = shapes.mass;
  if (object.material.empty()) object.material = "fastener";
}

}  // namespace

Description with_threads(const Description& description, const device::ModelLibrary& models, Diagnostics& diagnostics) {
  Description made = description;
  const auto threads = device::read_threads(models);
  if (!threads) diagnostics.append(threads.error());
  const device::ScrewThreadTable sizes = threads.value_or(device::ScrewThreadTable{});
  for (ObjectEntry& object : made.objects) {
    set_threads(object.parts, object.part_pointers, sizes, diagnostics);
    if (!object.screw) continue;
    const std::string pointer = pointer_of(object) + "/screw/thread";
    if (const device::ScrewThread* thread = find_thread(sizes, object.screw->thread, pointer, diagnostics))
      complete_screw(object, *thread);
  }
  return made;
}

std::optional<sim::ScrewDescription> simulated_screw(const ObjectEntry& entry) {
  if (!entry.screw || !entry.screw->figures) return std::nullopt;
  const device::ScrewThread& thread = *entry.screw->figures;
  sim::ScrewDescription screw;
  screw.thread = {entry.screw->thread,   thread.pitch,    thread.major,
                  thread.pitch_diameter, thread.run_down, thread.friction};
  return screw;
}

}  // namespace takt::cell
