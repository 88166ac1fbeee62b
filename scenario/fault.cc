#include "scenario/fault.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace takt::scenario {

/// All kinds of takt: NAME is defined by NAME_fault() in a file of its own (scenario/README.md).
// clang-format off
#define TAKT_FAULTS(add) \
  add(device) \
  add(emergency_stop) \
  add(push) \
  add(release) \
  add(reset) \
  add(sensor) \
  add(stop) \
  add(tool_changer)
// clang-format on

#define TAKT_DECLARE_FAULT(name) FaultKind name##_fault();
TAKT_FAULTS(TAKT_DECLARE_FAULT)

table::Kinds<std::unique_ptr<Fault>>& fault_kinds() {
  static auto kinds = [] {
    table::Kinds<std::unique_ptr<Fault>> all("fault");
#define TAKT_ADD_FAULT(name) all.add(name##_fault());
    TAKT_FAULTS(TAKT_ADD_FAULT)
#undef TAKT_ADD_FAULT
    return all;
  }();
  return kinds;
}

namespace {

std::shared_ptr<const Fault> read_fault(ObjectReader& reader) {
  const double at = reader.number("at_s", {}, kFaultTime);
  const FaultKind* kind = fault_kinds().read("do", reader, kFaultByDefault);
  if (kind == nullptr) return nullptr;
  std::unique_ptr<Fault> fault = kind->read(reader);
  fault->kind = kind->name;
  fault->pointer = reader.pointer();
  fault->at = static_cast<Nanoseconds>(std::llround(1e9 * at));
  return fault;
}

}  // namespace

FaultList read_faults(ObjectReader& reader) {
  FaultList faults;
  table::for_each_element(table::field("faults", table::Field::Type::kList, {}), reader, [&](ObjectReader& entry) {
    if (auto fault = read_fault(entry)) faults.push_back(std::move(fault));
  });
  std::ranges::stable_sort(faults, {}, [](const auto& fault) { return fault->at; });
  return faults;
}

const table::Field& fault_form() {
  static const auto form = [] {
    table::Field whole = table::field({}, table::Field::Type::kObject, {});
    whole.definition = "fault";
    table::Field choice = fault_kinds().choice("do", "What happens.");
    choice.fallback = kFaultByDefault;
    table::Field at = table::field("at_s", table::Field::Type::kNumber, "Simulated time at which it happens.");
    at.unit = "s";
    at.range = kFaultTime;
    at.required = true;
    whole.discriminator = choice.key;
    whole.fields = {std::move(choice), std::move(at)};
    whole.variants = fault_kinds().variants("fault_");
    return whole;
  }();
  return form;
}

}  // namespace takt::scenario
