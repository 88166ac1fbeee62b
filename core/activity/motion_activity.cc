#include "core/activity/motion_activity.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"

namespace takt::activity {
namespace {

using command::Cell;
using kinematics::JointVector;

/// One or several motions, blended into each other. The options of the last one are those of the whole: what ends it,
/// and how it may be left.
class MotionActivity final : public ActivityModel {
 public:
  struct Part {
    std::string kind;
    LegOf leg;
    MotionOptions options;
  };

  MotionActivity(std::string arm, std::vector<Part> parts)
      : ActivityModel(name_of(arm, parts)),
        arm_(std::move(arm)),
        parts_(std::move(parts)),
        options_(parts_.back().options) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {arm_}; }

  [[nodiscard]] ActivityPtr blended_into(const ActivityModel& next) const override {
    const auto* other = dynamic_cast<const MotionActivity*>(&next);
    if (other == nullptr || other->arm_ != arm_ || !options_.blend.wanted() || options_.until) return nullptr;
    if (!command::same(options_.compliance, other->options_.compliance)) return nullptr;
    if (!offsets_agree(parts_, other->parts_)) return nullptr;
    std::vector<Part> parts = parts_;
    parts.insert(parts.end(), other->parts_.begin(), other->parts_.end());
    return std::make_shared<const MotionActivity>(arm_, std::move(parts));
  }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    if (Diagnostics wrong = check(planning.cell); wrong.has_errors()) return std::unexpected(std::move(wrong));
    const command::MountedArm& arm = planning.cell.arms.find(arm_)->second;
    const Predecessor& before = planning.predecessors.find(arm_)->second;
    if (!before.at_end.rests())
      return failure(Code::kUnknownPosition, "",
                     fmt::format("'{}': its end position is unknown before the run", name()),
                     "a motion after the end of what runs");
    const motion::ArmModel model = command::planning_model(arm, options_.X_FM, before.at_end.tool);
    auto from_rest = motion::plan_sequence(model, *before.at_end.q, makers(model));
    if (!from_rest) return std::unexpected(std::move(from_rest.error()));
    ArmPlans plans{name(), arm_, model, std::move(*from_rest), blended_plan(model, before)};
    MotionOptions own = options_;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const MotionOptions& one = parts_[i].options;
      plans.weaves.push_back(one.weave);
      plans.abort_if.push_back(one.abort_if);
      if (one.weave) own.blend = {};  // who takes it over would drive the rest of its path bare
      if (one.force_offset && !plans.offset)
        plans.offset =
            OffsetPlan{.pressing = one.force_offset->pressing, .parameters = one.force_offset->parameters, .first = i};
    }
    auto prepared = prepare_dual_entry(planning, std::move(plans), own);
    if (prepared)
      prepared->verdict = [count = static_cast<int>(parts_.size()), options = options_](const RunView& run) {
        return motion_diagnostics(run, count, options);
      };
    return prepared;
  }

 private:
  [[nodiscard]] Diagnostics check(const Cell& cell) const {
    Diagnostics diagnostics;
    if (!cell.arms.contains(arm_)) {
      std::vector<std::string> names;
      for (const auto& [name, arm] : cell.arms) names.push_back(name);
      diagnostics.error(Code::kUnknownName, "/arm", fmt::format("there is no arm '{}'", arm_),
                        nearest_choice(arm_, names));
    }
    for (const Part& part : parts_) {
      check_blend(part.options, diagnostics);
      if (part.options.weave) diagnostics.append(command::check_figures(*part.options.weave), "/weave");
    }
    return diagnostics;
  }

  [[nodiscard]] std::vector<motion::LegMaker> makers(const motion::ArmModel& model) const {
    std::vector<motion::LegMaker> all;
    for (const Part& part : parts_) {
      const bool last = &part == &parts_.back();
      all.push_back([&part, &model, last](const JointVector& q) -> Result<motion::Leg> {
        auto leg = part.leg(model, q);
        if (!leg) return leg;
        leg->velocity = part.options.velocity;
        leg->acceleration = part.options.acceleration;
        if (part.options.weave || part.options.force_offset)
          leg->acceleration = std::min(leg->acceleration, command::kShareWithOverlay);
        leg->linear_velocity = part.options.linear_velocity;
        if (!last) leg->blend = inner_blend(part.options.blend);
        return leg;
      });
    }
    return all;
  }

  /// A force offset may begin in a blend, but not change or end in one, and there is no weave in the same plan.
  static bool offsets_agree(const std::vector<Part>& before, const std::vector<Part>& after) {
    const auto has_offset = [](const Part& part) { return part.options.force_offset.has_value(); };
    const auto has_weave = [](const Part& part) { return part.options.weave.has_value(); };
    const bool offset = std::ranges::any_of(before, has_offset) || std::ranges::any_of(after, has_offset);
    const bool weave = std::ranges::any_of(before, has_weave) || std::ranges::any_of(after, has_weave);
    if (offset && weave) return false;
    const std::optional<HeldForce>& held = before.back().options.force_offset;
    return !held || std::ranges::all_of(after, [&held](const Part& part) {
      const std::optional<HeldForce>& now = part.options.force_offset;
      return now && now->sensor == held->sensor && now->parameters == held->parameters;
    });
  }

  /// Inside of one plan there is no time yet: a share of the time counts as one of the path.
  static motion::Blend inner_blend(const BlendingCondition& blend) {
    if (!blend.time_share) return blend.along_path;
    return {motion::Blend::Kind::kFraction, 1.0 - *blend.time_share};
  }

  static std::string name_of(const std::string& arm, const std::vector<Part>& parts) {
    constexpr std::size_t kFew = 4;
    std::string name = arm;
    if (parts.size() > kFew) return fmt::format("{} {} motions", arm, parts.size());
    for (const Part& part : parts) name += " " + part.kind;
    return name;
  }

  /// Nothing where the arm has to come to rest first.
  [[nodiscard]] std::optional<motion::SequencePlan> blended_plan(const motion::ArmModel& model,
                                                                 const Predecessor& before) const {
    const auto from = departure_of(before, model.X_FM);
    if (!from || parts_.front().options.force_offset) return std::nullopt;  // a force offset begins at rest
    auto plan = motion::plan_take_over(model, *from, makers(model));
    return plan ? std::optional(std::move(*plan)) : std::nullopt;
  }

  std::string arm_;
  std::vector<Part> parts_;
  MotionOptions options_;
};

}  // namespace

