// Recordings that clients begin and end.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "serve/api.h"
#include "serve/recordings.h"

namespace takt::serve {
namespace {

using RecordingJson = nlohmann::ordered_json;

const std::vector<Field> kRecordingAnswer = {
    {"state", "string", "off, on, or last: only so many seconds are kept until they are saved"},
    {"seconds", "number", "of last"},
    {"files", "array", "names of those that are finished"},
    {"error", "string", "why the newest one stopped; empty: nothing went wrong"}};

/// Why clients cannot record.
HttpResponse recorded_by_run() {
  Diagnostics diagnostics;
  diagnostics.error(Code::kConflict, "", "a program commands this cell", "Record its run with --record");
  return problem(409, "clients cannot record this run", diagnostics);
}

HttpResponse status_answer(const Recordings* recordings) {
  const Recordings::Status status = recordings != nullptr ? recordings->status() : Recordings::Status{};
  return json_answer(
      200,
      {{"state", name_of(status.state)}, {"seconds", status.last_s}, {"files", status.files}, {"error", status.error}});
}

}  // namespace

void Api::add_recording_routes() {
  routes_.push_back(
      {.method = "GET",
       .path = "/v1/recording",
       .id = "recording",
       .summary = "What is recorded, and the files so far.",
       .answer = kRecordingAnswer,
       .handle = [this](const Call&, const Respond& respond) { respond(status_answer(cell_.recordings())); }});
  routes_.push_back({.method = "PUT",
                     .path = "/v1/recording",
                     .id = "set_recording",
                     .summary = "Begins or ends a recording; the server chooses the name of the file.",
                     .need = Need::kOperator,
                     .body = {{"state", "string", "off, on or last"},
                              {"seconds", "number", "of last: so much is kept in memory (default 30)", false, 1,
                               static_cast<std::int64_t>(Recordings::kLongest_s)}},
                     .answer = kRecordingAnswer,
                     .handle = [this](const Call& call, const Respond& respond) { set_recording(call, respond); }});
  routes_.push_back({.method = "POST",
                     .path = "/v1/recording/save",
                     .id = "save_recording",
                     .summary = "Writes the seconds that are kept to a file, and goes on keeping.",
                     .need = Need::kOperator,
                     .answer = {{"file", "string", "its name in the folder of the server"}},
                     .handle = [this](const Call& call, const Respond& respond) { save_recording(call, respond); }});
}

void Api::set_recording(const Call& call, const Respond& respond) {
  const auto json = read_body(*call.request);
  if (!json) return respond(json.error());
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const std::string state = reader.text("state");
  constexpr double kUsual_s = 30.0;
  const double seconds = reader.has("seconds")
                             ? reader.number("seconds", {}, Range{.low = 1.0, .high = Recordings::kLongest_s})
                             : kUsual_s;
  reader.finish();
  if (!diagnostics.has_errors() && state != "off" && state != "on" && state != "last")
    diagnostics.error(Code::kUnknownName, "/state", fmt::format("a recording is never '{}'", state),
                      "Give off, on or last");
  if (diagnostics.has_errors()) return respond(problem(422, "the request cannot be read", diagnostics));
  if (cell_.recordings() == nullptr) return respond(recorded_by_run());
  const auto job = [this, state, seconds, name = call.client.name, respond] {
    Recordings* recordings = cell_.recordings();
    const Diagnostics why = state == "off" ? recordings->end() : recordings->begin(state == "last" ? seconds : 0.0);
    if (why.has_errors()) return respond(problem(409, "the recording cannot be changed", why));
    log_(fmt::format("'{}' has set the recording to {}", name, state));
    respond(status_answer(recordings));
  };
  if (!work_elsewhere(job)) respond(problem(429, "too much is waiting to be done: ask again"));
}

void Api::save_recording(const Call& call, const Respond& respond) {
  const auto json = read_body(*call.request);
  if (!json) return respond(json.error());
  Diagnostics diagnostics;
  ObjectReader(*json, "", diagnostics).finish();
  if (diagnostics.has_errors()) return respond(problem(422, "the request cannot be read", diagnostics));
  if (cell_.recordings() == nullptr) return respond(recorded_by_run());
  const auto job = [this, name = call.client.name, respond] {
    const auto file = cell_.recordings()->save();
    if (!file) return respond(problem(409, "nothing was saved", file.error()));
    log_(fmt::format("'{}' has saved {}", name, *file));
    respond(json_answer(200, {{"file", *file}}));
  };
  if (!work_elsewhere(job)) respond(problem(429, "too much is waiting to be done: ask again"));
}

}  // namespace takt::serve
