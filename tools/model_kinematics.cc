#include "tools/model_kinematics.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/kinematics/arm_angle.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/closed_form.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

Json matrix(const Eigen::Isometry3d& X) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return rows;
}

Json joint_numbers(const JointVector& q) { return std::vector<double>(q.data(), q.data() + q.size()); }

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// All that is said of one posture.
struct PostureReport {
  kinematics::Posture posture;
  kinematics::Singularity singularity;
  kinematics::LimitMargin margin;
  std::optional<double> arm_angle;
};

PostureReport report_of(const kinematics::Chain& chain, const JointVector& q) {
  const auto arm = kinematics::ArmAngle::recognise(chain);
  return {kinematics::posture(chain, q), kinematics::singularity(chain, q), kinematics::limit_margin(chain, q),
          arm ? arm->of(q) : std::nullopt};
}

Json posture_json(const PostureReport& report, const kinematics::Chain& chain) {
  const auto& [posture, singularity, margin, arm_angle] = report;
  Json json = {{"branch", posture.name()}};
  if (!posture.shoulder.empty()) {
    json["shoulder"] = posture.shoulder;
    json["elbow"] = posture.elbow;
    json["wrist"] = posture.wrist;
  }
  if (arm_angle) json["arm_angle"] = *arm_angle;
  json["singularity"] = {{"measure", singularity.measure},     {"manipulability", singularity.manipulability},
                         {"condition", singularity.condition}, {"nearest", singularity.nearest},
                         {"distance", singularity.distance},   {"singular", singularity.singular}};
  json["limit_margin"] = {{"distance", number_or_null(margin.distance)}};
  if (margin.joint >= 0) {
    json["limit_margin"]["joint"] = chain.joint_names()[static_cast<std::size_t>(margin.joint)];
  }
  return json;
}

std::string limit_text(const PostureReport& report, const kinematics::Chain& chain) {
  const auto& margin = report.margin;
  if (margin.joint < 0) return "no limits";
  const bool slides = chain.is_prismatic(margin.joint);
  return fmt::format("{}{:.{}f} {} ({})", margin.distance < 0.0 ? "OUTSIDE by " : "",
                     slides ? std::abs(margin.distance) : std::abs(margin.distance) * kDegreesPerRadian, slides ? 4 : 1,
                     slides ? "m" : "deg", chain.joint_names()[static_cast<std::size_t>(margin.joint)]);
}

std::string singularity_text(const PostureReport& report) {
  const auto& s = report.singularity;
  return s.singular ? fmt::format("SINGULAR ({})", s.nearest) : fmt::format("{:.4f} ({})", s.measure, s.nearest);
}

/// One joint position as people read it.
double shown(const kinematics::Chain& chain, int i, double value) {
  return chain.is_prismatic(i) ? value : value * kDegreesPerRadian;
}

void print_text(const PostureReport& report, const kinematics::Chain& chain, const Eigen::Isometry3d& X_BF,
                double mass) {
  const Eigen::Quaterniond r(X_BF.linear());
  const Eigen::Vector3d p = X_BF.translation();
  fmt::print("flange in base    ({:.6f}, {:.6f}, {:.6f}) m\n", p.x(), p.y(), p.z());
  fmt::print("  quaternion      ({:.6f}, {:.6f}, {:.6f}, {:.6f}), w first\n", r.w(), r.x(), r.y(), r.z());
  const std::string name = report.posture.name();
  fmt::print("branch            {}\n", name.empty() ? "no name for this geometry" : name);
  if (report.arm_angle) fmt::print("arm angle         {:.4f} deg\n", *report.arm_angle * kDegreesPerRadian);
  fmt::print("singularity       {}; manipulability {:.4g}, condition {:.4f}\n", singularity_text(report),
             report.singularity.manipulability, report.singularity.condition);
  fmt::print("nearest limit     {}\n", limit_text(report, chain));
  fmt::print("mass              {:.3f} kg\n", mass);
}

/// @return the pose, or what is wrong with the numbers.
Result<Eigen::Isometry3d> pose_of(const std::vector<double>& values) {
  if (values.size() != 7) {
    return failure(Code::kWrongSize, "--ik", fmt::format("{} numbers", values.size()),
                   "Give x, y, z in m, then the quaternion w, x, y, z");
  }
  const Eigen::Quaterniond r(values[3], values[4], values[5], values[6]);
  bool finite = true;
  for (const double value : values) finite = finite && std::isfinite(value);
  if (!finite || std::abs(r.norm() - 1.0) > 1e-3) {
    return failure(Code::kOutOfRange, "--ik", "the pose is not finite or its quaternion has no unit norm",
                   "Give x, y, z, qw, qx, qy, qz");
  }
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.translation() << values[0], values[1], values[2];
  X_BF.linear() = r.normalized().toRotationMatrix();
  return X_BF;
}

