#include "cell/judge/pose_expectations.h"

#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "cell/file/degrees.h"
#include "cell/judge/step_window.h"
#include "cell/judge/true_poses.h"

namespace takt::cell {
namespace {

using Eigen::Isometry3d;

template <class Map>
std::vector<std::string> names_in(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

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
  explicit PoseTolerance(ObjectReader& reader)
      : within_m(reader.number("position_within_m", {}, kPositive)),
        within_rad(kDegree * reader.number("angle_within_deg", 180.0, kPositive)) {}

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
  EstimateExpectation(ObjectReader& reader, const BuiltCell& built)
      : estimate_(reader.text("estimate")),
        object_(reader.choice("of", names_in(built.cell.objects))),
        tolerance_(reader) {}

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
  BeliefExpectation(ObjectReader& reader, const BuiltCell& built)
      : frame_(reader.choice("frame", built.cell.frames.names())), tolerance_(reader) {}

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

  TruePoseExpectation(std::string what, Truth truth, ObjectReader& reader, const BuiltCell& built,
                      const StepNames& steps)
      : what_(std::move(what)),
        truth_(std::move(truth)),
        in_(reader.text("in", "world")),
        X_(reader.pose()),
        tolerance_(reader),
        during_(read_during(reader, steps)) {
    if (const auto X_WI = built.cell.frames.pose(in_); !X_WI)
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

}  // namespace

std::string read_arm_name(ObjectReader& reader, const BuiltCell& built) {
  const auto arms = names_in(built.cell.arms);
  return reader.choice("arm", arms, arms.size() == 1 ? std::optional(arms.front()) : std::nullopt);
}

std::unique_ptr<Expectation> estimate_expectation(ObjectReader& reader, const BuiltCell& built) {
  return std::make_unique<EstimateExpectation>(reader, built);
}

std::unique_ptr<Expectation> belief_expectation(ObjectReader& reader, const BuiltCell& built) {
  return std::make_unique<BeliefExpectation>(reader, built);
}

std::unique_ptr<Expectation> object_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                     const StepNames& steps) {
  const std::string object = reader.choice("object", names_in(built.cell.objects));
  const auto truth = [object](const BuiltCell& now) { return true_pose(now, object); };
  return std::make_unique<TruePoseExpectation>(object, truth, reader, built, steps);
}

std::unique_ptr<Expectation> tool_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                   const StepNames& steps) {
  const std::string arm = read_arm_name(reader, built);
  // Not where its own measurements say.
  const auto truth = [arm](const BuiltCell& now) { return true_tool(now, arm); };
  return std::make_unique<TruePoseExpectation>(arm, truth, reader, built, steps);
}

}  // namespace takt::cell
