#include "cell/judge/expectations.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "cell/judge/expectation_kinds.h"

namespace takt::cell {
namespace {

/// Gives the entry's name to what its expectation finds.
class Named final : public Expectation {
 public:
  Named(const ExpectationEntry& entry, std::unique_ptr<Expectation> expectation)
      : name_(entry.name), kind_(entry.kind), expectation_(std::move(expectation)) {}
  void begin(const activity::Variables& variables) override { expectation_->begin(variables); }
  void watch(const BuiltCell& built) override { expectation_->watch(built); }
  void step_begins(std::string_view name) override { expectation_->step_begins(name); }
  void steps_run(std::span<const std::string> paths) override { expectation_->steps_run(paths); }
  void happened(const LogEntry& entry) override { expectation_->happened(entry); }
  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result = expectation_->judge(outcome);
    result.name = name_;
    result.kind = kind_;
    return result;
  }

 private:
  std::string name_, kind_;
  std::unique_ptr<Expectation> expectation_;
};

}  // namespace

KindRegistry<ExpectationKind>& ExpectationKind::registry() {
  static KindRegistry<ExpectationKind> kinds(
      {belief_expectation(),     contact_force_expectation(), contacts_expectation(),    duration_expectation(),
       estimate_expectation(),   event_expectation(),         gripper_expectation(),     limits_expectation(),
       mean_force_expectation(), monitor_expectation(),       object_pose_expectation(), order_expectation(),
       peak_force_expectation(), relative_pose_expectation(), repeats_expectation(),     screw_expectation(),
       signal_expectation(),     step_expectation(),          tool_pose_expectation(),   value_expectation()});
  return kinds;
}

Result<std::vector<std::unique_ptr<Expectation>>> make_expectations(const std::vector<ExpectationEntry>& entries,
                                                                    BuiltCell& built, const StepNames& steps) {
  const auto& kinds = ExpectationKind::registry();
  Diagnostics diagnostics;
  std::vector<std::unique_ptr<Expectation>> expectations;
  for (const ExpectationEntry& entry : entries) {
    ObjectReader object(entry.json, entry.pointer, diagnostics);
    (void)object.text("name", "");
    (void)object.choice("kind", kinds.names());
    const ExpectationKind* kind = kinds.find(entry.kind);
    if (kind == nullptr) continue;
    ExpectationReader from(kind->form, object, built, steps);
    auto expectation = kind->make(from);
    from.check_rules();
    object.finish();
    expectations.push_back(std::make_unique<Named>(entry, std::move(expectation)));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return expectations;
}

nlohmann::ordered_json expectation_schema() {
  using Json = nlohmann::ordered_json;
  const auto& kinds = ExpectationKind::registry();
  return {{"type", "object"},
          {"required", Json::array({"kind"})},
          {"properties",
           {{"kind", {{"enum", kinds.names()}}},
            {"name", {{"type", "string"}, {"description", "Name in reports; default: the kind."}}},
            {"copies",
             {{"description",
               "The expectation stands for as many, one step further each; # in its texts is the number of the copy."},
              {"allOf", Json::array({{{"$ref", "#/definitions/copies"}}})}}}}},
          {"allOf", schema_of_kinds(kinds.forms(), "kind", {}, {"kind", "name", "copies"})}};
}

}  // namespace takt::cell
