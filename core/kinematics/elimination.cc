#include "core/kinematics/elimination.h"

#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Dense>

namespace takt::kinematics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector14 = Eigen::Matrix<double, 14, 1>;
using Lines = std::array<Line, 6>;
using Angles = std::array<double, 6>;

/// Each joint counts from an angle of its own, so that no posture that an engineer would choose lies at the half turn
/// where the tangent of half the angle is infinite.
constexpr std::array<double, 6> kZero = {0.43, -0.71, 0.83, -1.37, 2.11, 0.0};

/// A point and a direction: the last axis, which the last joint does not move.
struct Arrow {
  Vector3d p, l;
};

Arrow turned(const Arrow& arrow, const Line& line, double angle) {
  const Matrix3d R = turn(line.axis, angle);
  return {line.point + R * (arrow.p - line.point), R * arrow.l};
}

/// The fourteen numbers of an arrow that are multilinear in the sines and cosines of all joints on its side.
Vector14 numbers(const Arrow& arrow) {
  const auto& [p, l] = arrow;
  Vector14 out;
  out << p, l, p.squaredNorm(), p.dot(l), p.cross(l), p.squaredNorm() * l - 2.0 * p.dot(l) * p;
  return out;
}

/// f = a + b cos x + c sin x from its values at 0, 120 and 240 degrees.
Eigen::Matrix3d trigonometric_fit() {
  const double s = std::sqrt(3.0) / 3.0;
  Eigen::Matrix3d fit;
  fit << 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0,  //
      2.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0,   //
      0.0, s, -s;
  return fit;
}

double sample_angle(int joint, int k) {
  return kZero[static_cast<std::size_t>(joint)] + k * 2.0 * std::numbers::pi / 3;
}

/// One opened loop: turn 3 turn 4 turn 5 (arrow) = turn -2 turn -1 T (arrow).
class Loop {
 public:
  Loop(const Lines& lines, const Eigen::Isometry3d& T) : lines_(lines), T_(T) {
    // Lengths of about one, seen from the second axis.
    double scale = 1e-3;
    for (const Line& line : lines_) scale = std::max(scale, (line.point - lines[1].point).norm());
    const Vector3d origin = lines[1].point;
    for (Line& line : lines_) line.point = (line.point - origin) / scale;
    T_.translation() = (T * origin - origin) / scale;
    tool_ = {lines_[5].point, lines_[5].axis};
  }

  void solve(std::vector<Angles>& found) {
    fit_left();
    fit_right();
    eliminate_two();
    Eigen::Matrix<double, 24, 24> companion;
    if (!make_companion(companion)) return;
    const Eigen::EigenSolver<Eigen::Matrix<double, 24, 24>> roots(companion);
    if (roots.info() != Eigen::Success) return;
    for (int i = 0; i < 24; ++i) {
      const std::complex<double> x3 = roots.eigenvalues()[i];
      // Double roots come out as a pair a little beside the real axis. +-i are not of the arm.
      if (std::abs(x3.imag()) > 2e-2 * (1.0 + std::abs(x3))) continue;
      add(x3.real(), roots.eigenvectors().col(i).real(), found);
    }
  }

 private:
  using Left = Eigen::Matrix<double, 14, 27>;  ///< columns: (1, c3, s3) x (1, c4, s4) x (1, c5, s5)
  using Right = Eigen::Matrix<double, 14, 9>;  ///< columns: (1, c1, s1) x (1, c2, s2)
  using Block = Eigen::Matrix<double, 12, 12>;

  [[nodiscard]] Arrow left(double q3, double q4, double q5) const {
    return turned(turned(turned(tool_, lines_[4], q5), lines_[3], q4), lines_[2], q3);
  }
  [[nodiscard]] Arrow right(double q1, double q2) const {
    const Arrow moved{T_ * tool_.p, T_.linear() * tool_.l};
    return turned(turned(moved, lines_[0], -q1), lines_[1], -q2);
  }

  void fit_left() {
    const Matrix3d fit = trigonometric_fit();
    left_.setZero();
    for (int a = 0; a < 27; ++a) {
      const Vector14 value = numbers(left(sample_angle(2, a / 9), sample_angle(3, a / 3 % 3), sample_angle(4, a % 3)));
      for (int b = 0; b < 27; ++b) {
        left_.col(b) += fit(b / 9, a / 9) * fit(b / 3 % 3, a / 3 % 3) * fit(b % 3, a % 3) * value;
      }
    }
  }

  void fit_right() {
    const Matrix3d fit = trigonometric_fit();
    right_.setZero();
    for (int a = 0; a < 9; ++a) {
      const Vector14 value = numbers(right(sample_angle(0, a / 3), sample_angle(1, a % 3)));
      for (int b = 0; b < 9; ++b) right_.col(b) += fit(b / 3, a / 3) * fit(b % 3, a % 3) * value;
    }
  }

  /// Six combinations of the equations without joints 1 and 2.
  void eliminate_two() {
    const Eigen::Matrix<double, 14, 8> unwanted = right_.rightCols<8>();
    const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 14, 8>> qr(unwanted);
    const Eigen::Matrix<double, 14, 14> Q = qr.householderQ();
    Left moved = left_;
    moved.col(0) -= right_.col(0);
    equations_ = Q.rightCols<6>().transpose() * moved;
  }

