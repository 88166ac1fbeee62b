#include "cell/file/site.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/form_of.h"
#include "core/base/json.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSimulated = "sim";
constexpr const char* kSlowKind = "slow";
constexpr double kCycleMaxMs = 100.0;  // the slowest that a vendor offers
/// Settings of the kind "slow": key of a site file, word of --backend, unit there, its factor.
struct SlowKey {
  const char* key;
  const char* word;
  const char* unit;
  double factor;
};
constexpr SlowKey kSlowKeys[] = {
    {"cycle_ms", "cycle", "ms", 1.0},
    {"offset_ms", "offset", "ms", 1.0},
    {"drift_ppm", "drift", "ppm", 1.0},
    {"transport_ms", "transport", "ms", 1.0},
    {"jitter_ms", "jitter", "ms", 1.0},
    {"loss", "loss", "%", 0.01},
    {"repeat", "repeat", "%", 0.01},
    {"reorder", "reorder", "%", 0.01},
    {"answer_timeout_cycles", "timeout", "", 1.0},
};

std::vector<std::string> names_of_kinds() {
  std::vector<std::string> names;
  for (const BackendKind& kind : backend_kinds()) names.push_back(kind.name);
  return names;
}

constexpr Range kCycle{.low = 1.0, .high = kCycleMaxMs}, kWire{.low = 0.0, .high = 50.0},
    kShare{.low = 0.0, .high = 0.5};

