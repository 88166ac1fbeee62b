#include "core/operations/grasp/attach.h"

#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "core/expression/tool_settings.h"
#include "core/operations/grasp/held_part.h"
#include "core/operations/grasp/set_frame.h"
#include "core/operations/table/immediate_run.h"

namespace takt::operations {
namespace {

std::vector<std::string> tool_names(const expression::Cell& cell) {
  std::vector<std::string> names;
  for (const auto& [name, tool] : cell.tools) names.push_back(name);
  return names;
}

/// The key "tool": where the cell has only one, it need not be named.
template <class P>
ParameterTable<P> table_with_tool() {
  ParameterTable<P> table;
  table.text("tool", &P::tool, "Tool that holds the part: a device with a tool centre point.")
      .fallback("the only one of the cell")
      .rule([](P& parameters, const ReadContext& from) {
        const auto names = tool_names(from.cell);
        if (parameters.tool.empty() && names.size() == 1) parameters.tool = names.front();
        if (from.cell.tools.contains(parameters.tool)) return;
        const bool missing = parameters.tool.empty();
        from.reader.diagnostics().error(
            missing ? Code::kMissing : Code::kUnknownName, missing ? from.reader.pointer() : from.reader.at("tool"),
            missing ? "no tool is named" : fmt::format("there is no tool '{}'", parameters.tool),
            nearest_choice(parameters.tool, names));
      });
  return table;
}

/// Size 0: the tool is coupled to no arm.
kinematics::JointVector joints_at(const expression::Cell& cell, const std::string& tool) {
  const auto found = cell.arms.find(cell.tools.find(tool)->second.arm);
  if (found == cell.arms.end()) return {};
  const expression::MountedArm& arm = found->second;
  return arm.device->has_sample() ? arm.device->sample().q : arm.set_point();
}

Gripping attaching(const AttachParameters& parameters, const kinematics::JointVector& q) {
  return {.gripper = parameters.tool, .part = parameters.part, .grasp = parameters.grasp, .q = q};
}

/// Where the program says that the part is left, in `onto`.
std::optional<Eigen::Isometry3d> pose_left(const DetachParameters& parameters) {
  if (!parameters.position && !parameters.rpy) return std::nullopt;
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return pose_of(parameters.position.value_or(none), parameters.rpy.value_or(none));
}

Gripping detaching(const DetachParameters& parameters, const kinematics::JointVector& q) {
  return {.gripper = parameters.tool, .onto = parameters.onto, .X_left = pose_left(parameters), .q = q};
}

Diagnostics refused(Code code, std::string pointer, std::string message, std::string hint) {
  Diagnostics diagnostics;
  diagnostics.error(code, std::move(pointer), std::move(message), std::move(hint));
  return diagnostics;
}

/// What lies in a dock holds nothing.
Diagnostics check_coupled_tool(const expression::Cell& cell, const std::string& tool) {
  if (cell.arms.contains(cell.tools.find(tool)->second.arm)) return {};
  return refused(Code::kNotPossibleNow, "/tool", fmt::format("'{}' is coupled to no arm", tool),
                 "Put \"couple\" before it");
}

/// @param q  of the arm that carries the tool   @return the object
Result<std::string> attach_at(expression::Cell& cell, const AttachParameters& parameters,
                              const kinematics::JointVector& q) {
  const std::string& tool = parameters.tool;
  if (const Diagnostics away = check_coupled_tool(cell, tool); away.has_errors()) return std::unexpected(away);
  if (const auto held = cell.held.find(tool); held != cell.held.end())
    return std::unexpected(refused(Code::kConflict, "/tool",
                                   fmt::format("'{}' holds '{}' already", tool, held->second.object),
                                   "Put \"detach\" before it"));
  const auto hold = take_part(cell, attaching(parameters, q));
  if (!hold) return std::unexpected(hold.error());
  if (!hold->object.empty()) return hold->object;
  cell.held.erase(tool);
  return std::unexpected(refused(Code::kConditionNotMet, "", fmt::format("no free object is at '{}'", tool),
                                 "Name it with \"part\", or close the fingers within 10 mm of it"));
}

Result<std::string> detach_at(expression::Cell& cell, const DetachParameters& parameters,
                              const kinematics::JointVector& q) {
  if (const Diagnostics away = check_coupled_tool(cell, parameters.tool); away.has_errors())
    return std::unexpected(away);
  const auto left = leave_part(cell, detaching(parameters, q));
  if (!left) return std::unexpected(left.error());
  if (*left) return (*left)->object;
  return std::unexpected(refused(Code::kConditionNotMet, "/tool", fmt::format("'{}' holds nothing", parameters.tool),
                                 "Put \"attach\" before it"));
}

/// A step that changes the belief, and tells arms what they carry then.
template <class P, auto kChange, auto kChangeAt>
class HoldingStep final : public Step {
 public:
  explicit HoldingStep(P parameters) : parameters_(std::move(parameters)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const std::string& arm = rehearsal.cell.tools.find(parameters_.tool)->second.arm;
    const auto object = kChangeAt(rehearsal.cell, parameters_, rehearsal.q[arm]);
    if (!object) return diagnostics.append(object.error(), pointer);
    if constexpr (std::is_same_v<P, AttachParameters>) {
      if (!parameters_.part) rehearsal.one_of_many.insert(*object);
    }
    expression::expect_tool_settings(rehearsal.cell);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>([this](activity::Context& context, Diagnostics& diagnostics) {
      const auto object = kChange(context.cell, parameters_);
      if (!object) diagnostics.append(object.error());
      if (object)
        context.event(parameters_.tool, std::is_same_v<P, AttachParameters> ? "attached" : "detached", *object);
      return object.has_value();
    });
  }

