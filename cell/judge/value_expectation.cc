#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/expectation_kinds.h"
#include "core/expression/contact_reader.h"
#include "core/program/language/value_template.h"

namespace takt::cell {
namespace {

using program::EvalContext;
using program::Type;
using program::Value;
using program::ValueTemplate;

constexpr double kEverything = std::numeric_limits<double>::infinity();

/// Lower and upper end; infinite where none is given.
struct Band {
  double low = -kEverything, high = kEverything;

  [[nodiscard]] bool given() const { return std::isfinite(low) || std::isfinite(high); }
  [[nodiscard]] bool contains(double value) const { return value >= low && value <= high; }
  [[nodiscard]] std::string text() const {
    if (!std::isfinite(low)) return fmt::format("at most {:g}", high);
    if (!std::isfinite(high)) return fmt::format("at least {:g}", low);
    return fmt::format("{:g} to {:g}", low, high);
  }
};

Band read_band(FormReader& reader, const char* least, const char* most) {
  Band band{reader.number(least, -kEverything), reader.number(most, kEverything)};
  if (band.low > band.high)
    reader.diagnostics().error(Code::kConflict, reader.at(least),
                               fmt::format("{:g} is above {:g}, the upper bound", band.low, band.high),
                               "Give the lower bound first");
  return band;
}

class ValueExpectation final : public Expectation {
 public:
  explicit ValueExpectation(ExpectationReader& reader)
      : during_(reader.during()),
        clock_(during_.name()),
        span_(read_span(reader)),
        band_(read_band(reader, "at_least", "at_most")),
        mean_(read_band(reader, "mean_at_least", "mean_at_most")),
        share_(reader.number("share")) {
    if (reader.has("share") && !band_.given())
      reader.diagnostics().error(Code::kRequires, reader.at("share"), "a share of the time without bounds",
                                 "Give \"at_least\" or \"at_most\"");
    read_value(reader, reader.built);
  }

  void begin(const activity::Variables& variables) override { variables_ = &variables; }
  void step_begins(std::string_view) override { begun_ = true; }
  void steps_run(std::span<const std::string> paths) override { during_.look(paths); }
  void happened(const LogEntry& entry) override { clock_.hear(entry); }

  void watch(const BuiltCell& built) override {
    if (!during_.inside() || !span_.contains(clock_.at(built.core->time() - built.core->period()))) return;
    ++cycles_;
    Diagnostics wrong;
    EvalContext eval_context = context(EvalContext::Mode::kRun, built);
    eval_context.readers = &readers_;
    const Value value = value_.value(eval_context, wrong);
    if (value.null() || wrong.has_errors() || !std::isfinite(value.number())) {
      if (begun_ || known_ > 0) ++unknown_;
      return;
    }
    ++known_;
    sum_ += value.number();
    within_ += band_.contains(value.number()) ? 1 : 0;
    least_ = std::min(least_, value.number());
    greatest_ = std::max(greatest_, value.number());
  }

  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    if (!during_.ran()) return {.measured = fmt::format("'{}' did not run", during_.name())};
    if (cycles_ == 0)
      return {.measured = fmt::format("no cycle from {:g} to {:g} s{}", span_.from, span_.to,
                                      during_.name().empty() ? "" : fmt::format(" of '{}'", during_.name()))};
    if (known_ == 0) return {.measured = fmt::format("{} was never known", text_)};
    const double mean = sum_ / static_cast<double>(known_);
    const double share = static_cast<double>(within_) / static_cast<double>(cycles_);
    ExpectationResult result;
    result.passed = (!band_.given() || share >= share_) && (!mean_.given() || (mean_.contains(mean) && seen_whole()));
    result.value = mean_.given() ? mean : std::isfinite(band_.high) ? greatest_ : least_;
    result.measured = fmt::format("{}: {:.4g} to {:.4g}{}, mean {:.4g}", text_, least_, greatest_, unit_, mean);
    if (mean_.given()) result.measured += fmt::format(" (wanted: {})", mean_.text());
    if (mean_.given() && !seen_whole()) result.measured += fmt::format("; not known in {} cycles", unknown_);
    if (band_.given())
      result.measured += fmt::format("; {} in {:.2f} % of {} cycles (wanted: {:g} %)", band_.text(), 100.0 * share,
                                     cycles_, 100.0 * share_);
    return result;
  }

