#include "tools/new_scenario.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/output_file.h"
#include "core/device/device_file.h"
#include "core/kinematics/chain.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

bool is_file_name(const std::string& name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

/// To the centimetre, as the shortest decimal number.
double to_centimetre(double value) { return std::round(100.0 * value) / 100.0; }

/// Where the block lies: on the floor, to the side, out of the way of an arm of this reach.
Json block_beside(double reach) {
  const double y = to_centimetre(0.6 * reach + 0.1);
  return {{"shape", "box"},
          {"size_m", {0.1, 0.1, 0.1}},
          {"at", {{"in", "world"}, {"position_m", {0.0, y, 0.05}}}},
          {"rgba", {0.16, 0.38, 0.62, 1.0}}};
}

Json camera_at(double reach) {
  const double away = std::round(10.0 * (1.8 * reach + 0.6)) / 10.0, aside = to_centimetre(0.8 * away);
  return {{"at", {{"position_m", {away, -aside, aside}}}},
          {"look_at", {{"position_m", {0.0, 0.0, std::round(4.0 * reach) / 10.0}}}},
          {"fovy_deg", 34}};
}

/// Steps that any arm can make from its home: small joint moves, and home again.
Json program_of(const device::ArmDescription& arm) {
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  Json joints = Json::array();
  for (int i = 0; i < arm.home.size(); ++i) {
    const bool slides = arm.chain->is_prismatic(i);
    double q = slides ? arm.home[i] : arm.home[i] / kDegree;
    const double lower = slides ? arm.chain->lower()[i] : arm.chain->lower()[i] / kDegree;
    const double upper = slides ? arm.chain->upper()[i] : arm.chain->upper()[i] / kDegree;
    if (i == 0) q = std::clamp(q + (slides ? 0.05 : 20.0), lower, upper);
    joints.push_back(std::round(1000.0 * q) / 1000.0);
  }
  return {{"do", "sequence"},
          {"name", "first moves"},
          {"steps",
           {{{"do", "log"}, {"text", "hello"}},
            {{"do", "ptp"}, {"name", "to the side"}, {"to", {{"joints_deg", joints}}}, {"speed", 0.5}},
            {{"do", "wait"}, {"name", "a moment"}, {"seconds", 0.5}},
            {{"do", "ptp"}, {"name", "home"}, {"to", "home"}, {"speed", 0.5}}}}};
}

/// The schema as seen from the folder of the scenario; empty: there is none to be found.
std::string schema_of(const ScenarioOptions& options) {
  std::error_code error;
  if (options.schema.empty() || !std::filesystem::exists(options.schema, error)) return {};
  const auto folder = options.out.empty() ? std::filesystem::path(".") : options.out;
  const auto path = std::filesystem::relative(options.schema, folder, error);
  return error ? std::string() : path.generic_string();
}

/// A blank behind each comma and colon outside of texts.
std::string spaced(std::string_view json) {
  std::string text;
  bool inside = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const bool quote = json[i] == '"' && (i == 0 || json[i - 1] != '\\');
    inside = inside != quote;
    text += json[i];
    if (!inside && (json[i] == ',' || json[i] == ':')) text += ' ';
  }
  return text;
}

/// Indented, but for what fits on a line: vectors, and objects of a few values.
std::string written_out(const Json& json, std::size_t indent = 0) {
  constexpr std::size_t kLine = 100;
  const std::string inline_form = json.dump();
  const bool is_list = json.is_array();
  if ((!is_list && !json.is_object()) || json.empty()) return inline_form;
  const auto is_nested = [](const Json& one) { return one.is_structured() && !one.empty(); };
  const bool nested = std::ranges::any_of(json, is_nested);
  if (indent + inline_form.size() <= kLine && (!nested || !is_list) && indent > 0) return spaced(inline_form);
  const std::string margin(indent + 2, ' ');
  std::string text(1, is_list ? '[' : '{');
  for (auto member = json.begin(); member != json.end(); ++member) {
    text += fmt::format("{}\n{}", member == json.begin() ? "" : ",", margin);
    if (!is_list) text += fmt::format("{}: ", Json(member.key()).dump());
    text += written_out(*member, indent + 2);
  }
  return text + "\n" + std::string(indent, ' ') + (is_list ? ']' : '}');
}

Json scenario_of(const ScenarioOptions& options, const device::ArmDescription& arm) {
  const double reach = arm.chain->reach();
  return {{"title", options.name},
          {"description", "What happens here, and what it shows."},
          {"seed", 1},
          {"time_limit_s", 60},
          {"devices", {{"arm", {{"model", options.arm}, {"at", {{"in", "world"}}}}}}},
          {"objects", {{"block", block_beside(reach)}}},
          {"cameras", {{"overview", camera_at(reach)}}},
          {"film", {{"camera", "overview"}}},
          {"program", program_of(arm)},
          {"expectations",
           {{{"name", "inside the joint limits"}, {"kind", "limits"}, {"arm", "arm"}},
            {{"name", "nothing touches"}, {"kind", "contacts"}, {"only", Json::array()}},
            {{"name", "done in time"}, {"kind", "duration"}, {"below_s", 30}},
            {{"name", "the same again"}, {"kind", "repeats"}}}}};
}

}  // namespace

Result<std::filesystem::path> new_scenario(const ScenarioOptions& options, const device::ModelLibrary& models) {
  if (!is_file_name(options.name))
    return failure(Code::kInvalidName, "NAME", fmt::format("invalid name '{}'", options.name),
                   "Use letters, digits, '_' and '-'");
  const auto folder = models.find(options.arm, "--arm");
  if (!folder) return std::unexpected(folder.error());
  const auto arm = device::read_arm(*folder);
  if (!arm) return std::unexpected(arm.error());
  const std::filesystem::path file = options.out / (options.name + ".json");
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored))
    return failure(Code::kFileNotWritable, "NAME", fmt::format("'{}' is there already", file.string()),
                   "Choose another name");
  if (!options.out.empty()) std::filesystem::create_directories(options.out, ignored);
  Json scenario = Json::object();
  if (const std::string schema = schema_of(options); !schema.empty()) scenario["$schema"] = schema;
  scenario.update(scenario_of(options, **arm));
  const Diagnostics written = write_file(file, written_out(scenario) + "\n", "--out");
  if (written.has_errors()) return std::unexpected(written);
  return file;
}

}  // namespace takt::tools
