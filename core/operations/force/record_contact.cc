#include "core/operations/force/record_contact.h"

#include <fmt/format.h>

#include "core/operations/table/immediate_run.h"

namespace takt::operations {
namespace {

class RecordContactStep final : public Step {
 public:
  explicit RecordContactStep(const RecordContactParameters& record) : arm_(record.arm), name_(record.as) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    if (!rehearsal.touched[arm_]) {
      diagnostics.error(Code::kRequires, pointer,
                        fmt::format("the last motion of '{}' was not guarded, so there is no contact", arm_),
                        "Put a motion with \"until\" directly before it");
    }
    if (rehearsal.contacts.contains(name_)) {
      diagnostics.warning(Code::kDuplicate, pointer + "/as",
                          fmt::format("contact '{}' is recorded again; the later one counts", name_));
    }
    rehearsal.contacts[name_] = arm_;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>([this](activity::Context& context, Diagnostics& diagnostics) {
      const auto touch = context.variables.touches.find(arm_);
      if (touch == context.variables.touches.end()) {
        diagnostics.error(Code::kNoContact, {}, fmt::format("the last motion of '{}' ended without a contact", arm_),
                          "Ask known(touch('...')) before");
        return false;
      }
      context.variables.contacts[name_] = {name_, touch->second.p_W, touch->second.radius};
      return true;
    });
  }

 private:
  std::string arm_, name_;
};

}  // namespace

const ParameterTable<RecordContactParameters>& record_contact_parameters() {
  static const auto table = [] {
    ParameterTable<RecordContactParameters> record;
    record.name("arm", NameOf::kArm, &RecordContactParameters::arm, "Arm whose last motion ended with the contact.")
        .text("as", &RecordContactParameters::as, "Name under which the contact is kept.")
        .required();
    return record;
  }();
  return table;
}

Operation record_contact_operation() {
  return {.name = "record_contact",
          .doc = "Keeps the contact that the last guarded motion ended with.",
          .parameters = rows_of<record_contact_parameters>,
          .read_step = read_step<RecordContactStep, record_contact_parameters>};
}

}  // namespace takt::operations
