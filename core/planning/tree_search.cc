#include "core/planning/tree_search.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateSampler.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

namespace takt::planning {
namespace {

namespace ob = ompl::base;
using OmplState = ob::RealVectorStateSpace::StateType;

/// Longest branch that is added to a tree at once, s.
constexpr double kBranch = 0.5;
/// Most ways around are not far: so many postures are drawn in a box about start and goals, which is larger by so much.
constexpr double kNearShare = 0.8;
constexpr double kNearBox = 0.3;  // s
/// Of postures that are no way to a shorter path others are drawn, as often.
constexpr int kDraws = 100;
/// A tree that has grown so often without success is given up, even where every look is cheap.
constexpr int kIterations = 20'000;

/// The joints as OMPL sees them: each divided by its speed, so that a way is a time.
class Joints {
 public:
  Joints(FreeSpace& free_space, const Query& query, double shorter_than)
      : free_space_(free_space),
        query_(query),
        shorter_than_(shorter_than),
        speed_(query.speed),
        states_(std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(query.start.size()))),
        near_(static_cast<unsigned>(query.start.size())) {
    ob::RealVectorBounds bounds(static_cast<unsigned>(query.start.size()));
    for (Eigen::Index j = 0; j < speed_.size(); ++j) {
      bounds.setLow(static_cast<unsigned>(j), query.lower[j] / speed_[j]);
      bounds.setHigh(static_cast<unsigned>(j), query.upper[j] / speed_[j]);
    }
    states_->setBounds(bounds);
    find_near(query);
  }

  [[nodiscard]] FreeSpace& free_space() const { return free_space_; }
  [[nodiscard]] const std::shared_ptr<ob::RealVectorStateSpace>& states() const { return states_; }

  /// The part of the range around start and goals.
  [[nodiscard]] const ob::RealVectorBounds& near() const { return near_; }

  /// A path that is short enough may lead through it.
  [[nodiscard]] bool is_of_use(const ob::State* state) const {
    if (!std::isfinite(shorter_than_)) return true;
    const JointVector q = posture(state);
    const double from_start = length_of(query_.start, q, speed_);
    return std::ranges::any_of(
        query_.goals, [&](const JointVector& goal) { return from_start + length_of(q, goal, speed_) < shorter_than_; });
  }

  [[nodiscard]] JointVector posture(const ob::State* state) const {
    JointVector q = speed_;
    for (Eigen::Index j = 0; j < q.size(); ++j) q[j] *= state->as<OmplState>()->values[j];
    return q;
  }
  void write(const JointVector& q, ob::State* state) const {
    for (Eigen::Index j = 0; j < q.size(); ++j) state->as<OmplState>()->values[j] = q[j] / speed_[j];
  }

 private:
  void find_near(const Query& query) {
    for (Eigen::Index j = 0; j < speed_.size(); ++j) {
      double low = query.start[j], high = low;
      for (const JointVector& goal : query.goals) {
        low = std::min(low, goal[j]);
        high = std::max(high, goal[j]);
      }
      const auto i = static_cast<unsigned>(j);
      near_.setLow(i, std::max(low / speed_[j] - kNearBox, states_->getBounds().low[i]));
      near_.setHigh(i, std::min(high / speed_[j] + kNearBox, states_->getBounds().high[i]));
    }
  }

  FreeSpace& free_space_;
  const Query& query_;
  double shorter_than_;
  JointVector speed_;
  std::shared_ptr<ob::RealVectorStateSpace> states_;
  ob::RealVectorBounds near_;
};

/// OMPL seeds generators of its own in the order in which they are made, so its samplers are not used.
class Sampler final : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, const Joints& joints, Random& random)
      : StateSampler(space), joints_(joints), random_(random) {}

  void sampleUniform(ob::State* state) override {
    for (int i = 0; i < kDraws; ++i) {
      draw(state);
      if (joints_.is_of_use(state)) return;
    }
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    for (unsigned j = 0; j < space_->getDimension(); ++j)
      state->as<OmplState>()->values[j] = near->as<OmplState>()->values[j] + random_.uniform(-distance, distance);
    space_->enforceBounds(state);
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    for (unsigned j = 0; j < space_->getDimension(); ++j)
      state->as<OmplState>()->values[j] = mean->as<OmplState>()->values[j] + deviation * random_.normal();
    space_->enforceBounds(state);
  }

 private:
  void draw(ob::State* state) {
    const bool near = random_.unit() < kNearShare;
    const auto& bounds = near ? joints_.near() : space_->as<ob::RealVectorStateSpace>()->getBounds();
    for (std::size_t j = 0; j < bounds.low.size(); ++j)
      state->as<OmplState>()->values[j] = random_.uniform(bounds.low[j], bounds.high[j]);
  }

  const Joints& joints_;
  Random& random_;
};

class Motions final : public ob::MotionValidator {
 public:
  Motions(const ob::SpaceInformationPtr& information, const Joints& joints)
      : MotionValidator(information), joints_(joints) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return joints_.free_space().is_free_line(joints_.posture(from), joints_.posture(to));
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(from, to)) return true;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, from);
    last_valid.second = 0.0;
    return false;
  }

 private:
  const Joints& joints_;
};

ob::SpaceInformationPtr information_of(const Joints& joints, Random& random) {
  joints.states()->setStateSamplerAllocator(
      [&](const ob::StateSpace* space) { return std::make_shared<Sampler>(space, joints, random); });
  auto information = std::make_shared<ob::SpaceInformation>(joints.states());
  information->setStateValidityChecker(
      [&joints](const ob::State* state) { return joints.free_space().is_free(joints.posture(state)); });
  information->setMotionValidator(std::make_shared<Motions>(information, joints));
  information->setup();
  return information;
}

ob::ProblemDefinitionPtr problem_of(const ob::SpaceInformationPtr& information, const Joints& joints,
                                    const Query& query) {
  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(information);
  joints.write(query.start, state.get());
  problem->addStartState(state);
  auto goals = std::make_shared<ob::GoalStates>(information);
  for (const JointVector& goal : query.goals) {
    joints.write(goal, state.get());
    goals->addState(state);
  }
  problem->setGoal(goals);
  return problem;
}

}  // namespace

std::optional<std::vector<JointVector>> connect(FreeSpace& space, const Query& query, double shorter_than,
                                                Random& random, std::int64_t looks) {
  ompl::msg::noOutputHandler();
  const Joints joints(space, query, shorter_than);
  const ob::SpaceInformationPtr information = information_of(joints, random);
  const ob::ProblemDefinitionPtr problem = problem_of(information, joints, query);
  ompl::geometric::RRTConnect planner(information);
  // Exact, so that the nearest state does not depend on random pivots.
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setRange(kBranch);
  planner.setProblemDefinition(problem);
  int iterations = 0;
  const ob::PlannerTerminationCondition is_over([&] { return space.looks() >= looks || ++iterations > kIterations; });
  if (planner.solve(is_over) != ob::PlannerStatus::EXACT_SOLUTION) return std::nullopt;
  const auto path = std::dynamic_pointer_cast<ompl::geometric::PathGeometric>(problem->getSolutionPath());
  std::vector<JointVector> points;
  for (const ob::State* state : path->getStates()) points.push_back(joints.posture(state));
  return points;
}

}  // namespace takt::planning
