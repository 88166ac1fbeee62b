#include "core/operations/table/compliance.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/device/arm.h"
#include "core/kinematics/chain.h"
#include "core/operations/table/step.h"

namespace takt::operations {
namespace {

using device::ControlMode;
using kinematics::JointVector;

/// A key of the file, and what the command layer calls the same.
struct Key {
  const char *ours, *theirs;
  int count;      ///< numbers; 0: as many as the arm has joints
  int first = 0;  ///< of them in what the command layer has
};

constexpr Key kJointKeys[] = {
    {"stiffness_Nm_rad", "stiffness", 0}, {"damping_ratio", "damping_ratio", 0}, {"torque_Nm", "torque", 0}};
constexpr Key kCartesianKeys[] = {
    {"stiffness_N_m", "stiffness", 3},     {"rotational_stiffness_Nm_rad", "rotational_stiffness", 3},
    {"damping_ratio", "damping_ratio", 1}, {"force_N", "wrench", 3},
    {"torque_Nm", "wrench", 3, 3},         {"nullspace_stiffness_Nm_rad", "nullspace_stiffness", 1}};

std::span<const Key> keys_in(ControlMode mode) {
  switch (mode) {
    case ControlMode::kJointImpedance:
      return kJointKeys;
    case ControlMode::kCartesianImpedance:
      return kCartesianKeys;
    default:
      return {};
  }
}

/// One number, or one for each joint or axis. Of a force or torque each has its own.
std::vector<double> read_values(ObjectReader& reader, const Key& key) {
  const nlohmann::ordered_json& json = *reader.child(key.ours);
  const bool one_for_all = std::string_view(key.theirs) != "wrench" && std::string_view(key.theirs) != "torque";
  if (key.count == 1 || (json.is_number() && one_for_all)) return {reader.number(key.ours)};
  return reader.numbers(key.ours, static_cast<std::size_t>(key.count));
}

/// Reads values as the command layer wants them.
class Values {
 public:
  explicit Values(const ComplianceParameters& request) : values_(request.values) {}

