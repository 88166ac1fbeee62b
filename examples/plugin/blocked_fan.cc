// Fault "blocked_fan": for a while something is between the blades of a fan.
#include <fmt/format.h>

#include "cell/faults/fault_kind.h"
#include "sim_fan.h"

namespace fan {
namespace {

using namespace takt;

class BlockedFan final : public cell::Fault {
 public:
  explicit BlockedFan(cell::FaultReader& from) : fan_(from.text("fan")) {
    duration = from.duration(3600.0);
    if (!fan_.empty() && fan_of(from.built) == nullptr)
      from.diagnostics().error(Code::kUnknownName, from.at("fan"), fmt::format("there is no fan '{}'", fan_),
                               "Name a device of kind \"fan\"");
  }
  void begin(cell::FaultScene& scene) override {
    scene.note("blocked_fan", fan_);
    fan_of(scene.built)->block(true);
  }
  void end(cell::FaultScene& scene) override {
    fan_of(scene.built)->block(false);
    scene.note("blocked_fan", fmt::format("{} turns again", fan_));
  }

 private:
  SimFan* fan_of(cell::BuiltCell& built) const { return dynamic_cast<SimFan*>(built.world->device(fan_)); }

  std::string fan_;
};

cell::FaultKind blocked_fan() {
  return cell::fault_kind<BlockedFan>("blocked_fan", cell::Concerns::kMachine,
                                      {"Something is between the blades of a fan: it stands.",
                                       {text_key("fan", "Which fan.", 1), cell::duration_key("to the end")}});
}

TAKT_FAULT(blocked_fan);

}  // namespace
}  // namespace fan
