#include "cell/replay/fired_cancels.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/net_report.h"
#include "core/net/value_json.h"
#include "core/rcc/digest.h"

namespace takt::cell {
namespace {

using net::NetReport;

/// Cycles that a change may lie back: a state that has to be held for a second counts them.
constexpr std::size_t kMostMoments = 1200;
/// Bytes of them, for a net of any size.
constexpr std::size_t kMostMomentBytes = std::size_t{32} << 20;
/// Of one tree; whoever reads more has lost the thread.
constexpr int kMostChanges = 60;

std::string port_name(const NetReport& report, int primitive, int output) {
  const NetReport::Primitive& one = report.primitives[static_cast<std::size_t>(primitive)];
  return one.id + "." + one.info->outputs[static_cast<std::size_t>(output)].name;
}

/// Ports at which a cancel from outside meets the reasons of the net itself: Boolean outputs of what reads the request.
std::vector<std::string> cancel_gates(const NetReport& report) {
  std::vector<std::string> gates;
  for (const NetReport::Link& link : report.links) {
    const auto& from = report.primitives[static_cast<std::size_t>(link.from)];
    if (from.info->cancel_bound.empty() || link.to < 0) continue;
    const auto& outputs = report.primitives[static_cast<std::size_t>(link.to)].info->outputs;
    for (std::size_t i = 0; i < outputs.size(); ++i)
      if (outputs[i].type == net::ValueType::kBoolean) gates.push_back(port_name(report, link.to, static_cast<int>(i)));
  }
  return gates;
}

nlohmann::ordered_json change_to_json(const TracedChange& change) {
  nlohmann::ordered_json json = {{"port", change.port},   {"cycle", change.cycle},   {"before", change.before},
                                 {"after", change.after}, {"source", change.source}, {"seen", change.seen}};
  json["from"] = nlohmann::ordered_json::array();
  for (const TracedChange& one : change.from) json["from"].push_back(change_to_json(one));
  return json;
}

void write_change(const TracedChange& change, int depth, double period_s, std::string& text) {
  text += fmt::format("{:9.3f} s  {:{}}{}: {} -> {}{}{}\n", static_cast<double>(change.cycle) * period_s, "", 2 * depth,
                      change.port, change.before, change.after, change.source ? "  (from outside)" : "",
                      change.seen ? "  (as above)" : "");
  for (const TracedChange& one : change.from) write_change(one, depth + 1, period_s, text);
}

}  // namespace

/// One trace through the moments of a net.
struct FiredCancels::Trace {
  const Watched& watched;
  const NetReport& report;
  int changes = 0;
  std::set<std::pair<std::string, std::int64_t>> seen = {};

  explicit Trace(const Watched& of) : watched(of), report(of.net->report()) {}

  [[nodiscard]] const Moment* moment(std::int64_t cycle) const {
    const std::int64_t first = watched.moments.front().cycle;
    if (cycle < first || cycle > watched.moments.back().cycle) return nullptr;
    return &watched.moments[static_cast<std::size_t>(cycle - first)];
  }
  [[nodiscard]] const net::CompiledNet::Port& port(std::size_t number) const { return watched.net->ports()[number]; }
  [[nodiscard]] const std::byte* value(const Moment& at, std::size_t number) const {
    return at.slots.front().bytes + port(number).offset;
  }
  [[nodiscard]] bool changed(std::size_t number, std::int64_t cycle) const {
    const Moment *now = moment(cycle), *before = moment(cycle - 1);
    return now && before && std::memcmp(value(*now, number), value(*before, number), port(number).size) != 0;
  }
  [[nodiscard]] std::string text(std::size_t number, std::int64_t cycle) const {
    const Moment* at = moment(cycle);
    return at ? net::slot_to_json(port(number).type, value(*at, number)).dump() : "nothing";
  }

  /// A link into a primitive, with the port and the cycle that it reads.
  struct Input {
    std::size_t number;
    int primitive, output;
    std::int64_t delay;
  };
  [[nodiscard]] std::vector<Input> inputs_of(int primitive) const {
    std::vector<Input> inputs;
    for (const NetReport::Link& link : report.links) {
      if (link.to != primitive) continue;
      const auto number = watched.numbers.find(port_name(report, link.from, link.from_port));
      if (number == watched.numbers.end()) continue;
      inputs.push_back({number->second, link.from, link.from_port, link.delayed ? 1 : 0});
    }
    return inputs;
  }

