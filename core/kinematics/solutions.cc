#include "core/kinematics/solutions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/base/random.h"
#include "core/kinematics/arm_angle.h"
#include "core/kinematics/closed_form.h"
#include "core/kinematics/elimination.h"
#include "core/kinematics/joint_range.h"
#include "core/kinematics/pose_error.h"

namespace takt::kinematics {
namespace {

constexpr double kPi = std::numbers::pi;
/// Seeds per held value, and for the search with all joints free: enough that on the arms of the tests no branch and
/// no pose was missed.
constexpr int kSolutionSeeds = 60;
constexpr int kFreeSeeds = 400;
/// The last resort where a closed form has found nothing: mostly, the pose is out of reach.
constexpr int kLastSeeds = 20;
/// Openings of the loop in a row that bring no new branch before elimination counts as complete.
constexpr int kIdleOpenings = 4;
constexpr int kMostOpenings = 24;
constexpr std::array<double, 3> kTilts = {1e-3, 0.0, 1e-2};  // rad and shares of the arm's length, in turn
constexpr int kHeldGrid = 16;
constexpr int kFineGrid = 720;
constexpr int kMaxIterations = 60;
constexpr double kSolutionMaxStep = 0.6;  // rad: a damped step further than this trusts the linear picture too far
constexpr int kThird = 2;                 // the joint of seven that a human elbow is moved by
constexpr double kMet = 1e-9;             // m and rad by which a solution may be off
constexpr double kNear = 0.02;            // m and rad: from there another beginning may get to the pose
constexpr int kEnds = 6, kStations = 48, kHalvings = 40;
constexpr std::size_t kAround = 10;
constexpr double kAroundBy = 0.2;            // rad or m
constexpr double kStationStep = kPi / 12.0;  // rad or m
constexpr double kDistinct = 1e-5;           // rad or m: two results nearer than this are one solution

class Search {
 public:
  Search(const Chain& chain, const Eigen::Isometry3d& X_BF, const SolutionOptions& options)
      : chain_(chain), target_(X_BF), options_(options), n_(chain.joint_count()) {
    tolerance_ = 1e-12 * std::max(1.0, chain.reach());
    length_ = std::max(chain.reach(), 1e-3);
    reference_ = options.reference.size() == n_ ? options.reference : middle();
    found_.reserve(8);
    branches_.reserve(8);
  }

