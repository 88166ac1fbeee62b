// events: what a recorded run tells of itself.
#include <algorithm>
#include <cctype>
#include <iterator>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/judge/run_log.h"
#include "core/base/text_location.h"
#include "record/recording.h"
#include "tools/cli.h"
#include "tools/unread.h"

namespace takt::tools {
namespace {

using cell::LogEntry;

struct EventsArguments {
  std::string recording, level = "debug";
  std::vector<std::string> sources;
};

/// takt's own events; of a recording by something else its log.
std::vector<std::string> topics_of(const record::Recording& recording) {
  std::vector<std::string> topics = recording.event_topics();
  std::erase(topics, record::kBlockTopic);
  const bool own = std::ranges::any_of(
      topics, [&](const std::string& topic) { return recording.find_channel(topic)->schema == "takt.Event"; });
  if (own)
    std::erase_if(topics, [&](const auto& topic) { return recording.find_channel(topic)->schema != "takt.Event"; });
  return topics;
}

/// Levels of a foreign log are in capitals, in place of a name.
LogEntry entry_of(const record::RecordedEvent& event) {
  std::string lower = event.name;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto of_log = lower == event.name ? std::nullopt : cell::log_level_named(lower);
  return {.time = event.time,
          .cycle = event.cycle,
          .level = of_log.value_or(cell::level_of(event.source, event.name)),
          .source = event.source,
          .name = of_log ? "log" : event.name,
          .step = event.step,
          .text = event.text};
}

/// Of all topics, in the order of time.
Result<std::vector<LogEntry>> entries_of(const record::Recording& recording) {
  std::vector<LogEntry> entries;
  for (const std::string& topic : topics_of(recording)) {
    const auto events = recording.events(topic);
    if (!events) return std::unexpected(events.error());
    std::ranges::transform(*events, std::back_inserter(entries), entry_of);
  }
  std::ranges::stable_sort(entries, {}, &LogEntry::time);
  return entries;
}

/// By its message type, whatever its encoding.
bool may_have_events(const record::ChannelInfo& channel) {
  std::string schema = channel.schema;
  std::ranges::transform(schema, schema.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return schema.ends_with("log") || schema.ends_with("event");
}

Diagnostics check(const EventsArguments& arguments) {
  Diagnostics diagnostics;
  if (!cell::log_level_named(arguments.level))
    diagnostics.error(Code::kUnknownName, "--level", fmt::format("'{}' is not a level", arguments.level),
                      nearest_choice(arguments.level, cell::log_level_names()));
  return diagnostics;
}

int events(const EventsArguments& arguments, const Common& common) {
  if (const Diagnostics diagnostics = check(arguments); diagnostics.has_errors()) return report(diagnostics, common);
  const auto recording = record::Recording::open(arguments.recording);
  if (!recording) return report(recording.error(), common);
  auto entries = entries_of(*recording);
  if (!entries) {
    entries.error().set_file(arguments.recording);
    return report(entries.error(), common);
  }
  // Where nothing is read as events, every topic may have some.
  const bool any_read = !topics_of(*recording).empty();
  const Diagnostics unread = unread_parts(*recording, arguments.recording, [&](const record::ChannelInfo& channel) {
    return !any_read || may_have_events(channel);
  });
  const auto least = *cell::log_level_named(arguments.level);
  std::erase_if(*entries, [&](const LogEntry& entry) {
    const bool of_source =
        arguments.sources.empty() || std::ranges::find(arguments.sources, entry.source) != arguments.sources.end();
    return entry.level < least || !of_source;
  });
  if (unread.has_errors() && entries->empty()) return report(unread, common);
  const int status = unread.has_errors() ? kBadInput : kHeld;
  fmt::print(stderr, "{}", to_located_text(unread));
  if (common.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const LogEntry& entry : *entries) list.push_back(to_json(entry));
    print({{"result", status == kHeld ? "read" : "partly read"},
           {"events", std::move(list)},
           {"diagnostics", to_json(unread)}});
    return status;
  }
  for (const LogEntry& entry : *entries) fmt::print("{}\n", to_text(entry));
  return status;
}

}  // namespace

std::pair<CLI::App*, Verb> add_events(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<EventsArguments>();
  CLI::App* verb = app.add_subcommand("events", "What a recorded run tells: steps, retries, contacts, faults, acts");
  verb->add_option("RECORDING", arguments->recording, "Recording (MCAP)")->required();
  verb->add_option("--level", arguments->level, "From this level on: debug, info, warning, error")
      ->type_name("LEVEL")
      ->capture_default_str();
  verb->add_option("--source", arguments->sources,
                   "Only of this source: program, contact, operator, ...; several times")
      ->type_name("NAME")
      ->allow_extra_args(false);
  return {verb, [arguments, &common] { return events(*arguments, common); }};
}

}  // namespace takt::tools
