#include "app/remote/follower.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/command_tape.h"
#include "cell/run/follow_record.h"
#include "core/base/json.h"
#include "core/net/value_json.h"

namespace takt::app {
namespace {

using LinkJson = nlohmann::ordered_json;

constexpr const char* kProtocol = "takt.core.v1";

LinkJson joints_list(const kinematics::JointVector& joints) {
  return LinkJson(std::vector<double>(joints.data(), joints.data() + joints.size()));
}

LinkJson seams_json(const std::vector<rcc::NetSeam>& seams) {
  LinkJson list = LinkJson::array();
  for (const rcc::NetSeam& one : seams) {
    LinkJson seam = {{"device", one.device}};
    const auto add = [&seam](const char* key, const kinematics::JointVector& joints) {
      if (joints.size() > 0) seam[key] = joints_list(joints);
    };
    add("q", one.seam.q);
    add("dq", one.seam.dq);
    add("ddq", one.seam.ddq);
    if (one.seam.mode.size > 0) seam["mode"] = one.seam.mode.view();
    if (one.seam.tool) seam["tool"] = cell::values_of(*one.seam.tool);
    list.push_back(std::move(seam));
  }
  return list;
}

/// The name of the output that lies there.
std::string port_at(const net::CompiledNet& net, const void* slot) {
  const auto offset = static_cast<std::size_t>(static_cast<const std::byte*>(slot) - net.slots().data());
  for (const auto& port : net.ports())
    if (port.offset == offset) return port.name;
  return {};
}

/// As the server writes it; another one if this version does not know it.
Code code_named(std::string_view name) {
  for (int code = 0; code <= static_cast<int>(Code::kNote); ++code)
    if (takt::name_of(static_cast<Code>(code)) == name) return static_cast<Code>(code);
  return Code::kNotPossibleNow;
}

/// What a problem answer says, for people.
Diagnostics problem_diagnostics(const std::string& what, const std::string& body) {
  Diagnostics why;
  const auto json = parse_json(body);
  const std::string detail = json && json->is_object() ? json->value("detail", json->value("title", "")) : body;
  if (json && json->is_object() && json->contains("diagnostics"))
    for (const auto& one : json->at("diagnostics"))
      why.error(code_named(one.value("code", "")), one.value("pointer", ""), one.value("message", ""),
                one.value("hint", ""));
  if (!why.has_errors()) why.error(Code::kNotPossibleNow, "--core", fmt::format("{}: {}", what, detail), "");
  return why;
}

}  // namespace

Result<ServedCell> Follower::ask(ServerLink& link) {
  try {
    const ServerLink::Answer answer = link.ask("GET", "/v1/cell");
    const auto json = parse_json(answer.body);
    if (answer.status != 200 || !json || !json->is_object())
      return std::unexpected(problem_diagnostics("the server does not say what cell it has", answer.body));
    return ServedCell{.file = json->value("file", ""),
                      .hash = json->value("hash", ""),
                      .version = json->value("version", ""),
                      .seed = json->value("seed", std::uint64_t{0}),
                      .realtime = json->value("realtime", false)};
  } catch (const std::exception& error) {
    return failure(Code::kSystem, "--core", error.what(), "Check that takt serve runs there");
  }
}

bool Follower::fail(Code code, std::string message, std::string hint) {
  if (!failure_.has_errors()) failure_.error(code, "--core", std::move(message), std::move(hint));
  return false;
}

Diagnostics Follower::begin() {
  try {
    const ServerLink::Answer answer = link_.ask("POST", "/v1/lease", LinkJson({{"cycles", kLease}}).dump());
    if (answer.status == 409) {
      const Diagnostics why = problem_diagnostics("the lease", answer.body);
      Diagnostics held;
      held.error(Code::kConflict, "--core", why.list().front().message, "Wait until that program has ended, or end it");
      return held;
    }
    if (answer.status != 201) return problem_diagnostics("the lease", answer.body);
    fence_ = parse_json(answer.body)->value("fence", 0u);
    if (Diagnostics wrong = link_.connect(kProtocol); wrong.has_errors()) return wrong;
    if (served_.realtime) link_.repeat(R"({"op": "alive"})", std::chrono::milliseconds(50));
    link_.send(LinkJson({{"op", "follow"}, {"fence", fence_}}).dump());
    while (!begun_)
      if (!take(link_.receive())) return failure_;
  } catch (const LinkError& error) {
    (void)fail(Code::kSystem, error.what(), "Check that takt serve runs there");
  }
  return failure_;
}

bool Follower::next() {
  events_.clear();
  const std::int64_t before = cycles_;
  try {
    if (!served_.realtime) {
      link_.send(R"({"op": "steps", "cycles": 1})");
      while (cycles_ == before)
        if (!take(link_.receive())) return false;
      return true;
    }
    while (cycles_ == before)
      if (!take(link_.receive())) return false;
    while (const auto more = link_.poll())
      if (!take(*more)) return false;
  } catch (const LinkError& error) {
    return fail(Code::kSystem, error.what(), "What ran comes to rest within the lease; start the program again");
  }
  return true;
}

// -- What the server tells --------------------------------------------------------------------------------------------

bool Follower::take(const ServerLink::Message& message) {
  if (!message.binary) return take_text(message.bytes);
  std::span<const std::byte> bytes = std::as_bytes(std::span(message.bytes));
  while (!bytes.empty()) {
    std::uint32_t size = 0;
    if (bytes.size() < sizeof(size)) return fail(Code::kInternal, "a record is cut off", "");
    std::memcpy(&size, bytes.data(), sizeof(size));
    bytes = bytes.subspan(sizeof(size));
    if (size > bytes.size() || !take_record(bytes.first(size)))
      return fail(Code::kInternal, "a record is no record of this cell", "Use the same version of takt on both sides");
    bytes = bytes.subspan(size);
  }
  return true;
}

bool Follower::take_text(const std::string& text) {
  const auto json = parse_json(text);
  if (!json || !json->is_object()) return fail(Code::kInternal, "the server says what is no message", "");
  const std::string op = json->value("op", "");
  if (op == "problem") {
    Diagnostics why = problem_diagnostics(json->value("for", ""), text);
    if (!failure_.has_errors()) failure_ = std::move(why);
    return false;
  }
  if (op == "left") left_ = true;
  if (op != "verdict") return true;
  verdict_.emplace(Verdict{
      .digest = json->value("digest", ""), .cycles = json->value("cycles", std::int64_t{0}), .expectations = {}});
  for (const auto& one : json->at("expectations"))
    verdict_->expectations.push_back({.name = one.value("name", ""),
                                      .kind = one.value("kind", ""),
                                      .passed = one.value("passed", false),
                                      .judged = one.value("judged", false),
                                      .measured = one.value("measured", ""),
                                      .value = one.value("value", 0.0),
                                      .unit = one.value("unit", "")});
  return true;
}

bool Follower::take_record(std::span<const std::byte> record) {
  cell::ByteReader in(record);
  switch (static_cast<cell::FollowRecord>(in.get<std::uint8_t>())) {
    case cell::FollowRecord::kBegin:
      return take_begin(in);
    case cell::FollowRecord::kCycle:
      return take_cycle(in);
    case cell::FollowRecord::kRefused:
      return fail(Code::kNotPossibleNow, "the cell cannot be followed now: " + cell::get_text(in),
                  "Wait until it is at rest");
    case cell::FollowRecord::kLost:
      return fail(Code::kStopped, "the server has ended this program: " + cell::get_text(in),
                  "Start it again; what ran comes to rest");
  }
  return false;
}

bool Follower::take_begin(cell::ByteReader& in) {
  const auto last = in.get<std::int64_t>();
  if (begun_ || last < 0) return false;
  inlet().begin_at(last);
  built_.commands->samples().follow([](const std::string&, const device::ToolSetting&) {});
  std::map<std::string, device::ToolSetting, std::less<>> tools;
  if (!cell::restore_state(in, built_, last, tools)) return false;
  built_.core->step();
  begun_ = true;
  built_.commands->samples().follow(
      [this](const std::string& arm, const device::ToolSetting& tool) { tell_tool(arm, tool); });
  // The program before this one may have left an arm with a load that this one knows nothing of.
  for (const auto& [name, arm] : built_.cell.arms)
    if (cell::values_of(tools.at(name)) != cell::values_of(arm.device->tool())) tell_tool(name, arm.device->tool());
  return true;
}

bool Follower::take_cycle(cell::ByteReader& in) {
  rcc::ControlCore& core = *built_.core;
  const auto cycle = in.get<std::int64_t>();
  const auto hash = in.get<std::uint64_t>();
  if (!begun_ || cycle != core.cycle()) return false;
  for (std::uint16_t left = in.get<std::uint16_t>(); left > 0; --left) {
    const auto tag = in.get<std::uint32_t>();
    if (!take_command(tag, in.get<std::uint8_t>() != 0)) return false;
  }
  if (in.get<std::uint8_t>() != 0) inlet().stop_all(net::Cause::Code::kAborted, cell::get_text(in));
  if (!cell::read_latched(in, built_)) return false;
  built_.commands->samples().read(in);
  if (in.ended_early() || in.left() != 0) return false;
  core.step();
  ++cycles_;
  events_.insert(events_.end(), core.events().begin(), core.events().end());
  if (cell::hash_of_actuators(built_.cell) == hash) return true;
  return fail(Code::kIncompatible,
              fmt::format("after cycle {} this process and the server are not in the same state", cycle),
              "Use the same build of takt on both sides, and let nobody else drive the cell meanwhile");
}

bool Follower::take_command(std::uint32_t tag, bool posted) {
  const auto found = asked_.find(tag);
  if (found == asked_.end()) return false;
  const Asked asked = std::move(found->second);
  asked_.erase(found);
  switch (asked.kind) {
    case Asked::Kind::kRule:
      if (!posted) return fail(Code::kNotPossibleNow, "the core of the server had no room for a request", "");
      return inlet().post(asked.id, asked.rule);
    case Asked::Kind::kMode:
      if (!posted) return fail(Code::kNotPossibleNow, "the core of the server had no room for a request", "");
      return inlet().change_mode(asked.id, asked.arm, asked.mode);
    case Asked::Kind::kAbort:
      inlet().abort(asked.net);
      return true;
    case Asked::Kind::kUnload:
      inlet().unload(asked.net);
      there_.erase(asked.net);
      return true;
    case Asked::Kind::kOther:
      return true;
  }
  return false;
}

// -- What the program asks for ----------------------------------------------------------------------------------------

std::uint32_t Follower::keep(Asked asked) {
  asked_.emplace(++last_tag_, std::move(asked));
  return last_tag_;
}

Diagnostics Follower::load(rcc::NetId net, const net::NetDescription& description, const rcc::LoadOptions& options) {
  LinkJson body = {{"net", net::net_to_json(description)},
                   {"begins", seams_json(options.begins)},
                   {"ends", seams_json(options.ends)}};
  if (options.cancel_bound_cycles) body["cancel_bound_cycles"] = *options.cancel_bound_cycles;
  if (!options.goes_on.empty()) body["goes_on"] = options.goes_on;
  if (!options.stopped.empty()) body["stopped"] = options.stopped;
  try {
    ServerLink::Answer answer = link_.ask("POST", "/v1/nets", body.dump(), fence_);
    if (answer.status != 202) return problem_diagnostics("LOAD", answer.body);
    const auto number = parse_json(answer.body)->value("net", rcc::NetId{0});
    there_[net] = number;
    for (;;) {
      answer = link_.ask("GET", fmt::format("/v1/nets/{}", number));
      const auto state = parse_json(answer.body);
      if (answer.status != 200 || !state) return problem_diagnostics("LOAD", answer.body);
      const std::string name = state->value("state", "");
      if (name == "Rejected") return problem_diagnostics("LOAD", answer.body);
      if (name != "Loading") return {};
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  } catch (const LinkError& error) {
    Diagnostics why;
    why.error(Code::kSystem, "--core", error.what(), "Check that takt serve runs there");
    return why;
  }
}

bool Follower::post(rcc::RequestId id, const rcc::Rule& rule) {
  LinkJson terms = LinkJson::array();
  for (int i = 0; i < rule.condition.size; ++i) {
    const rcc::Term& term = rule.condition.terms[static_cast<std::size_t>(i)];
    LinkJson one = {{"net", there_[term.net]}};
    const rcc::NetHandle net = built_.core->net(term.net);
    if (term.states != 0) {
      one["states"] = LinkJson::array();
      for (const auto state : {rcc::NetState::kLoading, rcc::NetState::kRejected, rcc::NetState::kReady,
                               rcc::NetState::kRunning, rcc::NetState::kCanceling, rcc::NetState::kTerminated})
        if ((term.states >> static_cast<unsigned>(state) & 1u) != 0) one["states"].push_back(name_of(state));
    } else if (net == nullptr) {
      return false;
    } else if (term.port != nullptr) {
      one["port"] = port_at(*net, term.port);
    } else {
      constexpr double kMost = 1e300;
      one["port"] = port_at(*net, term.real);
      one["lower"] = std::max(term.lower, -kMost);
      one["upper"] = std::min(term.upper, kMost);
    }
    terms.push_back(std::move(one));
  }
  const auto transaction = [this](const rcc::Transaction& given) {
    const auto numbers = [this](const rcc::NetSet& nets) {
      LinkJson list = LinkJson::array();
      for (const rcc::NetId net : nets) list.push_back(there_[net]);
      return list;
    };
    return LinkJson({{"abort", numbers(given.abort)},
                     {"cancel", numbers(given.cancel)},
                     {"start", numbers(given.start)},
                     {"end", numbers(given.end)}});
  };
  LinkJson message = {{"op", "rule"}, {"condition", std::move(terms)}, {"action", transaction(rule.action)}};
  if (!rule.otherwise.empty()) message["otherwise"] = transaction(rule.otherwise);
  message["tag"] = keep({.kind = Asked::Kind::kRule, .id = id, .rule = rule});
  link_.send(message.dump());
  return true;
}

bool Follower::change_mode(rcc::RequestId id, std::string_view arm, device::ControlMode mode) {
  const auto tag = keep({.kind = Asked::Kind::kMode, .id = id, .arm = std::string(arm), .mode = mode});
  link_.send(LinkJson({{"op", "mode"}, {"tag", tag}, {"arm", arm}, {"mode", name_of(mode)}}).dump());
  return true;
}

void Follower::abort(rcc::NetId net) {
  const auto tag = keep({.kind = Asked::Kind::kAbort, .net = net});
  link_.send(LinkJson({{"op", "abort"}, {"tag", tag}, {"net", there_[net]}}).dump());
}

void Follower::unload(rcc::NetId net) {
  const auto tag = keep({.kind = Asked::Kind::kUnload, .net = net});
  link_.send(LinkJson({{"op", "unload"}, {"tag", tag}, {"net", there_[net]}}).dump());
}

void Follower::stop_all(net::Cause::Code, std::string_view text) {
  link_.send(LinkJson({{"op", "stop"}, {"text", text}}).dump());
}

void Follower::tell_tool(const std::string& arm, const device::ToolSetting& tool) {
  const auto tag = keep({});
  link_.send(LinkJson({{"op", "tool"}, {"tag", tag}, {"arm", arm}, {"tool", cell::values_of(tool)}}).dump());
}

void Follower::write_channel(const std::string& name, const std::optional<device::ChannelValue>& value) {
  const auto tag = keep({});
  LinkJson json;
  if (value) json = std::visit([](const auto& one) { return net::value_to_json(one); }, *value);
  link_.send(LinkJson({{"op", "channel"}, {"tag", tag}, {"name", name}, {"value", json}}).dump());
}

void Follower::touching(const std::set<std::string, std::less<>>& devices) {
  if (devices == touching_) return;
  touching_ = devices;
  link_.send(LinkJson({{"op", "touching"}, {"devices", devices}}).dump());
}

void Follower::note(std::string_view source, std::string_view name, std::string_view text) {
  link_.send(LinkJson({{"op", "note"}, {"source", source}, {"name", name}, {"text", text}}).dump());
}

void Follower::step_begun(std::string_view name) {
  link_.send(LinkJson({{"op", "step_begun"}, {"name", name}}).dump());
}

std::optional<Follower::Verdict> Follower::judge() {
  verdict_.reset();
  try {
    link_.send(R"({"op": "judge"})");
    while (!verdict_)
      if (!take(link_.receive())) return std::nullopt;
  } catch (const LinkError& error) {
    (void)fail(Code::kSystem, error.what(), "Check that takt serve runs there");
  }
  return verdict_;
}

void Follower::leave() {
  try {
    link_.send(R"({"op": "leave"})");
    while (!left_)
      if (!take(link_.receive())) return;
  } catch (const LinkError&) {
    // Who has lost the connection has lost the lease, too.
  }
}

}  // namespace takt::app