  std::vector<JointVector> run() {
    if (!X_is_finite()) return {};
    if (!options_.arm_angles.empty()) {
      run_arm_angles();
    } else if (n_ == 7) {
      run_seven();
    } else if (n_ != 6 || !options_.closed_form || !solve_six(middle(), {})) {
      search_free(kFreeSeeds);
    }
    branches_.clear();
    for (std::size_t i = 0; i < rough_.size() && (i > 0 || found_.empty()); ++i) take(rough_[i]);
    sort_and_cut();
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool X_is_finite() const { return target_.matrix().allFinite(); }
  [[nodiscard]] bool enough() const { return static_cast<int>(found_.size()) >= options_.enough; }

  void run_arm_angles() {
    const auto arm = ArmAngle::recognise(chain_);
    if (!arm) return;
    held_ = -1;
    for (const double angle : options_.arm_angles) {
      branches_.clear();
      for (const JointVector& candidate : arm->solve(target_, angle)) try_seed(candidate);
    }
  }

  void run_seven() {
    // Most arms are those of the third joint, and then what is recognised here is what the first value is solved with.
    redundant_ = options_.held_joint >= 0 ? options_.held_joint : kThird;
    bool closed = options_.closed_form;
    const bool chosen = options_.held_joint >= 0 || (closed && recognise_at(held_values().front()));
    if (!chosen) redundant_ = redundant_joint(chain_);
    for (const double value : held_values()) {
      if (enough() || !inside(redundant_, value)) continue;
      const double held = into_range(value, chain_.lower()[redundant_], chain_.upper()[redundant_]);
      closed = closed && solve_six_at(held);
      if (!closed) search_held(held);
    }
    if (!found_.empty() || !options_.held_values.empty()) return;
    // Where the grid found nothing, the held joint is free in a narrow range only, or nowhere.
    const bool quick = closed && closed_form_;
    for (int k = 0; quick && found_.empty() && k < kFineGrid; ++k) solve_six_at(grid_value(k, kFineGrid));
    if (found_.empty()) search_free(quick ? kLastSeeds : kFreeSeeds);
  }

  /// Whether six have a closed form with the redundant joint there; the form is kept for who solves there next.
  bool recognise_at(double value) {
    JointVector q = reference_;
    q[redundant_] = value;
    form_ = ClosedForm::recognise(chain_, q, {redundant_});
    form_at_ = value;
    return form_.has_value();
  }

  bool solve_six_at(double value) {
    JointVector q = reference_;
    q[redundant_] = value;
    held_ = redundant_;
    branches_.clear();
    return solve_six(q, {redundant_});
  }

  /// All solutions with the held joints at their values. @return false if a free joint slides.
  bool solve_six(const JointVector& q_held, const std::vector<int>& held) {
    const std::size_t before = found_.size();
    ends_.clear();
    if (!solve_candidates(q_held, held)) return false;
    if (found_.size() > before) return true;
    // In a singular posture two joints share an angle, and the share that a closed form takes may be outside the
    // limits: the reference may know one inside.
    JointVector q = reference_;
    for (const int i : held) q[i] = q_held[i];
    branches_.clear();
    try_seed(q);
    if (found_.size() > before) return true;
    if (form_) try_form(kAlmost);
    const bool beside = found_.size() == before && rough_.empty() && !ends_.empty() && besides_ > 0;
    besides_ -= beside ? 1 : 0;
    if (beside) search_beside();
    return true;
  }

  void try_form(double margin) {
    ClosedForm::Candidates candidates;
    candidates.margin = margin;
    form_->solve(target_, candidates);
    for (int i = 0; i < candidates.count; ++i) try_seed(form_->joints(candidates.angles[static_cast<std::size_t>(i)]));
  }

  bool solve_candidates(const JointVector& q_held, const std::vector<int>& held) {
    const bool known = form_ && n_ == 7 && held.front() == redundant_ && q_held[redundant_] == form_at_;
    if (!known) form_ = ClosedForm::recognise(chain_, q_held, held);
    if (form_) {
      closed_form_ = true;
      if (n_ == 7) form_at_ = q_held[held.front()];
      try_form(kExact);
      return true;
    }
    return solve_any_six(q_held, held);
  }

  /// By elimination, the loop opened at one joint after the other until some openings in a row brought nothing new.
  bool solve_any_six(const JointVector& q_held, const std::vector<int>& held) {
    std::vector<int> free;
    for (int i = 0; i < n_; ++i) {
      const bool is_held = std::find(held.begin(), held.end(), i) != held.end();
      if (!is_held && chain_.is_prismatic(i)) return false;
      if (!is_held) free.push_back(i);
    }
    JointVector zero = q_held;
    for (const int i : free) zero[i] = 0.0;
    Eigen::Isometry3d X_BF_zero;
    const auto all = joint_lines(chain_, zero, &X_BF_zero);
    std::array<Line, 6> lines;
    for (std::size_t i = 0; i < 6; ++i) lines[i] = all[static_cast<std::size_t>(free[i])];
    const Eigen::Isometry3d T = target_ * X_BF_zero.inverse();
    Random random(1, "tilt");
    int idle = 0;
    for (int opening = 0; opening < kMostOpenings && idle < kIdleOpenings; ++opening) {
      const std::size_t before = branches_.size();
      std::vector<std::array<double, 6>> candidates;
      eliminate(tilted(lines, kTilts[static_cast<std::size_t>(opening % 3)], random), T, opening % 6, candidates);
      for (const auto& angles : candidates) {
        JointVector q = zero;
        for (std::size_t i = 0; i < 6; ++i) q[free[i]] = angles[i];
        try_seed(q);
      }
      idle = branches_.size() > before ? 0 : idle + 1;
    }
    return true;
  }

  /// The same axes a little crooked: where two are parallel or meet, the equations of elimination depend on each other;
  /// those of a crooked arm do not, and its solutions are good seeds.
  [[nodiscard]] std::array<Line, 6> tilted(std::array<Line, 6> lines, double by, Random& random) const {
    const auto number = [&] { return random.uniform(-by, by); };
    for (Line& line : lines) {
      line.axis = (line.axis + Eigen::Vector3d(number(), number(), number())).normalized();
      line.point += length_ * Eigen::Vector3d(number(), number(), number());
    }
    return lines;
  }

  // --- seeds -------------------------------------------------------------------------------------------------------

  /// The part of a joint's range where seeds are drawn: one turn of a revolute joint is all there is.
  [[nodiscard]] double low(int i) const { return one_turn(chain_, i).low; }
  [[nodiscard]] double high(int i) const { return one_turn(chain_, i).high; }

  [[nodiscard]] JointVector middle() const {
    JointVector q(n_);
    for (int i = 0; i < n_; ++i) q[i] = 0.5 * (low(i) + high(i));
    return q;
  }

  [[nodiscard]] std::vector<double> held_values() const {
    if (!options_.held_values.empty()) return options_.held_values;
    std::vector<double> values{reference_[redundant_]};
    for (int k = 0; k < kHeldGrid; ++k) values.push_back(grid_value(k, kHeldGrid));
    return values;
  }

  [[nodiscard]] double grid_value(int k, int count) const {
    return low(redundant_) + (high(redundant_) - low(redundant_)) * (k + 0.5) / count;
  }

  void search_held(double value) {
    held_ = redundant_;
    branches_.clear();
    Random random(1, "held");
    for (int k = 0; k <= kSolutionSeeds && !enough(); ++k) {
      JointVector q = seed(k, random);
      q[redundant_] = value;
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

  /// Newton's method may stop beside a singular posture, where the way to the pose begins with a motion that the flange
  /// hardly notices and that is curved. Where it came near, that motion is gone along, and what is left of the way is
  /// followed to where it vanishes.
  void search_beside() {
    std::ranges::stable_sort(ends_, {}, &End::off);
    const std::vector<End> ends(ends_.begin(), ends_.begin() + std::min<std::ptrdiff_t>(kEnds, std::ssize(ends_)));
    const std::size_t before = found_.size();
    for (const End& end : ends)
      if (found_.size() == before) go_along(end.q, before);
    Random random(1, "beside");
    for (std::size_t k = 0; k < kAround * ends.size() && found_.size() == before; ++k) {
      JointVector q = ends[k % ends.size()].q;
      for (int i = 0; i < n_; ++i) q[i] += i == held_ ? 0.0 : random.uniform(-kAroundBy, kAroundBy);
      try_seed(q);
    }
    // Elimination may miss both of two solutions that are about to fall together.
    for (int k = 1; k <= kFreeSeeds && !form_ && !ends.empty() && found_.size() == before; ++k) {
      JointVector q = seed(k, random);
      if (held_ >= 0) q[held_] = ends.front().q[held_];
      try_seed(q);
    }
  }

  void go_along(const JointVector& from, std::size_t before) {
    JointVector turn = unnoticed_turn(from);
    Station older = station(from, turn, Vector6::Zero()), last = older;
    for (int k = 0; k < kStations && found_.size() == before; ++k) {
      const JointVector on = unnoticed_turn(last.q);
      turn = on.dot(turn) < 0.0 ? JointVector(-on) : on;
      const Station next = station(last.q + kStationStep * turn, turn, last.side);
      const bool least = std::abs(last.rest) <= std::min(std::abs(older.rest), std::abs(next.rest));
      if (last.rest * next.rest <= 0.0) {
        halve(last, next);
      } else if (k > 0 && least) {
        settle(older, next);
      }
      older = last;
      last = next;
    }
  }

  /// All joints but one where they come nearest to the pose, and what is left then: it has one direction.
  struct Station {
    JointVector q;
    Vector6 side = Vector6::Zero();  ///< the direction
    double rest = 0.0;               ///< with the sign that continues that of the station before
  };
  [[nodiscard]] Station station(JointVector q, const JointVector& turn, const Vector6& side) {
    Eigen::Index joint = 0;
    turn.cwiseAbs().maxCoeff(&joint);
    pinned_ = static_cast<int>(joint);
    (void)converge(q);
    Eigen::Isometry3d X;
    Jacobian J;
    chain_.jacobian(q, X, J);
    J.topRows<3>() *= 1.0 / length_;
    for (const int i : {held_, pinned_})
      if (i >= 0) J.col(i).setZero();
    pinned_ = -1;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(J.lazyProduct(J.transpose()));
    Station here{q, solver.eigenvectors().col(0), 0.0};
    if (here.side.dot(side) < 0.0) here.side = -here.side;
    here.rest = here.side.dot(weighted(pose_error(X, target_)));
    return here;
  }
  [[nodiscard]] Station between(const Station& a, const Station& b, double share) {
    const JointVector way = b.q - a.q;
    return station(a.q + share * way, way, a.side);
  }

  /// Between two stations whose rests have different signs.
  void halve(Station a, Station b) {
    for (int k = 0; k < kHalvings; ++k) {
      const Station middle = between(a, b, 0.5);
      (middle.rest * a.rest > 0.0 ? a : b) = middle;
    }
    try_seed(a.q);
  }
  /// Between two stations between which the rest may vanish and come back.
  void settle(Station a, Station b) {
    constexpr double kThirdOf = 1.0 / 3.0;
    for (int k = 0; k < kHalvings; ++k) {
      const Station left = between(a, b, kThirdOf), right = between(a, b, 1.0 - kThirdOf);
      if (left.rest * a.rest <= 0.0) return halve(a, left);
      if (right.rest * a.rest <= 0.0) return halve(a, right);
      (std::abs(left.rest) < std::abs(right.rest) ? b : a) = std::abs(left.rest) < std::abs(right.rest) ? right : left;
    }
    try_seed(a.q);
  }

  /// The motion of the joints that moves the flange least, its longest part 1.
  [[nodiscard]] JointVector unnoticed_turn(const JointVector& q) const {
    Eigen::Isometry3d X;
    Jacobian J;
    chain_.jacobian(q, X, J);
    J.topRows<3>() *= 1.0 / length_;
    if (held_ >= 0) J.col(held_).setZero();
    JointMatrix square = J.transpose().lazyProduct(J);
    if (held_ >= 0) square(held_, held_) = square.trace();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((Eigen::MatrixXd(square)));
    const JointVector turn = solver.eigenvectors().col(0);
    return turn / turn.cwiseAbs().maxCoeff();
  }

  // --- one seed ----------------------------------------------------------------------------------------------------

  void try_seed(JointVector q) {
    if (meets(q, 1e-12) || (converge(q) && meets(q, 1e-9))) return take(q);
    if (is_met(q)) rough_.push_back(q);
  }

  /// A solution, with the turns that are wanted.
  void take(JointVector q) {
    for (int i = 0; i < n_; ++i) {
      if (turns(i) && std::abs(q[i]) > kPi) q[i] = std::remainder(q[i], 2.0 * kPi);
    }
    const bool known =
        std::any_of(branches_.begin(), branches_.end(), [&](const JointVector& other) { return are_same(other, q); });
    if (known) return;
    branches_.push_back(q);
    if (options_.turns) {
      add_turns(q, 0);
    } else {
      add_nearest_turn(q);
    }
  }

  [[nodiscard]] bool meets(const JointVector& q, double tolerance) const {
    const Eigen::Isometry3d X = chain_.forward(q);
    const double off = (X.matrix() - target_.matrix()).cwiseAbs().maxCoeff();
    return off <= tolerance * std::max(1.0, chain_.reach());
  }

  /// m or rad, the larger one.
  [[nodiscard]] double distance_at(const JointVector& q) const {
    const Vector6 error = pose_error(chain_.forward(q), target_);
    return std::max(error.head<3>().norm(), error.tail<3>().norm());
  }

  /// Within what a solution may be off; where Newton's method has come to its end before 1e-12, that is what there is:
  /// a pose that was written down may lie some digits out of reach.
  [[nodiscard]] bool is_met(const JointVector& q) {
    const double off = distance_at(q);
    if (off < kNear) ends_.push_back({off, q});
    return off <= kMet;
  }

  [[nodiscard]] bool turns(int i) const { return !chain_.is_prismatic(i) && i != held_; }

  /// But for turns. Two branches mostly differ in the first joints already.
  [[nodiscard]] bool are_same(const JointVector& a, const JointVector& b) const {
    for (int i = 0; i < n_; ++i) {
      double apart = std::abs(a[i] - b[i]);
      if (turns(i) && apart > kPi) apart = std::abs(apart - 2.0 * kPi);
      if (!(apart < kDistinct)) return false;
    }
    return true;
  }

  [[nodiscard]] bool inside(int i, double value) const {
    return is_in_range(value, chain_.lower()[i], chain_.upper()[i]);
  }

  /// Adds q with every turn of the joints from `i` on that fits the limits.
  void add_turns(const JointVector& q, int i) {
    if (i == n_) return add(q);
    const bool more = turns(i) && std::isfinite(chain_.lower()[i]);
    JointVector turned = q;
    if (turns(i) && !more) {  // without limits all turns fit: the nearest stands for them
      turned[i] += 2.0 * kPi * std::round((reference_[i] - q[i]) / (2.0 * kPi));
      return add_turns(turned, i + 1);
    }
    for (int k = more ? -2 : 0; k <= (more ? 2 : 0); ++k) {
      turned[i] = q[i] + k * 2.0 * kPi;
      if (inside(i, turned[i])) add_turns(turned, i + 1);
    }
  }

  /// Adds q once, each joint in the turn nearest to the reference that its limits allow; nothing if one has none.
  void add_nearest_turn(JointVector q) {
    for (int i = 0; i < n_; ++i) {
      if (!turns(i)) {
        if (!inside(i, q[i])) return;
        continue;
      }
      const double apart = q[i] - reference_[i];
      const double nearest = std::abs(apart) <= kPi ? q[i] : q[i] - 2.0 * kPi * std::round(apart / (2.0 * kPi));
      const double side = nearest > reference_[i] ? -2.0 * kPi : 2.0 * kPi;
      const double wanted = inside(i, nearest) ? nearest : nearest + side;
      if (!inside(i, wanted)) return;
      q[i] = wanted;
    }
    add(q);
  }

  /// A joint at an end of its range goes there, as long as the pose is what was written.
  void add(const JointVector& q) {
    if (enough()) return;
    const JointVector inside = into_range(q, chain_.lower(), chain_.upper());
    constexpr double kWritten = 1e-6;  // m and rad: six digits
    if (inside == q || distance_at(inside) <= kWritten) found_.push_back(inside);
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
    if (pinned_ >= 0) J.col(pinned_).setZero();
    if (n_ < 6 || pinned_ >= 0) return short_step(J, error, damping);
    Eigen::Matrix<double, 6, 6> square = J.lazyProduct(J.transpose());
    square.diagonal().array() += damping + 1e-30;
    JointVector delta = J.transpose().lazyProduct(Vector6(square.ldlt().solve(error)));
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kSolutionMaxStep) delta *= kSolutionMaxStep / longest;
    return delta;
  }

  /// Fewer than six joints: the step that comes nearest, by the normal equations of the joints.
  [[nodiscard]] JointVector short_step(const Jacobian& J, const Vector6& error, double damping) const {
    JointMatrix square = J.transpose().lazyProduct(J);
    square.diagonal().array() += damping + 1e-30;
    JointVector delta = square.ldlt().solve(JointVector(J.transpose().lazyProduct(error)));
    const double longest = delta.cwiseAbs().maxCoeff();
    if (longest > kSolutionMaxStep) delta *= kSolutionMaxStep / longest;
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

  /// As many as a closed form gives.
  static constexpr std::size_t kFew = 16;
  [[nodiscard]] std::vector<JointVector>::iterator at(std::size_t i) {
    return found_.begin() + static_cast<std::ptrdiff_t>(i);
  }

  void sort_and_cut() {
    if (found_.size() < 2) return;
    const auto distance = [&](const JointVector& q) { return (q - reference_).squaredNorm(); };
    if (found_.size() <= kFew) {
      // Insertion keeps the order of equals, and each distance is computed once.
      std::array<double, kFew> key;
      for (std::size_t i = 0; i < found_.size(); ++i) {
        const double own = distance(found_[i]);
        std::size_t to = i;
        while (to > 0 && own < key[to - 1]) {
          key[to] = key[to - 1];
          --to;
        }
        key[to] = own;
        if (to < i) std::rotate(at(to), at(i), at(i + 1));
      }
    } else {
      std::stable_sort(found_.begin(), found_.end(),
                       [&](const JointVector& a, const JointVector& b) { return distance(a) < distance(b); });
    }
    if (static_cast<int>(found_.size()) > options_.most) found_.resize(static_cast<std::size_t>(options_.most));
  }

  const Chain& chain_;
  const Eigen::Isometry3d target_;
  const SolutionOptions& options_;
  const int n_;
  int held_ = -1;      ///< the joint that Newton's method may not move, or -1
  int pinned_ = -1;    ///< another one, for a while
  int redundant_ = 2;  ///< the joint of seven that is held
  bool closed_form_ = false;
  std::optional<ClosedForm> form_;     ///< as it was recognised last, ...
  double form_at_ = 0.0;               ///< ... of seven axes with the redundant joint there
  std::vector<JointVector> branches_;  ///< found at the present value of the redundancy, turns apart
  double tolerance_ = 1e-12;
  double length_ = 1.0;
  JointVector reference_;
  struct End {
    double off;  ///< m or rad from the pose
    JointVector q;
  };
  std::vector<JointVector> rough_;  ///< met within kMet only: they count where there is nothing better
  int besides_ = 3;                 ///< values of the redundancy at which search_beside() is worth its time
  std::vector<End> ends_;           ///< where Newton's method ended near the pose
  std::vector<JointVector> found_;
};

}  // namespace

int redundant_joint(const Chain& chain) {
  const JointVector q = JointVector::Constant(chain.joint_count(), 0.1);  // a posture without meaning
  for (const int joint : {2, 6, 5, 4, 3, 1, 0}) {
    if (joint < chain.joint_count() && ClosedForm::recognise(chain, q, {joint})) return joint;
  }
  return 2;
}

std::vector<double> arm_angle_grid(int count) {
  std::vector<double> angles;
  for (int k = 0; k < count; ++k) angles.push_back(-kPi + 2.0 * kPi * (k + 0.5) / count);
  return angles;
}

std::vector<JointVector> inverse_solutions(const Chain& chain, const Eigen::Isometry3d& X_BF,
                                           const SolutionOptions& options) {
  return Search(chain, X_BF, options).run();
}

}  // namespace takt::kinematics
