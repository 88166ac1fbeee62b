#include "core/kinematics/solutions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/base/random.h"
#include "core/kinematics/closed_form.h"
#include "core/kinematics/pose_error.h"

namespace takt::kinematics {
namespace {

constexpr double kPi = std::numbers::pi;
/// Seeds per held value, and for the search with all joints free: enough that on the arms of the tests no branch and
/// no pose was missed.
constexpr int kSeeds = 60;
constexpr int kFreeSeeds = 400;
/// The last resort where a closed form has found nothing: mostly, the pose is out of reach.
constexpr int kLastSeeds = 20;
constexpr int kHeldGrid = 16;
constexpr int kFineGrid = 720;
constexpr int kMaxIterations = 60;
constexpr double kMaxStep = 0.6;    // rad: a damped step further than this trusts the linear picture too far
constexpr double kDistinct = 1e-5;  // rad or m: two results nearer than this are one solution

class Search {
 public:
  Search(const Chain& chain, const Eigen::Isometry3d& X_BF, const SolutionOptions& options)
      : chain_(chain), target_(X_BF), options_(options), n_(chain.joint_count()) {
    tolerance_ = 1e-12 * std::max(1.0, chain.reach());
    length_ = std::max(chain.reach(), 1e-3);
    reference_ = options.reference.size() == n_ ? options.reference : middle();
  }

  std::vector<JointVector> run() {
    if (!X_is_finite()) return {};
    if (n_ == 6 && options_.closed_form && solve_closed(middle(), {})) {
      // Nothing to search for.
    } else if (n_ == 7) {
      run_seven();
    } else {
      search_free(kFreeSeeds);
    }
    sort_and_cut();
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool X_is_finite() const { return target_.matrix().allFinite(); }
  [[nodiscard]] bool enough() const { return static_cast<int>(found_.size()) >= options_.enough; }

  void run_seven() {
    bool closed = options_.closed_form;
    for (const double value : held_values()) {
      if (enough() || value < chain_.lower()[2] || value > chain_.upper()[2]) continue;
      closed = closed && solve_closed_at(value);
      if (!closed) search_held(value);
    }
    if (!found_.empty() || !options_.held_values.empty()) return;
    // Where the grid found nothing, the third joint is free in a narrow range only, or nowhere.
    for (int k = 0; closed && found_.empty() && k < kFineGrid; ++k) solve_closed_at(grid_value(k, kFineGrid));
    if (found_.empty()) search_free(closed ? kLastSeeds : kFreeSeeds);
  }

  bool solve_closed_at(double value) {
    JointVector q = reference_;
    q[2] = value;
    held_ = 2;
    return solve_closed(q, {2});
  }

  /// @return false if the chain has no closed form.
  bool solve_closed(const JointVector& q_held, const std::vector<int>& held) {
    const auto form = ClosedForm::recognise(chain_, q_held, held);
    if (!form) return false;
    for (const JointVector& candidate : form->solve(target_)) try_seed(candidate);
    return true;
  }

  // --- seeds -------------------------------------------------------------------------------------------------------

  /// The part of a joint's range where seeds are drawn: one turn of a revolute joint is all there is.
  [[nodiscard]] double low(int i) const { return std::max(chain_.lower()[i], chain_.is_prismatic(i) ? -10.0 : -kPi); }
  [[nodiscard]] double high(int i) const { return std::min(chain_.upper()[i], chain_.is_prismatic(i) ? 10.0 : kPi); }

  [[nodiscard]] JointVector middle() const {
    JointVector q(n_);
    for (int i = 0; i < n_; ++i) q[i] = 0.5 * (low(i) + high(i));
    return q;
  }

  [[nodiscard]] std::vector<double> held_values() const {
    if (!options_.held_values.empty()) return options_.held_values;
    std::vector<double> values{reference_[2]};
    for (int k = 0; k < kHeldGrid; ++k) values.push_back(grid_value(k, kHeldGrid));
    return values;
  }

  [[nodiscard]] double grid_value(int k, int count) const { return low(2) + (high(2) - low(2)) * (k + 0.5) / count; }

  void search_held(double value) {
    held_ = 2;
    Random random(1, "held");
    for (int k = 0; k <= kSeeds && !enough(); ++k) {
      JointVector q = seed(k, random);
      q[2] = value;
      try_seed(q);
    }
  }

  void search_free(int seeds) {
    held_ = -1;
    Random random(1, "free");
    for (int k = 0; k <= seeds && !enough(); ++k) {
      // A redundant arm has solutions everywhere: the first few stand for all.
      if (n_ > 6 && static_cast<int>(found_.size()) >= 16) return;
      try_seed(seed(k, random));
    }
  }

  [[nodiscard]] JointVector seed(int k, Random& random) const {
    if (k == 0) return reference_;
    JointVector q(n_);
    for (int i = 0; i < n_; ++i) q[i] = random.uniform(low(i), high(i));
    return q;
  }

  // --- one seed ----------------------------------------------------------------------------------------------------

  void try_seed(JointVector q) {
    if (!converge(q)) return;
    for (int i = 0; i < n_; ++i) {
      if (!chain_.is_prismatic(i) && i != held_) q[i] = std::remainder(q[i], 2.0 * kPi);
    }
    if (pose_error(chain_.forward(q), target_).cwiseAbs().maxCoeff() > 1e-9) return;
    add_turns(q, 0);
  }

  /// Adds q with every turn of the joints from `i` on that fits the limits.
  void add_turns(const JointVector& q, int i) {
    if (i == n_) return add(q);
    const bool turns = !chain_.is_prismatic(i) && i != held_ && std::isfinite(chain_.lower()[i]);
    JointVector turned = q;
    for (int k = turns ? -2 : 0; k <= (turns ? 2 : 0); ++k) {
      turned[i] = q[i] + k * 2.0 * kPi;
      if (turned[i] >= chain_.lower()[i] && turned[i] <= chain_.upper()[i]) add_turns(turned, i + 1);
    }
  }

  void add(const JointVector& q) {
    const bool known = std::any_of(found_.begin(), found_.end(), [&](const JointVector& other) {
      return (other - q).cwiseAbs().maxCoeff() < kDistinct;
    });
    if (!known && !enough()) found_.push_back(q);
  }

  /// Damped Newton: the damping follows the residual, so that the end is quadratic, and grows where a step did not
  /// help. All joints but the held one move; with more than six of them the step is the shortest one.
  bool converge(JointVector& q) const {
    Eigen::Isometry3d X;
    Jacobian J;
    chain_.jacobian(q, X, J);
    Vector6 error = weighted(pose_error(X, target_));
    double damping = 1e-2;
    for (int k = 0; k < kMaxIterations; ++k) {
      if (error.head<3>().cwiseAbs().maxCoeff() * length_ <= tolerance_ &&
          error.tail<3>().cwiseAbs().maxCoeff() <= 1e-12)
        return true;
      const JointVector next = clamped(q + step(J, error, damping * error.squaredNorm()));
      Eigen::Isometry3d X_next;
      Jacobian J_next;
      chain_.jacobian(next, X_next, J_next);
      const Vector6 error_next = weighted(pose_error(X_next, target_));
      const bool better = error_next.squaredNorm() < error.squaredNorm();
      damping = std::clamp(better ? damping * 0.2 : damping * 8.0, 1e-6, 1e6);
      if (!better && damping >= 1e6) return false;
      if (!better) continue;
      q = next;
      J = J_next;
      error = error_next;
    }
    return false;
  }

  [[nodiscard]] JointVector step(Jacobian J, const Vector6& error, double damping) const {
    J.topRows<3>() *= 1.0 / length_;
    if (held_ >= 0) J.col(held_).setZero();
    Eigen::Matrix<double, 6, 6> square = J.lazyProduct(J.transpose());
    square.diagonal().array() += damping + 1e-30;
    JointVector delta = J.transpose().lazyProduct(Vector6(square.ldlt().solve(error)));
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kMaxStep) delta *= kMaxStep / longest;
    return delta;
  }