 private:
  /// A mean of what was known says little where much was not.
  [[nodiscard]] bool seen_whole() const {
    constexpr double kMostUnknown = 0.01;  // of the cycles
    return static_cast<double>(unknown_) <= kMostUnknown * static_cast<double>(unknown_ + known_);
  }

  [[nodiscard]] EvalContext context(EvalContext::Mode mode, const BuiltCell& built) const {
    const bool runs = mode == EvalContext::Mode::kRun;
    return {.mode = mode, .cell = &built.cell, .measured = variables_, .time = runs ? built.core->time() : 0};
  }

  void read_value(FormReader& reader, const BuiltCell& built) {
    text_ = reader.text("value");
    if (text_.empty()) return;
    if (!text_.starts_with("$")) {
      reader.diagnostics().error(Code::kInvalidValue, reader.at("value"), fmt::format("'{}' is no expression", text_),
                                 "Write it as in \"$force('wrist')\": see docs/programs.md, expressions");
      return;
    }
    Diagnostics wrong;
    value_ = ValueTemplate::parse(text_, reader.at("value"), wrong);
    const Value checked = wrong.has_errors() ? Value() : value_.value(context(EvalContext::Mode::kCheck, built), wrong);
    if (!wrong.has_errors() && !checked.type.is(Type::Kind::kNumber))
      wrong.error(Code::kTypeMismatch, reader.at("value"), fmt::format("this is a {}", to_string(checked.type)),
                  "Give a number");
    if (const std::string unit = net::to_string(checked.type.unit); unit != "1" && !unit.empty()) unit_ = " " + unit;
    reader.diagnostics().append(wrong);
    text_.erase(0, 1);
  }

  StepWindow during_;
  StepClock clock_;
  TimeSpan span_;
  bool begun_ = false;  ///< the program
  Band band_, mean_;
  double share_;
  std::string text_, unit_;
  ValueTemplate value_;
  const activity::Variables* variables_ = nullptr;  ///< of the run
  expression::ContactReaders readers_;
  std::int64_t cycles_ = 0, known_ = 0, unknown_ = 0, within_ = 0;
  double sum_ = 0.0, least_ = kEverything, greatest_ = -kEverything;
};

}  // namespace

ExpectationKind value_expectation() {
  const auto bound = [](std::string key, std::string doc) {
    return number_key(std::move(key), "", kAnyNumber, std::move(doc)).optional();
  };
  Form form{
      "The value of an expression in the cycles of a step, or of the whole run: bounds, the share of the cycles in "
      "which they hold, mean.",
      {text_key("value",
                "An expression whose value is a number (docs/programs.md#expressions), without variables: "
                "\"$force('wrist')\".")
           .with_definition("expression"),
       during_key(), bound("at_least", "Lower bound in SI units."), bound("at_most", "Upper bound in SI units."),
       number_key("share", "", {.low = 0.0, .high = 1.0, .low_open = true},
                  "Share of the cycles in which these bounds hold at least; a cycle in which the value is not "
                  "known counts as one in which they do not.")
           .by_default(1.0),
       bound("mean_at_least",
             "Lower bound of the mean over the cycles in which the value is known: 99 % of them at least."),
       bound("mean_at_most", "Upper bound of this mean.")},
      {at_least_one({"at_least", "at_most", "mean_at_least", "mean_at_most"})}};
  std::ranges::copy(span_keys("Cycles"), std::back_inserter(form.keys));
  return expectation_kind<ValueExpectation>("value", std::move(form));
}

}  // namespace takt::cell