BlendingCondition BlendingCondition::at_distance(double metres) {
  return BlendingCondition(motion::Blend{motion::Blend::Kind::kDistance, metres});
}

void check_blend(const MotionOptions& options, Diagnostics& diagnostics) {
  const BlendingCondition& blend = options.blend;
  if (blend.wanted() && options.until)
    diagnostics.error(Code::kConflict, "/blend", "the end of a guarded motion is unknown", "no blend, or no condition");
  if (blend.time_share && blend.along_path.kind != motion::Blend::Kind::kNone)
    diagnostics.error(Code::kConflict, "/blend", "a blend by time and by distance", "one of them");
  if (blend.time_share && !(*blend.time_share >= 0.5 && *blend.time_share < 1.0))
    diagnostics.error(Code::kOutOfRange, "/blend", fmt::format("a blend at a share of {:g}", *blend.time_share),
                      "a share of the time, at least 0.5 and below 1");
}

ActivityPtr motion_activity(std::string kind, std::string arm, LegOf leg, MotionOptions parameters) {
  return std::make_shared<const MotionActivity>(
      std::move(arm), std::vector{MotionActivity::Part{std::move(kind), std::move(leg), std::move(parameters)}});
}

std::string speed_channel(const std::string& arm) { return arm + ".speed"; }

}  // namespace takt::activity
