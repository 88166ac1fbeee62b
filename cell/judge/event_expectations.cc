#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/part_expectations.h"
#include "cell/judge/step_window.h"
#include "record/curves.h"

namespace takt::cell {
namespace {

/// Which events are meant: all that is given has to fit.
struct EventPattern {
  std::string source, name, text, during;

  [[nodiscard]] bool fits(const LogEntry& entry) const {
    return (source.empty() || entry.source == source) && (name.empty() || entry.name == name) &&
           entry.text.find(text) != std::string::npos && (during.empty() || goes_through(entry.step, during));
  }
  [[nodiscard]] std::string words() const {
    std::string words = fmt::format("{}{}{}", source, source.empty() || name.empty() ? "" : " ", name);
    if (!text.empty()) words += fmt::format("{}'{}'", words.empty() ? "" : " ", text);
    if (!during.empty()) words += fmt::format(" in '{}'", during);
    return words;
  }
};

EventPattern read_pattern(ObjectReader& reader, const StepNames& steps) {
  EventPattern pattern{.source = reader.text("source", ""),
                       .name = reader.text("event", ""),
                       .text = reader.text("text", ""),
                       .during = read_during(reader, steps)};
  if (pattern.source.empty() && pattern.name.empty() && pattern.text.empty())
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "no event is named",
                               "Give \"source\", \"event\" or \"text\": what 'takt events' prints");
  return pattern;
}

constexpr Range kTime = TimeSpan::kAllowed;

/// What did not happen says something only of a window that was there: its step ran, and for as long.
class EventExpectation final : public Expectation {
 public:
  EventExpectation(ObjectReader& reader, const StepNames& steps)
      : pattern_(read_pattern(reader, steps)),
        during_(pattern_.during),
        clock_(pattern_.during),
        span_(read_span(reader)) {
    if (reader.has("times")) least_ = most_ = reader.integer("times", {}, kNotNegative);
    least_ = reader.integer("at_least", least_, kNotNegative);
    most_ = reader.integer("at_most", most_, kNotNegative);
    if (reader.has("times") && (reader.has("at_least") || reader.has("at_most")))
      reader.diagnostics().error(Code::kConflict, reader.at("times"), "'times' beside 'at_least' or 'at_most'",
                                 "Remove one of them");
    if (!reader.has("at_least") && reader.has("at_most")) least_ = 0;
    if (least_ > most_)
      reader.diagnostics().error(Code::kConflict, reader.at("at_least"),
                                 fmt::format("{} is above {}, the upper bound", least_, most_),
                                 "Set at_least to at most at_most");
  }

  void steps_run(std::span<const std::string> paths) override { during_.look(paths); }
  void watch(const BuiltCell& built) override {
    if (during_.inside()) longest_s_ = std::max(longest_s_, clock_.at(built.core->time()));
  }
  void happened(const LogEntry& entry) override {
    clock_.hear(entry);
    if (!pattern_.fits(entry)) return;
    (span_.contains(clock_.at(entry.time)) ? count_ : outside_) += 1;
    if (first_s_ < 0.0) first_s_ = to_seconds(entry.time);
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    if (!during_.ran()) return {.measured = fmt::format("'{}' did not run", during_.name())};
    if (longest_s_ < span_.from)
      return {.measured = fmt::format("{}{} took {:.3f} s, and the window begins at {:g} s",
                                      during_.name().empty() ? "the run" : "'" + during_.name(),
                                      during_.name().empty() ? "" : "'", longest_s_, span_.from)};
    ExpectationResult result;
    result.passed = count_ >= least_ && count_ <= most_;
    result.value = static_cast<double>(count_);
    result.measured = fmt::format("{}: {} times", pattern_.words(), count_);
    if (first_s_ >= 0.0) result.measured += fmt::format(", first at {:.3f} s", first_s_);
    if (outside_ > 0)
      result.measured += fmt::format(", {} times outside of {:g} to {:g} s{}", outside_, span_.from, span_.to,
                                     pattern_.during.empty() ? "" : " of the step");
    result.measured +=
        most_ == kMany ? fmt::format(" (at least {})", least_) : fmt::format(" ({} to {} times)", least_, most_);
    return result;
  }

 private:
  static constexpr std::int64_t kMany = std::numeric_limits<std::int64_t>::max();
  EventPattern pattern_;
  StepWindow during_;
  StepClock clock_;
  TimeSpan span_;
  double first_s_ = -1.0, longest_s_ = 0.0;
  std::int64_t least_ = 1, most_ = kMany, count_ = 0, outside_ = 0;
};

/// One event of an order.
struct OrderedEvent {
  EventPattern pattern;
  double within_s = kTime.high;  ///< after the one before it
};

/// Whatever happens between them does not matter. Each is the first that fits after the one before it.
class OrderExpectation final : public Expectation {
 public:
  OrderExpectation(ObjectReader& reader, const StepNames& steps) {
    const nlohmann::ordered_json* list = reader.array("events");
    for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
      ObjectReader one((*list)[i], reader.at("events") + pointer_segment(i), reader.diagnostics());
      events_.push_back({read_pattern(one, steps), one.number("within_s", kTime.high, kTime)});
      one.finish();
    }
    if (list != nullptr && events_.size() < 2)
      reader.diagnostics().error(Code::kWrongSize, reader.at("events"), fmt::format("{} events", events_.size()),
                                 "Give two or more");
  }

