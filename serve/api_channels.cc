// Values that go in (channels) and out (watches).
#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/keys_of.h"
#include "core/base/object_reader.h"
#include "serve/api.h"
#include "serve/cell_json.h"

namespace takt::serve {
namespace {

using ValueJson = nlohmann::ordered_json;

constexpr std::int64_t kMostEvery = 100'000, kMostKept = 100'000, kMostTaken = 4096;

const std::vector<Field> kWatchAnswer = {{"watch", "integer", "its number"},
                                         {"every", "integer", "cycles between two values"}};

std::int64_t watch_in(const Call& call) {
  const std::string& text = call.path.at("watch");
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  return error == std::errc() && end == text.data() + text.size() ? id : 0;
}

HttpResponse unknown_watch(const Call& call) {
  return problem(404, fmt::format("there is no watch '{}'", call.path.at("watch")));
}

}  // namespace

void Api::add_channel_routes() {
  routes_.push_back({.method = "GET",
                     .path = "/v1/channels",
                     .id = "channels",
                     .summary = "All channels: type, unit, who writes, value and age.",
                     .answer = {{"cycle", "integer", "after which the values were copied"}, {"channels", "array", ""}},
                     .handle = [this](const Call&, const Respond& respond) { respond(channels()); }});
  routes_.push_back({.method = "PUT",
                     .path = "/v1/channels/{channel}",
                     .id = "write_channel",
                     .summary = "Writes a channel from outside; the newest value of a cycle counts.",
                     .need = Need::kChannels,
                     .body = {{"value", "", "in the form of its type in net files; null: no value"},
                              {"expires_at_cycle", "integer", "refused from this cycle on (default: never)", false, 0}},
                     .answer = {{"written", "boolean", "true"}},
                     .handle = [this](const Call& call, const Respond& respond) { respond(write_channel(call)); }});
}

void Api::add_watch_routes() {
  routes_.push_back(
      {.method = "POST",
       .path = "/v1/watches",
       .id = "add_watch",
       .summary = "Watches a monitor or an output of a net, or a channel.",
       .need = Need::kOperator,
       .status = 201,
       .body = {{"net", "integer", "number of a net; without it a channel is meant", false, 1},
                {"port", "string", "monitor or id.port of the net, or name of the channel"},
                {"every", "integer", "cycles between two values (default 1); 0: none for now", false, 0, kMostEvery},
                {"keep", "integer", "values that are kept until they are read (default 0: the newest only)", false, 0,
                 kMostKept}},
       .answer = kWatchAnswer,
       .handle = [this](const Call& call, const Respond& respond) { respond(add_watch(call)); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/watches/{watch}",
                     .id = "read_watch",
                     .summary = "The newest value; with `keep` the values since the last time, oldest first.",
                     .answer = {{"newest", "", "cycle and value; null: none yet"},
                                {"values", "array", "cycle and value of each"},
                                {"dropped", "integer", "values that there was no room for"},
                                {"ended", "boolean", "no value comes any more"}},
                     .handle = [this](const Call& call, const Respond& respond) { respond(read_watch(call)); }});
  routes_.push_back({.method = "PUT",
                     .path = "/v1/watches/{watch}",
                     .id = "set_watch",
                     .summary = "Changes the rate of a watch.",
                     .need = Need::kOperator,
                     .body = {{"every", "integer", "cycles between two values; 0: none for now", true, 0, kMostEvery}},
                     .answer = kWatchAnswer,
                     .handle = [this](const Call& call, const Respond& respond) { respond(set_watch(call)); }});
  routes_.push_back({.method = "DELETE",
                     .path = "/v1/watches/{watch}",
                     .id = "drop_watch",
                     .summary = "Ends a watch.",
                     .need = Need::kOperator,
                     .answer = {{"watch", "integer", "its number"}},
                     .handle = [this](const Call& call, const Respond& respond) { respond(drop_watch(call)); }});
}

HttpResponse Api::channels() const {
  const CellView view = cell_.view();
  ValueJson list = ValueJson::array();
  for (const CellView::Channel& one : view.channels) {
    const device::ChannelDescription& known = cell_.built().cell.channels.at(one.name)->description();
    list.push_back({{"name", one.name},
                    {"type", name_of(known.type)},
                    {"unit", known.unit},
                    {"writer", known.writer == device::ChannelDescription::Writer::kOutside ? "outside" : "net"},
                    {"value", to_json(one.value)},
                    {"age_s", one.age ? ValueJson(to_seconds(*one.age)) : ValueJson()}});
  }
  return json_answer(200, {{"cycle", view.cycle}, {"channels", list}});
}

HttpResponse Api::write_channel(const Call& call) {
  const auto& channels = cell_.built().cell.channels;
  const std::string& name = call.path.at("channel");
  const auto found = channels.find(name);
  Diagnostics diagnostics;
  if (found == channels.end()) {
    diagnostics.error(Code::kUnknownName, "", fmt::format("the cell has no channel '{}'", name),
                      nearest_choice(name, keys_of(channels)));
    return problem(404, "there is no such channel", diagnostics);
  }
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  ObjectReader reader(*json, "", diagnostics);
  const ValueJson* given = reader.child("value");
  const auto expires = reader.has("expires_at_cycle")
                           ? std::optional(reader.integer("expires_at_cycle", {}, Range{.low = 0, .high = 9e15}))
                           : std::nullopt;
  reader.finish();
  if (given == nullptr) diagnostics.error(Code::kMissing, "/value", "no value", "Give a value, or null");
  std::optional<device::ChannelValue> value;
  if (given != nullptr) diagnostics.append(read_value(*given, found->second->description().type, value), "/value");
  if (diagnostics.has_errors()) return problem(422, "the value cannot be read", diagnostics);
  if (expires && cell_.core().cycle() >= *expires) return problem(409, "the value comes too late");
  // ARM.speed and the like belong to that arm.
  const std::string owner = name.substr(0, name.find('.'));
  if (cell_.built().cell.arms.contains(owner))
    if (const Diagnostics why = cell_.holders().check_device(call.fence, owner); why.has_errors())
      return problem(409, "this channel belongs to an arm that you do not hold", why);
  using Written = device::Channel::Written;
  switch (value ? found->second->write(*value) : found->second->write_null()) {
    case Written::kDone:
      return json_answer(200, {{"written", true}});
    case Written::kNetWrites:
      return problem(409, "nets write this channel");
    case Written::kBusy:
      return problem(503, "others write this channel just now: ask again");
    case Written::kWrongType:
      break;
  }
  return problem(500, "the value has another type than the channel");
}

HttpResponse Api::add_watch(const Call& call) {
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const std::string port = reader.text("port");
  const auto net = reader.integer("net", 0, Range{.low = 1, .high = 4294967295.0});
  rcc::WatchOptions options;
  options.every = static_cast<int>(reader.integer("every", 1, Range{.low = 0, .high = double(kMostEvery)}));
  options.capacity = static_cast<int>(reader.integer("keep", 0, Range{.low = 0, .high = double(kMostKept)}));
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  const auto own = [this, &call] {
    return static_cast<std::size_t>(
        std::ranges::count_if(watches_, [&call](const auto& one) { return one.second.client == call.client.name; }));
  };
  if (watches_.size() >= kMostWatches || own() >= kWatchesOfOne)
    std::erase_if(watches_, [](const auto& one) { return one.second.watch->ended(); });
  if (own() >= kWatchesOfOne) return problem(429, fmt::format("you have {} watches: end some", kWatchesOfOne));
  if (watches_.size() >= kMostWatches) return problem(429, fmt::format("there are {} watches: end some", kMostWatches));
  auto watch =
      net != 0 ? cell_.core().watch(static_cast<rcc::NetId>(net), port, options) : cell_.core().watch(port, options);
  if (!watch) return problem(422, "this cannot be watched", watch.error());
  watches_[++last_watch_] = {.watch = std::move(*watch), .client = call.client.name};
  HttpResponse response = json_answer(201, {{"watch", last_watch_}, {"every", options.every}});
  response.headers["Location"] = fmt::format("/v1/watches/{}", last_watch_);
  return response;
}

HttpResponse Api::read_watch(const Call& call) {
  const auto found = watches_.find(watch_in(call));
  if (found == watches_.end()) return unknown_watch(call);
  rcc::Watch& watch = *found->second.watch;
  const bool ended = watch.ended();  // before its last values are taken
  std::vector<rcc::WatchedValue> taken(kMostTaken);
  taken.resize(watch.take(taken));
  ValueJson values = ValueJson::array();
  for (const rcc::WatchedValue& one : taken) values.push_back(to_json(one));
  const auto newest = watch.newest();
  return json_answer(200, {{"newest", newest ? to_json(*newest) : ValueJson()},
                           {"values", values},
                           {"dropped", watch.dropped()},
                           {"ended", ended}});
}

HttpResponse Api::set_watch(const Call& call) {
  const auto found = watches_.find(watch_in(call));
  if (found == watches_.end()) return unknown_watch(call);
  const auto json = read_body(*call.request);
  if (!json) return json.error();
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  const auto every = reader.integer("every", {}, Range{.low = 0, .high = double(kMostEvery)});
  reader.finish();
  if (diagnostics.has_errors()) return problem(422, "the request cannot be read", diagnostics);
  found->second.watch->set_every(static_cast<int>(every));
  return json_answer(200, {{"watch", found->first}, {"every", every}});
}

HttpResponse Api::drop_watch(const Call& call) {
  const auto found = watches_.find(watch_in(call));
  if (found == watches_.end()) return unknown_watch(call);
  const std::int64_t id = found->first;
  cell_.core().unwatch(found->second.watch);
  watches_.erase(found);
  return json_answer(200, {{"watch", id}});
}

}  // namespace takt::serve
