#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/command/actuator.h"
#include "core/device/seam.h"

namespace takt::motion {
struct Motion;
}

namespace takt::command {

struct PlannedMotion;

/// What an action has put into its fragment.
struct Contribution {
  SetPoint set_point;
  expression::Signal done;  ///< a port in the fragment: it has come to its end, or was cancelled and has come to rest
  std::string path_clock = {};  ///< of a planned motion: its PathClock in the fragment
  double duration = 0.0;        ///< of a planned motion, s
};

/// What is to be done, without who does it. Immutable; any thread.
///
/// An action puts a source of set points into the fragment of its command. It is over when `done` is true; when the
/// command is cancelled (FragmentWriter::cancel) it comes to rest and is done then.
class ActionModel {
 public:
  ActionModel() = default;
  virtual ~ActionModel() = default;
  ActionModel(const ActionModel&) = delete;
  ActionModel& operator=(const ActionModel&) = delete;

  /// For people: "LIN".
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// The kind of its set points on this actuator.
  [[nodiscard]] virtual SetPointKind gives(const ActuatorModel& actuator) const = 0;
  /// The control mode that its set points are meant for; nothing: whichever the actuator is in.
  [[nodiscard]] virtual std::optional<device::ControlMode> mode() const { return std::nullopt; }
  /// What is wrong with its figures for this actuator, which takes its kind of set points.
  [[nodiscard]] virtual Diagnostics check(const ActuatorModel&) const { return {}; }
  /// The formulas that it follows, for checks.
  [[nodiscard]] virtual std::vector<expression::ExpressionPtr> formulas() const { return {}; }
  [[nodiscard]] virtual Contribution add_to(expression::FragmentWriter& fragment,
                                            const ActuatorModel& actuator) const = 0;

  /// Names of the states and values that it has beside "started", "completed": "error", "at_path", "progress".
  [[nodiscard]] virtual std::vector<std::string> states() const { return {}; }
  /// How many via points it passes, for `via_passed`; known once it is planned.
  [[nodiscard]] virtual int via_count() const { return 0; }
  /// Adds one of states(). @return its port in the fragment.
  [[nodiscard]] virtual std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                              const nlohmann::ordered_json& parameters) const;

  /// How long it takes from a cancel to rest, at most, s.
  [[nodiscard]] virtual double stop_time(const ActuatorModel&) const { return 0.0; }
  /// Whether its net declares that time at LOAD (Primitive::stop_time_bound), so that the mapping need not.
  [[nodiscard]] virtual bool net_knows_stop_time() const { return true; }

  /// How it takes its actuator over and leaves it (row L3): a seam for each device, in the order of
  /// ActuatorModel::devices(); empty: it does not know.
  [[nodiscard]] virtual std::vector<device::Seam> begins() const { return {}; }
  [[nodiscard]] virtual std::vector<device::Seam> ends() const { return {}; }
  /// Of a planned motion: how long it takes by its plan, s; else 0.
  [[nodiscard]] virtual double duration() const { return 0.0; }

  /// Of a planned motion of one arm: the plan, and the frame that it moves, in the flange; null: there is none.
  struct PlannedPath {
    const motion::Motion* motion = nullptr;
    Eigen::Isometry3d X_FM = Eigen::Isometry3d::Identity();
    std::vector<double> handed_over = {};  ///< path time at which each of its motions but the last hands over, s
    bool laid_over = false;                ///< its set points are not those of the plan: a weave
  };
  [[nodiscard]] virtual PlannedPath planned_path() const { return {}; }
  /// Of a motion that is planned, of one arm or of two, whatever is laid over it; null: it is none.
  [[nodiscard]] virtual const PlannedMotion* planned_motion() const { return nullptr; }

  /// Of a planned motion with which another one may go on before its goal (PlannedMotion::leaving).
  struct BlendOut {
    const PlannedMotion* motion = nullptr;  ///< null: it comes to rest first
    int abort_handlers = 0;  ///< the first event handlers of its command, which cancel it where it must not go on
  };
  [[nodiscard]] virtual BlendOut left_in_motion() const { return {}; }

  /// Whether it must be planned before it can be mapped.
  [[nodiscard]] virtual bool needs_plan() const { return false; }
  /// Plans it from where its actuator will be. @return the planned action. Realtime: setup.
  /// @param q_start  of each arm of the actuator; of others that commands around this one move too, of size 0 where
  ///                 that depends on the run
  [[nodiscard]] virtual Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                        const expression::Places& q_start) const;
};

/// What is to be done: LIN, PTP, set a value, grip, hold a force. A cheap value; its states speak of the one command
/// that carries it out. Any thread.
class Action {
 public:
  explicit Action(std::shared_ptr<const ActionModel> model);

  [[nodiscard]] const ActionModel& model() const { return *model_; }
  [[nodiscard]] std::shared_ptr<const ActionModel> shared_model() const { return model_; }
  [[nodiscard]] const expression::SubjectPtr& subject() const { return subject_; }

  [[nodiscard]] expression::State started() const { return state("started"); }
  /// It has come to its end, cancelled or not.
  [[nodiscard]] expression::State completed() const { return state("completed"); }
  /// It cannot do what it should: no joints for a pose, a target that is gone, a part that was lost.
  [[nodiscard]] expression::State error() const { return state("error"); }
  /// Of a motion: it is at or past this share of its path.
  [[nodiscard]] expression::State at_path(double fraction) const;
  /// Of a motion through several points: it has passed point number `i`, from 0, by its blend.
  [[nodiscard]] expression::State via_passed(int i) const;
  /// Of a motion: how far on its path it is, 0 to 1; null while the command does not run.
  [[nodiscard]] expression::RealSensor progress() const;
  /// A number that it shows, by name: of a grip its "width", m. Checks refuse one that the action does not have.
  [[nodiscard]] expression::RealSensor value(const std::string& name) const;
  /// A state by name; checks refuse one that the action does not have.
  [[nodiscard]] expression::State state(const std::string& name) const;

 private:
  std::shared_ptr<const ActionModel> model_;
  expression::SubjectPtr subject_;
};

}  // namespace takt::command