  void happened(const LogEntry& entry) override {
    if (seen_ == events_.size() || !events_[seen_].pattern.fits(entry)) return;
    const double after = to_seconds(entry.time - last_);
    if (seen_ > 0 && after > events_[seen_].within_s && late_.empty())
      late_ = fmt::format("{} came {:.3f} s after {} (at most {:g})", events_[seen_].pattern.words(), after,
                          events_[seen_ - 1].pattern.words(), events_[seen_].within_s);
    last_ = entry.time;
    ++seen_;
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    ExpectationResult result;
    result.value = static_cast<double>(seen_);
    result.passed = seen_ == events_.size() && late_.empty();
    result.measured = fmt::format("{} of {} in this order", seen_, events_.size());
    if (seen_ < events_.size()) {
      result.measured += fmt::format("; {} did not come", events_[seen_].pattern.words());
      if (seen_ > 0) result.measured += fmt::format(" after {}", events_[seen_ - 1].pattern.words());
    }
    if (!late_.empty()) result.measured += "; " + late_;
    return result;
  }

 private:
  std::vector<OrderedEvent> events_;
  std::size_t seen_ = 0;
  Nanoseconds last_ = 0;
  std::string late_;
};

std::vector<std::string> names_that_touch(const BuiltCell& built) {
  std::vector<std::string> names;
  for (const std::string& body : built.world->body_names()) {
    std::string owner = body.empty() ? "floor" : body.substr(0, body.find('/'));
    if (std::ranges::find(names, owner) == names.end()) names.push_back(std::move(owner));
  }
  return names;
}

class ContactsExpectation final : public Expectation {
 public:
  ContactsExpectation(ObjectReader& reader, const BuiltCell& built) {
    const std::vector<std::string> names = names_that_touch(built);
    const nlohmann::ordered_json* list = reader.array("only");
    for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
      const std::string number = std::to_string(i), pointer = reader.at("only") + pointer_segment(i);
      const auto one = nlohmann::ordered_json::object({{number, (*list)[i]}});
      ObjectReader pair(one, reader.at("only"), reader.diagnostics());
      const auto both = pair.texts(number);
      if (both.size() != 2)
        reader.diagnostics().error(Code::kWrongSize, pointer, fmt::format("{} names", both.size()), "Name two");
      for (std::size_t side = 0; side < both.size(); ++side)
        if (std::ranges::none_of(names, [&](const auto& name) { return record::matches(both[side], name); }))
          reader.diagnostics().error(Code::kUnknownName, pointer + pointer_segment(side),
                                     fmt::format("there is nothing called '{}'", both[side]),
                                     nearest_choice(both[side], names));
      if (both.size() == 2) only_.emplace_back(both[0], both[1]);
    }
  }

  [[nodiscard]] ExpectationResult judge(const Outcome& outcome) const override {
    ExpectationResult result{.passed = true};
    std::string others;
    for (const auto& [pair, touch] : outcome.contacts) {
      if (is_expected(pair.first, pair.second)) continue;
      result.passed = false;
      result.value = std::max(result.value, touch.force);
      others += fmt::format("{}'{}' and '{}' at {:.3f} s, {:.1f} N at most", others.empty() ? "" : "; ", pair.first,
                            pair.second, to_seconds(touch.first), touch.force);
    }
    result.measured = result.passed ? fmt::format("nothing else of {} pairs", outcome.contacts.size()) : others;
    if (outcome.standing > 0)
      result.measured += fmt::format("; {} stand on each other since the start", outcome.standing);
    return result;
  }

 private:
  [[nodiscard]] bool is_expected(std::string_view a, std::string_view b) const {
    return std::ranges::any_of(only_, [&](const auto& pair) {
      const auto& [first, second] = pair;
      return (record::matches(first, a) && record::matches(second, b)) ||
             (record::matches(first, b) && record::matches(second, a));
    });
  }

  std::vector<std::pair<std::string, std::string>> only_;  ///< names with * for any letters
};

}  // namespace

std::unique_ptr<Expectation> event_expectation(ObjectReader& reader, const StepNames& steps) {
  return std::make_unique<EventExpectation>(reader, steps);
}
std::unique_ptr<Expectation> order_expectation(ObjectReader& reader, const StepNames& steps) {
  return std::make_unique<OrderExpectation>(reader, steps);
}
std::unique_ptr<Expectation> contacts_expectation(ObjectReader& reader, const BuiltCell& built) {
  return std::make_unique<ContactsExpectation>(reader, built);
}

}  // namespace takt::cell
