#include "tools/import/mjcf_source.h"

#include <algorithm>
#include <charconv>
#include <set>

#include <fmt/format.h>

#include "core/base/json.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;
using kinematics::XmlElement;

/// What is taken of the elements that make bodies; of others nothing, or they are reported by name.
const std::map<std::string, std::set<std::string>>& taken() {
  static const std::set<std::string> kPose = {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"};
  const auto with_pose = [](std::set<std::string> words) {
    words.insert(kPose.begin(), kPose.end());
    return words;
  };
  static const std::map<std::string, std::set<std::string>> words = {
      {"body", with_pose({"name", "childclass"})},
      {"joint",
       {"name", "class", "type", "pos", "axis", "range", "limited", "ref", "armature", "damping", "frictionloss",
        "actuatorfrcrange", "actuatorfrclimited"}},
      {"freejoint", {"name"}},
      {"geom", with_pose({"name", "class", "type", "size", "fromto", "mesh", "fitscale", "mass", "density",
                          "shellinertia", "contype", "conaffinity", "group", "rgba", "material"})},
      {"site", with_pose({"name", "class", "fromto"})},
      {"material", {"name", "class", "rgba"}},
      {"key", {"name", "qpos"}},
      {"default", {"class"}}};
  return words;
}

/// Elements whose attributes all count, as MuJoCo's compiler makes one model of them, and classes of actuators.
const std::set<std::string>& structure() {
  static const std::set<std::string> words = {
      "mujoco",   "mujocoinclude", "compiler",    "include",   "asset",      "mesh",   "worldbody", "frame",
      "model",    "attach",        "inertial",    "keyframe",  "tendon",     "motor",  "equality",  "actuator",
      "position", "velocity",      "replicate",   "composite", "cylinder",   "muscle", "damper",    "adhesion",
      "general",  "pid",           "intvelocity", "dcmotor",   "orientation"};
  return words;
}

/// Their elements are reported one by one.
bool named_one_by_one(const std::string& element) {
  return element == "equality" || element == "tendon" || element == "actuator";
}

/// The numbers after a word, as in "line 7"; -1: none.
int number_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.rfind(word);
  if (at == text.npos) return -1;
  int number = -1;
  const char* begin = text.data() + at + word.size();
  std::from_chars(begin, text.data() + text.size(), number);
  return number;
}

/// The text in quotes after a word, as in "Element 'geom'"; empty: none.
std::string quoted_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.rfind(word + " '");
  if (at == text.npos) return {};
  const std::size_t begin = at + word.size() + 2, end = text.find('\'', begin);
  return end == text.npos ? std::string() : text.substr(begin, end - begin);
}

}  // namespace

void MjcfSource::add(const fs::path& path, const std::string& including, const std::string& pointer,
                     Diagnostics& diagnostics) {
  std::error_code error;
  const auto say = [&](Code code, const std::string& message, const std::string& hint) {
    diagnostics.error(code, pointer, message, hint);
    diagnostics.list().back().file = including;
  };
  if (!including.empty() && !fs::is_regular_file(path, error))
    return say(Code::kNotFound, fmt::format("there is no file '{}'", path.string()),
               "Name a file beside the model, or put it there");
  if (std::ranges::any_of(files_, [&](const File& one) { return fs::equivalent(one.path, path, error); }))
    return say(Code::kDuplicate, fmt::format("'{}' is included already", path.string()),
               "Include each file once; a file must not include itself");
  const auto text = read_file(path, kinematics::kMaxXmlBytes);
  auto tree = text ? kinematics::scan_xml(*text) : Result<kinematics::XmlTree>(std::unexpected(text.error()));
  if (!tree) {
    tree.error().set_file(path.string());
    return diagnostics.append(tree.error());
  }
  const std::size_t here = files_.size();
  files_.push_back({path, std::move(*tree)});
  const std::vector<XmlElement> elements = files_[here].tree.elements;
  for (const XmlElement& element : elements) {
    const std::string* name = element.attribute("file");
    if (element.name == "model" && name != nullptr)
      add_attached(files_.front().path.parent_path() / *name, diagnostics);
    if (element.name != "include") continue;
    const std::string line = fmt::format("line {}", element.line);
    if (name == nullptr) {
      diagnostics.error(Code::kMissing, line, "<include> has no file", "Give it file=\"NAME.xml\"");
      diagnostics.list().back().file = path.string();
      continue;
    }
    // MuJoCo looks beside the first file, then beside the one that includes.
    fs::path file = files_.front().path.parent_path() / *name;
    if (!fs::is_regular_file(file, error)) file = path.parent_path() / *name;
    add(file, path.string(), line, diagnostics);
  }
}

