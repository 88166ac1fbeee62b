#include "cell/judge/pair_expectations.h"
#include "cell/file/degrees.h"
#include "cell/judge/true_poses.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace takt::cell {
namespace {

class RelativePoseExpectation final : public Expectation {
 public:
  RelativePoseExpectation(ObjectReader& reader, const BuiltCell& built,
                          const std::optional<std::vector<std::string>>& steps)
      : arms_(reader.texts("arms")),
        from_(steps ? reader.choice("from", *steps) : reader.text("from")),
        to_(steps ? reader.choice("to", *steps) : reader.text("to")),
        within_m_(reader.number("position_within_m", {}, kPositive)),
        within_rad_(kDegree * reader.number("angle_within_deg", 180.0, kPositive)) {
    std::vector<std::string> known;
    for (const auto& [name, arm] : built.cell.arms) known.push_back(name);
    if (arms_.size() != 2 || arms_[0] == arms_[1]) {
      reader.diagnostics().error(Code::kWrongSize, reader.at("arms"), "not the names of two arms",
                                 fmt::format("Name two of {}", fmt::join(known, ", ")));
      return;
    }
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      if (built.cell.arms.contains(arms_[i])) continue;
      reader.diagnostics().error(Code::kUnknownName, reader.at("arms") + pointer_segment(i),
                                 fmt::format("there is no arm '{}'", arms_[i]), nearest_choice(arms_[i], known));
    }
  }

  void step_begins(std::string_view name) override {
    if (name == to_ && looks_) {
      looks_ = false;
      ++closed_;
    }
    if (name != from_) return;
    looks_ = true;
    X_first_.reset();
  }

  void watch(const BuiltCell& built) override {
    if (!looks_) return;
    const Eigen::Isometry3d X = true_tool(built, arms_[0]).inverse() * true_tool(built, arms_[1]);
    if (!X_first_) X_first_ = X;
    const Eigen::Isometry3d X_off = X_first_->inverse() * X;
    ++cycles_;
    distance_ = std::max(distance_, X_off.translation().norm());
    angle_ = std::max(angle_, Eigen::AngleAxisd(X_off.linear()).angle());
  }

  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    ExpectationResult result;
    if (!looks_ && closed_ == 0) return {.measured = fmt::format("step '{}' never began", from_)};
    if (looks_) return {.measured = fmt::format("step '{}' did not begin after '{}'", to_, from_)};
    if (cycles_ == 0) return {.measured = fmt::format("'{}' began in the same cycle as '{}'", to_, from_)};
    result.passed = distance_ <= within_m_ && angle_ <= within_rad_;
    result.value = distance_;
    result.unit = "m";
    result.upper = within_m_;
    result.measured =
        fmt::format("'{}' to '{}' off by {:.3f} mm (at most {:.3f}) and {:.4f} deg (at most {:.4f})", arms_[1],
                    arms_[0], 1e3 * distance_, 1e3 * within_m_, angle_ / kDegree, within_rad_ / kDegree);
    return result;
  }

 private:
  std::vector<std::string> arms_;
  std::string from_, to_;
  double within_m_, within_rad_;
  bool looks_ = false;
  std::optional<Eigen::Isometry3d> X_first_;
  double distance_ = 0.0, angle_ = 0.0;
  std::int64_t cycles_ = 0, closed_ = 0;  ///< closed: windows
};

}  // namespace

std::unique_ptr<Expectation> relative_pose_expectation(ObjectReader& reader, const BuiltCell& built,
                                                       const std::optional<std::vector<std::string>>& steps) {
  return std::make_unique<RelativePoseExpectation>(reader, built, steps);
}

}  // namespace takt::cell
