// Fault "torch": the arc does not light, or goes out.
#include <fmt/format.h>

#include "cell/faults/fault_kinds.h"
#include "sim/machines/torch.h"

namespace takt::cell {
namespace {

using Torch = sim::SimTorch;

constexpr const char* kNoIgnition = "no_ignition";
constexpr const char* kLost = "lost";

std::vector<std::string> names_of_torches(const BuiltCell& built) {
  std::vector<std::string> names;
  for (const auto& [name, tool] : built.cell.tools)
    if (dynamic_cast<Torch*>(built.world->device(name)) != nullptr) names.push_back(name);
  return names;
}

class TorchFault final : public Fault {
 public:
  explicit TorchFault(FaultReader& from)
      : name_(from.device("torch", "torch", names_of_torches(from.built))), kind_(from.choice("fault")) {
    duration = from.duration(1.0);
    if (!name_.empty()) return;
    const auto names = names_of_torches(from.built);
    if (names.size() == 1) {
      name_ = names.front();
    } else {
      from.diagnostics().error(Code::kMissing, from.at("torch"), fmt::format("one of {} torches", names.size()),
                               "Name a torch of the cell");
    }
  }
  void begin(FaultScene& scene) override {
    scene.note("torch", fmt::format("{}: {} for {:g} s", name_, kind_, to_seconds(*duration)));
    scene.newest_of_device[name_] = this;
    set(scene, kind_ == kLost ? Torch::Fault::kLost : Torch::Fault::kNoIgnition);
  }
  void end(FaultScene& scene) override {
    const auto newest = scene.newest_of_device.find(name_);
    if (newest == scene.newest_of_device.end() || newest->second != this) return;
    scene.newest_of_device.erase(newest);
    set(scene, Torch::Fault::kNone);
    scene.note("torch", fmt::format("{}: as before", name_));
  }

 private:
  void set(FaultScene& scene, Torch::Fault fault) const {
    dynamic_cast<Torch&>(*scene.built.world->device(name_)).set_fault(fault);
  }

  std::string name_, kind_;
};

}  // namespace

FaultKind torch_fault() {
  return fault_kind<TorchFault>(
      "torch", Concerns::kMachine,
      {"An arc does not light, or goes out.",
       {text_key("torch", "Which torch.").optional("the only one"),
        choice_key("fault", {kNoIgnition, kLost},
                   "no_ignition: it does not light (one that burns goes on); lost: it goes out, and does not light."),
        duration_key("1")}});
}

}  // namespace takt::cell
