#include "languages/program/urscript_map.h"

#include <array>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/urscript/poses.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

bool is_variable(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (name.empty() || !letter(name.front())) return false;
  for (const char c : name)
    if (!letter(c) && (c < '0' || c > '9')) return false;
  return true;
}

class UrscriptMapReader {
 public:
  UrscriptMapReader(const Json& json, const std::string& pointer, const expression::Cell& cell,
                    Diagnostics& diagnostics, UrscriptMap& map)
      : reader_(json, pointer, diagnostics), signals_(reader_, cell, map, 0), cell_(cell), map_(map) {}

  void read() {
    signals_.read();
    for (const auto& [name, steps] : map_.calls) check_name(name, "calls");
    each("frames", [&](const std::string& name, const Json& value, const std::string& at) {
      if (std::string frame = signals_.frame(value, at); !frame.empty()) map_.frames[name] = std::move(frame);
    });
    each("tools", [&](const std::string& name, const Json& value, const std::string& at) {
      if (const auto tool = signals_.tool(value, at)) map_.tools[name] = *tool;
    });
    channels();
    force();
    reader_.finish();
  }

 private:
  void check_name(const std::string& name, std::string_view key) {
    if (is_variable(name) && names_.insert(name).second) return;
    const bool again = names_.contains(name);
    signals_.error(
        again ? Code::kDuplicate : Code::kInvalidName, reader_.at(key) + pointer_segment(name),
        again ? fmt::format("'{}' is there already", name) : fmt::format("'{}' is no name of a program", name),
        "Use a name of its own of letters, digits and '_'");
  }

  template <class Function>
  void each(std::string_view key, Function function) {
    const Json* object = reader_.object(key, false);
    if (object == nullptr) return;
    for (const auto& [name, value] : object->items()) {
      check_name(name, key);
      function(name, value, reader_.at(key) + pointer_segment(name));
    }
  }

  void channels() {
    const Json* json = reader_.object("channels", false);
    if (json == nullptr) return;
    ObjectReader reader(*json, reader_.at("channels"), reader_.diagnostics());
    map_.pose_channel = channel(reader, "pose", net::ValueType::kFrame);
    map_.velocity_channel = channel(reader, "velocity", net::ValueType::kTwist);
    map_.enable_channel = channel(reader, "enable", net::ValueType::kBoolean);
    reader.finish();
  }

  std::string channel(ObjectReader& reader, std::string_view key, net::ValueType type) {
    if (!reader.has(key)) return {};
    std::string name = reader.text(key);
    const auto found = cell_.channels.find(name);
    std::vector<std::string> names;
    for (const auto& [one, channel] : cell_.channels)
      if (channel == nullptr || channel->description().type == type) names.push_back(one);
    const bool fits = found != cell_.channels.end() &&
                      (found->second == nullptr ||
                       (found->second->description().type == type &&
                        found->second->description().writer == device::ChannelDescription::Writer::kOutside));
    if (fits) return name;
    signals_.error(found == cell_.channels.end() ? Code::kUnknownName : Code::kTypeMismatch, reader.at(key),
                   fmt::format("'{}' is no channel of type {} that is written from outside", name, name_of(type)),
                   nearest_choice(name, names));
    return {};
  }

  void force() {
    const Json* json = reader_.object("force", false);
    if (json == nullptr) return;
    ObjectReader reader(*json, reader_.at("force"), reader_.diagnostics());
    std::vector<std::string> sensors;
    for (const auto& [name, sensor] : cell_.sensors)
      if (sensor.arm == map_.arm) sensors.push_back(name);
    if (reader.has("sensor")) map_.sensor = reader.choice("sensor", sensors);
    if (reader.has("travel_m"))
      map_.travel = reader.number("travel_m", map_.travel, {.low = 0.0, .high = 2.0, .low_open = true});
    reader.finish();
  }

  ObjectReader reader_;
  SignalMapReader signals_;
  const expression::Cell& cell_;
  UrscriptMap& map_;
  std::set<std::string> names_;
};

using urscript::Signal;

