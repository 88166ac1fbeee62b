#include "languages/program/krl_map.h"

#include <algorithm>
#include <array>
#include <charconv>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/krl/lexer.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

template <class Map>
std::vector<std::string> keys(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

/// Joints as KRL names them: a third of seven is the external axis E1, as on a KUKA LWR.
std::vector<std::string> usual_axes(std::size_t joints) {
  if (joints == 7) return {"A1", "A2", "E1", "A3", "A4", "A5", "A6"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < joints; ++i)
    names.push_back(i < 6 ? fmt::format("A{}", i + 1) : fmt::format("E{}", i - 5));
  return names;
}

class MapReader {
 public:
  MapReader(const Json& json, const std::string& pointer, const expression::Cell& cell, Diagnostics& diagnostics,
            KrlMap& map)
      : reader_(json, pointer, diagnostics), cell_(cell), map_(map) {}

  void read() {
    signals("inputs", keys(cell_.digital_inputs), map_.inputs);
    signals("analog_inputs", keys(cell_.analog_inputs), map_.analog_inputs);
    signals("analog_outputs", keys(cell_.analog_outputs), map_.analog_outputs);
    outputs();
    calls();
    tools();
    each("bases", [&](int number, const Json& value, const std::string& at) {
      const std::string frame = value.is_string() ? value.get<std::string>() : std::string();
      if (cell_.frames.contains(frame)) {
        map_.bases[number] = frame;
      } else {
        error(Code::kUnknownName, at, fmt::format("there is no frame '{}'", frame), "Name a frame of the cell");
      }
    });
    if (const Json* list = reader_.array("nominal_inputs", false))
      for (const Json& one : *list)
        if (one.is_number_integer()) map_.nominal_inputs.insert(one.get<int>());
    axes();
    reader_.finish();
  }

 private:
  void error(Code code, const std::string& at, std::string message, std::string hint) {
    reader_.diagnostics().error(code, at, std::move(message), std::move(hint));
  }

  /// The members of an object whose keys are numbers.
  template <class Function>
  void each(std::string_view key, Function function) {
    const Json* object = reader_.object(key, false);
    if (object == nullptr) return;
    for (const auto& [name, value] : object->items()) {
      const std::string at = reader_.at(key) + pointer_segment(name);
      int number = 0;
      const auto [end, wrong] = std::from_chars(name.data(), name.data() + name.size(), number);
      if (wrong != std::errc{} || end != name.data() + name.size() || number < 1 || number > 8192) {
        error(Code::kInvalidName, at, fmt::format("'{}' is no number of a signal", name), "Use 1 to 8192");
        continue;
      }
      function(number, value, at);
    }
  }

  void signals(std::string_view key, const std::vector<std::string>& known, std::map<int, std::string>& to) {
    each(key, [&](int number, const Json& value, const std::string& at) {
      const std::string name = value.is_string() ? value.get<std::string>() : std::string();
      if (std::ranges::find(known, name) == known.end()) {
        error(Code::kUnknownName, at, fmt::format("there is no signal '{}'", name), nearest_choice(name, known));
      } else {
        to[number] = name;
      }
    });
  }

  void outputs() {
    each("outputs", [&](int number, const Json& value, const std::string& at) {
      KrlMap::Output made;
      if (value.is_object()) {
        for (const auto& [level, steps] : value.items()) {
          if (level != "on" && level != "off") {
            error(Code::kUnknownKey, at + pointer_segment(level), fmt::format("unknown key '{}'", level),
                  "Use 'on' and 'off'");
          } else {
            (level == "on" ? made.on : made.off) = steps.dump();
          }
        }
      } else {
        made.name = value.is_string() ? value.get<std::string>() : std::string();
        if (!cell_.digital_outputs.contains(made.name)) {
          error(Code::kUnknownName, at, fmt::format("there is no output '{}'", made.name),
                nearest_choice(made.name, keys(cell_.digital_outputs)));
          return;
        }
      }
      map_.outputs[number] = made;
    });
  }

  void calls() {
    const Json* object = reader_.object("calls", false);
    if (object == nullptr) return;
    for (const auto& [name, steps] : object->items()) {
      std::string capitals = name;
      for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      map_.calls[capitals] = steps.dump();
    }
  }

  void tools() {
    each("tools", [&](int number, const Json& value, const std::string& at) {
      const std::string text = value.is_string() ? value.get<std::string>() : std::string();
      const std::size_t slash = text.find('/');
      const std::string name = text.substr(0, slash);
      const auto tool = cell_.tools.find(name);
      if (tool == cell_.tools.end() || tool->second.arm != map_.arm) {
        error(Code::kUnknownName, at, fmt::format("'{}' is no tool of '{}'", name, map_.arm),
              nearest_choice(name, keys(cell_.tools)));
        return;
      }
      const std::string tcp = slash == std::string::npos ? tool->second.tcp : text.substr(slash + 1);
      const auto found = tool->second.X_FT.find(tcp);
      if (found == tool->second.X_FT.end()) {
        error(Code::kUnknownName, at, fmt::format("'{}' has no tool centre point '{}'", name, tcp),
              nearest_choice(tcp, keys(tool->second.X_FT)));
        return;
      }
      map_.tools[number] = {name, tcp, found->second};
    });
  }

  void axes() {
    const std::size_t joints = map_.axes.size();
    if (reader_.has("axes")) map_.axes = reader_.texts("axes");
    if (reader_.has("axis_offsets_deg")) map_.offsets = reader_.numbers("axis_offsets_deg", joints);
    constexpr std::array kNames{"A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2", "E3", "E4", "E5", "E6"};
    const bool known = std::ranges::all_of(
        map_.axes, [&](const std::string& one) { return std::ranges::find(kNames, one) != kNames.end(); });
    const std::set<std::string> once(map_.axes.begin(), map_.axes.end());
    if (map_.axes.size() == joints && known && once.size() == joints) return;
    error(Code::kInvalidValue, reader_.at("axes"), "not the names of the joints",
          fmt::format("Give {} different names, A1 to A6 and E1 to E6", joints));
    map_.axes = usual_axes(joints);
  }

  ObjectReader reader_;
  const expression::Cell& cell_;
  KrlMap& map_;
};

bool same_pose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kEqual = 1e-6;  // m, rad
  return (a.translation() - b.translation()).norm() < kEqual &&
         Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() < kEqual;
}

}  // namespace

