#include "serve/rule_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/sample_tape.h"

namespace takt::serve {
namespace {

using RuleJson = nlohmann::ordered_json;

constexpr Range kNetNumbers{.low = 1, .high = 4294967295.0};

const std::vector<rcc::NetState>& all_states() {
  using enum rcc::NetState;
  static const std::vector<rcc::NetState> all = {kLoading, kRejected, kReady, kRunning, kCanceling, kTerminated};
  return all;
}

std::uint8_t read_states(ObjectReader& term) {
  std::vector<std::string> names;
  for (const rcc::NetState one : all_states()) names.emplace_back(name_of(one));
  std::uint8_t states = 0;
  for (const std::string& text : term.texts("states")) {
    const auto found = std::ranges::find(names, text);
    if (found == names.end()) {
      term.diagnostics().error(Code::kUnknownName, term.at("states"), fmt::format("a net is never '{}'", text),
                               nearest_choice(text, names));
      continue;
    }
    states |= static_cast<std::uint8_t>(
        1u << static_cast<unsigned>(all_states()[static_cast<std::size_t>(found - names.begin())]));
  }
  if (states == 0 && !term.diagnostics().has_errors())
    term.diagnostics().error(Code::kMissing, term.at("states"), "no states", "Name at least one");
  return states;
}

rcc::Term read_term(ObjectReader& term, const rcc::ControlCore& core) {
  const rcc::NetId id = read_net(term, "net");
  rcc::Term read{.net = id};
  if (term.has("states")) {
    read.states = read_states(term);
    term.finish();
    return read;
  }
  const std::string port = term.text("port");
  const bool range = term.has("lower") || term.has("upper");
  read.lower = term.number("lower", -std::numeric_limits<double>::infinity());
  read.upper = term.number("upper", std::numeric_limits<double>::infinity());
  term.finish();
  if (term.diagnostics().has_errors()) return read;
  const rcc::NetHandle net = core.net(id);
  if (net == nullptr) {
    term.diagnostics().error(Code::kUnknownName, term.at("net"),
                             fmt::format("net {} is not loaded, or still Loading", id), "Wait until it is Ready");
    return read;
  }
  if (range) {
    read.real = net->find<net::Real>(port);
  } else {
    read.port = net->find<net::Boolean>(port);
  }
  if (read.port == nullptr && read.real == nullptr)
    term.diagnostics().error(
        Code::kUnknownName, term.at("port"),
        fmt::format("net {} has no {} output '{}'", id, range ? "Real" : "Boolean", port),
        range ? "Name a Real output as id.port" : "Name a Boolean output, or give lower and upper");
  return read;
}

rcc::NetSet read_set(ObjectReader& reader, std::string_view key) {
  rcc::NetSet set;
  for (const double number : reader.numbers(key, 0, std::vector<double>{}, kNetNumbers)) {
    if (number != std::floor(number)) {
      reader.diagnostics().error(Code::kWrongType, reader.at(key), fmt::format("{} is no number of a net", number),
                                 "Give integers");
    } else if (!set.add(static_cast<rcc::NetId>(number))) {
      reader.diagnostics().error(Code::kWrongSize, reader.at(key),
                                 fmt::format("more than {} nets", rcc::NetSet::kCapacity), "Name fewer nets");
      break;
    }
  }
  return set;
}

rcc::Transaction read_transaction(const RuleJson& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  rcc::Transaction read{.abort = read_set(reader, "abort"),
                        .cancel = read_set(reader, "cancel"),
                        .start = read_set(reader, "start"),
                        .end = read_set(reader, "end")};
  reader.finish();
  if (read.empty() && !diagnostics.has_errors())
    diagnostics.error(Code::kMissing, pointer, "nothing is to be done", "Name nets to abort, cancel, start or end");
  return read;
}

void read_condition(ObjectReader& reader, const rcc::ControlCore& core, rcc::Condition& condition) {
  Diagnostics& diagnostics = reader.diagnostics();
  const RuleJson* terms = reader.array("condition", false);
  for (std::size_t i = 0; terms != nullptr && i < terms->size(); ++i) {
    const std::string pointer = reader.at("condition") + pointer_segment(i);
    if (!(*terms)[i].is_object()) {
      diagnostics.error(Code::kWrongType, pointer, "a term is an object", "Give net, and states or port");
      continue;
    }
    ObjectReader term((*terms)[i], pointer, diagnostics);
    if (condition.add(read_term(term, core))) continue;
    diagnostics.error(Code::kWrongSize, reader.at("condition"),
                      fmt::format("more than {} terms", rcc::Condition::kCapacity), "Give fewer terms");
    return;
  }
}

kinematics::JointVector read_joints(ObjectReader& reader, std::string_view key) {
  const std::vector<double> values = reader.numbers(key, 0, std::vector<double>{});
  if (values.size() > static_cast<std::size_t>(kinematics::kMaxJoints)) {
    reader.diagnostics().error(Code::kWrongSize, reader.at(key), fmt::format("{} joints", values.size()),
                               fmt::format("Give at most {}", kinematics::kMaxJoints));
    return {};
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::vector<rcc::NetSeam> read_seams(ObjectReader& reader, std::string_view key) {
  std::vector<rcc::NetSeam> seams;
  const RuleJson* list = reader.array(key, false);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const std::string pointer = reader.at(key) + pointer_segment(i);
    if (!(*list)[i].is_object()) {
      reader.diagnostics().error(Code::kWrongType, pointer, "a seam is an object", "Give device, and q, dq, ddq");
      continue;
    }
    ObjectReader entry((*list)[i], pointer, reader.diagnostics());
    rcc::NetSeam seam{.device = entry.text("device"),
                      .seam = {.q = read_joints(entry, "q"),
                               .dq = read_joints(entry, "dq"),
                               .ddq = read_joints(entry, "ddq"),
                               .mode = net::Text(entry.text("mode", ""))}};
    if (entry.has("tool")) {
      const std::vector<double> tool = entry.numbers("tool", cell::kToolValues);
      if (tool.size() == cell::kToolValues) seam.seam.tool = cell::tool_of(tool);
    }
    entry.finish();
    seams.push_back(std::move(seam));
  }
  return seams;
}

}  // namespace

rcc::LoadOptions read_load_options(ObjectReader& reader) {
  rcc::LoadOptions options;
  if (reader.has("cancel_bound_cycles"))
    options.cancel_bound_cycles = reader.integer("cancel_bound_cycles", {}, Range{.low = 1, .high = 1e9});
  options.goes_on = reader.text("goes_on", "");
  options.stopped = reader.text("stopped", "");
  options.begins = read_seams(reader, "begins");
  options.ends = read_seams(reader, "ends");
  return options;
}

rcc::NetId read_net(ObjectReader& reader, std::string_view key) {
  const auto net = reader.integer(key, {}, kNetNumbers);
  return static_cast<rcc::NetId>(net);
}

rcc::Rule read_rule(ObjectReader& reader, const rcc::ControlCore& core) {
  rcc::Rule rule;
  read_condition(reader, core, rule.condition);
  if (const RuleJson* action = reader.object("action"))
    rule.action = read_transaction(*action, reader.at("action"), reader.diagnostics());
  if (const RuleJson* otherwise = reader.object("otherwise", false))
    rule.otherwise = read_transaction(*otherwise, reader.at("otherwise"), reader.diagnostics());
  return rule;
}

}  // namespace takt::serve
