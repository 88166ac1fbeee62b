#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt::motion {

/// Where a law is at one instant: path parameter and its derivatives with respect to path time tau.
struct LawPoint {
  double s = 0.0;     ///< 0 at the start of the path, 1 at its end
  double ds = 0.0;    ///< 1/s
  double dds = 0.0;   ///< 1/s^2
  double ddds = 0.0;  ///< 1/s^3
};

/// `from` carried on for `t` seconds with its own third derivative. Realtime: cyclic.
[[nodiscard]] LawPoint advanced(const LawPoint& from, double t);

/// Bounds on the derivatives of the path parameter, all > 0: 1/s, 1/s^2, 1/s^3.
struct RateLimits {
  double velocity = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
};

/// The law s(tau) by which a path is run: pieces of constant jerk, from s = 0 to rest at s = 1. It begins at rest, or
/// in motion where it goes on from another law. The default is the law of a path without length: duration 0, always at
/// its end. As JSON: [[duration_s, jerk], ...], in motion {"begin": [ds, dds], "pieces": [[duration_s, jerk], ...]};
/// the same numbers give the same bits.
class TimeLaw {
 public:
  struct Segment {
    double duration_s;  ///< >= 0
    double jerk;        ///< 1/s^3
  };

  TimeLaw() = default;

  /// Speed with which a law begins.
  struct Begin {
    double ds = 0.0;   ///< 1/s, >= 0
    double dds = 0.0;  ///< 1/s^2
  };
  /// @return the law, or diagnostics: an entry that is not finite, a negative duration, an end that is not at rest at
  /// s = 1 (within 1e-9 of what the law reaches). No segments = duration 0. Realtime: setup.
  [[nodiscard]] static Result<TimeLaw> create(std::vector<Segment> segments) { return create(std::move(segments), {}); }
  [[nodiscard]] static Result<TimeLaw> create(std::vector<Segment> segments, const Begin& begin);

  /// The fastest law from rest to rest within the limits: at most seven segments, closed form. Limits must be > 0;
  /// infinite ones do not bind, but one must. Realtime: setup.
  /// Source: own derivation; the order of cases as in Lambrechts et al., "Trajectory planning and feedforward design",
  /// 2005.
  [[nodiscard]] static TimeLaw rest_to_rest(const RateLimits& limits);

  /// The same shape, `factor` (> 0) times as long: rates shrink by factor, factor^2, factor^3. Realtime: setup.
  [[nodiscard]] TimeLaw stretched(double factor) const;

  [[nodiscard]] double duration() const { return knots_.empty() ? 0.0 : knots_.back().tau; }
  [[nodiscard]] const std::vector<Segment>& segments() const { return segments_; }

  /// The rest of the law from `tau` (s) on, over what is left of the path: its s runs from 0 to 1 again. At or behind
  /// the end the default law. Realtime: setup.
  [[nodiscard]] TimeLaw rest_from(double tau) const;

  /// The pieces between two times (s). Realtime: setup.
  [[nodiscard]] std::vector<Segment> segments_between(double from, double to) const;

  [[nodiscard]] const Begin& begin() const { return begin_; }
  /// It does not begin at rest.
  [[nodiscard]] bool begins_in_motion() const { return begin_.ds != 0.0 || begin_.dds != 0.0; }

  /// The law at `tau` (s): at rest at s = 0 before the start, at rest at exactly s = 1 from duration() on; a law
  /// without segments is always at its end. Realtime: cyclic, O(log segments), no allocation.
  [[nodiscard]] LawPoint at(double tau) const;

 private:
  struct Knot {
    double tau;
    LawPoint point;  ///< with the jerk of the segment that begins here
  };

  TimeLaw(std::vector<Segment> segments, const Begin& begin);

  Begin begin_;
  std::vector<Segment> segments_;
  std::vector<Knot> knots_;  ///< start of each segment, then the end
};

[[nodiscard]] nlohmann::ordered_json to_json(const TimeLaw& law);
/// Diagnostics carry `pointer` as prefix. Realtime: setup.
[[nodiscard]] Result<TimeLaw> time_law_from_json(const nlohmann::ordered_json& json, const std::string& pointer = {});

}  // namespace takt::motion
