// LOAD, START, CANCEL, ABORT, STATE, rules: the Realtime Primitives Interface.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/run_report.h"
#include "core/base/object_reader.h"
#include "core/net/description.h"
#include "core/net/net_report.h"
#include "serve/api.h"
#include "serve/rule_reader.h"

namespace takt::serve {
namespace {

using Json = nlohmann::ordered_json;

const Field kExpires{.name = "expires_at_cycle",
                     .type = "integer",
                     .doc = "The command is refused from this cycle on.",
                     .required = false,
                     .minimum = 0};
const std::vector<Field> kPosted = {{"request", "integer", "number that the event done or refused will carry"}};

std::optional<HttpResponse> expired(ObjectReader& reader, const rcc::ControlCore& core) {
  const std::int64_t cycle = core.cycle();
  const auto expires = reader.integer("expires_at_cycle", std::numeric_limits<std::int64_t>::max(), kNotNegative);
  if (cycle < expires || reader.diagnostics().has_errors()) return {};
  Diagnostics why;
  why.error(Code::kNotPossibleNow, "/expires_at_cycle", fmt::format("it is cycle {}", cycle), "Send a new command");
  return problem(409, "the command came too late", why);
}

Route with_net(std::string method, std::string path, std::string id, std::string summary, Need need, int status) {
  return {.method = std::move(method),
          .path = "/v1/nets" + path,
          .id = std::move(id),
          .summary = std::move(summary),
          .need = need,
          .status = status};
}

HttpResponse unknown_net(const Call& call) {
  return problem(404, fmt::format("there is no net '{}'", call.path.at("net")));
}

}  // namespace

void Api::add_net_routes() {
  Route load_route =
      with_net("POST", "", "load",
               "LOAD: verifies and compiles a net outside of the cycle; STATE says when it is Ready or Rejected.",
               Need::kHolder, 202);
  load_route.body = {{"net", "object", "the net, as in a net file"},
                     {"cancel_bound_cycles", "integer", "from a cancel to the end, at most", false, 1},
                     {"goes_on", "string", "a Boolean, id.port: while it is true the bound does not count", false},
                     {"stopped", "string", "a Boolean, id.port: the net has ended because it was stopped", false},
                     {"begins", "array", "seams: device, q, dq, ddq, mode, tool: how the net takes it over", false},
                     {"ends", "array", "seams: how the net leaves its devices", false}};
  load_route.answer = {{"net", "integer", "number of the net"}, {"state", "string", "Loading"}};
  load_route.handle = [this](const Call& call, const Respond& respond) { load(call, respond); };
  routes_.push_back(std::move(load_route));

  Route list = with_net("GET", "", "nets", "All nets that are loaded.", Need::kLook, 200);
  list.answer = {{"nets", "array", "number, name and state of each"}};
  list.handle = [this](const Call&, const Respond& respond) { respond(list_nets()); };
  routes_.push_back(std::move(list));

  Route state = with_net("GET", "/{net}", "net_state", "STATE: of a net, and why it is in it.", Need::kLook, 200);
  state.answer = {{"net", "integer", "number of the net"},
                  {"name", "string", ""},
                  {"state", "string", "Loading, Rejected, Ready, Running, Canceling or Terminated"},
                  {"cause", "string", "of its end"},
                  {"diagnostics", "array", "why it was rejected"}};
  state.handle = [this](const Call& call, const Respond& respond) { respond(net_state(call)); };
  routes_.push_back(std::move(state));

  Route report = with_net("GET", "/{net}/report", "net_report",
                          "The reaction certificate, notes and order of evaluation of a net.", Need::kLook, 200);
  report.answer = {{"reactions", "array", "certified cycles from each source to each sink"}};
  report.handle = [this](const Call& call, const Respond& respond) { respond(net_report(call)); };
  routes_.push_back(std::move(report));

  Route graph = with_net("GET", "/{net}/graph", "net_graph", "A net as a graph, for viewers.", Need::kLook, 200);
  graph.answer = {{"net", "integer", "number of the net"},
                  {"name", "string", ""},
                  {"resources", "array", "devices that it drives"},
                  {"primitives", "array", "id, type, place in the order of evaluation, inputs and outputs of each"},
                  {"links", "array", "from and to: indices of primitives, and of their ports"}};
  graph.handle = [this](const Call& call, const Respond& respond) { respond(net_graph(call)); };
  routes_.push_back(std::move(graph));

  Route drop = with_net("DELETE", "/{net}", "unload", "Forgets a net that is not active.", Need::kHolder, 200);
  drop.answer = {{"net", "integer", "number of the net"}};
  drop.handle = [this](const Call& call, const Respond& respond) { respond(unload(call)); };
  routes_.push_back(std::move(drop));

  const std::vector<std::pair<std::string, std::string>> commands = {
      {"start", "START, in the next cycle."},
      {"cancel", "CANCEL: the net comes to its end in order, motions on their paths."},
      {"abort", "ABORT: the stop reaction, now."}};
  for (const auto& [what, summary] : commands) {
    Route route = with_net("POST", "/{net}/" + what, what, summary, Need::kHolder, 202);
    route.body = {kExpires};
    route.answer = kPosted;
    route.handle = [this, what = what](const Call& call, const Respond& respond) { respond(command(call, what)); };
    routes_.push_back(std::move(route));
  }
}

void Api::add_command_routes() {
  routes_.push_back(
      {.method = "POST",
       .path = "/v1/rules",
       .id = "post_rule",
       .summary = "A transaction, carried out wholly or not at all in the first cycle in which all terms of the "
                  "condition hold.",
       .need = Need::kHolder,
       .status = 202,
       .body = {{"condition", "array",
                 "terms: net with states; net with a Boolean port; net with a Real port, lower and upper", false},
                {"action", "object", "nets to abort, cancel, start, end"},
                {"otherwise", "object", "a second transaction for the case that the first is refused", false},
                kExpires},
       .answer = kPosted,
       .handle = [this](const Call& call, const Respond& respond) { respond(post_rule(call)); }});
  routes_.push_back({.method = "POST",
                     .path = "/v1/schedule",
                     .id = "schedule_after",
                     .summary = "Starts a net in the cycle in which another one ends.",
                     .need = Need::kHolder,
                     .status = 202,
                     .body = {{"predecessor", "integer", "number of a net", true, 1},
                              {"successor", "integer", "number of a net", true, 1},
                              {"from_rest", "integer", "net to start instead if the seam does not fit", false, 1},
                              kExpires},
                     .answer = kPosted,
                     .handle = [this](const Call& call, const Respond& respond) { respond(schedule(call)); }});
}

void Api::load_now(const Json& json, std::uint32_t fence, const Respond& respond) {
  Diagnostics diagnostics;
  ObjectReader reader(json, "", diagnostics);
  const Json* net = reader.object("net");
  const rcc::LoadOptions options = read_load_options(reader);
  reader.finish();
  std::optional<net::NetDescription> description;
  if (net != nullptr) {
    auto read = net::net_from_json(*net);
    if (read) {
      description = std::move(*read);
    } else {
      diagnostics.append(read.error(), "/net");
    }
  }
  if (diagnostics.has_errors() || !description) return respond(problem(422, "the net cannot be read", diagnostics));
  const std::string name = description->name;
  const rcc::NetId id = cell_.core().load_async(std::move(*description), options);
  if (id == 0) return respond(problem(429, "no more nets can be loaded: unload some"));
  if (!cell_.lease().add(id, fence)) {
    (void)cell_.core().unload(id);
    return respond(problem(429, fmt::format("{} nets are loaded that have not ended: unload some", rcc::Lease::kNets)));
  }
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(names_, [this](const auto& one) { return !cell_.core().knows(one.first); });
    names_[id] = name;
  }
  HttpResponse response = json_answer(202, {{"net", id}, {"state", name_of(cell_.core().state(id))}});
  response.headers["Location"] = fmt::format("/v1/nets/{}", id);
  respond(std::move(response));
}

