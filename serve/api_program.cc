// The program of a run that is watched: its tree, where it is, and what operators ask of it.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "serve/api.h"
#include "serve/program_desk.h"

namespace takt::serve {
namespace {

using ProgramJson = nlohmann::ordered_json;

constexpr std::int64_t kMostEntries = 1000;
constexpr int kDeepestCall = 8;

HttpResponse no_program() {
  Diagnostics why;
  why.error(Code::kNotFound, "", "this cell is served without a program", "Run one with 'takt run FILE --panel'");
  return problem(404, "there is no program", why);
}

/// The steps in a part of a program, in the order of the file: a step is an object that says what to "do". Of each its
/// kind, its name, its place in the file and what is in it.
class StepTree {
 public:
  explicit StepTree(const ProgramJson& programs) : programs_(programs) {}

  [[nodiscard]] ProgramJson steps_in(const ProgramJson& part, const std::string& pointer, int depth = 0) const {
    ProgramJson steps = ProgramJson::array();
    add(part, pointer, depth, steps);
    return steps;
  }

 private:
  void add(const ProgramJson& part, const std::string& pointer, int depth, ProgramJson& steps) const {
    if (part.is_object() && part.contains("do") && part["do"].is_string()) {
      steps.push_back(step(part, pointer, depth));
    } else if (part.is_structured()) {
      add_parts(part, pointer, depth, steps);
    }
  }

  void add_parts(const ProgramJson& whole, const std::string& pointer, int depth, ProgramJson& steps) const {
    std::size_t index = 0;
    for (const auto& [key, part] : whole.items())
      add(part, pointer + (whole.is_array() ? pointer_segment(index++) : pointer_segment(key)), depth, steps);
  }

  [[nodiscard]] ProgramJson step(const ProgramJson& json, const std::string& pointer, int depth) const {
    ProgramJson inside = ProgramJson::array();
    add_parts(json, pointer, depth, inside);
    const std::string called = json["do"] == "call" && json.contains("program") && json["program"].is_string()
                                   ? json["program"].get<std::string>()
                                   : std::string();
    if (depth < kDeepestCall && programs_.is_object() && programs_.contains(called))
      add(programs_[called], "/programs" + pointer_segment(called), depth + 1, inside);
    return {{"do", json["do"]},
            {"name", json.contains("name") && json["name"].is_string() ? json["name"] : ProgramJson("")},
            {"pointer", pointer},
            {"steps", std::move(inside)}};
  }

