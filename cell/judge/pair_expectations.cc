#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cell/file/degrees.h"
#include "cell/judge/expectation_kinds.h"
#include "cell/judge/true_poses.h"

namespace takt::cell {
namespace {

class RelativePoseExpectation final : public Expectation {
 public:
  explicit RelativePoseExpectation(ExpectationReader& reader)
      : arms_(reader.texts("arms")),
        from_(reader.step("from")),
        to_(reader.step("to")),
        within_m_(reader.number("position_within_m")),
        within_rad_(kDegree * reader.number("angle_within_deg")) {
    const auto known = keys_of(reader.built.cell.arms);
    if (arms_.size() != 2) return;
    if (arms_[0] == arms_[1]) {
      reader.diagnostics().error(Code::kWrongSize, reader.at("arms"), fmt::format("'{}' twice", arms_[0]),
                                 fmt::format("Name two of {}", fmt::join(known, ", ")));
      return;
    }
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      if (reader.built.cell.arms.contains(arms_[i])) continue;
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

ExpectationKind relative_pose_expectation() {
  return expectation_kind<RelativePoseExpectation>(
      "relative_pose",
      {"The true pose of the second arm's tool relative to the first arm's tool stays this close to what it was, "
       "between the starts of two steps.",
       {pair_key("arms", "The two arms."), text_key("from", "Step at whose start it begins to count, each time."),
        text_key("to", "Step at whose start it stops counting; it has to begin after each 'from'."), within_m_key(),
        within_deg_key()}});
}

}  // namespace takt::cell