HttpResponse Api::list_nets() const {
  Json nets = Json::array();
  const std::lock_guard lock(mutex_);
  for (const auto& [id, name] : names_)
    if (cell_.core().knows(id))
      nets.push_back({{"net", id}, {"name", name}, {"state", name_of(cell_.core().state(id))}});
  return json_answer(200, {{"nets", nets}});
}

HttpResponse Api::net_state(const Call& call) const {
  const rcc::NetId id = net_in(call);
  if (!cell_.core().knows(id)) return unknown_net(call);
  const rcc::NetStatus status = cell_.core().status(id);
  std::string name;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = names_.find(id); found != names_.end()) name = found->second;
  }
  // Those of a program and of joggings were not loaded by a client.
  if (const rcc::NetHandle net = cell_.core().net(id); name.empty() && net != nullptr) name = net->name();
  return json_answer(200, {{"net", id},
                           {"name", name},
                           {"state", name_of(status.state)},
                           {"cause", name_of(status.cause.code)},
                           {"cause_text", status.cause.text.view()},
                           {"first_cycle", status.first_cycle},
                           {"last_cycle", status.last_cycle},
                           {"cancel_bound_cycles", status.cancel_bound_cycles},
                           {"cost_ns", status.cost_ns},
                           {"diagnostics", cell::to_json(cell_.core().diagnostics(id))}});
}