/// Which signal a built-in function is about; `first` is its number of the map for terminal 0.
struct SignalWord {
  std::string_view name;
  Signal kind;
  int first;
  bool without_group = false;  ///< 8 and 9 are the tool's
};
constexpr std::array kSignalWords = {SignalWord{"set_standard_digital_out", Signal::kDigitalOut, 0},
                                     SignalWord{"get_standard_digital_out", Signal::kDigitalOut, 0},
                                     SignalWord{"get_standard_digital_in", Signal::kDigitalIn, 0},
                                     SignalWord{"set_configurable_digital_out", Signal::kDigitalOut, 8},
                                     SignalWord{"get_configurable_digital_out", Signal::kDigitalOut, 8},
                                     SignalWord{"get_configurable_digital_in", Signal::kDigitalIn, 8},
                                     SignalWord{"set_tool_digital_out", Signal::kDigitalOut, 16},
                                     SignalWord{"get_tool_digital_out", Signal::kDigitalOut, 16},
                                     SignalWord{"get_tool_digital_in", Signal::kDigitalIn, 16},
                                     SignalWord{"set_digital_out", Signal::kDigitalOut, 0, true},
                                     SignalWord{"get_digital_out", Signal::kDigitalOut, 0, true},
                                     SignalWord{"get_digital_in", Signal::kDigitalIn, 0, true},
                                     SignalWord{"set_standard_analog_out", Signal::kAnalogOut, 0},
                                     SignalWord{"get_standard_analog_out", Signal::kAnalogOut, 0},
                                     SignalWord{"set_analog_out", Signal::kAnalogOut, 0},
                                     SignalWord{"get_analog_out", Signal::kAnalogOut, 0},
                                     SignalWord{"get_standard_analog_in", Signal::kAnalogIn, 0},
                                     SignalWord{"get_analog_in", Signal::kAnalogIn, 0},
                                     SignalWord{"get_tool_analog_in", Signal::kAnalogIn, 2}};

class CallChecker {
 public:
  CallChecker(const UrscriptMap& map, const std::string& file, Diagnostics& diagnostics)
      : map_(map), file_(file), diagnostics_(diagnostics) {}

  void check(const urscript::BuiltinCall& call) {
    for (const SignalWord& word : kSignalWords)
      if (word.name == call.name) check_signal(call, word);
    if (call.name == "servoj" || call.name == "servoc") check_channel(call, map_.pose_channel, "pose", "Frame");
    if (call.name == "speedl") {
      check_channel(call, map_.velocity_channel, "velocity", "Twist");
      check_channel(call, map_.enable_channel, "enable", "Boolean");
    }
    const bool payload = call.name.starts_with("set_payload") || call.name == "set_target_payload";
    if (payload && told_.insert(call.name).second)
      add(call, Severity::kNote, Code::kNote, fmt::format("{}() is data only", call.name),
          "Say the mass of a part where it is gripped: the load is that of what the gripper holds");
  }

 private:
  void check_signal(const urscript::BuiltinCall& call, const SignalWord& word) {
    const auto* given = call.first ? call.first->get<std::int32_t>() : nullptr;
    if (given == nullptr) return;
    const int number = word.first + *given + (word.without_group && *given > 7 ? 8 : 0);
    const bool known = word.kind == Signal::kDigitalIn    ? map_.inputs.contains(number)
                       : word.kind == Signal::kDigitalOut ? map_.outputs.contains(number)
                       : word.kind == Signal::kAnalogIn   ? map_.analog_inputs.contains(number)
                                                          : map_.analog_outputs.contains(number);
    constexpr std::array kKeys{"inputs", "outputs", "analog_inputs", "analog_outputs"};
    const char* const key = kKeys.at(static_cast<std::size_t>(word.kind));
    if (known || !told_.insert(fmt::format("{} {}", key, number)).second) return;
    add(call, Severity::kError, Code::kUnknownName, fmt::format("{}({}) is no signal of this cell", call.name, *given),
        fmt::format("Give number {} in \"{}\" of the map", number, key));
  }

  void check_channel(const urscript::BuiltinCall& call, const std::string& channel, const char* key, const char* type) {
    if (!channel.empty() || !told_.insert(key).second) return;
    add(call, Severity::kError, Code::kMissing, fmt::format("{}() has no channel that it writes", call.name),
        fmt::format("Give a channel of type {} as \"{}\" in \"channels\" of the map", type, key));
  }

