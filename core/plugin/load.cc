#include "core/plugin/load.h"

#include <cxxabi.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "core/base/registration.h"
#include "core/plugin/about.h"
#include "core/plugin/elf_section.h"

namespace takt::plugin {
namespace {

constexpr const char* kRebuild = "build it against this takt, with CMake's takt::plugin";

using Lines = std::map<std::string, std::string, std::less<>>;

/// The lines of an About, or nothing if it is none.
std::optional<Lines> parse(std::string_view text) {
  if (!text.starts_with(kMagic)) return std::nullopt;
  text.remove_prefix(kMagic.size());
  text = text.substr(0, text.find('\0'));
  Lines lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) {
    const std::size_t blank = line.find(' ');
    if (blank != std::string::npos) lines.emplace(line.substr(0, blank), line.substr(blank + 1));
  }
  return lines;
}

std::string value_or(const Lines& lines, std::string_view key, std::string_view other) {
  const auto found = lines.find(key);
  return std::string(found == lines.end() ? other : found->second).substr(0, 64);
}

/// The compiler's name of a symbol as people write it, inside the text of dlerror().
std::string readable(const std::string& text) {
  const std::size_t begin = text.find("_Z");
  if (begin == std::string::npos) return text;
  const std::string symbol = text.substr(begin, text.find_first_of(" :)\n", begin) - begin);
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(abi::__cxa_demangle(symbol.c_str(), nullptr, nullptr, &status),
                                                         &std::free);
  return name ? text.substr(0, begin) + name.get() + text.substr(begin + symbol.size()) : text;
}

std::vector<std::string>& loaded_names() {
  static std::vector<std::string> names;
  return names;
}

/// The plug-in's registrations in the order of their names, so that nothing depends on the order of its files.
std::vector<Registration*> in_order(Registration* first) {
  std::vector<Registration*> list;
  for (Registration* one = first; one; one = one->next()) list.push_back(one);
  const auto key = [](const Registration* one) { return std::pair(one->what(), one->name()); };
  std::ranges::sort(list, {}, key);
  return list;
}

Diagnostics check_registrations(const std::vector<Registration*>& list) {
  Diagnostics diagnostics;
  if (list.empty())
    diagnostics.error(Code::kMissing, "", "brings nothing",
                      "Add TAKT_PRIMITIVE, TAKT_DEVICE_KIND or TAKT_OPERATION to one of its files");
  for (std::size_t i = 0; i < list.size(); ++i) {
    diagnostics.append(list[i]->check());
    if (i == 0 || list[i]->what() != list[i - 1]->what() || list[i]->name() != list[i - 1]->name()) continue;
    diagnostics.error(Code::kDuplicate, "", fmt::format("declares {} '{}' twice", list[i]->what(), list[i]->name()));
  }
  return diagnostics;
}

Result<Loaded> load_checked(const std::filesystem::path& file, const Lines& about) {
  Loaded loaded{file, value_or(about, "name", "?"), value_or(about, "version", "?"), {}};
  if (std::ranges::find(loaded_names(), loaded.name) != loaded_names().end()) {
    return failure(Code::kDuplicate, "", fmt::format("a plug-in '{}' is loaded already", loaded.name),
                   "Load each plug-in once");
  }
  // Never closed: nets, devices and registries point into it. RTLD_NOW: a missing symbol shows here, not in the cycle.
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return failure(Code::kIncompatible, "", fmt::format("cannot be loaded: {}", readable(dlerror())), kRebuild);
  const auto entry = reinterpret_cast<Registration* (*)()>(dlsym(library, "takt_plugin_registrations"));
  if (!entry)
    return failure(Code::kIncompatible, "", "has no takt_plugin_registrations()",
                   "Add TAKT_PLUGIN(name, version), which makes it");
  const std::vector<Registration*> list = in_order(entry());
  if (Diagnostics wrong = check_registrations(list); wrong.has_errors()) return std::unexpected(std::move(wrong));
  for (Registration* one : list) {
    one->add();
    loaded.brings.push_back(fmt::format("{} {}", one->what(), one->name()));
  }
  loaded_names().push_back(loaded.name);
  return loaded;
}

}  // namespace

Diagnostics check_about(std::string_view text) {
  Diagnostics diagnostics;
  const auto theirs = parse(text);
  if (!theirs) {
    diagnostics.error(Code::kIncompatible, "", "is not a plug-in of takt",
                      "Add TAKT_PLUGIN(name, version) to one of its files");
    return diagnostics;
  }
  constexpr About here = about_plugin("", "");
  Lines ours = *parse(here.view());
  const std::string version = value_or(*theirs, "takt", "an unknown version");
  if (version != TAKT_VERSION) {
    diagnostics.error(Code::kIncompatible, "",
                      fmt::format("is built for takt {}; this is takt {}", version, TAKT_VERSION), kRebuild);
    return diagnostics;  // that everything else differs too is a consequence
  }
  for (const char* own : {"name", "version"}) ours.erase(own);
  for (const auto& [key, value] : ours) {
    const std::string other = value_or(*theirs, key, "nothing");
    if (other == value) continue;
    diagnostics.error(Code::kIncompatible, "", fmt::format("is built with {} {}; this takt with {}", key, other, value),
                      kRebuild);
  }
  return diagnostics;
}

Result<Loaded> load(const std::filesystem::path& file) {
  const auto loaded = [&]() -> Result<Loaded> {
    const auto section = read_elf_section(file, kSection);
    if (!section) return std::unexpected(section.error());
    if (Diagnostics wrong = check_about(*section); wrong.has_errors()) return std::unexpected(std::move(wrong));
    std::error_code error;
    return load_checked(std::filesystem::canonical(file, error), *parse(*section));
  };
  Result<Loaded> result = loaded();
  if (!result) result.error().set_file(file.string());
  return result;
}

}  // namespace takt::plugin
