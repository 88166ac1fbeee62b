#include "cell/judge/expectations.h"

#include <algorithm>
#include <utility>

#include "cell/file/copies.h"
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
       seam_expectation(),       signal_expectation(),        step_expectation(),        tool_pose_expectation(),
       value_expectation()});
  return kinds;
}

Result<std::vector<std::unique_ptr<Expectation>>> make_expectations(const std::vector<ExpectationEntry>& entries,
                                                                    BuiltCell& built, const StepNames& steps) {
  Diagnostics diagnostics;
  std::vector<std::unique_ptr<Expectation>> expectations;
  for (const ExpectationEntry& entry : entries) {
    ObjectReader object(entry.json, entry.pointer, diagnostics);
    FormReader common(expectation_form(), object);
    (void)common.text("name");
    const auto kind = common.kind();
    if (!kind) continue;
    ExpectationReader from(kind->form, object, built, steps);
    auto expectation = ExpectationKind::registry().find(kind->name)->make(from);
    from.check_rules();
    object.finish();
    expectations.push_back(std::make_unique<Named>(entry, std::move(expectation)));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return expectations;
}

const Form& expectation_form() {
  static const Form form{
      .doc = "A statement about the run.",
      .keys = {text_key("name", "Name in reports.").optional("the kind"),
               object_key("copies", copies_form().form(),
                          "The expectation stands for as many, one step further each; # in its texts is the number of "
                          "the copy.")
                   .optional()},
      .definition = "expectation",
      .kinds = Kinds{choice_key("kind", {}, "What it states."), [] { return ExpectationKind::registry().forms(); }}};
  return form;
}

}  // namespace takt::cell
