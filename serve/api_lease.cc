// Who commands which devices.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "serve/api.h"

namespace takt::serve {
namespace {

using LeaseJson = nlohmann::ordered_json;

/// In place of a device: one client at a time writes the channels of a program.
constexpr std::string_view kProgramChannels = "/channels";
constexpr std::int64_t kMostSilence = 600'000;  // ten minutes at 1 kHz

const std::vector<Field> kLeaseAnswer = {{"fence", "integer", "for the header Takt-Fence; 0: nobody holds the lease"}};

/// Devices that a net can hold, by their names.
std::vector<std::string> driven_devices(const expression::Cell& cell) {
  std::vector<std::string> names;
  const auto add = [&names](const auto& devices) {
    for (const auto& [name, device] : devices) names.push_back(name);
  };
  add(cell.arms);
  add(cell.grippers);
  add(cell.digital_outputs);
  add(cell.analog_outputs);
  return names;
}

std::optional<Holders::Devices> read_devices(ObjectReader& reader, const expression::Cell& cell) {
  if (!reader.has("devices")) return std::nullopt;
  const std::vector<std::string> known = driven_devices(cell), asked = reader.texts("devices");
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (std::ranges::find(known, asked[i]) == known.end())
      reader.diagnostics().error(Code::kUnknownName, reader.at("devices") + pointer_segment(i),
                                 fmt::format("the cell has no device '{}' that can be driven", asked[i]),
                                 nearest_choice(asked[i], known));
  if (asked.empty() && !reader.diagnostics().has_errors())
    reader.diagnostics().error(Code::kMissing, reader.at("devices"), "no devices",
                               "Name at least one, or leave the list out for all");
  return Holders::Devices(asked.begin(), asked.end());
}

}  // namespace

void Api::add_lease_routes() {
  routes_.push_back({.method = "GET",
                     .path = "/v1/lease",
                     .id = "leases",
                     .summary = "Who holds which devices.",
                     .answer = {{"leases", "array", "fence, client and devices of each; devices null: all"}},
                     .handle = [this](const Call&, const Respond& respond) { respond(leases()); }});
  routes_.push_back(
      {.method = "POST",
       .path = "/v1/lease",
       .id = "take_lease",
       .summary = "Makes this client the holder of devices; what a former one had running comes to rest on its path. "
                  "Where a program commands the cell the holder writes its channels, and nothing else.",
       .need = Need::kOperator,
       .status = 201,
       .body = {{"cycles", "integer", "of silence, after which everything of this client comes to rest; real time only",
                 false, 1, kMostSilence},
                {"devices", "array", "names of what is wanted (default: all of the cell)", false},
                {"take_over", "boolean", "also if somebody else holds one of them (default false)", false}},
       .answer = kLeaseAnswer,
       .handle = [this](const Call& call, const Respond& respond) { respond(take_lease(call)); }});
  routes_.push_back({.method = "PUT",
                     .path = "/v1/lease",
                     .id = "renew_lease",
                     .summary = "A sign of life of the holder; every command is one too.",
                     .need = Need::kChannels,
                     .answer = kLeaseAnswer,
                     .handle = [this](const Call& call, const Respond& respond) { respond(renew_lease(call)); }});
  routes_.push_back({.method = "DELETE",
                     .path = "/v1/lease",
                     .id = "release_lease",
                     .summary = "The holder lets go; what it has running comes to rest on its path.",
                     .need = Need::kChannels,
                     .answer = kLeaseAnswer,
                     .handle = [this](const Call& call, const Respond& respond) { respond(release_lease(call)); }});
}

HttpResponse Api::leases() const {
  LeaseJson list = LeaseJson::array();
  for (const Holders::Holding& one : cell_.holders().list())
    list.push_back({{"fence", one.fence},
                    {"client", one.client},
                    {"devices", one.devices ? LeaseJson(*one.devices) : LeaseJson()}});
  return json_answer(200, {{"leases", list}});
}

HttpResponse Api::take_lease(const Call& call) {
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  constexpr std::int64_t kSilence = 200;
  const std::int64_t cycles = reader.integer("cycles", kSilence, Range{.low = 1, .high = double(kMostSilence)});
  auto devices = read_devices(reader, cell_.built().cell);
  const bool take_over = reader.boolean("take_over", false);
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  if (cell_.program() != nullptr && devices) {
    diagnostics.error(Code::kConflict, "/devices", "a program commands the devices of this cell",
                      "Leave devices out: the lease is for the channels then");
    return problem(409, "the devices are commanded by a program", diagnostics);
  }
  if (cell_.program() != nullptr) devices = Holders::Devices{std::string(kProgramChannels)};
  const auto fence =
      cell_.holders().take(call.client.name, std::move(devices), cell_.realtime() ? cycles : 0, take_over, log_);
  if (!fence) return problem(409, "somebody else holds the lease", fence.error());
  return json_answer(201, {{"fence", *fence}});
}

HttpResponse Api::renew_lease(const Call& call) {
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader(*json, "", diagnostics).finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  return json_answer(200, {{"fence", call.fence}});
}

HttpResponse Api::release_lease(const Call& call) {
  if (!cell_.lease().release(call.fence)) return problem(409, "the lease is not yours");
  log_(fmt::format("'{}' has let go of the lease, fence {}", call.client.name, call.fence));
  return json_answer(200, {{"fence", 0}});
}

}  // namespace takt::serve
