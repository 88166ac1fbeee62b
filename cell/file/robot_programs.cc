#include "cell/file/robot_programs.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "languages/krl/program.h"
#include "languages/program/krl_node.h"
#include "languages/program/urscript_node.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostProgramBytes = 1u << 20;
constexpr std::size_t kMostModules = 64;

/// The kinds of nodes are known to whoever can read them from a file.
[[maybe_unused]] const bool kLanguagesKnown =
    (program::add_node_kind(languages::krl_kind()), program::add_node_kind(languages::urscript_kind()), true);

std::string in_capitals(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// The file with this stem in capitals and this ending; empty: there is none.
std::filesystem::path find_module(const std::filesystem::path& folder, const std::string& stem,
                                  std::string_view ending) {
  std::vector<std::filesystem::path> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::filesystem::path& file = entry.path();
    if (in_capitals(file.stem().string()) == stem && in_capitals(file.extension().string()) == ending)
      found.push_back(file);
  }
  std::ranges::sort(found);
  return found.empty() ? std::filesystem::path() : found.front();
}

class ModuleReader {
 public:
  ModuleReader(std::filesystem::path folder, const std::string& pointer, Diagnostics& diagnostics)
      : folder_(std::move(folder)), pointer_(pointer), diagnostics_(diagnostics) {}

  Json read(const std::filesystem::path& file) {
    add(file.stem().string(), file);
    // What is called and not there may be a module of the same folder.
    for (bool again = true; again && modules_.size() < kMostModules;) {
      again = false;
      for (const std::string& name : languages::krl::missing_programs(modules_)) {
        if (!asked_.insert(name).second) continue;
        const std::filesystem::path found = find_module(folder_, name, ".SRC");
        if (found.empty()) continue;
        add(name, found);
        again = true;
      }
    }
    if (const auto config = find_module(folder_, "$CONFIG", ".DAT"); !config.empty()) add("$CONFIG", {});
    Json list = Json::array();
    for (const auto& one : modules_)
      list.push_back({{"name", one.name},
                      {"file", one.file},
                      {"source", one.source},
                      {"data_file", one.data_file},
                      {"data", one.data}});
    return {{"modules", std::move(list)}};
  }

 private:
  void add(const std::string& name, const std::filesystem::path& source) {
    languages::krl::ModuleText module;
    module.name = in_capitals(name);
    module.file = source.string();
    if (!source.empty()) module.source = text_of(source);
    if (const auto data = find_module(folder_, module.name, ".DAT"); !data.empty()) {
      module.data_file = data.string();
      module.data = text_of(data);
    }
    modules_.push_back(std::move(module));
  }

  std::string text_of(const std::filesystem::path& file) {
    auto text = read_file(file, kMostProgramBytes);
    if (!text) diagnostics_.append(text.error(), pointer_);
    if (!text) return {};
    // KRL is written in Latin-1: what is no ASCII stands in comments and texts.
    for (char& c : *text)
      if (static_cast<unsigned char>(c) > 127) c = '?';
    return std::move(*text);
  }

  std::filesystem::path folder_;
  const std::string& pointer_;
  Diagnostics& diagnostics_;
  std::vector<languages::krl::ModuleText> modules_;
  std::set<std::string, std::less<>> asked_;
};

/// A program in URScript is one text.
Json read_script(const std::filesystem::path& file, const std::string& pointer, Diagnostics& diagnostics) {
  const auto text = read_file(file, kMostProgramBytes);
  if (!text) diagnostics.append(text.error(), pointer);
  return {{"file", file.string()}, {"source", text ? *text : std::string()}};
}

Json read_program(std::string_view language, const std::filesystem::path& file, const std::string& pointer,
                  Diagnostics& diagnostics) {
  if (language == "urscript") return read_script(file, pointer, diagnostics);
  return ModuleReader(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."), pointer, diagnostics)
      .read(file);
}

void take_in_program(Json& place, std::string_view language, const std::string& pointer,
                     const std::filesystem::path& folder, Diagnostics& diagnostics) {
  if (!place.is_string()) return;
  const auto name = place.get<std::string>();
  if (const auto inside = resolve_below(folder, name, pointer); !inside) {
    diagnostics.append(inside.error());
    return;
  }
  place = read_program(language, folder / name, pointer, diagnostics);
}

void find_programs(Json& json, const std::string& pointer, const std::filesystem::path& folder,
                   Diagnostics& diagnostics) {
  if (!json.is_structured()) return;
  const std::string language =
      json.is_object() && json.contains("do") && json["do"].is_string() ? json["do"].get<std::string>() : std::string();
  const bool is_node = language == "krl" || language == "urscript";
  std::size_t index = 0;
  for (auto& [key, value] : json.items()) {
    const std::string inside = pointer + (json.is_array() ? pointer_segment(index++) : pointer_segment(key));
    if (is_node && key == "program") {
      take_in_program(value, language, inside, folder, diagnostics);
    } else if (!is_node) {
      find_programs(value, inside, folder, diagnostics);
    }
  }
}

}  // namespace

void read_robot_programs(Json& document, const std::filesystem::path& folder, Diagnostics& diagnostics) {
  for (const char* key : {"program", "programs"})
    if (document.is_object() && document.contains(key))
      find_programs(document[key], "/" + std::string(key), folder, diagnostics);
}

Result<Override> to_override(const RobotProgram& program) {
  Diagnostics diagnostics;
  const std::filesystem::path file = program.file;
  const std::string ending = in_capitals(file.extension().string());
  if (ending != ".SRC" && ending != ".SCRIPT")
    return failure(Code::kUnsupported, "--program", fmt::format("'{}' is in no language that is known", program.file),
                   "Name a file that ends in .src (KRL) or .script (URScript)");
  const std::string language = ending == ".SRC" ? "krl" : "urscript";
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  Json node{{"do", language}, {"name", file.stem().string()}};
  node["program"] = read_program(language, file, "--program", diagnostics);
  if (!program.arm.empty()) node["arm"] = program.arm;
  std::filesystem::path map = program.map;
  std::error_code ignored;
  if (map.empty() && std::filesystem::exists(folder / (file.stem().string() + ".map.json"), ignored))
    map = folder / (file.stem().string() + ".map.json");
  if (!map.empty()) {
    auto json = read_json(map);
    if (json) {
      json->erase("$schema");
      node["map"] = std::move(*json);
    } else {
      diagnostics.append(json.error(), "", map.string());
    }
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return Override{"/program", node.dump()};
}

}  // namespace takt::cell
