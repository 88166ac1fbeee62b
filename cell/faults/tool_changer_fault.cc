// Fault "tool_changer": it has no air, or its lock opens by itself, for a while.
#include <fmt/format.h>

#include "cell/faults/fault_kinds.h"
#include "cell/file/description.h"
#include "core/base/keys_of.h"

namespace takt::cell {
namespace {

class ToolChangerFault final : public Fault {
 public:
  explicit ToolChangerFault(FaultReader& from)
      : changer_(from.device("changer", "tool changer", keys_of(from.built.cell.changers))),
        opens_(from.choice("fault") == "opens") {
    duration = from.duration(kLongestRun);
  }
  void begin(FaultScene& scene) override {
    scene.note("tool_changer",
               fmt::format("{}: {} for {:g} s", changer_, opens_ ? "its lock opens" : "no air", to_seconds(*duration)));
    count(scene, 1);
  }
  void end(FaultScene& scene) override {
    count(scene, -1);
    scene.note("tool_changer", fmt::format("{}: {}", changer_, opens_ ? "its lock works again" : "there is air again"));
  }

 private:
  /// As all faults of this changer together have it.
  void count(FaultScene& scene, int change) const {
    LockFaults& faults = scene.lock_faults[changer_];
    (opens_ ? faults.open : faults.without_air) += change;
    sim::SimToolChanger& machine = *scene.built.world->tool_changer(changer_);
    machine.set_air(faults.without_air == 0);
    machine.set_broken(faults.open > 0);
  }

  std::string changer_;
  bool opens_;  ///< its lock; else its air is gone
};

}  // namespace

FaultKind tool_changer_fault() {
  return fault_kind<ToolChangerFault>(
      "tool_changer", Concerns::kMachine,
      {"A tool changer has no air, or its lock opens by itself.",
       {text_key("changer", "The tool changer.", 1),
        choice_key("fault", {"no_air", "opens"}, "no_air: its lock stays as it is; opens: its lock opens by itself."),
        duration_key("to the end")}});
}

}  // namespace takt::cell
