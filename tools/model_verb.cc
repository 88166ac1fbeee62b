// model: what takt knows of a robot, sensor or thing: figures, kinematics, pictures.
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/device/base_description.h"
#include "core/device/device_file.h"
#include "core/kinematics/robot_model.h"
#include "tools/cli.h"
#include "tools/model_figures.h"
#include "tools/model_kinematics.h"
#include "tools/model_picture.h"
#include "tools/reach_picture.h"

namespace takt::tools {
namespace {

struct ModelArguments {
  std::string name;
  std::vector<double> fk;
  InverseQuestion ik;
  bool branches = false;
  std::string image, reach;
  std::vector<double> posture;
  PictureOptions picture;
};

/// What a model is, whatever its kind.
struct LoadedModel {
  std::string kind;
  std::shared_ptr<const kinematics::RobotModel> robot;
  std::shared_ptr<const device::ArmDescription> arm;          ///< or base; null for any other kind
  std::shared_ptr<const device::GripperDescription> gripper;  ///< null for any other kind
};

/// An arm, or a base, which is one of three joints.
Result<std::shared_ptr<const device::ArmDescription>> read_driven(const std::filesystem::path& folder,
                                                                  const std::string& kind) {
  if (kind == "arm") return device::read_arm(folder);
  return device::read_base(folder);
}

Result<LoadedModel> load(const std::string& name, const Common& common) {
  const auto folder = common.library().find(name);
  if (!folder) return std::unexpected(folder.error());
  LoadedModel model;
  const auto kind = device::read_device_kind(*folder);
  if (!kind) return std::unexpected(kind.error());
  model.kind = *kind;
  if (model.kind == "arm" || model.kind == "base") {
    const auto arm = read_driven(*folder, model.kind);
    if (!arm) return std::unexpected(arm.error());
    model.arm = *arm;
    model.robot = (*arm)->robot;
    return model;
  }
  if (model.kind == "gripper") {
    const auto gripper = device::read_gripper(*folder);
    if (!gripper) return std::unexpected(gripper.error());
    model.gripper = *gripper;
  }
  auto robot = kinematics::RobotModel::load(*folder / (folder->filename().string() + ".urdf"));
  if (!robot) return std::unexpected(robot.error());
  model.robot = std::make_shared<kinematics::RobotModel>(*std::move(robot));
  return model;
}

/// What only an arm or a base can answer.
Diagnostics check_kind(const ModelArguments& arguments, const LoadedModel& model) {
  Diagnostics diagnostics;
  const std::pair<const char*, bool> asked[] = {
      {"--fk", !arguments.fk.empty()}, {"--ik", !arguments.ik.pose.empty()}, {"--reach", !arguments.reach.empty()}};
  for (const auto& [option, given] : asked) {
    if (given && !model.arm)
      diagnostics.error(Code::kInvalidValue, option,
                        fmt::format("'{}' is neither an arm nor a base but: {}", arguments.name, model.kind));
  }
  return diagnostics;
}

/// Of numbers that are none nothing can be told.
Diagnostics check_numbers(const ModelArguments& arguments) {
  Diagnostics diagnostics;
  const std::pair<const char*, const std::vector<double>*> lists[] = {
      {"--fk", &arguments.fk}, {"--ik", &arguments.ik.pose}, {"--posture", &arguments.posture}};
  constexpr double kMost = 1e6;
  for (const auto& [option, numbers] : lists) {
    for (const double number : *numbers) {
      if (std::abs(number) <= kMost) continue;
      diagnostics.error(Code::kOutOfRange, option, fmt::format("{} is out of range", number),
                        fmt::format("Use numbers up to {:g}", kMost));
    }
  }
  for (const auto& [option, number] :
       {std::pair{"--arm-angle", arguments.ik.arm_angle}, {"--held", arguments.ik.held}}) {
    if (number && !(std::abs(*number) <= kMost))
      diagnostics.error(Code::kOutOfRange, option, fmt::format("{} is out of range", *number),
                        fmt::format("Use at most {:g}", kMost));
  }
  return diagnostics;
}

/// Tells on stderr how far the sampling of a work space is: once a second, and on a terminal in one line.
class WorkSpaceProgress {
 public:
  void operator()(double share) {
    const auto now = std::chrono::steady_clock::now();
    if (terminal_ && share >= 1.0 && told_) fmt::print(stderr, "\r\033[K");
    if (now - last_ < std::chrono::seconds(1) || share >= 1.0) return;
    last_ = now;
    told_ = true;
    fmt::print(stderr, "{}the work space is sampled: {:.0f} %{}", terminal_ ? "\r" : "", 100.0 * share,
               terminal_ ? "" : "\n");
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  bool terminal_ = isatty(STDERR_FILENO) != 0, told_ = false;
};

int draw(const ModelArguments& arguments, const LoadedModel& model, const Common& common) {
  PictureOptions options = arguments.picture;
  options.q = arguments.posture;
  if (!arguments.image.empty()) {
    const auto drawn = draw_model(*model.robot, model.arm.get(), options, arguments.image);
    if (!drawn) return report(drawn.error(), common);
    fmt::print(stderr, "{}: {}x{}\n", arguments.image, options.width, options.height);
  }
  if (!arguments.reach.empty()) {
    const auto drawn = draw_reach(*model.arm, arguments.reach, {.progress = WorkSpaceProgress()});
    if (!drawn) return report(drawn.error(), common);
    fmt::print(stderr, "{}: reach {:.3f} m\n", arguments.reach, drawn->farthest_m);
    if (drawn->share < 1.0)
      fmt::print(stderr, "{}: the time was enough for the lower {:.0f} % of the right section\n", arguments.reach,
                 100.0 * drawn->share);
  }
  return kHeld;
}

int model(const ModelArguments& arguments, const Common& common) {
  if (const Diagnostics diagnostics = check_numbers(arguments); diagnostics.has_errors())
    return report(diagnostics, common);
  const auto model = load(arguments.name, common);
  if (!model) return report(model.error(), common);
  if (const Diagnostics diagnostics = check_kind(arguments, *model); diagnostics.has_errors())
    return report(diagnostics, common);
  if (const int status = draw(arguments, *model, common); status != kHeld) return status;
  if (!arguments.fk.empty()) return print_forward(*model->arm, arguments.fk, common);
  if (!arguments.ik.pose.empty()) return print_inverse(*model->arm, arguments.ik, common);
  if (!common.json && (!arguments.image.empty() || !arguments.reach.empty())) return kHeld;
  return print_figures(arguments.name, model->kind, *model->robot, model->arm.get(), model->gripper.get(), common);
}

}  // namespace

std::pair<CLI::App*, Verb> add_model(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<ModelArguments>();
  CLI::App* verb = app.add_subcommand("model", "Figures, kinematics and pictures of a model");
  verb->add_option("NAME", arguments->name, "Folder below models/")->required();
  verb->add_option("--fk", arguments->fk, "Flange pose, branch, singularity and limits at joint positions, rad")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("Q1,Q2,...");
  verb->add_option("--ik", arguments->ik.pose, "All joint positions for a flange pose in the base")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("X,Y,Z,QW,QX,QY,QZ");
  verb->add_option("--arm-angle", arguments->ik.arm_angle, "With --ik: the arm angle of a seven-axis arm, rad")
      ->type_name("RAD");
  verb->add_option("--held", arguments->ik.held, "With --ik: the value of the joint that a seven-axis arm holds, rad")
      ->type_name("RAD");
  verb->add_flag("--branches", arguments->branches, "With --ik: each branch once, without full turns");
  verb->add_option("--image", arguments->image, "Draw the model into a picture")->type_name("OUT.png");
  verb->add_option("--size", arguments->picture.size, "Of the picture, default 960x720")->type_name("WxH");
  verb->add_option("--posture", arguments->posture, "In the picture: positions of all movable joints, rad or m")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("Q1,Q2,...");
  verb->add_option("--reach", arguments->reach,
                   "Draw a section of the work space, coloured by how well the arm moves there")
      ->type_name("OUT.svg");
  return {verb, [arguments, &common] {
            arguments->ik.turns = !arguments->branches;
            return model(*arguments, common);
          }};
}

}  // namespace takt::tools
