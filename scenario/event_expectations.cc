#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "record/curves.h"
#include "scenario/part_expectations.h"
#include "scenario/step_window.h"

namespace takt::scenario {
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
                               "\"source\", \"event\" or \"text\": what 'takt events' prints");
  return pattern;
}

constexpr Range kTime{.low = 0.0, .high = 3600.0};

/// Since the node that "during" names has begun, or since the run has. Only steps tell that they begin: a node around
/// them begins with its first one.
class StepClock {
 public:
  explicit StepClock(std::string node) : node_(std::move(node)) {}

  /// @return s
  [[nodiscard]] double at(const LogEntry& entry) {
    if (!node_.empty() && entry.source == "program" && entry.name == "begin") begins(entry);
    return to_seconds(entry.time - begin_);
  }

 private:
  void begins(const LogEntry& entry) {
    const std::string_view found = node_in(entry.step, node_);
    const bool itself = found.size() == std::string_view(entry.step).size();
    if (found.empty() || (!itself && found == running_)) return;
    running_ = found;
    begin_ = entry.time;
  }

  std::string node_, running_;  ///< running: with the path that leads to it
  Nanoseconds begin_ = 0;
};

class EventExpectation final : public Expectation {
 public:
  EventExpectation(ObjectReader& reader, const StepNames& steps)
      : pattern_(read_pattern(reader, steps)),
        clock_(pattern_.during),
        from_s_(reader.number("from_s", 0.0, kTime)),
        to_s_(reader.number("to_s", kTime.high, kTime)) {
    if (reader.has("times")) least_ = most_ = reader.integer("times", {}, kNotNegative);
    least_ = reader.integer("at_least", least_, kNotNegative);
    most_ = reader.integer("at_most", most_, kNotNegative);
    if (reader.has("times") && (reader.has("at_least") || reader.has("at_most")))
      reader.diagnostics().error(Code::kConflict, reader.at("times"), "'times' beside 'at_least' or 'at_most'",
                                 "one of them");
    if (!reader.has("at_least") && reader.has("at_most")) least_ = 0;
  }

  void happened(const LogEntry& entry) override {
    const double time = clock_.at(entry);
    if (!pattern_.fits(entry)) return;
    const bool in_time = time >= from_s_ && time <= to_s_;
    (in_time ? count_ : outside_) += 1;
    if (first_s_ < 0.0) first_s_ = to_seconds(entry.time);
  }
  [[nodiscard]] ExpectationResult judge(const Outcome&) const override {
    ExpectationResult result;
    result.passed = count_ >= least_ && count_ <= most_;
    result.value = static_cast<double>(count_);
    result.measured = fmt::format("{}: {} times", pattern_.words(), count_);
    if (first_s_ >= 0.0) result.measured += fmt::format(", first at {:.3f} s", first_s_);
    if (outside_ > 0)
      result.measured += fmt::format(", {} times outside of {:g} to {:g} s{}", outside_, from_s_, to_s_,
                                     pattern_.during.empty() ? "" : " of the step");
    result.measured +=
        most_ == kMany ? fmt::format(" (at least {})", least_) : fmt::format(" ({} to {} times)", least_, most_);
    return result;
  }

 private:
  static constexpr std::int64_t kMany = std::numeric_limits<std::int64_t>::max();
  EventPattern pattern_;
  StepClock clock_;
  double from_s_, to_s_, first_s_ = -1.0;
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
                                 "two or more");
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
        reader.diagnostics().error(Code::kWrongSize, pointer, fmt::format("{} names", both.size()), "two");
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

}  // namespace takt::scenario
