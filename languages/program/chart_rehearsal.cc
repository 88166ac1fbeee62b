#include "languages/program/chart_rehearsal.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "languages/program/chart_values.h"
#include "languages/scxml/system.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

/// More calls than these are charts that go on for ever.
constexpr int kMostCalls = 200;
/// So many instants are looked at, as of a chart that does something each 10 ms for three minutes.
constexpr int kMostInstants = 20'000;
/// A rehearsal ends after a day.
constexpr std::int64_t kLongest_ns = 86'400ll * 1'000'000'000;

class ChartRehearsal {
 public:
  ChartRehearsal(const std::vector<ProgramChart>& charts, const program::Node& node, operations::Rehearsal& rehearsal,
                 Diagnostics& diagnostics)
      : charts_(charts),
        node_(node),
        rehearsal_(rehearsal),
        before_(rehearsal),
        diagnostics_(diagnostics),
        system_(
            {.begin = [this](const ChartSession& from, const ChartCall& call) { return begin(from, call); },
             .cancel = [this](const ChartSession& from, const std::string& id) { cancel(from, id); },
             .sensors = [this](const ChartSession& from, const ChartTransition& one) { return holds(from, one); }}) {}

  void run() {
    for (const ProgramChart& one : charts_) (void)system_.add(one.chart, one.name);
    const double begin = rehearsal_.duration;
    std::int64_t now = 0;
    int instants = 0;
    for (; !system_.over() && calls_ < kMostCalls && now >= 0 && now < kLongest_ns; now = next()) {
      if (++instants > kMostInstants) break;
      system_.advance(now);
      for (const Nominal& due : take_due(now)) (void)system_.end_call(due.session, due.id, due.event);
      system_.advance(now);
    }
    rehearsal_.duration = std::max(rehearsal_.duration, begin + static_cast<double>(system_.now_ns()) * 1e-9);
    if (!system_.over()) note_waiting();
    play_rest();
  }

 private:
  /// A call that is planned, with what it tells its chart at its end.
  struct Nominal {
    std::int64_t end_ns = 0;
    std::string session, id;
    ChartEvent event;
    std::set<std::string, std::less<>> devices = {};
  };

  [[nodiscard]] const ProgramChart* chart_of(const ChartSession& session) const {
    const auto found =
        std::ranges::find_if(charts_, [&](const ProgramChart& one) { return one.chart.get() == &session.chart(); });
    return found == charts_.end() ? nullptr : &*found;
  }

  std::int64_t next() const {
    std::int64_t due = system_.next_ns();
    for (const Nominal& one : running_) due = due < 0 ? one.end_ns : std::min(due, one.end_ns);
    return due;
  }
  std::vector<Nominal> take_due(std::int64_t now) {
    std::vector<Nominal> due;
    for (const Nominal& one : running_)
      if (one.end_ns <= now) due.push_back(one);
    std::erase_if(running_, [&](const Nominal& one) { return one.end_ns <= now; });
    return due;
  }

  std::string begin(const ChartSession& from, const ChartCall& call) {
    const ProgramChart* const chart = chart_of(from);
    if (chart == nullptr) return "nothing runs it";
    const auto found = chart->programs.find(call.from);
    if (found == chart->programs.end()) return fmt::format("nothing here runs '{}'", call.type);
    played_.insert(call.from);
    ++calls_;
    const double started = rehearsal_.duration;
    Nominal nominal{.session = from.id(), .id = call.id, .event = {.name = "done.invoke." + call.id}};
    play(*chart, found->second, *call.from, call.parameters, rehearsal_, nominal, diagnostics_);
    for (const Nominal& other : running_) check_conflict(*chart, *call.from, other, nominal);
    nominal.end_ns = system_.now_ns() + std::llround((rehearsal_.duration - started) * 1e9);
    rehearsal_.duration = started;
    running_.push_back(std::move(nominal));
    return {};
  }

