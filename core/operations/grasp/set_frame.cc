#include "core/operations/grasp/set_frame.h"

#include <fmt/format.h>

#include "core/operations/grasp/held_part.h"
#include "core/operations/table/immediate_run.h"

namespace takt::operations {
namespace {

using world::Relation;

NewFrame new_frame(const SetFrameParameters& parameters) {
  return {
      .as = parameters.as, .in = parameters.in, .of = parameters.of, .X = pose_of(parameters.position, parameters.rpy)};
}

/// An object that is not fixed: the program has found out where it is.
bool is_free_object(const expression::Cell& cell, const std::string& name) {
  const auto object = cell.objects.find(name);
  return object != cell.objects.end() && !object->second.fixed;
}

void check_name(SetFrameParameters& parameters, const ReadContext& from) {
  const bool possible = !parameters.as.empty() && parameters.as.find('/') == std::string::npos;
  if (possible && is_free_frame_name(from.cell, parameters.as)) return;
  if (is_free_object(from.cell, parameters.as)) return;
  from.reader.diagnostics().error(
      Code::kInvalidName, from.reader.at("as"),
      fmt::format("'{}' cannot be the name of a frame that a step makes", parameters.as),
      "Choose a name that the cell does not have yet, without '/', or an object that is not fixed");
}

class SetFrameStep final : public Step {
 public:
  explicit SetFrameStep(SetFrameParameters parameters) : parameters_(std::move(parameters)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    diagnostics.append(set_frame(rehearsal.cell, new_frame(parameters_)), pointer);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>([this](activity::Context& context, Diagnostics& diagnostics) {
      diagnostics.append(set_frame(context.cell, new_frame(parameters_)));
      return !diagnostics.has_errors();
    });
  }

 private:
  SetFrameParameters parameters_;
};

}  // namespace

Eigen::Isometry3d pose_of(const Eigen::Vector3d& position, const Eigen::Vector3d& rpy) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = position;
  X.linear() =
      (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return X;
}

bool is_free_frame_name(const expression::Cell& cell, const std::string& name) {
  const Relation* relation = cell.frames.relation(name);
  const bool made_by_step = relation != nullptr && relation->kind == Relation::Kind::kEstimate;
  return name != world::FrameGraph::kWorld && !cell.objects.contains(name) && (relation == nullptr || made_by_step);
}

Diagnostics set_frame(expression::Cell& cell, const NewFrame& frame) {
  Diagnostics diagnostics;
  const std::string parent = standing_frame(cell, frame.in);
  const std::string from = frame.of.empty() ? parent : standing_frame(cell, frame.of);
  const bool is_object = cell.objects.contains(frame.as);
  const auto X_PF = cell.frames.pose(from, is_object ? std::string(world::FrameGraph::kWorld) : parent);
  if (!X_PF) {
    const bool no_parent = !cell.frames.contains(parent) || frame.of.empty();
    diagnostics.append(X_PF.error(), no_parent ? "/in" : "/of");
    return diagnostics;
  }
  if (is_object) {
    diagnostics.append(cell.found(frame.as, *X_PF * frame.X), "/as");
    return diagnostics;
  }
  diagnostics.append(
      cell.frames.set(frame.as, {.kind = Relation::Kind::kEstimate, .parent = parent, .X_PF = *X_PF * frame.X}), "/as");
  return diagnostics;
}

const ParameterTable<SetFrameParameters>& set_frame_parameters() {
  static const auto table = [] {
    ParameterTable<SetFrameParameters> frame;
    frame
        .text("as", &SetFrameParameters::as,
              "Name of the frame; of an object that is not fixed: it has been found there.")
        .required()
        .text("in", &SetFrameParameters::in,
              "Frame, object or base that it depends on from now on; an object stays on what it stands on.")
        .text("of", &SetFrameParameters::of, "Frame from whose present pose it is counted.")
        .fallback("that of 'in'")
        .vector("position_m", "m", &SetFrameParameters::position, "Position in that frame.")
        .vector("rpy_deg", "deg", &SetFrameParameters::rpy, "Orientation in that frame: roll, pitch, yaw.")
        .rule(check_name);
    return frame;
  }();
  return table;
}

Operation set_frame_operation() {
  return {.name = "set_frame",
          .doc =
              "Makes a frame, on whatever it depends on from then on, moves one that a step has made, or says where an "
              "object has been found.",
          .parameters = rows_of<set_frame_parameters>,
          .read_step = read_step<SetFrameStep, set_frame_parameters>};
}

}  // namespace takt::operations
