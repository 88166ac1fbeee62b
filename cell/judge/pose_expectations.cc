#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "cell/file/degrees.h"
#include "cell/judge/expectation_kinds.h"
#include "cell/judge/true_poses.h"

namespace takt::cell {
namespace {

using Eigen::Isometry3d;

/// How far a pose is from another one.
struct PoseMiss {
  double distance = 0.0, angle = 0.0;  ///< m, rad
};

PoseMiss miss_of(const Isometry3d& measured, const Isometry3d& wanted) {
  return {.distance = (measured.translation() - wanted.translation()).norm(),
          .angle = Eigen::AngleAxisd(measured.linear().transpose() * wanted.linear()).angle()};
}

/// How near a pose has to be: keys "position_within_m", "angle_within_deg".
struct PoseTolerance {
  explicit PoseTolerance(FormReader& from)
      : within_m(from.number("position_within_m")), within_rad(kDegree * from.number("angle_within_deg")) {}

  [[nodiscard]] ExpectationResult judge(const std::string& what, const PoseMiss& miss) const {
    ExpectationResult result;
    result.passed = miss.distance <= within_m && miss.angle <= within_rad;
    result.value = miss.distance;
    result.unit = "m";
    result.upper = within_m;
    result.measured = fmt::format("{} off by {:.3f} mm (at most {:.3f}) and {:.3f} deg (at most {:.3f})", what,
                                  1e3 * miss.distance, 1e3 * within_m, miss.angle / kDegree, within_rad / kDegree);
    return result;
  }

  double within_m, within_rad;
};

class EstimateExpectation final : public Expectation {
 public:
  explicit EstimateExpectation(ExpectationReader& from)
      : estimate_(from.text("estimate")),
        object_(from.name("of", keys_of(from.built.cell.objects))),
        tolerance_(from) {}

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const auto found = outcome.variables.estimates.find(estimate_);
    if (found == outcome.variables.estimates.end()) {
      return {.measured = fmt::format("nothing was estimated as '{}'", estimate_)};
    }
    return tolerance_.judge(fmt::format("'{}'", estimate_), miss_of(found->second, true_pose(outcome.built, object_)));
  }

 private:
  std::string estimate_, object_;
  PoseTolerance tolerance_;
};

/// What the program believes of a frame or an object against where it truly is.
class BeliefExpectation final : public Expectation {
 public:
  explicit BeliefExpectation(ExpectationReader& from)
      : frame_(from.name("frame", from.built.cell.frames.names())), tolerance_(from) {}

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const auto believed = outcome.built.cell.frames.pose(frame_);
    const auto truth = true_frame(outcome.built, frame_);
    if (!believed || !truth) return {.measured = fmt::format("it is not known where '{}' is", frame_)};
    return tolerance_.judge(fmt::format("the belief of '{}'", frame_), miss_of(*believed, *truth));
  }

 private:
  std::string frame_;
  PoseTolerance tolerance_;
};

/// Where something has to be in a frame that is where the simulation has it: at the end, or in each cycle of a step.
class TruePoseExpectation final : public Expectation {
 public:
  using Truth = std::function<Isometry3d(const BuiltCell&)>;

  TruePoseExpectation(std::string what, Truth truth, ExpectationReader& reader)
      : what_(std::move(what)),
        truth_(std::move(truth)),
        in_(reader.text("in")),
        X_(reader.object().pose()),
        tolerance_(reader),
        during_(reader.during()) {
    if (const auto X_WI = reader.built.cell.frames.pose(in_); !X_WI)
      reader.diagnostics().append(X_WI.error(), reader.at("in"));
  }

  void steps_run(std::span<const std::string> paths) override { during_.look(paths); }
  void watch(const BuiltCell& built) override {
    if (during_.name().empty() || !during_.inside()) return;
    ran_ = true;
    const auto miss = miss_now(built);
    known_ = known_ && miss;
    if (!miss) return;
    worst_.distance = std::max(worst_.distance, miss->distance);
    worst_.angle = std::max(worst_.angle, miss->angle);
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const bool at_end = during_.name().empty();
    if (!at_end && !ran_) return {.measured = fmt::format("'{}' did not run", during_.name())};
    const auto miss = at_end ? miss_now(outcome.built) : known_ ? std::optional(worst_) : std::nullopt;
    if (!miss) return {.measured = fmt::format("it is not known what '{}' depends on", in_)};
    return tolerance_.judge(at_end ? fmt::format("'{}'", what_) : fmt::format("'{}', in '{}',", what_, during_.name()),
                            *miss);
  }

 private:
  [[nodiscard]] std::optional<PoseMiss> miss_now(const BuiltCell& built) const {
    const auto X_WI = true_frame(built, in_);
    if (!X_WI) return std::nullopt;
    return miss_of(truth_(built), *X_WI * X_);
  }

  std::string what_;
  Truth truth_;
  std::string in_;
  Isometry3d X_;
  PoseTolerance tolerance_;
  StepWindow during_;
  bool ran_ = false, known_ = true;  ///< the step; where the frame was, all the time
  PoseMiss worst_;                   ///< while it ran
};

/// The pose that is expected, and how nearly.
Form pose_form(std::string doc, Key whose) {
  Form form{std::move(doc),
            {std::move(whose),
             text_key("in",
                      "Frame of the pose, where it truly is: a frame, a device, an object, ARM/flange, TOOL/TCP, "
                      "OBJECT/GRASP or world.")
                 .by_default("world"),
             within_m_key(), within_deg_key(),
             during_key()
                 .with_doc("In each cycle in which this step or any other node of the program runs; NAME (2) is its "
                           "second round, OUTER / INNER a node in another one.")
                 .optional("at the end")},
            {pose_rule()}};
  std::ranges::copy(pose_keys(), std::back_inserter(form.keys));
  return form;
}

}  // namespace

ExpectationKind estimate_expectation() {
  return expectation_kind<EstimateExpectation>(
      "estimate", {"A pose found by fit_pose is this close to the true pose of an object.",
                   {text_key("estimate", "Name that a fit_pose step gave ('as')."),
                    text_key("of", "Object whose true pose it is compared with."), within_m_key(), within_deg_key()}});
}

ExpectationKind belief_expectation() {
  return expectation_kind<BeliefExpectation>(
      "belief", {"A frame or object is at the end where the program believes it to be.",
                 {text_key("frame", "Frame or object."), within_m_key(), within_deg_key()}});
}

ExpectationKind object_pose_expectation() {
  return {"object_pose",
          pose_form("The true pose of an object is this close to a pose, at the end or in each cycle of a step.",
                    text_key("object", "Which object.")),
          [](ExpectationReader& from) {
            const std::string object = from.name("object", keys_of(from.built.cell.objects));
            const auto truth = [object](const BuiltCell& now) { return true_pose(now, object); };
            return std::make_unique<TruePoseExpectation>(object, truth, from);
          }};
}

ExpectationKind tool_pose_expectation() {
  return {
      "tool_pose",
      pose_form("The true pose of an arm's tool, or of a base, is this close to a pose, at the end or in each cycle "
                "of a step.",
                arm_key()),
      [](ExpectationReader& from) {
        const std::string arm = from.arm();
        // Not where its own measurements say.
        const auto truth = [arm](const BuiltCell& now) { return true_tool(now, arm); };
        return std::make_unique<TruePoseExpectation>(arm, truth, from);
      }};
}

}  // namespace takt::cell