  void play(const ProgramChart& chart, const ChartProgram& program, const ChartInvoke& invoke,
            const std::vector<std::pair<std::string, Data>>& parameters, operations::Rehearsal& rehearsal,
            Nominal& nominal, Diagnostics& diagnostics) {
    program::Scope scope;
    Diagnostics own;
    auto* const outer = std::exchange(rehearsal.claimed, &nominal.devices);
    if (declare_arguments(program, parameters, program::sight_of(rehearsal, scope), scope, own))
      program.node->rehearse(rehearsal, scope, own);
    operations::settle_rehearsal(rehearsal, own);
    rehearsal.claimed = outer;
    if (outer != nullptr) outer->insert(nominal.devices.begin(), nominal.devices.end());
    if (program.result) nominal.event.data = to_data(scope.find(kChartResult)->value);
    move_to_chart(own, 0, *chart.chart, invoke.at);
    diagnostics.append(own);
  }

  void check_conflict(const ProgramChart& chart, const ChartInvoke& invoke, const Nominal& other, const Nominal& one) {
    if (!one.devices.empty() && !other.devices.empty() && noted_.insert({one.id, other.id}).second) {
      diagnostics_.note(
          {},
          fmt::format("'{}' runs beside '{}' of chart '{}': their motions are not checked against each other", one.id,
                      other.id, other.session),
          "Use messages to give the room to one of them, or a parallel");
      move_to_chart(diagnostics_, diagnostics_.list().size() - 1, *chart.chart, invoke.at);
    }
    for (const std::string& device : one.devices) {
      if (!other.devices.contains(device)) continue;
      error_at(invoke.at, Code::kResourceConflict,
               fmt::format("'{}' is driven here while '{}' of chart '{}' drives it", device, other.id, other.session),
               "Invoke one after the other", diagnostics_);
      diagnostics_.list().back().file = chart.chart->file;
    }
  }

  void cancel(const ChartSession& from, const std::string& id) {
    std::erase_if(running_, [&](const Nominal& one) { return one.session == from.id() && one.id == id; });
  }

  std::optional<bool> holds(const ChartSession& from, const ChartTransition& transition) {
    const ProgramChart* const chart = chart_of(from);
    if (chart == nullptr || !chart->sensors.contains(&transition)) return std::nullopt;
    const program::Scope nothing;
    Diagnostics wrong;
    const program::Value value = chart->sensors.at(&transition).evaluate(program::sight_of(rehearsal_, nothing), wrong);
    return wrong.has_errors() || value.null() ? std::nullopt : std::optional(value.boolean());
  }

  void note_waiting() {
    std::string where;
    for (const ChartSession* one : system_.charts()) {
      if (!one->running()) continue;
      where += fmt::format("{}'{}' in {}", where.empty() ? "" : ", ", one->id(), fmt::join(one->configuration(), " "));
    }
    diagnostics_.note(node_.pointer, "on nominal values the charts do not come to an end: " + where,
                      "Expect that what follows is not checked before the run");
  }

  /// Where the arms are when these begin is not known.
  void play_rest() {
    for (const ProgramChart& chart : charts_) {
      for (const ChartState& state : chart.chart->states) {
        for (const ChartInvoke& invoke : state.invokes) {
          const auto found = chart.programs.find(&invoke);
          if (found == chart.programs.end() || played_.contains(&invoke)) continue;
          operations::Rehearsal own = before_;
          own.effort = rehearsal_.effort;
          Diagnostics inside;
          Nominal nominal;
          play(chart, found->second, invoke, {}, own, nominal, inside);
          diagnostics_.append(program::as_warnings(inside, "the nominal run of the charts does not come here"));
          rehearsal_.effort = own.effort;
          rehearsal_.contacts.insert(own.contacts.begin(), own.contacts.end());
          rehearsal_.estimates.insert(own.estimates.begin(), own.estimates.end());
        }
      }
    }
  }

  const std::vector<ProgramChart>& charts_;
  const program::Node& node_;
  operations::Rehearsal& rehearsal_;
  operations::Rehearsal before_;
  Diagnostics& diagnostics_;
  std::vector<Nominal> running_;
  std::set<const ChartInvoke*> played_;
  std::set<std::pair<std::string, std::string>> noted_;
  int calls_ = 0;
  ChartSystem system_;
};

}  // namespace

void rehearse_charts(const std::vector<ProgramChart>& charts, const program::Node& node,
                     operations::Rehearsal& rehearsal, Diagnostics& diagnostics) {
  operations::settle_rehearsal(rehearsal, diagnostics);
  ChartRehearsal(charts, node, rehearsal, diagnostics).run();
}

}  // namespace takt::languages