  void add(const urscript::BuiltinCall& call, Severity severity, Code code, std::string message, std::string hint) {
    diagnostics_.add({.severity = severity,
                      .code = code,
                      .file = file_,
                      .pointer = {},
                      .message = std::move(message),
                      .hint = std::move(hint),
                      .line = call.line,
                      .column = call.column});
  }

  const UrscriptMap& map_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  std::set<std::string> told_;
};

}  // namespace

std::vector<std::string> UrscriptMap::given_names() const {
  std::vector<std::string> names;
  for (const auto& [name, frame] : frames) names.push_back(name);
  for (const auto& [name, tool] : tools) names.push_back(name);
  return names;
}

std::vector<urscript::GivenVariable> UrscriptMap::given(const expression::Cell& cell) const {
  std::vector<urscript::GivenVariable> all;
  const auto X_WB = cell.frames.pose(arm);
  for (const auto& [name, frame] : frames) {
    const auto X_WF = cell.frames.pose(frame);
    const bool known = X_WB && X_WF;
    all.push_back({name, known ? urscript::Value(urscript::to_pose(X_WB->inverse() * *X_WF)) : urscript::Value()});
  }
  for (const auto& [name, tool] : tools) all.push_back({name, urscript::to_pose(tool.X_FT)});
  return all;
}

const Form& urscript_map_form() {
  const auto names = [](const char* key, const char* doc) {
    return members_key(key, text_key("", ""), doc).optional();
  };
  static const Form channels{
      .doc = "",
      .keys = {text_key("pose", "Channel of type Frame that servoj() and servoc() write.").optional(),
               text_key("velocity", "Channel of type Twist that speedl() writes.").optional(),
               text_key("enable", "Channel of type Boolean, true while speedl() moves the arm.").optional()},
      .definition = "urscript_channels"};
  static const Form force{.doc = "",
                          .keys = {text_key("sensor", "Force/torque sensor on the arm.").optional("the only one"),
                                   number_key("travel_m", "m", {.low = 0.0, .high = 2.0, .low_open = true},
                                              "How far force_mode() looks for the contact.")
                                       .optional("0.05")},
                          .definition = "urscript_force"};
  static const Form form{
      .doc = "",
      .keys = {names("inputs", "Number of a digital input: 0 to 7 standard, 8 to 15 configurable, 16 and 17 tool."),
               names("analog_inputs", "Number of an analog input: 0 and 1 standard, 2 and 3 tool."),
               names("analog_outputs", "Number of an analog output."),
               members_key("outputs", any_of_key("", {"string", "object"}, ""),
                           "Number of a digital output, as of inputs, to one of the cell, or to steps as 'on' and "
                           "'off'.")
                   .optional(),
               members_key("calls", any_of_key("", {"object", "array"}, ""),
                           "Name of a function that the program does not have to a step or to steps.")
                   .optional(),
               list_key("nominal_inputs", 0, integer_key("", {.low = 0, .high = 8192}, ""),
                        "Numbers of inputs that are true in the rehearsal.")
                   .optional(),
               names("frames", "Name of a variable to a frame: its pose in the base of the arm."),
               names("tools", "Name of a variable to a tool of the arm, 'NAME' or 'NAME/TCP': for set_tcp()."),
               object_key("channels", channels, "Channels of the cell that the program writes.").optional(),
               object_key("force", force, "What force_mode() works with.").optional()},
      .definition = "urscript_map"};
  return form;
}

UrscriptMap read_urscript_map(ObjectReader& node, const expression::Cell& cell) {
  UrscriptMap map;
  map.arm = read_arm(node, cell);
  if (map.arm.empty()) return map;
  if (const Json* json = node.object("map", false))
    UrscriptMapReader(*json, node.at("map"), cell, node.diagnostics(), map).read();
  return map;
}

void check_calls(const UrscriptMap& map, const urscript::Program& program, const std::string& file,
                 Diagnostics& diagnostics) {
  CallChecker checker(map, file, diagnostics);
  for (const urscript::BuiltinCall& call : program.calls) checker.check(call);
}

}  // namespace takt::languages
