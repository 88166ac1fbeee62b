// Fault "tool_changer": a tool changer has no air for a while, or its lock is open by itself.
#include <algorithm>

#include <fmt/format.h>

#include "scenario/cell_builder.h"
#include "scenario/fault.h"

namespace takt::scenario {
namespace {

class LockFault final : public Fault {
 public:
  LockFault() { duration = 3600 * kSecond; }

  void add_to(BuiltCell& built, Diagnostics& diagnostics) const override {
    if (built.cell.changers.contains(changer)) return;
    std::vector<std::string> changers;
    for (const auto& [name, one] : built.cell.changers) changers.push_back(name);
    diagnostics.error(Code::kUnknownName, pointer + "/changer", fmt::format("there is no tool changer '{}'", changer),
                      nearest_choice(changer, changers));
  }
  void begin(FaultContext& context) const override {
    note(context,
         fmt::format("{}: {} for {:g} s", changer, opens ? "its lock opens" : "no air", to_seconds(*duration)));
    apply(context);
  }
  void end(FaultContext& context) const override {
    apply(context);
    note(context, fmt::format("{}: {}", changer, opens ? "its lock works again" : "there is air again"));
  }

  std::string changer = {};
  bool opens = false;  ///< the lock opens; else its air is gone

 private:
  /// As all faults of this changer together have it.
  void apply(FaultContext& context) const {
    const auto lasts = [&](bool opening) {
      return std::ranges::any_of(context.active, [&](const Fault* one) {
        const auto* other = dynamic_cast<const LockFault*>(one);
        return other != nullptr && other->changer == changer && other->opens == opening;
      });
    };
    sim::SimToolChanger& machine = *context.built.world->tool_changer(changer);
    machine.set_air(!lasts(false));
    machine.set_broken(lasts(true));
  }
};

const table::Table<LockFault>& lock_table() {
  static const auto table = [] {
    table::Table<LockFault> lock;
    lock.named("changer", table::NameOf::kToolChanger, &LockFault::changer, "The tool changer.")
        .required()
        .choice("fault", &LockFault::opens, table::Words<bool>{{"no_air", false}, {"opens", true}},
                "no_air: its lock stays as it is; opens: its lock opens by itself.")
        .required()
        .value("seconds", table::seconds_type(kFaultDuration), &LockFault::duration, "Duration.")
        .fallback("to the end");
    return lock;
  }();
  return table;
}

}  // namespace

FaultKind tool_changer_fault() {
  return fault_kind<LockFault, lock_table>("tool_changer", "A tool changer has no air, or its lock opens by itself.");
}

}  // namespace takt::scenario
