
#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "cell/judge/expectation_kinds.h"
#include "cell/judge/signal_reader.h"

namespace takt::cell {
namespace {

class GripperExpectation final : public Expectation {
 public:
  explicit GripperExpectation(ExpectationReader& from)
      : gripper_(from.name("gripper", keys_of(from.built.cell.grippers))), wanted_(from.choice("is")) {}

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const device::Gripper& gripper = *outcome.built.cell.grippers.find(gripper_)->second.device;
    if (!gripper.has_sample())
      return {.measured = fmt::format("'{}' gives no reading (wanted: {})", gripper_, wanted_)};
    const std::string is(name_of(gripper.sample().state));
    ExpectationResult result;
    result.passed = is == wanted_;
    result.value = gripper.sample().width;
    result.measured = fmt::format("'{}' is {} at {:.2f} mm, {:.1f} N (wanted: {})", gripper_, is,
                                  1e3 * gripper.sample().width, gripper.sample().force, wanted_);
    return result;
  }

 private:
  std::string gripper_, wanted_;
};

class SignalExpectation final : public Expectation {
 public:
  explicit SignalExpectation(ExpectationReader& reader) {
    const auto signals = signals_of(reader.built.cell);
    std::vector<std::string> names;
    for (const NamedSignal& signal : signals) names.push_back(signal.name);
    signal_ = reader.name("signal", names);
    const auto found = std::ranges::find(signals, signal_, &NamedSignal::name);
    digital_ = found == signals.end() || found->digital;
    if (found != signals.end()) read_ = found->read;
    if (digital_) {
      if (reader.has("is")) level_ = reader.boolean("is");
      if (reader.has("rises")) rises_ = reader.integer("rises");
      if (!level_ && !rises_)
        reader.diagnostics().error(Code::kMissing, reader.pointer(), "nothing is expected",
                                   "Give 'is', 'rises' or both");
    } else {
      lowest_ = reader.number("at_least", lowest_);
      highest_ = reader.number("at_most", highest_);
    }
  }

  void step_begins(std::string_view) override { begun_ = true; }
  void watch(const BuiltCell&) override {
    const auto value = read_();
    if (!value) {
      if (begun_) ++silent_;
      return;
    }
    begun_ = true;
    const bool high = *value >= 0.5;
    if (high && !high_before_.value_or(true)) ++risen_;
    high_before_ = high;
  }

  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    const auto value = read_();
    ExpectationResult result;
    result.value = value.value_or(std::numeric_limits<double>::quiet_NaN());
    if (digital_) {
      const bool level = value && *value >= 0.5;
      result.passed = value && level == level_.value_or(level) && risen_ == rises_.value_or(risen_);
      result.measured = fmt::format("'{}' is {} and rose {} times", signal_, level ? "true" : "false", risen_);
      if (rises_ && silent_ > 0) {
        result.passed = false;
        result.measured += fmt::format("; it had no value in {} cycles", silent_);
      }
    } else {
      if (std::isfinite(lowest_)) result.lower = lowest_;
      if (std::isfinite(highest_)) result.upper = highest_;
      result.passed = value && *value >= lowest_ && *value <= highest_;
      result.measured = fmt::format("'{}' is {:g} (from {:g} to {:g})", signal_, result.value, lowest_, highest_);
    }
    if (!value) result.measured = fmt::format("'{}' has no value", signal_);
    return result;
  }

 private:
  std::string signal_;
  SignalReader read_;
  bool digital_ = true;
  std::optional<bool> level_;
  std::optional<std::int64_t> rises_;
  double lowest_ = -std::numeric_limits<double>::infinity(), highest_ = std::numeric_limits<double>::infinity();
  std::optional<bool> high_before_;  ///< nothing: before the first cycle
  bool begun_ = false;               ///< the program, or the readings
  std::int64_t risen_ = 0, silent_ = 0;
};

/// How a screw is in its thread, and by how many turns.
class ScrewExpectation final : public Expectation {
 public:
  explicit ScrewExpectation(ExpectationReader& reader) {
    const auto names = reader.built.world->threads().screw_names();
    screw_ = reader.name("screw", names);
    index_ = static_cast<std::size_t>(std::ranges::find(names, screw_) - names.begin());
    wanted_ = reader.choice("is");
    fewest_ = reader.number("turns_at_least", fewest_);
    most_ = reader.number("turns_at_most", most_);
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    const sim::ThreadLaw& threads = outcome.built.world->threads();
    const sim::ThreadEvent::Kind state = threads.state_of(index_);
    const std::string is = state == sim::ThreadEvent::Kind::kReleased ? "free" : std::string(name_of(state));
    ExpectationResult result;
    result.value = threads.turned(index_) / (2.0 * std::numbers::pi);
    result.passed = is == wanted_ && result.value >= fewest_ && result.value <= most_;
    result.measured = fmt::format("'{}' is {} by {:.2f} turns (wanted: {}, from {:g} to {:g})", screw_, is,
                                  result.value, wanted_, fewest_, most_);
    return result;
  }

 private:
  std::string screw_, wanted_;
  std::size_t index_ = 0;
  double fewest_ = -std::numeric_limits<double>::infinity(), most_ = std::numeric_limits<double>::infinity();
};

}  // namespace

ExpectationKind screw_expectation() {
  const Key turns = number_key("turns_at_least", "", kAnyNumber, "Turns to the right since it was caught.").optional();
  Key most = turns;
  most.name = "turns_at_most";
  return expectation_kind<ScrewExpectation>(
      "screw", {"How a screw is in its thread, and by how many turns.",
                {text_key("screw", "Name of the object."),
                 choice_key("is", {"free", "caught", "crossed", "seated"},
                            "In no thread, in one, in one at an angle, with its head at rest."),
                 turns, most}});
}

ExpectationKind gripper_expectation() {
  return expectation_kind<GripperExpectation>(
      "gripper", {"State of a gripper at the end.",
                  {text_key("gripper", "Which gripper.").optional("the only one"),
                   choice_key("is", {"idle", "moving", "holding", "lost"}, "State at the end.")}});
}

ExpectationKind signal_expectation() {
  return expectation_kind<SignalExpectation>(
      "signal",
      {"Value of an input or output at the end, and how often it became true.",
       {text_key("signal", "Name of the input or output."), boolean_key("is", "Digital: level at the end.").optional(),
        integer_key("rises", kNotNegative, "Digital: how often it became true.").optional(),
        number_key("at_least", "", kAnyNumber, "Analog: lower bound at the end, in its unit.").optional(),
        number_key("at_most", "", kAnyNumber, "Analog: upper bound at the end, in its unit.").optional()}});
}

}  // namespace takt::cell