  /// Those of the inputs that changed in a cycle; of Booleans and others the Booleans alone, if any of them did.
  [[nodiscard]] std::vector<Input> changed_inputs(const std::vector<Input>& inputs, std::int64_t cycle) const {
    std::vector<Input> all, flags;
    for (const Input& input : inputs) {
      if (!changed(input.number, cycle - input.delay)) continue;
      all.push_back(input);
      if (port(input.number).type == net::ValueType::kBoolean) flags.push_back(input);
    }
    return flags.empty() ? all : flags;
  }

  [[nodiscard]] TracedChange follow(int primitive, std::size_t number, std::int64_t cycle) {
    const auto& info = *report.primitives[static_cast<std::size_t>(primitive)].info;
    TracedChange change{.port = port(number).name,
                        .cycle = cycle,
                        .before = text(number, cycle - 1),
                        .after = text(number, cycle),
                        .source = info.source,
                        .seen = false,
                        .from = {}};
    change.seen = !seen.insert({change.port, cycle}).second;
    if (change.seen || ++changes >= kMostChanges) return change;
    const std::vector<Input> inputs = inputs_of(primitive);
    std::vector<Input> reasons = changed_inputs(inputs, cycle);
    // What counts or waits changes by itself: its reason is the last change before.
    std::int64_t when = cycle;
    while (reasons.empty() && !inputs.empty() && when > watched.moments.front().cycle)
      reasons = changed_inputs(inputs, --when);
    for (const Input& input : reasons) change.from.push_back(follow(input.primitive, input.number, when - input.delay));
    return change;
  }

  /// The primitive of an output.
  [[nodiscard]] std::optional<int> primitive_of(const std::string& name) const {
    const std::string id = name.substr(0, name.rfind('.'));
    const auto found = std::ranges::find(report.primitives, id, &NetReport::Primitive::id);
    if (found == report.primitives.end()) return std::nullopt;
    return static_cast<int>(found - report.primitives.begin());
  }
};

FiredCancels::Watched FiredCancels::watch(rcc::NetHandle net) {
  Watched watched{.net = std::move(net), .gates = {}, .numbers = {}, .moments = {}};
  const auto& ports = watched.net->ports();
  for (std::size_t i = 0; i < ports.size(); ++i) watched.numbers.emplace(ports[i].name, i);
  for (const std::string& gate : cancel_gates(watched.net->report())) {
    const auto number = watched.numbers.find(gate);
    if (number != watched.numbers.end()) watched.gates.push_back(number->second);
  }
  return watched;
}

void FiredCancels::look_at(Watched& watched, std::int64_t cycle) {
  const auto slots = watched.net->slots();
  Moment moment{.cycle = cycle, .slots = std::vector<Line>((slots.size() + sizeof(Line) - 1) / sizeof(Line) + 1)};
  std::memcpy(moment.slots.data(), slots.data(), slots.size());
  if (!watched.moments.empty() && watched.moments.back().cycle + 1 != cycle) watched.moments.clear();
  const std::size_t most =
      std::clamp<std::size_t>(kMostMomentBytes / std::max<std::size_t>(1, slots.size()), 2, kMostMoments);
  watched.moments.push_back(std::move(moment));
  if (watched.moments.size() > most) watched.moments.pop_front();
  Trace trace(watched);
  for (const std::size_t gate : watched.gates) {
    if (!trace.changed(gate, cycle) || trace.text(gate, cycle) != "true") continue;
    const auto primitive = trace.primitive_of(trace.port(gate).name);
    if (primitive) fired_.push_back({watched.net->name(), trace.follow(*primitive, gate, cycle)});
  }
}

void FiredCancels::look(rcc::ControlCore& core) {
  const std::int64_t cycle = core.cycle() - 1;
  std::map<rcc::NetId, Watched> running;
  for (const rcc::Digest::BlockValue& block : core.digest().blocks()) {
    const auto id = static_cast<rcc::NetId>(block.block);
    if (block.block == 0 || block.block != id) continue;
    if (auto known = nets_.extract(id); !known.empty()) {
      running.insert(std::move(known));
    } else if (rcc::NetHandle net = core.net(id)) {
      running.emplace(id, watch(std::move(net)));
    }
  }
  nets_ = std::move(running);
  for (auto& [id, watched] : nets_) look_at(watched, cycle);
}

nlohmann::ordered_json to_json(const FiredCancel& fired) {
  return {{"net", fired.net}, {"change", change_to_json(fired.change)}};
}

std::string to_text(const FiredCancel& fired, double period_s) {
  std::string text = fmt::format("cancel in net '{}':\n", fired.net);
  write_change(fired.change, 0, period_s, text);
  return text;
}

}  // namespace takt::cell
