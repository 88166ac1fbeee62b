#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/expectation_kinds.h"
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

/// Its rows.
Form pattern_form(std::string doc) {
  return {std::move(doc),
          {text_key("source", "Who tells it: \"program\", \"contact\", \"operator\", \"fault\", a device.")
               .optional("anybody"),
           text_key("event",
                    "What: \"begin\", \"end\", \"failed\", \"retry\", \"log\", \"touch\", \"contact\", "
                    "\"parted\" ... as 'takt events' prints it.")
               .optional("anything"),
           text_key("text", "A part of its text.").optional("any text"), during_key()},
          {at_least_one({"source", "event", "text"})}};
}

EventPattern read_pattern(FormReader& reader, const StepNames& steps) {
  return {.source = reader.text("source"),
          .name = reader.text("event"),
          .text = reader.text("text"),
          .during = read_during(reader, steps)};
}

constexpr Range kTime = TimeSpan::kAllowed;

/// What did not happen says something only of a window that was there: its step ran, and for as long.
class EventExpectation final : public Expectation {
 public:
  explicit EventExpectation(ExpectationReader& reader)
      : pattern_(read_pattern(reader, reader.steps)),
        during_(pattern_.during),
        clock_(pattern_.during),
        span_(read_span(reader)) {
    if (reader.has("times")) least_ = most_ = reader.integer("times");
    least_ = reader.integer("at_least", least_);
    most_ = reader.integer("at_most", most_);
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
  explicit OrderExpectation(ExpectationReader& reader) {
    reader.elements("events", [&](const nlohmann::ordered_json& json, const std::string& pointer) {
      ObjectReader object(json, pointer, reader.diagnostics());
      FormReader one(*reader.row("events").element->form, object);
      events_.push_back({read_pattern(one, reader.steps), one.number("within_s", kTime.high)});
      one.check_rules();
      object.finish();
    });
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
  explicit ContactsExpectation(ExpectationReader& reader) {
    const std::vector<std::string> names = names_that_touch(reader.built);
    reader.elements("only", [&](const nlohmann::ordered_json& json, const std::string& pointer) {
      const std::string number = pointer.substr(pointer.rfind('/') + 1);
      const auto one = nlohmann::ordered_json::object({{number, json}});
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
    });
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

ExpectationKind event_expectation() {
  Form form = pattern_form(
      "Something that the log tells happens so often, in this time (docs/recording.md#the-log). A step that does not "
      "run, "
      "or a time that the run does not reach, does not hold.");
  form.keys.push_back(
      integer_key("times", kNotNegative, "Exactly so often; instead of 'at_least' and 'at_most'.").optional());
  form.keys.push_back(integer_key("at_least", kNotNegative, "So often or more.").optional("1, with only 'at_most' 0"));
  form.keys.push_back(integer_key("at_most", kNotNegative, "So often or less.").optional("any number"));
  std::ranges::copy(span_keys("Events"), std::back_inserter(form.keys));
  form.rules.push_back(at_most_one({"times", "at_least"}));
  form.rules.push_back(at_most_one({"times", "at_most"}));
  return expectation_kind<EventExpectation>("event", std::move(form));
}

ExpectationKind order_expectation() {
  Form event = pattern_form("");
  event.keys.push_back(
      number_key("within_s", "s", kTime, "At most so long after the one before it.").optional("any time"));
  return expectation_kind<OrderExpectation>(
      "order", {"Things that the log tells happen one after the other; others may come between them.",
                {objects_key("events", 2, std::move(event),
                             "What comes first, and so on; each is the first that fits after the one before it.")}});
}

ExpectationKind contacts_expectation() {
  return expectation_kind<ContactsExpectation>(
      "contacts",
      {"Nothing begins to touch but these pairs, whoever it is: devices, objects, the floor; a touch is 0.1 N or more. "
       "What stands on something when the run begins counts once it has parted from it.",
       {pairs_key("only",
                  "Pairs of devices (all their bodies), objects or \"floor\", with * for any letters; an empty list: "
                  "nothing touches at all.")}});
}

}  // namespace takt::cell
