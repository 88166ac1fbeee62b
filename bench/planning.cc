// Ways around obstacles: `move` in a shelf, between two arms and out of a container, against plain OMPL on the same
// model. docs/benchmarks.md has the figures. Arguments: number of queries of each kind (100), seconds of the long
// search (0: none) whose best path the length is compared with, a part of the name of the cells that count (all). Long
// searches run on all processors, one for each query: bench_planning 6 60 takes 18 minutes over their number.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include "core/planning/rounded_path.h"
#include "tests/support/planning_cells.h"

namespace takt {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using test::PlanningCell;

/// Of this thread: others on the machine do not disturb it. s
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Outcome {
  bool solved = false;
  double seconds = 0.0;
  double length = 0.0;  ///< s, as core/planning measures it
  bool free = true;     ///< all of it, as proven by takt
};

struct Figures {
  std::vector<Outcome> outcomes;

  [[nodiscard]] double percentile(double share) const {
    std::vector<double> seconds;
    for (const Outcome& one : outcomes) seconds.push_back(one.seconds);
    std::ranges::sort(seconds);
    return seconds[std::min(seconds.size() - 1, static_cast<std::size_t>(share * static_cast<double>(seconds.size())))];
  }
  [[nodiscard]] long count(auto holds) const { return std::ranges::count_if(outcomes, holds); }
  void print(const char* name) const {
    double length = 0.0;
    for (const Outcome& one : outcomes) length += one.length / static_cast<double>(outcomes.size());
    std::printf(
        "  %-14s solved within 1 s %3ld of %zu, collides %3ld; p50 %6.1f ms, p90 %6.1f ms, p99 %6.1f ms; length %.3f "
        "s\n",
        name, count([](const Outcome& one) { return one.solved && one.seconds < 1.0; }), outcomes.size(),
        count([](const Outcome& one) { return one.solved && !one.free; }), 1e3 * percentile(0.5), 1e3 * percentile(0.9),
        1e3 * percentile(0.99), length);
  }
};

Outcome with_takt(const PlanningCell& cell, const PlanningCell::Task& task, std::int64_t looks,
                  std::optional<std::uint64_t> seed = {}) {
  const double begin = processor_time();
  planning::FreeSpace space = cell.free_space();
  planning::Query query = cell.query(task);
  query.looks = looks;
  if (seed) query.seed = *seed;
  Outcome outcome;
  if (const auto path = find_path(space, query)) {
    const motion::ArmModel arm{
        .chain = *cell.arm->chain, .inverse = nullptr, .limits = cell.arm->limits, .cartesian = cell.arm->cartesian};
    outcome.solved = rounded_path(space, arm, path->points).has_value();
    outcome.length = path->length;
  }
  outcome.seconds = processor_time() - begin;
  return outcome;
}

/// OMPL as its users have it: its own samplers, motions checked at its default resolution, its own simplification. Or
/// with takt's proof in place of the checks of its motions.
class PlainOmpl {
 public:
  PlainOmpl(const PlanningCell& cell, const PlanningCell::Task& task, bool proven = false)
      : cell_(cell), space_(cell.free_space()) {
    const auto dimension = static_cast<unsigned>(task.start.size());
    auto states = std::make_shared<ob::RealVectorStateSpace>(dimension);
    ob::RealVectorBounds bounds(dimension);
    for (unsigned j = 0; j < dimension; ++j) {
      bounds.setLow(j, cell.arm->limits.lower[j] / cell.arm->limits.velocity[j]);
      bounds.setHigh(j, cell.arm->limits.upper[j] / cell.arm->limits.velocity[j]);
    }
    states->setBounds(bounds);
    setup_ = std::make_unique<og::SimpleSetup>(states);
    setup_->setStateValidityChecker([this](const ob::State* state) { return space_.is_free(posture(state)); });
    if (proven)
      setup_->getSpaceInformation()->setMotionValidator(
          std::make_shared<ProvenMotions>(*this, setup_->getSpaceInformation()));
    ob::ScopedState<> start(states), goal(states);
    for (unsigned j = 0; j < dimension; ++j) {
      start[j] = task.start[j] / cell.arm->limits.velocity[j];
      goal[j] = task.goal[j] / cell.arm->limits.velocity[j];
    }
    setup_->setStartAndGoalStates(start, goal);
  }

  Outcome run(double seconds, bool optimal) {
    const double begin = processor_time();
    if (optimal) {
      setup_->setPlanner(std::make_shared<og::BITstar>(setup_->getSpaceInformation()));
    } else {
      setup_->setPlanner(std::make_shared<og::RRTConnect>(setup_->getSpaceInformation()));
    }
    Outcome outcome;
    outcome.solved = setup_->solve(seconds) == ob::PlannerStatus::EXACT_SOLUTION;
    if (outcome.solved) setup_->simplifySolution(1.0);
    outcome.seconds = processor_time() - begin;
    if (!outcome.solved) return outcome;
    std::vector<kinematics::JointVector> points;
    for (const ob::State* state : setup_->getSolutionPath().getStates()) points.push_back(posture(state));
    outcome.length = planning::length_of(points, cell_.arm->limits.velocity);
    space_.relax();
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      outcome.free = outcome.free && space_.is_free_line(points[i], points[i + 1]);
    return outcome;
  }

