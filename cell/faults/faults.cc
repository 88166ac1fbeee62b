#include "cell/faults/faults.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/faults/fault_kinds.h"

namespace takt::cell {
namespace {

constexpr Range kFaultTime{.low = 0.0, .high = kLongestRun};

}  // namespace

KindRegistry<FaultKind>& FaultKind::registry() {
  static KindRegistry<FaultKind> kinds({device_fault(), emergency_stop_fault(), push_fault(), release_fault(),
                                        reset_fault(), sensor_fault(), stop_fault(), tool_changer_fault(),
                                        torch_fault()});
  return kinds;
}

Result<std::vector<ScheduledFault>> make_faults(const std::vector<FaultEntry>& entries, BuiltCell& built) {
  Diagnostics diagnostics;
  std::vector<ScheduledFault> faults;
  for (const FaultEntry& entry : entries) {
    ObjectReader object(entry.json, entry.pointer, diagnostics);
    FormReader common(fault_form(), object);
    (void)common.number("at_s");
    const auto kind = common.kind();
    if (!kind) continue;
    FaultReader from(kind->form, object, built);
    faults.push_back({.at = entry.at, .fault = FaultKind::registry().find(kind->name)->make(from)});
    from.check_rules();
    object.finish();
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return faults;
}

const Form& fault_form() {
  static const Form form{.doc = "A fault, or an action of a person at the cabinet, at a given time.",
                         .keys = {number_key("at_s", "s", kFaultTime, "Simulated time.")},
                         .definition = "fault",
                         .kinds = Kinds{choice_key("do", {}, "Kind of the fault.").by_default(FaultEntry::kDefaultKind),
                                        [] { return FaultKind::registry().forms(); }}};
  return form;
}

Diagnostics check_faults_of_machines(const std::vector<FaultEntry>& entries) {
  Diagnostics diagnostics;
  for (const FaultEntry& entry : entries) {
    const FaultKind* kind = FaultKind::registry().find(entry.kind);
    if (kind == nullptr || kind->of_machine) continue;
    diagnostics.error(Code::kUnsupported, entry.pointer,
                      fmt::format("'{}' is a fault of the process with the core, not of a machine", entry.kind),
                      "Remove it with --set, and leave it to takt run");
  }
  return diagnostics;
}

void Faults::apply(Nanoseconds now) {
  scene_.circuit.begin_cycle();
  for (; next_ < faults_.size() && faults_[next_].at <= now; ++next_) {
    Fault& fault = *faults_[next_].fault;
    fault.begin(scene_);
    if (fault.duration) lasting_.push_back({.fault = &fault, .until = now + *fault.duration});
  }
  std::erase_if(lasting_, [&](const Lasting& one) {
    if (one.until > now) return false;
    one.fault->end(scene_);
    return true;
  });
  scene_.circuit.end_cycle();
}

}  // namespace takt::cell
