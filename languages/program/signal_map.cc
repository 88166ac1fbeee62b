#include "languages/program/signal_map.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

template <class Map>
std::vector<std::string> keys(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

bool same_pose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kEqual = 1e-6;  // m, rad
  return (a.translation() - b.translation()).norm() < kEqual &&
         Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() < kEqual;
}

}  // namespace

Eigen::Isometry3d SignalMap::usual_tool(const expression::Cell& cell) const {
  const auto& mounted = cell.arms.find(arm)->second;
  const auto tool = cell.tools.find(mounted.tool_name);
  return tool != cell.tools.end() ? tool->second.X_FT.at(tool->second.tcp) : mounted.X_FT;
}

std::optional<CellTool> SignalMap::find_tool(const expression::Cell& cell, const Eigen::Isometry3d& X_FT) const {
  if (!cell.arms.contains(arm)) return std::nullopt;
  const Eigen::Isometry3d X_usual = usual_tool(cell);
  if (same_pose(X_usual, X_FT)) return CellTool{{}, {}, X_usual};
  for (const auto& [name, tool] : cell.tools) {
    if (tool.arm != arm) continue;
    for (const auto& [tcp, X] : tool.X_FT)
      if (same_pose(X, X_FT)) return CellTool{name, tcp, X};
  }
  return std::nullopt;
}

Json pose_goal(const Eigen::Isometry3d& X, const std::string& frame) {
  const Eigen::Vector3d p = X.translation();
  const Eigen::Quaterniond q(X.linear());
  return {{"in", frame}, {"position_m", {p.x(), p.y(), p.z()}}, {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
}

Json output_step(const SignalMap& map, bool analog, int number, double value) {
  if (analog) {
    const auto found = map.analog_outputs.find(number);
    if (found == map.analog_outputs.end()) return nullptr;
    return {{"do", "set"}, {"output", found->second}, {"value", value}};
  }
  const auto found = map.outputs.find(number);
  if (found == map.outputs.end()) return nullptr;
  if (!found->second.name.empty()) return {{"do", "set"}, {"output", found->second.name}, {"value", value != 0.0}};
  const std::string& text = value != 0.0 ? found->second.on : found->second.off;
  const auto steps = parse_json(text.empty() ? "[]" : text);
  if (!steps || !steps->is_array()) return steps ? *steps : Json();
  return {{"do", "sequence"}, {"name", fmt::format("output {}", number)}, {"steps", *steps}};
}

void SignalMapReader::read() {
  signals("inputs", keys(cell_.digital_inputs), map_.inputs);
  signals("analog_inputs", keys(cell_.analog_inputs), map_.analog_inputs);
  signals("analog_outputs", keys(cell_.analog_outputs), map_.analog_outputs);
  outputs();
  calls();
  if (const Json* list = reader_.array("nominal_inputs", false))
    for (const Json& one : *list)
      if (one.is_number_integer()) map_.nominal_inputs.insert(one.get<int>());
}

std::optional<int> SignalMapReader::number(const std::string& name, const std::string& at) {
  constexpr int kHighest = 8192;
  int number = 0;
  const auto [end, wrong] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (wrong == std::errc{} && end == name.data() + name.size() && number >= lowest_ && number <= kHighest)
    return number;
  error(Code::kInvalidName, at, fmt::format("'{}' is no number of a signal", name),
        fmt::format("Use {} to {}", lowest_, kHighest));
  return std::nullopt;
}

void SignalMapReader::each(std::string_view key,
                           const std::function<void(int, const Json&, const std::string&)>& function) {
  const Json* object = reader_.object(key, false);
  if (object == nullptr) return;
  for (const auto& [name, value] : object->items()) {
    const std::string at = reader_.at(key) + pointer_segment(name);
    if (const auto found = number(name, at)) function(*found, value, at);
  }
}

void SignalMapReader::signals(std::string_view key, const std::vector<std::string>& known,
                              std::map<int, std::string>& to) {
  each(key, [&](int number, const Json& value, const std::string& at) {
    const std::string name = value.is_string() ? value.get<std::string>() : std::string();
    if (std::ranges::find(known, name) == known.end()) {
      error(Code::kUnknownName, at, fmt::format("there is no signal '{}'", name), nearest_choice(name, known));
    } else {
      to[number] = name;
    }
  });
}

void SignalMapReader::outputs() {
  each("outputs", [&](int number, const Json& value, const std::string& at) {
    SignalMap::Output made;
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

void SignalMapReader::calls() {
  const Json* object = reader_.object("calls", false);
  if (object == nullptr) return;
  for (const auto& [name, steps] : object->items()) map_.calls[name] = steps.dump();
}

std::optional<CellTool> SignalMapReader::tool(const Json& value, const std::string& at) {
  const std::string text = value.is_string() ? value.get<std::string>() : std::string();
  const std::size_t slash = text.find('/');
  const std::string name = text.substr(0, slash);
  const auto tool = cell_.tools.find(name);
  if (tool == cell_.tools.end() || tool->second.arm != map_.arm) {
    error(Code::kUnknownName, at, fmt::format("'{}' is no tool of '{}'", name, map_.arm),
          nearest_choice(name, keys(cell_.tools)));
    return std::nullopt;
  }
  const std::string tcp = slash == std::string::npos ? tool->second.tcp : text.substr(slash + 1);
  const auto found = tool->second.X_FT.find(tcp);
  if (found == tool->second.X_FT.end()) {
    error(Code::kUnknownName, at, fmt::format("'{}' has no tool centre point '{}'", name, tcp),
          nearest_choice(tcp, keys(tool->second.X_FT)));
    return std::nullopt;
  }
  return CellTool{name, tcp, found->second};
}

std::string SignalMapReader::frame(const Json& value, const std::string& at) {
  std::string frame = value.is_string() ? value.get<std::string>() : std::string();
  if (cell_.frames.contains(frame)) return frame;
  error(Code::kUnknownName, at, fmt::format("there is no frame '{}'", frame), "Name a frame of the cell");
  return {};
}

std::string read_arm(ObjectReader& node, const expression::Cell& cell) {
  const std::vector<std::string> arms = keys(cell.arms);
  std::string arm = node.has("arm") ? node.choice("arm", arms) : arms.size() == 1 ? arms.front() : std::string();
  if (cell.arms.contains(arm)) return arm;
  if (!node.has("arm"))
    node.diagnostics().error(Code::kMissing, node.pointer(), "the program does not say which arm it moves",
                             "Give 'arm' (--arm): " + nearest_choice("", arms));
  return {};
}

void check_steps(const SignalMap& map, const std::string& pointer, program::NodeParser& parser) {
  const auto check = [&](const std::string& text, const std::string& at) {
    if (text.empty()) return;
    const auto json = parse_json(text);
    if (!json) return;
    const program::NodeParser::Inner inner(parser, false);
    if (!json->is_array()) return (void)parser.node(*json, at);
    for (std::size_t i = 0; i < json->size(); ++i) (void)parser.node((*json)[i], at + pointer_segment(i));
  };
  for (const auto& [number, output] : map.outputs) {
    check(output.on, fmt::format("{}/outputs/{}/on", pointer, number));
    check(output.off, fmt::format("{}/outputs/{}/off", pointer, number));
  }
  for (const auto& [name, steps] : map.calls) check(steps, pointer + "/calls" + pointer_segment(name));
}

}  // namespace takt::languages