  /// The equations at one basis function (1, c3, s3) of joint 3 as polynomials in x4, x5 = tan of half the angle, each
  /// once as it is and once times x4: columns x4^a x5^b, a = 0..3, b = 0..2.
  [[nodiscard]] Block block(int basis) const {
    // (1 + x^2) (1, cos, sin) as polynomials in x.
    static const Matrix3d kHalf = (Matrix3d() << 1, 0, 1, 1, 0, -1, 0, 2, 0).finished();
    Eigen::Matrix<double, 6, 9> plain = Eigen::Matrix<double, 6, 9>::Zero();
    for (int a = 0; a < 9; ++a) {
      for (int b = 0; b < 9; ++b) {
        plain.col(b) += kHalf(a / 3, b / 3) * kHalf(a % 3, b % 3) * equations_.col(9 * basis + a);
      }
    }
    Block whole = Block::Zero();
    whole.topLeftCorner<6, 9>() = plain;
    whole.bottomRightCorner<6, 9>() = plain;
    return whole;
  }

  /// (A x^2 + B x + C) v = 0 as an eigenvalue problem of twice the size.
  [[nodiscard]] bool make_companion(Eigen::Matrix<double, 24, 24>& companion) const {
    const Block one = block(0), cosine = block(1), sine = block(2);
    const Block A = one - cosine, B = 2.0 * sine, C = one + cosine;
    const Eigen::PartialPivLU<Block> lu(A);
    if (!(lu.rcond() > 1e-14)) return false;
    companion.setZero();
    companion.topRightCorner<12, 12>().setIdentity();
    companion.bottomLeftCorner<12, 12>() = -lu.solve(C);
    companion.bottomRightCorner<12, 12>() = -lu.solve(B);
    return companion.allFinite();
  }

  /// Joints 4 and 5 from the eigenvector, 1 and 2 from the equations, 6 from the rest of the rotation.
  void add(double x3, const Eigen::Matrix<double, 24, 1>& vector, std::vector<Angles>& found) const {
    // The lower half of the vector is x3 times the upper one: the longer is the better.
    const Eigen::Matrix<double, 12, 1> v =
        vector.head<12>().squaredNorm() > vector.tail<12>().squaredNorm() ? vector.head<12>() : vector.tail<12>();
    const double x4 = v.tail<9>().dot(v.head<9>()) / v.head<9>().squaredNorm();
    double above = 0.0, below = 0.0;
    for (int a = 0; a < 4; ++a) {
      above += v[3 * a + 1] * v[3 * a] + v[3 * a + 2] * v[3 * a + 1];
      below += v[3 * a] * v[3 * a] + v[3 * a + 1] * v[3 * a + 1];
    }
    const double q3 = kZero[2] + 2.0 * std::atan(x3);
    const double q4 = kZero[3] + 2.0 * std::atan(x4);
    const double q5 = kZero[4] + 2.0 * std::atan2(above, below);
    const Eigen::Matrix<double, 14, 8> unknown = right_.rightCols<8>();
    const Vector14 known = numbers(left(q3, q4, q5)) - right_.col(0);
    const Eigen::Matrix<double, 8, 1> trig = unknown.colPivHouseholderQr().solve(known);
    // Columns: c2, s2, c1, c1 c2, c1 s2, s1, s1 c2, s1 s2.
    const double q1 = kZero[0] + std::atan2(trig[5], trig[2]);
    const double q2 = kZero[1] + std::atan2(trig[1], trig[0]);
    const Matrix3d five = turn(lines_[0].axis, q1) * turn(lines_[1].axis, q2) * turn(lines_[2].axis, q3) *
                          turn(lines_[3].axis, q4) * turn(lines_[4].axis, q5);
    const Vector3d across = tool_.l.unitOrthogonal();
    const double q6 = onto_point(tool_.l, across, five.transpose() * T_.linear() * across);
    const Angles angles{q1, q2, q3, q4, q5, q6};
    for (const double angle : angles) {
      if (!std::isfinite(angle)) return;
    }
    found.push_back(angles);
  }

  Lines lines_;
  Eigen::Isometry3d T_;
  Arrow tool_;
  Left left_;
  Right right_;
  Eigen::Matrix<double, 6, 27> equations_;
};

}  // namespace

void eliminate(const Lines& lines, const Eigen::Isometry3d& T, int first, std::vector<Angles>& found) {
  // turn 1 ... turn 6 = T is the same as turn k+1 ... turn 6 turn' 1 ... turn' k = T with the axes of the first k
  // joints carried by T^-1.
  const auto k = static_cast<std::size_t>(first);
  const Eigen::Isometry3d back = T.inverse();
  Lines opened;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t j = (i + k) % 6;
    opened[i] = i + k < 6 ? lines[j] : Line{back * lines[j].point, back.linear() * lines[j].axis};
  }
  std::vector<Angles> here;
  Loop(opened, T).solve(here);
  for (const Angles& angles : here) {
    Angles ordered;
    for (std::size_t i = 0; i < 6; ++i) ordered[(i + k) % 6] = angles[i];
    found.push_back(ordered);
  }
}

}  // namespace takt::kinematics
