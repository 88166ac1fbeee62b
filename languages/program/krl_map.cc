#include "languages/program/krl_map.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/krl/lexer.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

/// Joints as KRL names them: a third of seven is the external axis E1, as on a KUKA LWR.
std::vector<std::string> usual_axes(std::size_t joints) {
  if (joints == 7) return {"A1", "A2", "E1", "A3", "A4", "A5", "A6"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < joints; ++i)
    names.push_back(i < 6 ? fmt::format("A{}", i + 1) : fmt::format("E{}", i - 5));
  return names;
}

class KrlMapReader {
 public:
  KrlMapReader(const Json& json, const std::string& pointer, const expression::Cell& cell, Diagnostics& diagnostics,
               KrlMap& map)
      : reader_(json, pointer, diagnostics), signals_(reader_, cell, map, 1), map_(map) {}

  void read() {
    signals_.read();
    std::map<std::string, std::string> calls;
    for (auto& [name, steps] : map_.calls) {
      std::string capitals = name;
      for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      calls[capitals] = steps;
    }
    map_.calls = std::move(calls);
    signals_.each("tools", [&](int number, const Json& value, const std::string& at) {
      if (const auto tool = signals_.tool(value, at)) map_.tools[number] = *tool;
    });
    signals_.each("bases", [&](int number, const Json& value, const std::string& at) {
      if (std::string frame = signals_.frame(value, at); !frame.empty()) map_.bases[number] = std::move(frame);
    });
    axes();
    reader_.finish();
  }

 private:
  void axes() {
    const std::size_t joints = map_.axes.size();
    if (reader_.has("axes")) map_.axes = reader_.texts("axes");
    if (reader_.has("axis_offsets_deg")) map_.offsets = reader_.numbers("axis_offsets_deg", joints);
    constexpr std::array kNames{"A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2", "E3", "E4", "E5", "E6"};
    const bool known = std::ranges::all_of(
        map_.axes, [&](const std::string& one) { return std::ranges::find(kNames, one) != kNames.end(); });
    const std::set<std::string> once(map_.axes.begin(), map_.axes.end());
    if (map_.axes.size() == joints && known && once.size() == joints) return;
    signals_.error(Code::kInvalidValue, reader_.at("axes"), "not the names of the joints",
                   fmt::format("Give {} different names, A1 to A6 and E1 to E6", joints));
    map_.axes = usual_axes(joints);
  }

  ObjectReader reader_;
  SignalMapReader signals_;
  KrlMap& map_;
};

}  // namespace

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
  map.arm = read_arm(node, cell);
  const auto arm = cell.arms.find(map.arm);
  if (arm == cell.arms.end()) return map;
  map.axes = usual_axes(static_cast<std::size_t>(arm->second.start.size()));
  map.offsets.assign(map.axes.size(), 0.0);
  if (const Json* json = node.object("map", false))
    KrlMapReader(*json, node.at("map"), cell, node.diagnostics(), map).read();
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
