#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/device/servo.h"
#include "core/net/value.h"

namespace takt::primitives {

/// A second-order low pass, by backward differences: stable for any figures.
struct ServoLowPass {
  double value = 0.0, rate = 0.0;

  void begin(double at) { *this = {.value = at}; }
  void update(double input, double frequency, double damping_ratio, double h) {
    const double stiffness = h * frequency * frequency;
    rate = (rate + stiffness * (input - value)) / (1.0 + 2.0 * h * damping_ratio * frequency + h * stiffness);
    value += h * rate;
  }
};

/// How a surface comes and goes under a tool that slides: its tilt and curvature along the path, from what the tool was
/// told to do and what became of its force (docs/force-control.md, "Surfaces that come and go"). Realtime: cyclic.
class SurfaceObserver {
 public:
  using Vector = net::Vector;

  /// 1/s, both poles, of a surface that is not known yet: an arm has to be as fast.
  static constexpr double kFastest = 30.0;

  /// Nothing is known of a surface, and nothing has moved.
  void begin() {
    past_.fill({});
    tilt_.setZero();
    curvature_ = 0.0;
    ahead_.setZero();
    known_for_ = edge_for_ = smooth_for_ = 0.0;
  }
  /// The tool meets the surface, perhaps again. @param force  that is felt now, N
  void meet(double force) { felt_.begin(force); }
  /// In each cycle without contact: what was known counts less and less.
  void fade(double h) {
    const double keep = std::max(0.0, 1.0 - h / kFade_s);
    tilt_ *= keep;
    curvature_ *= keep;
    known_for_ = 0.0;
  }
  /// In each cycle, what has moved since the last one. @param velocity  along the direction, m/s  @param path  of the
  /// path, m/s
  void move(double velocity, const Vector& path) {
    newest_ = (newest_ + 1) % past_.size();
    past_[newest_] = {.velocity = velocity, .path = path};
  }
  /// In each cycle, before the next move(). @param arm  with a stiffness > 0, and kFastest or faster  @param dead_time
  /// from a velocity to its force, s  @param touches  false: nothing is learned
  void feel(double force, const device::ServoResponse& arm, double dead_time, bool touches, double h) {
    felt_.update(force, arm.natural_frequency, arm.damping_ratio, h);
    const double cycles = std::clamp(std::round(dead_time / h), 1.0, static_cast<double>(past_.size()));
    const auto late = static_cast<std::size_t>(cycles);
    const Moment& then = before(late - 1);
    ahead_.setZero();
    for (std::size_t i = 0; i < late; ++i) ahead_ += h * before(i).path;
    const double speed = then.path.norm();
    if (!touches || speed < kRests) return;
    known_for_ += h;
    const double rate = std::min(kFastest, std::max(kRate, kQuick / known_for_));
    const double came = then.velocity - felt_.rate / (kSeries * arm.stiffness);
    const double off = came - tilt_.dot(then.path);
    const double usual = kUsual * speed + kUsualSpeed;
    const bool edge = is_edge(std::abs(off) > usual, speed * h);
    const double error = (edge ? kEdgeShare * std::clamp(off, -usual, usual) : off) / (speed * speed + kSlow * kSlow);
    lean(h * (curvature_ + 2.0 * rate * error) * then.path);
    if (!edge) curvature_ = std::clamp(curvature_ + h * rate * rate * error, -kMostCurved, kMostCurved);
  }
  /// What somebody else has learned of its tilt.
  void lean(const Vector& change) {
    tilt_ += change;
    tilt_ *= std::min(1.0, kSteepest / std::max(tilt_.norm(), kSteepest));
  }
  /// Of the surface along the direction, where the tool is now, m/s.
  [[nodiscard]] double velocity(const Vector& path) const { return (tilt_ + curvature_ * ahead_).dot(path); }

 private:
  static constexpr double kRate = 12.0;  ///< 1/s, both poles, of a surface that is known
  static constexpr double kQuick = 3.0;  ///< in between: over the time for which it is known
  /// A surface that is known comes no faster than it was thought to by this: tilt, and velocity, m/s. What does is an
  /// edge.
  static constexpr double kUsual = 0.05, kUsualSpeed = 1e-3;
  static constexpr double kEdgeShare = 0.3;    ///< of that is learned at an edge
  static constexpr double kEdge = 8e-3;        ///< m: what goes on for so long is another surface and no edge
  static constexpr double kKnown_s = 0.05;     ///< before nothing is an edge
  static constexpr double kFade_s = 0.2;       ///< without contact
  static constexpr double kSeries = 0.6;       ///< stiffness of arm and surface over the arm's: between hard and soft
  static constexpr double kRests = 1e-3;       ///< m/s: a path that is slower shows nothing of a tilt
  static constexpr double kSlow = 2e-3;        ///< m/s: from here on a path shows it well
  static constexpr double kSteepest = 1.0;     ///< tilt, m/m: 45 degrees
  static constexpr double kMostCurved = 30.0;  ///< 1/m

  struct Moment {
    double velocity = 0.0;
    Vector path = Vector::Zero();
  };
  /// @param cycles  0: the newest
  [[nodiscard]] const Moment& before(std::size_t cycles) const {
    return past_[(newest_ + past_.size() - cycles) % past_.size()];
  }
  /// @param way  since the last look, m
  bool is_edge(bool unusual, double way) {
    if (!unusual || known_for_ <= kKnown_s) {
      smooth_for_ += way;
      if (smooth_for_ > kEdge) edge_for_ = 0.0;
      return false;
    }
    edge_for_ += way;
    smooth_for_ = 0.0;
    if (edge_for_ > kEdge) known_for_ = edge_for_ = 0.0;
    return true;
  }

  std::array<Moment, 64> past_{};
  std::size_t newest_ = 0;
  ServoLowPass felt_;                         ///< force, through the arm's own low pass
  Vector tilt_ = Vector::Zero();              ///< height of the surface over the way along the path, a dead time ago
  double curvature_ = 0.0;                    ///< 1/m: how the tilt changes along the path
  Vector ahead_ = Vector::Zero();             ///< m, the way along the path since then
  double known_for_ = 0.0;                    ///< s, in contact
  double edge_for_ = 0.0, smooth_for_ = 0.0;  ///< m
};

}  // namespace takt::primitives
