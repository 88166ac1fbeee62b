// model: what takt knows of a robot, sensor or thing.
#include <cmath>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/kinematics/chain.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

// -- model ---------------------------------------------------------------------------------------------------------

struct ModelArguments {
  std::string name;
  std::vector<double> fk, ik;
};

Json matrix(const Eigen::Isometry3d& X) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return rows;
}

Json numbers(const JointVector& q) { return std::vector<double>(q.data(), q.data() + q.size()); }

int forward(const device::ArmDescription& arm, const std::vector<double>& values, const Common& common) {
  if (static_cast<int>(values.size()) != arm.chain->joint_count()) {
    Findings findings;
    findings.error("--fk", fmt::format("{} numbers for {} joints", values.size(), arm.chain->joint_count()),
                   "one per joint, rad");
    return report(findings, common);
  }
  JointVector q(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) q[static_cast<Eigen::Index>(i)] = values[i];
  if (!q.allFinite()) {
    Findings findings;
    findings.error("--fk", "a number is not finite", "finite joint positions, rad");
    return report(findings, common);
  }
  const Eigen::Isometry3d X_BF = arm.chain->forward(q);
  if (common.json) {
    print({{"model", arm.model}, {"pose", matrix(X_BF)}, {"mass", arm.robot->total_mass()}, {"q", numbers(q)}});
    return kHeld;
  }
  const Eigen::Quaterniond r(X_BF.linear());
  fmt::print(
      "flange in base: ({:.6f}, {:.6f}, {:.6f}) m, quaternion ({:.6f}, {:.6f}, {:.6f}, {:.6f}); mass {:.3f} kg\n",
      X_BF.translation().x(), X_BF.translation().y(), X_BF.translation().z(), r.w(), r.x(), r.y(), r.z(),
      arm.robot->total_mass());
  return kHeld;
}

int inverse(const device::ArmDescription& arm, const std::vector<double>& values, const Common& common) {
  Findings findings;
  Eigen::Quaterniond r(1, 0, 0, 0);
  if (values.size() != 7) {
    findings.error("--ik", fmt::format("{} numbers", values.size()), "x, y, z in m, then the quaternion w, x, y, z");
  } else {
    r = Eigen::Quaterniond(values[3], values[4], values[5], values[6]);
    bool finite = true;
    for (const double value : values) finite = finite && std::isfinite(value);
    if (!finite || std::abs(r.norm() - 1.0) > 1e-3) {
      findings.error("--ik", "the pose is not finite or its quaternion has no unit norm", "x, y, z, qw, qx, qy, qz");
    }
  }
  if (findings.has_errors()) return report(findings, common);
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.translation() << values[0], values[1], values[2];
  X_BF.linear() = r.normalized().toRotationMatrix();
  kinematics::SolutionOptions options;
  options.reference = arm.home;
  const auto solutions = kinematics::inverse_solutions(*arm.chain, X_BF, options);
  if (common.json) {
    Json list = Json::array();
    for (const JointVector& q : solutions) list.push_back(numbers(q));
    print({{"model", arm.model}, {"solutions", list}});
  } else {
    fmt::print("{} solutions, the nearest to home first (deg)\n", solutions.size());
    for (const JointVector& q : solutions) {
      for (const double value : q) fmt::print(" {:9.4f}", value * 180 / std::numbers::pi);
      fmt::print("\n");
    }
  }
  return kHeld;
}

int describe_arm(const device::ArmDescription& arm, const Common& common) {
  if (common.json) {
    print({{"model", arm.model},
           {"joints", arm.joint_names},
           {"lower", numbers(arm.limits.lower)},
           {"upper", numbers(arm.limits.upper)},
           {"velocity", numbers(arm.limits.velocity)},
           {"acceleration", numbers(arm.limits.acceleration)},
           {"jerk", numbers(arm.limits.jerk)},
           {"effort", numbers(arm.effort)},
           {"home", numbers(arm.home)},
           {"mass", arm.robot->total_mass()}});
    return kHeld;
  }
  fmt::print("{}: {} joints, {:.2f} kg\n", arm.model, arm.chain->joint_count(), arm.robot->total_mass());
  fmt::print("  {:<10} {:>16} {:>10} {:>12} {:>10} {:>9}\n", "joint", "range deg", "deg/s", "deg/s2", "deg/s3", "Nm");
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (std::size_t i = 0; i < arm.joint_names.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const std::string range =
        fmt::format("{:.1f}..{:.1f}", arm.limits.lower[j] * kDegrees, arm.limits.upper[j] * kDegrees);
    fmt::print("  {:<10} {:>16} {:>10.1f} {:>12.1f} {:>10.0f} {:>9.1f}\n", arm.joint_names[i], range,
               arm.limits.velocity[j] * kDegrees, arm.limits.acceleration[j] * kDegrees, arm.limits.jerk[j] * kDegrees,
               arm.effort[j]);
  }
  return kHeld;
}

int model(const ModelArguments& arguments, const Common& common) {
  const auto folder = common.library().find(arguments.name);
  if (!folder) return report(folder.error(), common);
  const auto kind = device::read_device_kind(*folder);
  if (!kind) return report(kind.error(), common);
  if (*kind != "arm") {
    const auto robot = kinematics::RobotModel::load(*folder / (arguments.name + ".urdf"));
    if (!robot) return report(robot.error(), common);
    if (common.json) {
      print({{"model", arguments.name}, {"kind", *kind}, {"mass", robot->total_mass()}});
    } else {
      fmt::print("{}: {}, {:.3f} kg\n", arguments.name, *kind, robot->total_mass());
    }
    return kHeld;
  }
  const auto arm = device::read_arm(*folder);
  if (!arm) return report(arm.error(), common);
  if (!arguments.fk.empty()) return forward(**arm, arguments.fk, common);
  if (!arguments.ik.empty()) return inverse(**arm, arguments.ik, common);
  return describe_arm(**arm, common);
}

}  // namespace

std::pair<CLI::App*, Verb> add_model(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<ModelArguments>();
  CLI::App* verb = app.add_subcommand("model", "Figures, forward and inverse kinematics of a model");
  verb->add_option("NAME", arguments->name, "Folder below models/")->required();
  verb->add_option("--fk", arguments->fk, "Flange pose for joint positions, rad")
      ->delimiter(',')
      ->type_name("Q1,Q2,...");
  verb->add_option("--ik", arguments->ik, "Joint positions for a flange pose in the base")
      ->delimiter(',')
      ->type_name("X,Y,Z,QW,QX,QY,QZ");
  return {verb, [arguments, &common] { return model(*arguments, common); }};
}

}  // namespace takt::tools