 private:
  class ProvenMotions final : public ob::MotionValidator {
   public:
    ProvenMotions(PlainOmpl& owner, const ob::SpaceInformationPtr& information)
        : ob::MotionValidator(information), owner_(owner) {}
    bool checkMotion(const ob::State* from, const ob::State* to) const override {
      return owner_.space_.is_free_line(owner_.posture(from), owner_.posture(to));
    }
    bool checkMotion(const ob::State* from, const ob::State* to, std::pair<ob::State*, double>& last) const override {
      if (checkMotion(from, to)) return true;
      if (last.first != nullptr) si_->copyState(last.first, from);
      last.second = 0.0;
      return false;
    }

   private:
    PlainOmpl& owner_;
  };

  [[nodiscard]] kinematics::JointVector posture(const ob::State* state) const {
    kinematics::JointVector q = cell_.arm->limits.velocity;
    for (Eigen::Index j = 0; j < q.size(); ++j) q[j] *= state->as<ob::RealVectorStateSpace::StateType>()->values[j];
    return q;
  }

  const PlanningCell& cell_;
  planning::FreeSpace space_;
  std::unique_ptr<og::SimpleSetup> setup_;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void print_ratios(const char* name, std::vector<double> ratios) {
  const double worst = ratios.empty() ? 0.0 : *std::ranges::max_element(ratios);
  const auto within = std::ranges::count_if(ratios, [](double ratio) { return ratio <= 1.3; });
  std::printf("  %-14s length against the best: p50 %.2f, worst %.2f, within 1.3: %ld of %zu\n", name, median(ratios),
              worst, within, ratios.size());
}

/// A query whose length is compared with that of a long search.
struct Compared {
  PlanningCell::Task task;
  double own = 0.0, best = 0.0;  ///< s, lengths
};

/// The best path that keeps clear: half of the time BIT* with takt's proof of its motions, half of it takt's search
/// again and again with other random numbers.
double best_of_long_search(const PlanningCell& cell, const PlanningCell::Task& task, double seconds) {
  double best = std::numeric_limits<double>::infinity();
  const Outcome optimal = PlainOmpl(cell, task, /*proven=*/true).run(0.5 * seconds, true);
  if (optimal.solved && optimal.free) best = optimal.length;
  const double begin = processor_time();
  for (std::uint64_t seed = 2; processor_time() - begin < 0.5 * seconds; ++seed) {
    const Outcome again = with_takt(cell, task, planning::Query().looks, seed);
    if (again.solved) best = std::min(best, again.length);
  }
  return best;
}

/// All processors work, each on a query of its own.
void search_long(const PlanningCell& cell, std::vector<Compared>& compared, double seconds) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < compared.size(); i = next++)
      compared[i].best = std::min(compared[i].best, best_of_long_search(cell, compared[i].task, seconds));
  };
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) workers.emplace_back(work);
}

void measure(const char* name, PlanningCell::Kind kind, int queries, double long_search) {
  PlanningCell cell(kind);
  Random random(17, name);
  Figures own, plain;
  std::vector<Compared> compared;
  for (int i = 0; i < queries; ++i) {
    const PlanningCell::Task task = cell.draw(random);
    own.outcomes.push_back(with_takt(cell, task, planning::Query().looks));
    plain.outcomes.push_back(PlainOmpl(cell, task).run(1.0, false));
    const Outcome &ours = own.outcomes.back(), &theirs = plain.outcomes.back();
    if (!ours.solved) continue;
    const bool counts = theirs.solved && theirs.free;
    compared.push_back({task, ours.length, counts ? std::min(ours.length, theirs.length) : ours.length});
  }
  std::printf("%s\n", name);
  own.print("takt");
  plain.print("plain OMPL");
  if (long_search > 0.0) {
    search_long(cell, compared, long_search);
    std::vector<double> ratios;
    for (const Compared& one : compared) ratios.push_back(one.own / one.best);
    print_ratios("takt", ratios);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace takt

int main(int argc, char** argv) {
  ompl::msg::noOutputHandler();
  ompl::RNG::setSeed(1);
  const int queries = argc > 1 ? std::atoi(argv[1]) : 100;
  const double long_search = argc > 2 ? std::atof(argv[2]) : 0.0;
  const std::string wanted = argc > 3 ? argv[3] : "";
  using Kind = takt::test::PlanningCell::Kind;
  for (const auto& [name, kind] : {std::pair("in a shelf", Kind::kShelf), std::pair("between two arms", Kind::kTwoArms),
                                   std::pair("out of a container", Kind::kContainer)})
    if (std::string(name).find(wanted) != std::string::npos) takt::measure(name, kind, queries, long_search);
}