  /// A redundant arm is kept inside its limits on the way; six joints have isolated solutions, which are judged after.
  [[nodiscard]] JointVector clamped(JointVector q) const {
    if (n_ == 6 || held_ >= 0) return q;
    for (int i = 0; i < n_; ++i) q[i] = std::clamp(q[i], chain_.lower()[i], chain_.upper()[i]);
    return q;
  }

  [[nodiscard]] Vector6 weighted(Vector6 error) const {
    error.head<3>() *= 1.0 / length_;
    return error;
  }

  void sort_and_cut() {
    std::stable_sort(found_.begin(), found_.end(), [&](const JointVector& a, const JointVector& b) {
      return (a - reference_).squaredNorm() < (b - reference_).squaredNorm();
    });
    if (static_cast<int>(found_.size()) > options_.most) found_.resize(static_cast<std::size_t>(options_.most));
  }

  const Chain& chain_;
  const Eigen::Isometry3d target_;
  const SolutionOptions& options_;
  const int n_;
  int held_ = -1;
  double tolerance_ = 1e-12;
  double length_ = 1.0;
  JointVector reference_;
  std::vector<JointVector> found_;
};

}  // namespace

std::vector<JointVector> inverse_solutions(const Chain& chain, const Eigen::Isometry3d& X_BF,
                                           const SolutionOptions& options) {
  return Search(chain, X_BF, options).run();
}

}  // namespace takt::kinematics