 private:
  P parameters_;
};

using AttachStep = HoldingStep<AttachParameters, attach, attach_at>;
using DetachStep = HoldingStep<DetachParameters, detach, detach_at>;

}  // namespace

Result<std::string> attach(expression::Cell& cell, const AttachParameters& parameters) {
  auto object = attach_at(cell, parameters, joints_at(cell, parameters.tool));
  expression::tell_tool_settings(cell);
  return object;
}

Result<std::string> detach(expression::Cell& cell, const DetachParameters& parameters) {
  auto object = detach_at(cell, parameters, joints_at(cell, parameters.tool));
  expression::tell_tool_settings(cell);
  return object;
}

const ParameterTable<AttachParameters>& attach_parameters() {
  static const auto table = [] {
    auto attach = table_with_tool<AttachParameters>();
    attach
        .name("part", NameOf::kObject, &AttachParameters::part,
              "Object that the tool holds: the free object at its tool centre point.")
        .text("grasp", &AttachParameters::grasp,
              "Grasp of the object that is at the tool centre point: it is held as it is believed to be.");
    return attach;
  }();
  return table;
}

const ParameterTable<DetachParameters>& detach_parameters() {
  static const auto table = [] {
    auto detach = table_with_tool<DetachParameters>();
    detach
        .text("onto", &DetachParameters::onto,
              "What the part stands on then: a frame, an object, a base; found by shapes.")
        .vector("position_m", "m", &DetachParameters::position,
                "Where the part is then, in 'onto': where the tool has it.")
        .vector("rpy_deg", "deg", &DetachParameters::rpy, "Its orientation then, in 'onto': roll, pitch, yaw.")
        .rule([](DetachParameters& parameters, const ReadContext& from) {
          if (parameters.onto || !(parameters.position || parameters.rpy)) return;
          from.reader.diagnostics().error(Code::kMissing, from.reader.pointer(), "a pose without 'onto'",
                                          "Add \"onto\": the frame that it is in");
        });
    return detach;
  }();
  return table;
}

Operation attach_operation() {
  return {.name = "attach",
          .doc = "Notes that a tool without fingers holds an object: a magnet, a suction cup.",
          .parameters = rows_of<attach_parameters>,
          .read_step = read_step<AttachStep, attach_parameters>};
}

Operation detach_operation() {
  return {.name = "detach",
          .doc = "Notes that a tool without fingers does not hold its object any more.",
          .parameters = rows_of<detach_parameters>,
          .read_step = read_step<DetachStep, detach_parameters>};
}

}  // namespace takt::operations
