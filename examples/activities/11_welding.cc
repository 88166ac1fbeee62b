// 11. The welding application of the 2010 paper: a torch as a composed device, a workpiece that knows its lines, and
// weld() as an interface of the robot with its torch, which carries out a whole seam as one real-time command. (The
// operation `weld` of takt does the same and more; this is how such an operation is made.)
#include <takt/takt.h>

using namespace takt::app;
using Pose = Eigen::Isometry3d;

/// A torch is three outputs: the gas valve, the source, the wire feeder.
ComposedDevice welding_torch(Cell& cell, const std::string& device) {
  return {device,
          {{"gas", cell.output(device + "/gas")},
           {"arc", cell.output(device + "/arc")},
           {"wire", cell.output(device + "/wire")}}};
}

/// Poses of the tool centre point along a seam, in the base of the robot.
using WeldingLine = std::vector<Pose>;

/// A workpiece knows its lines; another one with lines of the same names is welded by the same program.
class WeldedWorkpiece {
 public:
  WeldedWorkpiece(Cell& cell, std::string name) : cell_(cell), name_(std::move(name)) {}
  WeldingLine line(const std::string& line, const Actuator& robot, double stick_out = 0.015) const {
    const std::vector<std::string> frames = cell_.model().frames.names();
    WeldingLine poses;
    for (int i = 1;; ++i) {
      const std::string point = fmt::format("{}/{}/{}", name_, line, i);
      if (std::ranges::find(frames, point) == frames.end()) return poses;
      Pose X_BT = robot.frame(point) * Eigen::Translation3d(0.0, 0.0, -stick_out);
      poses.push_back(X_BT);
    }
  }

 private:
  Cell& cell_;
  std::string name_;
};

struct WeldingParameters {
  double speed = 0.01, overlap = 0.005, retract = 0.05;                                // m/s, m, m
  double gas_preflow = 0.3, ignition_timeout = 1.0, crater = 0.3, gas_postflow = 0.5;  // s
};

/// What only a robot with its torch can do.
class WeldingInterface : public DeviceInterface {
 public:
  static constexpr std::string_view kName = "WeldingInterface";
  static bool offered_by(const ComposedDevice& device) {
    return device.has_part("robot") && device.has_part("gas") && device.has_part("arc") && device.has_part("wire");
  }
  using DeviceInterface::DeviceInterface;

  /// From the pose of now to the line, along it, and away from it.
  [[nodiscard]] Activity weld(const WeldingLine& line, const State& burns, const WeldingParameters& own) const {
    RuntimeCommand approach("ignition movement", robot(), lin_along({line.front()}, 0.1));
    RuntimeCommand gas_on("gas on", output("gas"), command::set_value(true));
    WaitCommand preflow("preflow", own.gas_preflow);
    const auto seam_motion = command::while_process(
        lin_along({line.begin() + 1, line.end()}, own.speed), burns,
        {.start_timeout = own.ignition_timeout, .finish_time = own.crater, .overlap = own.overlap / own.speed});
    RuntimeCommand seam("seam", robot(), seam_motion);
    RuntimeCommand arc("arc", output("arc"), command::follow_state(seam_motion.state("process")));
    RuntimeCommand wire("wire", output("wire"), command::follow_state(seam_motion.state("process")));
    WaitCommand postflow("postflow", own.gas_postflow);
    RuntimeCommand gas_off("gas off", output("gas"), command::set_value(false));
    const Pose X_BT_away = line.back() * Eigen::Translation3d(0.0, 0.0, -own.retract);
    RuntimeCommand away("final movement", robot(), lin_along({X_BT_away}, 0.1));
    seam.fails_if((seam_motion.state("not_started") || seam_motion.state("lost")).once());

    TransactionCommand weld("weld");
    weld.add_started(approach).add(gas_on).add(preflow).add(seam).add(arc).add(wire);
    weld.add(postflow).add(gas_off).add(away).on_cancel_forward_to({approach, preflow, seam});
    const auto when = [&](const State& state, std::initializer_list<command::Effect> effects) {
      for (const command::Effect& effect : effects) weld.on_entered(state, effect);
    };
    when(approach.completed() && !approach.cancelled(), {start(gas_on), start(preflow)});
    when(preflow.completed() && !preflow.cancelled(), {start(seam), start(arc), start(wire)});
    when(preflow.cancelled(), {start(gas_off)});
    when(seam.completed() || seam.failed(), {cancel(arc), cancel(wire), start(postflow)});
    when(postflow.completed(), {start(gas_off)});
    when(postflow.completed() && seam.completed() && !seam.cancelled(), {start(away)});
    return {part("robot").runtime(), takt::activity::command_activity(weld)};
  }

 private:
  [[nodiscard]] const takt::expression::Cell& model() const { return part("robot").runtime().cell(); }
  [[nodiscard]] command::Actuator robot() const { return command::arm(model(), part("robot").name()); }
  [[nodiscard]] command::Actuator output(const char* role) const { return command::output(model(), part(role).name()); }
  /// Straight lines with blends between them.
  [[nodiscard]] command::Action lin_along(const std::vector<Pose>& goals, double speed) const {
    std::vector<command::SequencePart> parts;
    for (const Pose& X_BT : goals) {
      const auto leg = [arm = &model().arms.find(part("robot").name())->second, X_BT](const auto& q) {
        return takt::motion::lin_leg(expression::planning_model(*arm), q, X_BT);
      };
      parts.push_back({.geometry = leg, .parameters = {.linear_velocity = speed}});
      parts.back().blend = {takt::motion::Blend::Kind::kDistance, 0.004};
    }
    parts.back().blend = {};
    return command::sequence(parts);
  }
};

int main(int argc, char** argv) {
  return run(argc, argv, "welding.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const ComposedDevice torch = welding_torch(cell, "torch");
    const ComposedDevice welder(
        "welder",
        {{"robot", robot}, {"gas", torch.part("gas")}, {"arc", torch.part("arc")}, {"wire", torch.part("wire")}});
    const WeldedWorkpiece workpiece(cell, "workpiece");
    const State burns = cell.input("torch/established");
    for (const char* name : {"edge", "side"}) {
      const WeldingLine line = workpiece.line(name, robot);
      cell.step(name);
      robot.use<PtpInterface>().ptp(line.front() * Eigen::Translation3d(0.0, 0.0, -0.08), {.velocity = 0.4}).execute();
      welder.use<WeldingInterface>().weld(line, burns, {.speed = 0.02}).execute();
    }
    robot.use<PtpInterface>().ptp(robot.home(), {.velocity = 0.4}).execute();
  });
}