Diagnostics check_redundancy(const kinematics::Chain& chain, const InverseQuestion& question) {
  Diagnostics diagnostics;
  if (question.arm_angle && !kinematics::ArmAngle::recognise(chain)) {
    diagnostics.error(Code::kInvalidValue, "--arm-angle", "this arm has no arm angle",
                      "Name an arm with spherical shoulder, elbow, spherical wrist");
  }
  if (question.held && chain.joint_count() != 7) {
    diagnostics.error(Code::kInvalidValue, "--held",
                      fmt::format("an arm with {} joints has none to hold", chain.joint_count()),
                      "Name an arm with seven joints");
  }
  if (question.held && question.arm_angle) {
    diagnostics.error(Code::kConflict, "--held", "the redundancy is given twice", "Give --held or --arm-angle");
  }
  for (const auto& value : {question.arm_angle, question.held}) {
    if (value && !std::isfinite(*value))
      diagnostics.error(Code::kOutOfRange, "--ik", "a value is not finite", "Give a finite number, rad");
  }
  return diagnostics;
}

void print_table(const kinematics::Chain& chain, const std::vector<JointVector>& solutions) {
  fmt::print("{} solutions, the nearest to home first (deg)\n", solutions.size());
  for (const std::string& name : chain.joint_names()) fmt::print(" {:>13}", name);
  fmt::print("  {:<22} {:<28} {}\n", "branch", "singularity (nearest)", "nearest limit");
  for (const JointVector& q : solutions) {
    for (int i = 0; i < q.size(); ++i) fmt::print(" {:13.4f}", shown(chain, i, q[i]));
    const PostureReport report = report_of(chain, q);
    fmt::print("  {:<22} {:<28} {}\n", report.posture.name(), singularity_text(report), limit_text(report, chain));
  }
}

}  // namespace

int print_forward(const device::ArmDescription& arm, const std::vector<double>& values, const Common& common) {
  const kinematics::Chain& chain = *arm.chain;
  Diagnostics diagnostics;
  if (static_cast<int>(values.size()) != chain.joint_count()) {
    diagnostics.error(Code::kWrongSize, "--fk",
                      fmt::format("{} numbers for {} joints", values.size(), chain.joint_count()),
                      "Give one per joint, rad");
    return report(diagnostics, common);
  }
  JointVector q(chain.joint_count());
  std::copy(values.begin(), values.end(), q.begin());
  if (!q.allFinite()) {
    diagnostics.error(Code::kOutOfRange, "--fk", "a number is not finite", "Give finite joint positions, rad");
    return report(diagnostics, common);
  }
  const Eigen::Isometry3d X_BF = chain.forward(q);
  const PostureReport posture = report_of(chain, q);
  if (!common.json) {
    print_text(posture, chain, X_BF, arm.robot->total_mass());
    return kHeld;
  }
  Json json = {
      {"model", arm.model}, {"pose", matrix(X_BF)}, {"mass", arm.robot->total_mass()}, {"q", joint_numbers(q)}};
  json.update(posture_json(posture, chain));
  print(json);
  return kHeld;
}

int print_inverse(const device::ArmDescription& arm, const InverseQuestion& question, const Common& common) {
  const kinematics::Chain& chain = *arm.chain;
  const auto X_BF = pose_of(question.pose);
  Diagnostics diagnostics = check_redundancy(chain, question);
  if (!X_BF) diagnostics.append(X_BF.error());
  if (diagnostics.has_errors()) return report(diagnostics, common);
  kinematics::SolutionOptions options;
  options.reference = arm.home;
  options.turns = question.turns;
  if (question.held) options.held_values = {*question.held};
  if (question.arm_angle) options.arm_angles = {*question.arm_angle};
  const auto solutions = kinematics::inverse_solutions(chain, *X_BF, options);
  // No answer is an answer, but not the one that was asked for.
  const int status = solutions.empty() ? kNotHeld : kHeld;
  if (solutions.empty())
    fmt::print(stderr, "--ik: the flange of '{}' cannot be there within the limits of its joints\n", arm.model);
  if (!common.json) {
    print_table(chain, solutions);
    return status;
  }
  Json list = Json::array(), branches = Json::array();
  for (const JointVector& q : solutions) {
    list.push_back(joint_numbers(q));
    branches.push_back(posture_json(report_of(chain, q), chain));
  }
  print({{"model", arm.model}, {"way", way_to_solutions(arm)}, {"solutions", list}, {"branches", branches}});
  return status;
}

std::string way_to_solutions(const device::ArmDescription& arm) {
  const kinematics::Chain& chain = *arm.chain;
  const int n = chain.joint_count();
  bool revolute = true;
  for (int i = 0; i < n; ++i) revolute = revolute && !chain.is_prismatic(i);
  if (n < 6) return "place and the nearest turn, numeric";
  if (!revolute || n > 7) return "numeric search";
  std::vector<int> held;
  std::string of_seven;
  if (n == 7) {
    held = {kinematics::redundant_joint(chain)};
    of_seven = fmt::format(", {} held", chain.joint_names()[static_cast<std::size_t>(held.front())]);
    if (kinematics::ArmAngle::recognise(chain)) of_seven += " or arm angle";
  }
  const auto form = kinematics::ClosedForm::recognise(chain, arm.home, held);
  if (!form) return "elimination" + of_seven;
  return fmt::format("closed form: {}{}{}", to_string(form->family()), form->reversed() ? ", from the flange" : "",
                     of_seven);
}

}  // namespace takt::tools