  const ProgramJson& programs_;
};

ProgramJson view_json(const ProgramDesk::View& view) {
  return {{"state", name_of(view.state)},
          {"speed", view.speed},
          {"steps", view.steps},
          {"single", view.single},
          {"cancelled", view.cancelled},
          {"next", {{"name", view.next.name}, {"pointer", view.next.pointer}, {"changed", view.next.changed}}},
          {"planned_s", view.planned},
          {"running", view.running},
          {"verdict", view.verdict},
          {"findings", view.findings}};
}

HttpResponse accepted(bool done, const ProgramDesk& desk) {
  if (done) return json_answer(200, view_json(desk.view()));
  const ProgramDesk::View view = desk.view();
  Diagnostics why;
  why.error(Code::kNotPossibleNow, "", fmt::format("the program is in the state '{}'", name_of(view.state)),
            view.steps ? "Ask for what fits its state" : "Run without --realtime to go step by step");
  return problem(409, "that is not possible now", why);
}

HttpResponse set_speed(const HttpRequest& request, ProgramDesk& desk) {
  const auto json = read_body(request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const double share = reader.number("share", {}, Range{.low = 0.0, .high = 1.0});
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  return accepted(desk.set_speed(share), desk);
}

HttpResponse log_answer(const Call& call, const ProgramDesk& desk) {
  const auto from = call.query.find("from");
  std::int64_t next = from == call.query.end() ? 1 : from->second;
  ProgramJson entries = ProgramJson::array();
  for (const ProgramDesk::Entry& one : desk.log_from(next, kMostEntries)) {
    ProgramJson json = cell::to_json(one.entry);
    json["sequence"] = one.sequence;
    entries.push_back(std::move(json));
    next = one.sequence + 1;
  }
  return json_answer(200, {{"entries", std::move(entries)}, {"next", next}});
}

const std::vector<Field>& view_fields() {
  static const std::vector<Field> all = {
      {"state", "string", "awaits start, runs, paused, awaits step, ended"},
      {"speed", "number", "share of the planned speed, 0 to 1"},
      {"steps", "boolean", "single steps are possible"},
      {"single", "boolean", "each step waits for its permission"},
      {"cancelled", "boolean", "an end was asked for"},
      {"next", "object", "name and pointer of the step that would begin, and variables that have changed"},
      {"planned_s", "number", "predicted duration, s"},
      {"running", "array", "paths of the steps that run"},
      {"verdict", "string", "once it has ended"},
      {"findings", "array", "once it has ended: what went wrong"}};
  return all;
}

}  // namespace

void Api::add_program_routes() {
  const auto with_desk = [this](auto answer) {
    return [this, answer](const Call& call, const Respond& respond) {
      ProgramDesk* desk = cell_.program();
      respond(desk == nullptr ? no_program() : answer(call, *desk));
    };
  };
  routes_.push_back(
      {.method = "GET",
       .path = "/v1/program",
       .id = "program",
       .summary = "Where the program is that commands this cell.",
       .answer = view_fields(),
       .handle = with_desk([](const Call&, ProgramDesk& desk) { return json_answer(200, view_json(desk.view())); })});
  routes_.push_back({.method = "GET",
                     .path = "/v1/program/tree",
                     .id = "program_tree",
                     .summary = "The steps of the program as its file has them; it does not change.",
                     .answer = {{"steps", "array", "do, name, pointer, steps of each"}},
                     .handle = with_desk([this](const Call&, ProgramDesk&) {
                       const cell::Description& file = cell_.description();
                       const StepTree tree(file.programs);
                       return json_answer(200, {{"steps", tree.steps_in(file.program, "/program")}});
                     })});
  routes_.push_back({.method = "GET",
                     .path = "/v1/program/log",
                     .id = "program_log",
                     .summary = "What the run tells of itself, in order, from a number on; the last 4096 are kept.",
                     .query = {{"from", "integer", "number of the first entry", false, 1}},
                     .answer = {{"entries", "array", "time, level, source, name, step and text of each"},
                                {"next", "integer", "number to go on from"}},
                     .handle = with_desk(log_answer)});
  const auto add = [&](const char* what, const char* summary, bool (ProgramDesk::*ask)()) {
    routes_.push_back(
        {.method = "POST",
         .path = fmt::format("/v1/program/{}", what),
         .id = fmt::format("program_{}", what),
         .summary = summary,
         .need = Need::kOperator,
         .answer = view_fields(),
         .handle = with_desk([ask](const Call&, ProgramDesk& desk) { return accepted((desk.*ask)(), desk); })});
  };
  add("start", "Begins, or goes on without stops.", &ProgramDesk::go_on);
  add("pause", "Motions come to rest on their paths, no step begins.", &ProgramDesk::pause);
  add("step", "One step begins, and the next one waits; the simulated time stands meanwhile.", &ProgramDesk::step);
  add("cancel", "Ends in order: steps that run are cancelled.", &ProgramDesk::cancel);
  routes_.push_back(
      {.method = "PUT",
       .path = "/v1/program/speed",
       .id = "program_speed",
       .summary = "From now on motions run at this share of their planned speed.",
       .need = Need::kOperator,
       .body = {{"share", "number", "0 to 1", true, 0, 1}},
       .answer = view_fields(),
       .handle = with_desk([](const Call& call, ProgramDesk& desk) { return set_speed(*call.request, desk); })});
}

}  // namespace takt::serve