  [[nodiscard]] std::optional<JointVector> joint_values(const char* key, int count) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return std::nullopt;
    const std::vector<double>& numbers = found->second;
    if (numbers.size() == 1) return JointVector(JointVector::Constant(count, numbers.front()));
    return JointVector(JointVector::Map(numbers.data(), std::ssize(numbers)));
  }
  [[nodiscard]] std::optional<expression::Term<net::JointArray>> joints(const char* key, int count) const {
    const auto values = joint_values(key, count);
    return values ? std::optional<expression::Term<net::JointArray>>(net::JointArray(*values)) : std::nullopt;
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> axes(const char* key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return std::nullopt;
    const std::vector<double>& numbers = found->second;
    if (numbers.size() == 3) return Eigen::Vector3d(Eigen::Vector3d::Map(numbers.data()));
    return Eigen::Vector3d(Eigen::Vector3d::Constant(numbers.empty() ? 0.0 : numbers.front()));
  }
  [[nodiscard]] std::optional<double> number(const char* key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::nullopt : std::optional(found->second.front());
  }

 private:
  const std::map<std::string, std::vector<double>, std::less<>>& values_;
};

template <class T, class U>
void put(std::optional<T>& into, const std::optional<U>& value) {
  if (value) into.emplace(*value);
}

command::JointCompliance joint_compliance(const Values& values, int joint_count) {
  return {.stiffness = values.joints("stiffness_Nm_rad", joint_count),
          .damping_ratio = values.joints("damping_ratio", joint_count),
          .torque = values.joints("torque_Nm", joint_count)};
}

command::CartesianCompliance cartesian_compliance(const Values& values, bool in_tool_axes) {
  command::CartesianCompliance compliance{.in_tool_axes = in_tool_axes};
  put(compliance.stiffness, values.axes("stiffness_N_m"));
  put(compliance.rotational_stiffness, values.axes("rotational_stiffness_Nm_rad"));
  put(compliance.damping_ratio, values.number("damping_ratio"));
  put(compliance.nullspace_stiffness, values.number("nullspace_stiffness_Nm_rad"));
  const auto force = values.axes("force_N"), torque = values.axes("torque_Nm");
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  if (force || torque)
    compliance.wrench.emplace(net::Wrench{.force = force.value_or(none), .torque = torque.value_or(none)});
  return compliance;
}

/// What the command layer has found, at the keys of the file.
Diagnostics in_file(const Diagnostics& found, const ComplianceParameters& request) {
  Diagnostics placed;
  const auto places = places_of(request);
  for (Diagnostic diagnostic : found.list()) {
    const auto place = std::ranges::find_if(places, [&](const auto& one) {
      return diagnostic.pointer == one.first || diagnostic.pointer.starts_with(one.first + "/");
    });
    if (place != places.end()) diagnostic.pointer.replace(0, place->first.size(), place->second);
    placed.add(std::move(diagnostic));
  }
  return placed;
}

}  // namespace

const ParameterInfo& compliance_parameter() {
  static const ParameterInfo parameter = [] {
    const auto field = [](std::string key, std::string unit, std::string doc) {
      return ParameterInfo{
          .key = std::move(key), .type = ParameterInfo::Type::kNumbers, .unit = std::move(unit), .doc = std::move(doc)};
    };
    ParameterInfo whole{.key = "compliance", .type = ParameterInfo::Type::kObject, .definition = "compliance"};
    whole.doc = "How the arm yields to forces meanwhile; the arm has to be in that control mode.";
    ParameterInfo mode{.key = "mode", .type = ParameterInfo::Type::kChoice, .required = true};
    for (const ControlMode one : device::all_control_modes()) mode.choices.emplace_back(name_of(one));
    mode.doc = "Control mode whose stiffness is set.";
    whole.fields = {
        std::move(mode),
        {.key = "axes",
         .type = ParameterInfo::Type::kChoice,
         .choices = {"base", "tool"},
         .fallback = "base",
         .doc = "Axes of Cartesian stiffness, force and torque."},
        field("stiffness_Nm_rad", "Nm/rad", "Joint stiffness: one number for all joints, or one for each."),
        field("torque_Nm", "Nm", "Torque added to the springs: of each joint, or about each axis."),
        field("stiffness_N_m", "N/m", "Cartesian stiffness along x, y, z."),
        field("rotational_stiffness_Nm_rad", "Nm/rad", "Cartesian stiffness about x, y, z."),
        field("damping_ratio", "", "Share of critical damping."),
        field("force_N", "N", "Force that the tool exerts beside the springs."),
        field("nullspace_stiffness_Nm_rad", "Nm/rad", "Stiffness of the posture where the tool does not move.")};
    return whole;
  }();
  return parameter;
}

std::optional<ComplianceParameters> read_compliance(ObjectReader& step) {
  const nlohmann::ordered_json* json = step.object("compliance", false);
  if (json == nullptr) return std::nullopt;
  ObjectReader reader(*json, step.at("compliance"), step.diagnostics());
  std::vector<std::string> modes;
  for (const ControlMode mode : device::all_control_modes()) modes.emplace_back(name_of(mode));
  const auto mode = device::control_mode_of(reader.choice("mode", modes));
  if (!mode) return std::nullopt;  // which keys belong to it is unknown
  ComplianceParameters request;
  request.mode = *mode;
  for (const Key& key : keys_in(request.mode))
    if (reader.child(key.ours) != nullptr) request.values[key.ours] = read_values(reader, key);
  if (request.mode == ControlMode::kCartesianImpedance)
    request.in_tool_axes = reader.choice("axes", {"base", "tool"}, "base") == "tool";
  reader.finish();
  return request;
}

command::SpringParameters compliance_of(const ComplianceParameters& request, int joint_count) {
  if (request.of_program) return *request.of_program;
  const Values values(request);
  if (request.mode == ControlMode::kJointImpedance) return joint_compliance(values, joint_count);
  if (request.mode == ControlMode::kCartesianImpedance) return cartesian_compliance(values, request.in_tool_axes);
  return command::Stiff{};
}

void check_springs_of_two(const ComplianceParameters& request, const std::string& pointer, Diagnostics& diagnostics) {
  for (const char* key : {"force_N", "torque_Nm"}) {
    if (request.values.contains(key))
      diagnostics.error(Code::kConflict, pointer + "/compliance/" + key,
                        "two arms that move as one have stiffness only, no force",
                        "Give a stiffness only, or move one arm");
  }
}

namespace {

void collect_numbers(const nlohmann::ordered_json& constant, std::vector<double>& numbers) {
  if (constant.is_number()) numbers.push_back(constant.get<double>());
  if (!constant.is_structured()) return;
  for (const auto& part : constant) collect_numbers(part, numbers);
}

/// The constants among what a program has given, by the keys of files. What is a formula is not known before.
std::map<std::string, std::vector<double>, std::less<>> constants_of(const command::SpringParameters& springs) {
  std::map<std::string, std::vector<double>, std::less<>> values;
  const auto put = [&values](const char* key, const auto& term) {
    if (term && !term->operand().node) collect_numbers(term->operand().constant, values[key]);
  };
  if (const auto* joints = std::get_if<command::JointCompliance>(&springs)) {
    put("stiffness_Nm_rad", joints->stiffness);
    put("torque_Nm", joints->torque);
  }
  if (const auto* tool = std::get_if<command::CartesianCompliance>(&springs)) {
    put("stiffness_N_m", tool->stiffness);
    put("rotational_stiffness_Nm_rad", tool->rotational_stiffness);
    put("force_N", tool->wrench);  // and torque: six numbers
    if (const auto wrench = values.find("force_N"); wrench != values.end() && wrench->second.size() == 6) {
      values["torque_Nm"] = {wrench->second.begin() + 3, wrench->second.end()};
      wrench->second.resize(3);
    }
  }
  return values;
}

/// The same in the form that files have.
ComplianceParameters in_numbers(const ComplianceParameters& request) {
  ComplianceParameters numbers = request;
  numbers.values = constants_of(*request.of_program);
  const auto* tool = std::get_if<command::CartesianCompliance>(&*request.of_program);
  numbers.in_tool_axes = tool != nullptr && tool->in_tool_axes;
  numbers.of_program.reset();
  return numbers;
}

}  // namespace

device::Compliance springs_of(const ComplianceParameters& request, const device::ArmDescription& arm) {
  if (request.of_program) return springs_of(in_numbers(request), arm);
  if (request.mode == ControlMode::kPosition || !arm.modes.has(request.mode)) return {};
  device::Compliance springs = arm.impedance.standard(request.mode);
  springs.in_tool_axes = request.in_tool_axes;
  const Values values(request);
  if (request.mode == ControlMode::kJointImpedance) {
    const int count = arm.chain->joint_count();
    const auto put_joints = [&](const char* key, JointVector& into) {
      const auto joints = values.joint_values(key, count);
      if (joints && joints->size() == count) into = *joints;
    };
    put_joints("stiffness_Nm_rad", springs.stiffness);
    put_joints("torque_Nm", springs.feed_forward);
    return springs;
  }
  const auto put_axes = [&values](const char* key, JointVector& into, Eigen::Index from) {
    if (const auto axes = values.axes(key)) into.segment(from, 3) = *axes;
  };
  put_axes("stiffness_N_m", springs.stiffness, 0);
  put_axes("rotational_stiffness_Nm_rad", springs.stiffness, 3);
  put_axes("force_N", springs.feed_forward, 0);
  put_axes("torque_Nm", springs.feed_forward, 3);
  return springs;
}

Diagnostics check_compliance(const ComplianceParameters& request, const expression::Cell& cell,
                             const std::vector<std::string>& arms) {
  Diagnostics found;
  const device::ArmDescription* first = nullptr;
  for (const std::string& name : arms) {
    const device::Arm* arm = cell.arms.find(name)->second.device;
    if (arm == nullptr) return found;
    const int joint_count = arm->description().chain->joint_count();
    if (first == nullptr) first = &arm->description();
    if (request.mode == ControlMode::kJointImpedance && joint_count != first->chain->joint_count())
      found.error(Code::kConflict, "/compliance/mode",
                  fmt::format("joint stiffness of '{}' and '{}'", arms.front(), name),
                  "Name arms with as many joints each, or give a tool stiffness");
    found.append(
        in_file(command::check_compliance(compliance_of(request, joint_count), arm->description(), name), request));
  }
  return found;
}

void rehearse_mode(Rehearsal& rehearsal, const std::string& name, ControlMode needed, const std::string& pointer,
                   Diagnostics& diagnostics) {
  const device::Arm* arm = rehearsal.cell.arms.find(name)->second.device;
  if (arm == nullptr) return;  // only names are known
  const auto is = rehearsal.modes.find(name);
  const Diagnostics refused =
      activity::check_needed_mode(*arm, is != rehearsal.modes.end() ? std::optional(is->second) : std::nullopt, needed);
  diagnostics.append(refused, pointer + "/compliance");
  if (!refused.has_errors()) rehearsal.modes[name] = needed;
}

bool rehearse_compliance(const ComplianceParameters& request, Rehearsal& rehearsal,
                         const std::vector<std::string>& arms, const std::string& pointer, Diagnostics& diagnostics) {
  Diagnostics own;
  for (const std::string& arm : arms) rehearse_mode(rehearsal, arm, request.mode, pointer, own);
  own.append(check_compliance(request, rehearsal.cell, arms), pointer);
  diagnostics.append(own);
  return !own.has_errors();
}

std::vector<std::pair<std::string, std::string>> places_of(const ComplianceParameters& request) {
  std::vector<std::pair<std::string, std::string>> places;
  for (const Key& key : keys_in(request.mode)) {
    const std::string theirs = std::string("/compliance/") + key.theirs, ours = std::string("/compliance/") + key.ours;
    const bool is_part = std::string_view(key.theirs) == "wrench";
    for (int i = 0; is_part && i < key.count; ++i)
      places.emplace_back(fmt::format("{}/{}", theirs, key.first + i), fmt::format("{}/{}", ours, i));
    if (!is_part) places.emplace_back(theirs, ours);
  }
  return places;
}

}  // namespace takt::operations