std::optional<CellTool> KrlMap::find_tool(const expression::Cell& cell, const Eigen::Isometry3d& X_FT) const {
  const auto mounted = cell.arms.find(arm);
  if (mounted == cell.arms.end()) return std::nullopt;
  const auto usual = cell.tools.find(mounted->second.tool_name);
  const Eigen::Isometry3d X_usual =
      usual != cell.tools.end() ? usual->second.X_FT.at(usual->second.tcp) : mounted->second.X_FT;
  if (same_pose(X_usual, X_FT)) return CellTool{{}, {}, X_usual};
  for (const auto& [name, tool] : cell.tools) {
    if (tool.arm != arm) continue;
    for (const auto& [tcp, X] : tool.X_FT)
      if (same_pose(X, X_FT)) return CellTool{name, tcp, X};
  }
  return std::nullopt;
}

const Form& krl_map_form() {
  const auto names = [](const char* key, const char* doc) {
    return members_key(key, text_key("", ""), doc).optional();
  };
  static const Form form{
      .doc = "",
      .keys =
          {names("inputs", "Number of $IN to a digital input."),
           names("analog_inputs", "Number of $ANIN to an analog input."),
           names("analog_outputs", "Number of $ANOUT to an analog output."),
           members_key("outputs", any_of_key("", {"string", "object"}, ""),
                       "Number of $OUT to a digital output, or to steps as 'on' and 'off'.")
               .optional(),
           members_key("calls", any_of_key("", {"object", "array"}, ""),
                       "Name of a call that the program does not have to a step or to steps.")
               .optional(),
           names("tools", "Number of a tool to one of the arm, 'NAME' or 'NAME/TCP'."),
           names("bases", "Number of a base to a frame."),
           texts_key("axes", "Names of the joints in their order, A1 to A6 and E1 to E6.").optional(),
           numbers_key("axis_offsets_deg", 0, "deg", {}, "What the program says less what the joint has.").optional(),
           list_key("nominal_inputs", 0, integer_key("", {.low = 1, .high = 8192}, ""),
                    "Numbers of inputs that are TRUE in the rehearsal.")
               .optional()},
      .definition = "krl_map"};
  return form;
}

KrlMap read_krl_map(ObjectReader& node, const expression::Cell& cell) {
  KrlMap map;
  std::vector<std::string> arms;
  for (const auto& [name, arm] : cell.arms) arms.push_back(name);
  map.arm = node.has("arm") ? node.choice("arm", arms) : arms.size() == 1 ? arms.front() : std::string();
  const auto arm = cell.arms.find(map.arm);
  if (arm == cell.arms.end()) {
    if (!node.has("arm"))
      node.diagnostics().error(Code::kMissing, node.pointer(), "the program does not say which arm it moves",
                               "Give 'arm' (--arm): " + nearest_choice("", arms));
    return map;
  }
  map.axes = usual_axes(static_cast<std::size_t>(arm->second.start.size()));
  map.offsets.assign(map.axes.size(), 0.0);
  if (const Json* json = node.object("map", false))
    MapReader(*json, node.at("map"), cell, node.diagnostics(), map).read();
  return map;
}

void check_signals(const KrlMap& map, const krl::Program& program, Diagnostics& diagnostics) {
  std::set<std::pair<krl::Live, std::int64_t>> told;
  for (const krl::SignalUse& use : program.signals) {
    const auto number = static_cast<int>(use.number);
    const bool known = use.kind == krl::Live::kIn         ? map.inputs.contains(number)
                       : use.kind == krl::Live::kOut      ? map.outputs.contains(number)
                       : use.kind == krl::Live::kAnalogIn ? map.analog_inputs.contains(number)
                                                          : map.analog_outputs.contains(number);
    if (known || !told.insert({use.kind, use.number}).second) continue;
    constexpr std::array kNames{"$IN", "$OUT", "$ANIN", "$ANOUT"};
    constexpr std::array kKeys{"inputs", "outputs", "analog_inputs", "analog_outputs"};
    const auto kind = static_cast<std::size_t>(use.kind);
    krl::error_at(diagnostics, program.modules[static_cast<std::size_t>(use.module)].file, use.at, Code::kUnknownName,
                  fmt::format("{}[{}] is no signal of this cell", kNames.at(kind), use.number),
                  fmt::format("Name it in \"{}\" of the map", kKeys.at(kind)));
  }
}

}  // namespace takt::languages
