// Expectation "seam": what a torch has left on a workpiece, along one of its lines.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cell/judge/expectation_kinds.h"
#include "cell/judge/true_poses.h"
#include "sim/machines/torch.h"

namespace takt::cell {
namespace {

using Eigen::Vector3d;
using Torch = sim::SimTorch;

/// Where an object has its line, in its own frame, arcs as short pieces.
std::vector<Vector3d> line_of(const world::Object& object, const std::string& line) {
  constexpr int kPieces = 32;
  std::vector<Vector3d> points;
  for (int number = 1;; ++number) {
    const std::string name = fmt::format("{}/{}", line, number);
    const auto point = object.grasps.find(name);
    if (point == object.grasps.end()) return points;
    const Vector3d end = point->second.translation();
    if (const auto via = object.grasps.find(name + "/via"); via != object.grasps.end() && !points.empty()) {
      const Vector3d from = points.back(), a = via->second.translation() - from, b = end - from, n = a.cross(b);
      // The circle through three points.
      const Vector3d centre =
          from + (b.squaredNorm() * n.cross(a) - a.squaredNorm() * n.cross(b)).eval() * (1.0 / (2.0 * n.squaredNorm()));
      const Vector3d axis = n.normalized(), radius = from - centre;
      double angle = std::atan2(axis.dot(radius.cross(end - centre)), radius.dot(end - centre));
      if (angle <= 0.0) angle += 2.0 * std::numbers::pi;
      for (int i = 1; i < kPieces; ++i)
        points.push_back(centre + Eigen::AngleAxisd(angle * i / kPieces, axis) * radius);
    }
    points.push_back(end);
  }
}

/// Lengths along a polyline and distances from it.
class Line {
 public:
  explicit Line(std::vector<Vector3d> points) : points_(std::move(points)) {
    for (std::size_t i = 1; i < points_.size(); ++i) length_ += (points_[i] - points_[i - 1]).norm();
  }
  [[nodiscard]] double length() const { return length_; }

  struct Foot {
    double along = 0.0, distance = std::numeric_limits<double>::infinity();  ///< m
  };
  [[nodiscard]] Foot nearest(const Vector3d& p) const {
    Foot best;
    double before = 0.0;
    for (std::size_t i = 1; i < points_.size(); ++i) {
      const Vector3d way = points_[i] - points_[i - 1];
      const double length = way.norm();
      const double t = length > 0.0 ? std::clamp((p - points_[i - 1]).dot(way) / (length * length), 0.0, 1.0) : 0.0;
      const double distance = (p - points_[i - 1] - t * way).norm();
      if (distance < best.distance) best = {before + t * length, distance};
      before += length;
    }
    return best;
  }

 private:
  std::vector<Vector3d> points_;
  double length_ = 0.0;
};

std::vector<std::string> lines_of_object(const BuiltCell& built, const std::string& object) {
  std::vector<std::string> lines;
  const auto found = built.cell.objects.find(object);
  if (found == built.cell.objects.end()) return lines;
  for (const auto& [name, X] : found->second.grasps)
    if (name.ends_with("/1")) lines.push_back(name.substr(0, name.size() - 2));
  return lines;
}

class SeamExpectation final : public Expectation {
 public:
  explicit SeamExpectation(ExpectationReader& from)
      : object_(from.name("object", keys_of(from.built.cell.objects))),
        line_name_(from.name("line", lines_of_object(from.built, object_))),
        within_(from.number("within_m")),
        gap_(from.number("gap_below_m")),
        length_(from.has("length_m") ? std::optional(from.number("length_m")) : std::nullopt),
        length_within_(from.number("length_within_m")),
        speed_(from.numbers("mean_speed_m_s", std::vector<double>{})) {
    if (const auto found = from.built.cell.objects.find(object_); found != from.built.cell.objects.end())
      line_.emplace(line_of(found->second, line_name_));
    for (const auto& [name, tool] : from.built.cell.tools)
      if (const auto* torch = dynamic_cast<const Torch*>(from.built.world->device(name))) torches_.push_back(torch);
    if (line_) done_.resize(1 + static_cast<std::size_t>(std::ceil(line_->length() / kCell_m)), false);
    period_ = to_seconds(from.built.core->period());
    if (torches_.empty())
      from.diagnostics().error(Code::kMissing, from.pointer(), "the cell has no torch", "Add a device of kind torch");
  }