HttpResponse Api::net_report(const Call& call) const {
  const rcc::NetId id = net_in(call);
  if (!cell_.core().knows(id)) return unknown_net(call);
  const rcc::NetHandle net = cell_.core().net(id);
  if (net == nullptr) return problem(409, "the net is still Loading, or was rejected");
  return json_answer(200, net::report_to_json(net->report()));
}

HttpResponse Api::unload(const Call& call) {
  const rcc::NetId id = net_in(call);
  if (!cell_.core().knows(id)) return unknown_net(call);
  if (const Diagnostics why = cell_.holders().check_owner(call.fence, id); why.has_errors())
    return problem(409, "the net is somebody else's", why);
  if (cell_.core().unload(id)) return json_answer(200, {{"net", id}});
  return problem(409, fmt::format("the net is {}: cancel it, or wait", name_of(cell_.core().state(id))));
}

HttpResponse Api::posted(rcc::RequestId request) const {
  if (request == 0) return problem(429, "too many requests in this cycle: ask again");
  return json_answer(202, {{"request", request}});
}

std::optional<HttpResponse> Api::check_quota(const Call& call, bool waits) {
  constexpr std::size_t kEventsAtOnce = 4096;
  Asked& asked = asked_[call.client.name];
  if (std::exchange(asked.cycle, cell_.core().cycle()) != cell_.core().cycle()) asked.in_cycle = 0;
  if (asked.in_cycle >= kRequestsOfOne)
    return problem(429, fmt::format("{} requests of yours go to one cycle: ask again", kRequestsOfOne));
  if (!waits || asked.waiting.size() < kRulesOfOne) return {};
  for (;;) {
    const auto page = cell_.events_from(answers_seen_, kEventsAtOnce);
    for (const LoggedEvent& one : page.events)
      for (auto& [client, other] : asked_) other.waiting.erase(one.event.request);
    answers_seen_ = page.next;
    if (page.events.size() < kEventsAtOnce) break;
  }
  if (asked.waiting.size() < kRulesOfOne) return {};
  return problem(429,
                 fmt::format("{} rules of yours are waiting: let some come true, or unload their nets", kRulesOfOne));
}

void Api::note_posted(const Call& call, rcc::RequestId request, bool waits) {
  Asked& asked = asked_[call.client.name];
  ++asked.in_cycle;
  if (waits && request != 0) asked.waiting.insert(request);
}

HttpResponse Api::command(const Call& call, const std::string& what) {
  const rcc::NetId id = net_in(call);
  if (!cell_.core().knows(id)) return unknown_net(call);
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  auto late = expired(reader, cell_.core());
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the command cannot be read", diagnostics);
  if (late) return std::move(*late);
  const Diagnostics foreign =
      what == "start" ? cell_.holders().check_start(call.fence, id) : cell_.holders().check_owner(call.fence, id);
  if (foreign.has_errors()) return problem(409, "this net is not for you to command", foreign);
  if (what == "abort") return posted(cell_.core().abort(id));
  if (auto full = check_quota(call, false)) return std::move(*full);
  const rcc::RequestId request = what == "start" ? cell_.core().start(id) : cell_.core().cancel(id);
  note_posted(call, request, false);
  return posted(request);
}

HttpResponse Api::post_rule(const Call& call) {
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const rcc::Rule rule = read_rule(reader, cell_.core());
  auto late = expired(reader, cell_.core());
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the rule cannot be read", diagnostics);
  if (late) return std::move(*late);
  Diagnostics foreign = cell_.holders().check(call.fence, rule.action);
  foreign.append(cell_.holders().check(call.fence, rule.otherwise));
  if (foreign.has_errors()) return problem(409, "these nets are not for you to command", foreign);
  const bool waits = rule.condition.size > 0;
  if (auto full = check_quota(call, waits)) return std::move(*full);
  const rcc::RequestId request = cell_.core().post(rule);
  note_posted(call, request, waits);
  return posted(request);
}

HttpResponse Api::schedule(const Call& call) {
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const rcc::NetId predecessor = read_net(reader, "predecessor"), successor = read_net(reader, "successor");
  const rcc::NetId from_rest = reader.has("from_rest") ? read_net(reader, "from_rest") : 0;
  auto late = expired(reader, cell_.core());
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  if (late) return std::move(*late);
  Diagnostics foreign = cell_.holders().check_start(call.fence, successor);
  if (from_rest != 0) foreign.append(cell_.holders().check_start(call.fence, from_rest));
  if (foreign.has_errors()) return problem(409, "these nets are not for you to command", foreign);
  if (auto full = check_quota(call, true)) return std::move(*full);
  const auto request = cell_.core().schedule_after(predecessor, successor, from_rest);
  if (!request) return problem(409, "the successor cannot follow", request.error());
  note_posted(call, *request, true);
  return posted(*request);
}

}  // namespace takt::serve
