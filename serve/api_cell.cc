// The cell as a whole: state, events, time, STOP.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/site_devices.h"
#include "core/base/object_reader.h"
#include "core/base/version.h"
#include "record/recorder.h"
#include "serve/api.h"
#include "serve/cell_json.h"

namespace takt::serve {
namespace {

using CellJson = nlohmann::ordered_json;

constexpr std::int64_t kMostEvents = 4096;

/// The most serious of all devices: what moves counts before what is emulated, and that before what is simulated.
std::string_view reality_of(const std::map<std::string, device::BackendMode>& realities) {
  auto most = device::BackendMode::kSimulated;
  for (const auto& [name, reality] : realities) most = std::max(most, reality);
  return name_of(most);
}

/// What stands in the way now: cause, since when, and what to do.
CellJson faults_json(const CellView& view, const cell::BuiltCell& built, Nanoseconds period) {
  CellJson faults = CellJson::array();
  const auto add = [&](const std::string& device, std::int64_t cycle, const std::string& cause, const char* hint) {
    faults.push_back({{"device", device},
                      {"cycle", cycle},
                      {"time_s", to_seconds(period) * static_cast<double>(cycle)},
                      {"cause", cause},
                      {"hint", hint}});
  };
  if (view.emergency_stop)
    add(built.emergency_stop->name(), view.emergency_cycle, "the emergency stop is pressed",
        "Release it, then reset it");
  for (const ArmView& arm : view.arms)
    if (arm.fault != 0)
      add(arm.name, arm.fault_cycle, built.cell.arms.at(arm.name).device->fault_text(arm.fault),
          "Remove the cause, then reset the arm");
  return faults;
}

}  // namespace

void Api::add_cell_routes() {
  const std::vector<Field> state_answer = {{"cycle", "integer", "the next cycle to be run"},
                                           {"time_s", "number", "time of that cycle, s"},
                                           {"digest", "string", "of all cycles so far"},
                                           {"connected", "boolean", "all devices are there: nets may start"}};
  Route state_route{.method = "GET",
                    .path = "/v1/state",
                    .id = "state",
                    .summary = "Time, digest and holder of the cell.",
                    .answer = state_answer,
                    .handle = [this](const Call&, const Respond& respond) { respond(state()); }};
  state_route.answer.push_back({"realtime", "boolean", "the wall clock's pace; else POST /v1/steps"});
  state_route.answer.push_back({"holder", "integer", "fence of the newest lease; 0: nobody holds one"});
  state_route.answer.push_back({"holder_name", "string", "who holds that; empty: nobody"});
  state_route.answer.push_back({"title", "string", "of the file"});
  state_route.answer.push_back({"reality", "string", "SIM, EMULATED or HARDWARE: the most serious of all devices"});
  state_route.answer.push_back({"program", "boolean", "a program commands the cell (/v1/program), no client does"});
  state_route.answer.push_back({"health", "object", "overruns: cycles that began late; worst_cycle_s: the longest, s"});
  state_route.answer.push_back({"faults", "array", "device, cycle, time_s, cause, hint of what stands in the way now"});
  routes_.push_back(std::move(state_route));
  routes_.push_back({.method = "GET",
                     .path = "/v1/cell",
                     .id = "cell",
                     .summary = "From which file the cell is built: a program in another process builds the same.",
                     .answer = {{"file", "string", "its name"},
                                {"hash", "string", "of its text, with what was changed on the command line"},
                                {"seed", "integer", "that it was built with"},
                                {"realtime", "boolean", "the wall clock's pace"},
                                {"version", "string", "of takt"}},
                     .handle = [this](const Call&, const Respond& respond) {
                       const cell::Description& cell = cell_.description();
                       respond(json_answer(200, {{"file", cell.file.filename().string()},
                                                 {"hash", record::content_hash(cell.text)},
                                                 {"seed", cell.seed},
                                                 {"realtime", cell_.realtime()},
                                                 {"version", TAKT_VERSION}}));
                     }});
  routes_.push_back(
      {.method = "GET",
       .path = "/v1/events",
       .id = "events",
       .summary =
           "What has happened, in order; with `next` of one answer as `from` of the next request nothing is missed.",
       .query = {{"from", "integer", "number of the first event", false, 1},
                 {"most", "integer", "events in one answer", false, 1, kMostEvents}},
       .answer = {{"events", "array", "in order, numbered without gaps"},
                  {"next", "integer", "number to go on from"},
                  {"lost", "boolean", "events before the first one are not kept any more"}},
       .handle = [this](const Call& call, const Respond& respond) { respond(events(call)); }});
  routes_.push_back({.method = "POST",
                     .path = "/v1/steps",
                     .id = "steps",
                     .summary = "Lock-step: runs so many cycles and answers after the last one.",
                     .need = Need::kHolder,
                     .body = {{"cycles", "integer", "how many", true, 1, kMostCycles}},
                     .answer = state_answer,
                     .handle = [this](const Call& call, const Respond& respond) { steps(call, respond); }});
  routes_.push_back({.method = "POST",
                     .path = "/v1/stop",
                     .id = "stop",
                     .summary = "STOP: ends all nets in the next cycle; arms brake within their limits.",
                     .need = Need::kStop,
                     .answer = {{"stopped", "boolean", "true"}},
                     .handle = [this](const Call& call, const Respond& respond) { respond(stop(call)); }});
}

HttpResponse Api::state() const {
  const CellView view = cell_.view();
  CellJson json = to_json(view);
  const std::vector<Holders::Holding> holders = cell_.holders().list();
  json["realtime"] = cell_.realtime();
  json["holder"] = holders.empty() ? 0 : holders.back().fence;
  json["holder_name"] = holders.empty() ? "" : holders.back().client;
  json["title"] = cell_.description().title;
  json["reality"] = reality_of(cell_.built().site->realities());
  json["program"] = cell_.program() != nullptr;
  json["health"] = {{"overruns", view.overruns}, {"worst_cycle_s", to_seconds(view.worst_cycle)}};
  json["faults"] = faults_json(view, cell_.built(), cell_.period());
  return json_answer(200, json);
}

HttpResponse Api::events(const Call& call) const {
  const auto value = [&call](const char* name, std::int64_t fallback) {
    const auto found = call.query.find(name);
    return found == call.query.end() ? fallback : found->second;
  };
  const auto found = cell_.events_from(value("from", 1), static_cast<std::size_t>(value("most", kMostEvents)));
  CellJson list = CellJson::array();
  for (const LoggedEvent& event : found.events) list.push_back(to_json(event));
  return json_answer(200, {{"events", list}, {"next", found.next}, {"lost", found.lost}});
}

void Api::steps(const Call& call, const Respond& respond) {
  const auto json = read_body(*call.request);
  if (!json) return respond(json.error());
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const std::int64_t cycles = reader.integer("cycles", {}, Range{.low = 1, .high = double(kMostCycles)});
  reader.finish();
  if (diagnostics.has_errors()) return respond(problem(422, "the request cannot be read", diagnostics));
  if (cell_.realtime()) return respond(problem(409, "this cell runs in real time: nobody steps it"));
  const bool taken = cell_.steps(cycles, [respond](const CellView& view) { respond(json_answer(200, to_json(view))); });
  if (!taken) respond(problem(429, "too many orders wait: ask again"));
}

HttpResponse Api::stop(const Call& call) {
  cell_.stop_all(call.client.name);
  log_(fmt::format("STOP by '{}'", call.client.name));
  return json_answer(200, {{"stopped", true}});
}

}  // namespace takt::serve