  void watch(const BuiltCell& built) override {
    for (const Torch* torch : torches_) look(*torch, built);
  }

  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    const Seam seam = measure();
    const double wanted = length_.value_or(line_ ? line_->length() : 0.0);
    ExpectationResult result;
    result.value = seam.length;
    result.unit = "m";
    const double mean = time_ > 0.0 ? way_ / time_ : 0.0;
    const bool fast = speed_.size() == 2 && time_ > 0.0 && (mean < speed_[0] || mean > speed_[1]);
    result.passed = std::abs(seam.length - wanted) <= length_within_ && seam.gap < gap_ && farthest_ <= within_ &&
                    !fast && without_gas_ == 0.0 && without_wire_ == 0.0;
    result.measured = fmt::format(
        "{:.1f} mm of {:.1f} mm, largest gap {:.1f} mm (below {:.1f}), {:.2f} mm off at most (at most {:.2f}), {:.2f} "
        "mm/s",
        1e3 * seam.length, 1e3 * wanted, 1e3 * seam.gap, 1e3 * gap_, 1e3 * farthest_, 1e3 * within_, 1e3 * mean);
    if (without_gas_ > 0.0) result.measured += fmt::format(", {:.3f} s without gas", without_gas_);
    if (without_wire_ > 0.0) result.measured += fmt::format(", {:.3f} s without wire", without_wire_);
    return result;
  }

 private:
  static constexpr double kCell_m = 0.5e-3;  ///< of what counts as covered
  static constexpr double kMoves_m_s = 1e-4;

  struct Seam {
    double length = 0.0, gap = 0.0;  ///< m
  };
  /// From the first place to the last; the gap between two.
  [[nodiscard]] Seam measure() const {
    const auto first = std::ranges::find(done_, true);
    if (first == done_.end()) return {};
    std::size_t last = 0, run = 0, longest = 0;
    for (std::size_t i = static_cast<std::size_t>(first - done_.begin()); i < done_.size(); ++i) {
      run = done_[i] ? 0 : run + 1;
      if (!done_[i]) continue;
      last = i;
    }
    run = 0;
    for (std::size_t i = static_cast<std::size_t>(first - done_.begin()); i <= last; ++i) {
      run = done_[i] ? 0 : run + 1;
      longest = std::max(longest, run);
    }
    const auto cells = last - static_cast<std::size_t>(first - done_.begin());
    return {.length = kCell_m * static_cast<double>(cells), .gap = kCell_m * static_cast<double>(longest)};
  }

  void look(const Torch& torch, const BuiltCell& built) {
    const Torch::Spot& spot = torch.spot();
    if (!spot.burns || spot.body < 0 || !line_) return forget();
    // In the frame of the object, wherever that truly is: a fixed one is a part of the world.
    const sim::Pose X_WB = built.world->body_pose(spot.body);
    const Vector3d p_O = true_pose(built, object_).inverse() * (X_WB * spot.p_B);
    const Line::Foot foot = line_->nearest(p_O);
    if (foot.distance > kElsewhere_m) return forget();
    farthest_ = std::max(farthest_, foot.distance);
    if (!spot.gas) without_gas_ += period_;
    if (!spot.wire) without_wire_ += period_;
    if (before_) {
      cover(std::min(foot.along, before_->along), std::max(foot.along, before_->along));
      if ((p_O - before_->p_O).norm() > kMoves_m_s * period_) {  // not while a crater is filled
        way_ += foot.along - before_->along;                     // a swing is no way
        time_ += period_;
      }
    }
    before_ = {p_O, foot.along};
  }
  void forget() { before_.reset(); }
  void cover(double from, double to) {
    const auto begin = static_cast<std::size_t>(from / kCell_m), end = static_cast<std::size_t>(to / kCell_m);
    for (std::size_t i = begin; i <= end && i < done_.size(); ++i) done_[i] = true;
  }

  static constexpr double kElsewhere_m = 0.02;  ///< the arc is on another line

  std::string object_, line_name_;
  double within_, gap_;
  std::optional<double> length_;
  double length_within_;
  std::vector<double> speed_;
  std::optional<Line> line_;
  std::vector<const Torch*> torches_;
  std::vector<bool> done_;
  struct Place {
    Vector3d p_O = Vector3d::Zero();
    double along = 0.0;  ///< m
  };
  std::optional<Place> before_;  ///< in the cycle before
  double farthest_ = 0.0, way_ = 0.0, time_ = 0.0, without_gas_ = 0.0, without_wire_ = 0.0, period_ = 0.0;
};

}  // namespace

ExpectationKind seam_expectation() {
  constexpr Range kLength{.low = 0.0, .high = 100.0, .low_open = true};
  return expectation_kind<SeamExpectation>(
      "seam",
      {"A line of a workpiece is welded: the arc has burned all along it, with gas and wire.",
       {text_key("object", "Workpiece with lines.", 1), text_key("line", "Which of its lines.", 1),
        number_key("length_m", "m", kLength, "From the first place at which the arc burned to the last.")
            .optional("that of the line"),
        number_key("length_within_m", "m", kLength, "How far the length may be off.").by_default(0.002),
        number_key("gap_below_m", "m", kLength, "No part of it that is so long was left out.").by_default(0.002),
        number_key("within_m", "m", kLength, "Largest distance of the arc from the line.").by_default(0.001),
        numbers_key("mean_speed_m_s", 2, "m/s", kNotNegative, "Least and largest mean speed along the line.")
            .optional("any")}});
}

}  // namespace takt::cell
