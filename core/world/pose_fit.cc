#include "core/world/pose_fit.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace takt::world {
namespace {

constexpr std::array<const char*, 6> kCoordinateNames{"x", "y", "z", "roll", "pitch", "yaw"};
/// Weighs rotations against translations: an object of about this size turns by 1 rad as it shifts by this, m.
constexpr double kLength = 0.1;

/// The problem in scaled coordinates: m for translations, kLength * rad for rotations.
class Problem {
 public:
  Problem(const Object& object, const std::vector<Contact>& contacts, const Eigen::Isometry3d& nominal,
          const std::vector<Coordinate>& free)
      : object_(object), contacts_(contacts), nominal_(nominal), free_(free) {}

  [[nodiscard]] Eigen::Isometry3d pose(const Eigen::VectorXd& x) const {
    Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index i = 0; i < x.size(); ++i) step[static_cast<int>(free_[static_cast<std::size_t>(i)])] = x[i];
    const Eigen::Vector3d turn = step.tail<3>() / kLength;
    Eigen::Isometry3d X = nominal_;
    X.translation() += step.head<3>();
    if (turn.norm() > 0.0) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * nominal_.linear();
    return X;
  }

  [[nodiscard]] Eigen::VectorXd residuals(const Eigen::VectorXd& x) const {
    const Eigen::Isometry3d X_OR = pose(x).inverse();
    Eigen::VectorXd r(static_cast<Eigen::Index>(contacts_.size()));
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      r[static_cast<Eigen::Index>(i)] = signed_distance(object_, X_OR * contacts_[i].p_R) - contacts_[i].radius;
    }
    return r;
  }

  [[nodiscard]] Eigen::MatrixXd jacobian(const Eigen::VectorXd& x) const {
    constexpr double kStep = 1e-7;  // m: far above rounding (1e-16), far below the curvature of real parts
    Eigen::MatrixXd J(static_cast<Eigen::Index>(contacts_.size()), x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      Eigen::VectorXd ahead = x, behind = x;
      ahead[i] += kStep;
      behind[i] -= kStep;
      J.col(i) = (residuals(ahead) - residuals(behind)) / (2 * kStep);
    }
    return J;
  }

 private:
  const Object& object_;
  const std::vector<Contact>& contacts_;
  const Eigen::Isometry3d& nominal_;
  const std::vector<Coordinate>& free_;
};

/// The coordinate that the contacts leave free, as text; empty if they determine all.
std::string undetermined(const Eigen::MatrixXd& J, const std::vector<Coordinate>& free) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(J.transpose() * J);
  constexpr double kSmallest = 1e-4;  // 1 = one contact straight along the coordinate
  if (eigen.eigenvalues()[0] > kSmallest) return {};
  Eigen::Index worst = 0;
  eigen.eigenvectors().col(0).cwiseAbs().maxCoeff(&worst);
  return kCoordinateNames[static_cast<std::size_t>(free[static_cast<std::size_t>(worst)])];
}

}  // namespace

Result<PoseFit> fit_pose(const Object& object, const std::vector<Contact>& contacts,
                         const Eigen::Isometry3d& X_RO_nominal, const std::vector<Coordinate>& free,
                         double max_residual) {
  if (contacts.size() < free.size()) {
    return failure(
        Code::kWrongSize, {},
        fmt::format("{} contacts for {} free coordinates of '{}'", contacts.size(), free.size(), object.name),
        "Use at least one contact a coordinate");
  }
  const Problem problem(object, contacts, X_RO_nominal, free);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
  Eigen::VectorXd r = problem.residuals(x);
  PoseFit fit;
  double damping = 1e-6;
  for (; fit.iterations < 200; ++fit.iterations) {
    const Eigen::MatrixXd J = problem.jacobian(x);
    const Eigen::MatrixXd H = J.transpose() * J;
    const Eigen::MatrixXd damped = H + damping * Eigen::MatrixXd::Identity(H.rows(), H.cols());
    const Eigen::VectorXd step = damped.ldlt().solve(-J.transpose() * r);
    const Eigen::VectorXd next = problem.residuals(x + step);
    if (next.squaredNorm() <= r.squaredNorm()) {
      x += step;
      r = next;
      damping = std::max(damping * 0.1, 1e-12);
      if (step.norm() < 1e-12) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  if (const std::string name = undetermined(problem.jacobian(x), free); !name.empty()) {
    return failure(Code::kNoContact, {}, fmt::format("the contacts do not determine '{}' of '{}'", name, object.name),
                   "Touch a face that this coordinate moves, or take it out of the free ones");
  }
  fit.X_RO = problem.pose(x);
  fit.rms_residual = contacts.empty() ? 0.0 : std::sqrt(r.squaredNorm() / static_cast<double>(contacts.size()));
  if (fit.rms_residual > max_residual) {
    return failure(Code::kNoContact, {},
                   fmt::format("the best pose of '{}' misses the contacts by {:.3g} mm (rms)", object.name,
                               1e3 * fit.rms_residual),
                   fmt::format("Touch again so that it misses by at most {:.3g} mm, or check which faces were touched",
                               1e3 * max_residual));
  }
  return fit;
}

}  // namespace takt::world