Form slow_form() {
  const auto ms = [](const char* key, double absent, const Range& range, const char* doc) {
    return number_key(key, "ms", range, doc).by_default(absent);
  };
  const auto share = [](const char* key, const char* doc) { return number_key(key, "", kShare, doc).by_default(0.0); };
  return {
      .doc = "In the simulation, with a clock and a connection of its own.",
      .keys = {number_key("cycle_ms", "ms", kCycle, "Cycle of the device, on its own clock.").optional("its model's"),
               ms("offset_ms", 12'345.678, {.low = -1e9, .high = 1e9}, "Time of its clock when the core's is 0."),
               number_key("drift_ppm", "ppm", {.low = -500.0, .high = 500.0}, "Drift of its clock.").by_default(100.0),
               ms("transport_ms", 0.1, kWire, "Least transport time of a message."),
               ms("jitter_ms", 0.3, kWire, "Largest additional transport time."),
               share("loss", "Share of the messages that do not arrive."),
               share("repeat", "Share of the messages that arrive twice."),
               share("reorder", "Share of the messages that arrive after the next one."),
               integer_key("answer_timeout_cycles", {.low = 0, .high = 100},
                           "Cycles without an answer that an arm bridges before it stops by itself.")
                   .by_default(3.0)}};
}

emulation::SlowOptions read_slow(FormReader& from) {
  const auto time = [&](const char* key) {
    return static_cast<Nanoseconds>(std::llround(from.number(key) * kMillisecond));
  };
  emulation::SlowOptions slow;
  slow.cycle = from.has("cycle_ms") ? time("cycle_ms") : 0;
  slow.clock_offset = time("offset_ms");
  slow.drift = 1e-6 * from.number("drift_ppm");
  slow.wire.transport = time("transport_ms");
  slow.wire.jitter = time("jitter_ms");
  slow.wire.loss = from.number("loss");
  slow.wire.repeat = from.number("repeat");
  slow.wire.reorder = from.number("reorder");
  slow.answer_timeout_cycles = static_cast<int>(from.integer("answer_timeout_cycles"));
  return slow;
}

/// The kinds of back ends of takt itself; those with a driver come from DriverKinds.
std::vector<NamedForm> binding_forms() {
  static const Form sim{.doc = "In the simulation, with the cycle of its model and an ideal clock."};
  static const Form slow = slow_form();
  static const Form terminals{.doc = "An I/O block on the terminals of an arm's controller (docs/hardware-ur.md).",
                              .keys = {text_key("of", "The arm whose controller has them; it has a driver.")}};
  std::vector<NamedForm> forms{{kSimulated, sim}, {kSlowKind, slow}, {kTerminals, terminals}};
  for (const auto& driver : device::DriverKinds::global().list()) forms.push_back({driver->name(), driver->form()});
  return forms;
}

const FormOf<Binding>& binding_form() {
  static const auto form =
      FormOf<Binding>("back_end", "The back end of a device.")
          .kinds({.key = choice_key("backend", {}, "Its kind.").by_default(kSimulated), .forms = binding_forms},
                 [](FormReader& from, Binding& binding) {
                   binding.pointer = from.pointer();
                   const auto kind = from.kind();
                   if (!kind) return;
                   FormReader settings(kind->form, from.object());
                   binding.kind = kind->name;
                   if (binding.kind == kSlowKind) binding.slow = read_slow(settings);
                   if (binding.kind == kTerminals) binding.of = settings.text("of");
                   if (const device::DriverKind* driver = device::DriverKinds::global().find(binding.kind))
                     binding.driver = driver->read(settings);
                 });
  return form;
}

/// One part of an address as key and value of a site file; a number without a word is the cycle.
void add_setting(std::string_view part, Json& settings, Diagnostics& diagnostics) {
  const std::size_t equals = part.find('=');
  const std::string_view word = equals == part.npos ? "cycle" : part.substr(0, equals);
  const std::string_view text = equals == part.npos ? part : part.substr(equals + 1);
  const auto known = std::ranges::find(kSlowKeys, word, [](const SlowKey& key) { return std::string_view(key.word); });
  if (known == std::end(kSlowKeys)) {
    std::vector<std::string> words;
    for (const SlowKey& key : kSlowKeys) words.emplace_back(key.word);
    return diagnostics.error(Code::kInvalidValue, "--backend", fmt::format("a slow device has no '{}'", word),
                             nearest_choice(word, words));
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (error != std::errc() || !std::isfinite(value) || unit != known->unit) {
    return diagnostics.error(Code::kInvalidValue, "--backend", fmt::format("'{}' is no {}", text, word),
                             fmt::format("Give a number with the unit '{}'", known->unit));
  }
  value *= known->factor;
  if (std::string_view(known->unit).empty()) {
    settings[known->key] = static_cast<std::int64_t>(value);
  } else {
    settings[known->key] = value;
  }
}

/// A number with its unit as a site file has it: "0.3ms" as "KEY_ms": 0.3, "5%" as 0.05.
bool add_number(const std::string& key, std::string_view text, Json& settings) {
  struct Unit {
    std::string_view text, suffix;
    double factor;
  };
  constexpr Unit kUnits[] = {{"", "", 1.0}, {"ms", "_ms", 1.0}, {"ppm", "_ppm", 1.0}, {"%", "", 0.01}};
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const auto unit = std::ranges::find(kUnits, rest, &Unit::text);
  if (error != std::errc() || unit == std::end(kUnits)) return false;
  value *= unit->factor;
  const bool whole = std::abs(value) < 1e15 && value == std::floor(value);
  settings[key + std::string(unit->suffix)] = whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
  return true;
}

/// One part of the address of a driver: "192.0.2.1:49938", "krl=ros_control", "loss=5%".
void add_driver_setting(std::string_view part, Json& settings) {
  const std::size_t equals = part.find('=');
  if (equals == part.npos) {
    settings["address"] = std::string(part);
    return;
  }
  const std::string key(part.substr(0, equals));
  const std::string_view text = part.substr(equals + 1);
  if (text == "true" || text == "false") {
    settings[key] = text == "true";
  } else if (!add_number(key, text, settings)) {
    settings[key] = std::string(text);
  }
}

}  // namespace

std::vector<ArmSet> merged(const ArmGroups& groups) {
  std::vector<ArmSet> out;
  for (ArmSet group : groups) {
    const auto shares = [&group](const ArmSet& other) {
      return std::ranges::any_of(other, [&](const std::string& arm) { return group.contains(arm); });
    };
    for (auto other = std::ranges::find_if(out, shares); other != out.end();
         other = std::ranges::find_if(out, shares)) {
      group.merge(*other);
      out.erase(other);
    }
    out.push_back(std::move(group));
  }
  return out;
}

std::vector<BackendKind> backend_kinds() {
  std::vector<BackendKind> kinds{
      {"sim", false, "in the simulation, with the cycle of its model and an ideal clock"},
      {"slow", false, "in the simulation, with a clock and a wire of its own"},
      {kTerminals, false, "I/O blocks: the terminals of the controller of an arm that has a driver"},
  };
  for (const auto& driver : device::DriverKinds::global().list())
    kinds.push_back({driver->name(), false, driver->doc()});
  return kinds;
}

const FormOf<Site>& site_form() {
  static const auto form =
      FormOf<Site>("", "The back end of each device (docs/sites.md). Devices that are not listed are simulated.")
          .add(text_key("title", "Text for readers of the file.").optional())
          .add(boolean_key("pad_delays",
                           "Arms that one net drives together get the delay of the slowest of them, so that they are "
                           "synchronous at their flanges.")
                   .optional(),
               &Site::pad_delays)
          .add(text_key("master_clock",
                        "The arm whose controller's clock paces the core with --realtime; it has a driver on an "
                        "address.")
                   .optional("the machine's clock"),
               &Site::master_clock)
          .add(number_key("speed_override", "", {.low = 0.01, .high = 1.0},
                          "Share of the planned speed with which a run begins.")
                   .optional("1, where hardware moves 0.25"),
               &Site::speed_override)
          .add(members_key("devices", object_key("", binding_form().form(), ""),
                           "Devices by their names in the scenario."),
               [](FormReader& from, Site& site) {
                 from.members("devices", [&](const std::string& name, const Json& json, const std::string& pointer) {
                   site.devices[name] = binding_form().read(json, pointer, from.diagnostics());
                 });
               });
  return form;
}

Result<Site> parse_site(std::string_view text) {
  const auto document = parse_json(text);
  if (!document) return std::unexpected(document.error());
  Diagnostics diagnostics;
  Site site = site_form().read(*document, "", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return site;
}

Result<Site> read_site(const std::filesystem::path& file) {
  const auto text = read_file(file, InputLimits{}.bytes);
  auto site = text ? parse_site(*text) : Result<Site>(std::unexpected(text.error()));
  if (!site) {
    site.error().set_file(file.string());
    return site;
  }
  site->text = *text;
  site->file = file.string();
  for (auto& [name, binding] : site->devices) binding.file = file.string();
  return site;
}

Diagnostics bind(Site& site, std::string_view argument) {
  Diagnostics diagnostics;
  const std::size_t equals = argument.find('=');
  if (equals == argument.npos || equals == 0) {
    diagnostics.error(Code::kInvalidValue, "--backend", fmt::format("'{}' is not NAME=KIND[:ADDR]", argument),
                      "Write it as in --backend arm=slow:8ms");
    return diagnostics;
  }
  const std::string_view target = argument.substr(equals + 1);
  const std::size_t colon = target.find(':');
  const std::string kind(target.substr(0, colon));
  std::string_view address = colon == target.npos ? "" : target.substr(colon + 1);
  const auto kinds = names_of_kinds();
  if (std::ranges::find(kinds, kind) == kinds.end()) {
    diagnostics.error(Code::kUnknownName, "--backend", fmt::format("there is no back end of kind '{}'", kind),
                      nearest_choice(kind, kinds));
    return diagnostics;
  }
  Json settings{{"backend", kind}};
  const bool driver = device::DriverKinds::global().find(kind) != nullptr;
  if (kind == kTerminals && !address.empty()) settings["of"] = std::string(std::exchange(address, {}));
  if (kind != "slow" && !driver && !address.empty()) {
    diagnostics.error(Code::kInvalidValue, "--backend",
                      fmt::format("a back end of kind '{}' has no address, but '{}' is given", kind, address));
  }
  while ((kind == "slow" || driver) && !address.empty()) {
    const std::size_t comma = std::min(address.find(','), address.size());
    const std::string_view part = address.substr(0, comma);
    driver ? add_driver_setting(part, settings) : add_setting(part, settings, diagnostics);
    address.remove_prefix(std::min(comma + 1, address.size()));
  }
  Diagnostics unfit;
  Binding binding = binding_form().read(settings, "", unfit);
  binding.pointer = "--backend";
  diagnostics.append(unfit, "--backend");
  if (!diagnostics.has_errors()) site.devices[std::string(argument.substr(0, equals))] = binding;
  return diagnostics;
}

Diagnostics check_clocks(const Site& site, bool realtime, const std::vector<BackendKind>& kinds) {
  Diagnostics diagnostics;
  for (const auto& [name, binding] : site.devices) {
    const auto kind = std::ranges::find(kinds, binding.kind, &BackendKind::name);
    const bool own_clock = binding.own_clock() || (kind != kinds.end() && kind->own_clock);
    if (realtime || !own_clock) continue;
    diagnostics.add({Severity::kError, Code::kIncompatible, binding.file, binding.pointer,
                     fmt::format("'{}' is reached as '{}', which has a clock of its own; lock-step has none for it",
                                 name, binding.kind),
                     "--realtime, or a simulated back end"});
  }
  return diagnostics;
}

}  // namespace takt::cell