void MjcfSource::add_attached(const fs::path& path, Diagnostics& diagnostics) {
  std::error_code error;
  // One that is not there, or no model, is MuJoCo's to refuse.
  const bool known =
      std::ranges::any_of(files_, [&](const File& one) { return fs::equivalent(one.path, path, error); });
  if (!known && fs::is_regular_file(path, error) && path.extension() == ".xml") add(path, {}, {}, diagnostics);
}

void MjcfSource::index(std::size_t file) {
  for (const XmlElement& element : files_[file].tree.elements)
    if (const std::string* name = element.attribute("name"))
      named_.try_emplace({element.name, *name}, file, element.line);
}

Result<MjcfSource> MjcfSource::scan(const fs::path& file) {
  MjcfSource source;
  Diagnostics diagnostics;
  source.add(file, {}, {}, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  for (std::size_t i = 0; i < source.files_.size(); ++i) source.index(i);
  return source;
}

std::string MjcfSource::place(std::size_t file, int line) const {
  return file == 0 ? fmt::format("line {}", line)
                   : fmt::format("{} line {}", files_[file].path.filename().string(), line);
}

std::string MjcfSource::place(const std::string& element, const std::string& name) const {
  const auto found = named_.find({element, name});
  return found == named_.end() ? std::string() : place(found->second.first, found->second.second);
}

std::map<std::string, MjcfSource::Unread> MjcfSource::unread() const {
  std::map<std::string, Unread> found;
  const auto count = [&](const std::string& what, std::size_t file, int line) {
    Unread& one = found[what];
    if (one.count++ == 0) one.first = place(file, line);
  };
  for (std::size_t file = 0; file < files_.size(); ++file) {
    const auto& elements = files_[file].tree.elements;
    std::vector<bool> skipped(elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const XmlElement& element = elements[i];
      for (const int child : element.children)
        skipped[static_cast<std::size_t>(child)] = skipped[i] || named_one_by_one(element.name);
      if (skipped[i] || structure().contains(element.name)) continue;
      const auto known = taken().find(element.name);
      if (known == taken().end()) {
        count(fmt::format("<{}>", element.name), file, element.line);
        for (const int child : element.children) skipped[static_cast<std::size_t>(child)] = true;
        continue;
      }
      for (const auto& [attribute, value] : element.attributes)
        if (!known->second.contains(attribute))
          count(fmt::format("{} of {}", attribute, element.name), file, element.line);
    }
  }
  return found;
}

void MjcfSource::locate(const std::string& text, Diagnostic& diagnostic) const {
  diagnostic.file = files_.front().path.string();
  const int line = number_after(text, "line ");
  if (line > 0) {
    diagnostic.pointer = fmt::format("line {}", line);
    return;
  }
  // Of included files MuJoCo knows no lines: the name may tell; or there is one such element only.
  const std::string element = quoted_after(text, "Element"), name = quoted_after(text, "name");
  const auto at = [&](std::size_t file, int found) {
    diagnostic.file = files_[file].path.string();
    diagnostic.pointer = fmt::format("line {}", found);
  };
  for (const auto& [key, place] : named_)
    if (!name.empty() && key.second == name && (element.empty() || key.first == element))
      return at(place.first, place.second);
  const fs::path missing = fs::path(quoted_after(text, "file")).filename();
  std::vector<std::pair<std::size_t, int>> all;
  for (std::size_t file = 0; file < files_.size(); ++file) {
    for (const XmlElement& one : files_[file].tree.elements) {
      const std::string* named = one.attribute("file");
      if (!missing.empty() && named != nullptr && fs::path(*named).filename() == missing) return at(file, one.line);
      if (!element.empty() && one.name == element) all.emplace_back(file, one.line);
    }
  }
  if (all.size() == 1) at(all.front().first, all.front().second);
}

}  // namespace takt::tools
