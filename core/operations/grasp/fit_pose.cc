#include "core/operations/grasp/fit_pose.h"
#include "core/base/keys_of.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/read_parts.h"
#include "core/operations/grasp/set_frame.h"
#include "core/operations/table/immediate_run.h"

namespace takt::operations {
namespace {

/// The fit of an object may replace what the file says of this object, and of nothing else.
void check_estimate(FitPoseParameters& parameters, const ReadContext& from) {
  if (parameters.as == parameters.object || is_free_frame_name(from.cell, parameters.as)) return;
  from.reader.diagnostics().error(Code::kInvalidName, from.reader.at("as"),
                                  fmt::format("'{}' cannot be the name of an estimate", parameters.as),
                                  fmt::format("Choose a new name, or '{}'", parameters.object));
}

const std::vector<std::string>& coordinate_names() {
  static const std::vector<std::string> names{"x", "y", "z", "roll", "pitch", "yaw"};
  return names;
}

void read_coordinates(const ParameterInfo& row, const ReadContext& from, FitPoseParameters& parameters) {
  const auto free = from.reader.texts(row.key);
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto found = std::ranges::find(coordinate_names(), free[i]);
    if (found == coordinate_names().end()) {
      from.reader.diagnostics().error(Code::kUnknownName, from.reader.at(row.key) + pointer_segment(i),
                                      fmt::format("unknown coordinate '{}'", free[i]),
                                      nearest_choice(free[i], coordinate_names()));
    } else {
      parameters.free.push_back(static_cast<world::Coordinate>(found - coordinate_names().begin()));
    }
  }
}

void write_coordinates(const ParameterInfo& row, const FitPoseParameters& parameters, ParameterWriter& to) {
  std::vector<std::string> names;
  for (const world::Coordinate one : parameters.free)
    names.push_back(coordinate_names().at(static_cast<std::size_t>(one)));
  to.texts(row.key, names);
}

class FitPoseStep final : public Step {
 public:
  explicit FitPoseStep(FitPoseParameters parameters) : parameters_(std::move(parameters)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    for (std::size_t i = 0; i < parameters_.contacts.size(); ++i) {
      const std::string& name = parameters_.contacts[i];
      if (rehearsal.contacts.contains(name)) continue;
      diagnostics.error(Code::kUnknownName, pointer + "/contacts" + pointer_segment(i),
                        fmt::format("no contact '{}' is recorded before this", name),
                        nearest_choice(name, keys_of(rehearsal.contacts)));
    }
    if (parameters_.contacts.size() < parameters_.free.size()) {
      diagnostics.error(
          Code::kWrongSize, pointer + "/contacts",
          fmt::format("{} contacts for {} free coordinates", parameters_.contacts.size(), parameters_.free.size()),
          "Use at least one contact a coordinate");
    }
    const auto X_WO = rehearsal.cell.frames.pose(parameters_.object);
    if (!X_WO) return diagnostics.append(X_WO.error(), pointer + "/object");
    diagnostics.append(note_pose(rehearsal.cell, *X_WO), pointer);
    rehearsal.estimates.insert(parameters_.as);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    return std::make_unique<ImmediateRun>(
        [this](activity::Context& context, Diagnostics& diagnostics) { return fit(context, diagnostics); });
  }

 private:
  /// The object is believed to be there from now on. The estimate stands where the object does, and stays when that is
  /// taken away.
  [[nodiscard]] Diagnostics note_pose(expression::Cell& cell, const Eigen::Isometry3d& X_WO) const {
    Diagnostics diagnostics;
    diagnostics.append(cell.found(parameters_.object, X_WO), "/object");
    if (parameters_.as == parameters_.object || diagnostics.has_errors()) return diagnostics;
    const std::string parent = cell.standing_on(parameters_.object);
    const auto X_PO = cell.frames.pose(parameters_.object, parent);
    if (!X_PO) return X_PO.error();
    diagnostics.append(
        cell.frames.set(parameters_.as, {.kind = world::Relation::Kind::kEstimate, .parent = parent, .X_PF = *X_PO}),
        "/as");
    return diagnostics;
  }
  /// The fit is done in the axes of the object's nominal frame, so that "x" in the file is the object's own x.
  bool fit(activity::Context& context, Diagnostics& diagnostics) const {
    const auto nominal = context.cell.frames.pose(parameters_.object);
    if (!nominal) {
      diagnostics.append(nominal.error(), "/object");
      return false;
    }
    const Eigen::Isometry3d& X_WN = *nominal;
    std::vector<world::Contact> contacts;
    for (const std::string& name : parameters_.contacts) {
      const auto found = context.variables.contacts.find(name);
      if (found == context.variables.contacts.end()) {
        diagnostics.error(Code::kNoContact, "/contacts", fmt::format("contact '{}' was not recorded", name),
                          nearest_choice(name, keys_of(context.variables.contacts)));
        continue;
      }
      contacts.push_back(found->second);
      contacts.back().p_R = X_WN.inverse() * found->second.p_R;
    }
    if (diagnostics.has_errors()) return false;
    const world::Object& object = context.cell.objects.find(parameters_.object)->second;
    const auto fit =
        world::fit_pose(object, contacts, Eigen::Isometry3d::Identity(), parameters_.free, parameters_.max_residual);
    if (!fit) {
      diagnostics.append(fit.error());
      return false;
    }
    const Eigen::Isometry3d X_WO = X_WN * fit->X_RO;
    context.variables.estimates[parameters_.as] = X_WO;
    context.variables.residuals[parameters_.as] = fit->rms_residual;
    diagnostics.append(note_pose(context.cell, X_WO));
    const Eigen::Vector3d step = fit->X_RO.translation() * 1e3;
    context.event(
        "program", "estimate",
        fmt::format("{}: ({:+.3f}, {:+.3f}, {:+.3f}) mm off nominal", parameters_.as, step.x(), step.y(), step.z()));
    return !diagnostics.has_errors();
  }

  FitPoseParameters parameters_;
};

}  // namespace

const ParameterTable<FitPoseParameters>& fit_pose_parameters() {
  static const auto table = [] {
    ParameterInfo free{.key = "free", .type = ParameterInfo::Type::kTexts, .required = true};
    free.doc = "Coordinates that are fitted: x, y, z, roll, pitch, yaw of the object.";
    ParameterTable<FitPoseParameters> fit;
    fit.name("object", NameOf::kObject, &FitPoseParameters::object, "Object that was touched.")
        .required()
        .text("as", &FitPoseParameters::as, "Name of the frame that gets the fitted pose.")
        .required()
        .texts("contacts", &FitPoseParameters::contacts, "Names of recorded contacts.")
        .object(std::move(free), read_coordinates, write_coordinates)
        .number("max_residual_m", "m", &FitPoseParameters::max_residual, kPositive,
                "Largest residual (rms) of a good fit.")
        .rule(check_estimate);
    return fit;
  }();
  return table;
}

Operation fit_pose_operation() {
  return {.name = "fit_pose",
          .doc = "Finds the pose of an object from recorded contacts.",
          .parameters = rows_of<fit_pose_parameters>,
          .read_step = read_step<FitPoseStep, fit_pose_parameters>};
}

}  // namespace takt::operations
