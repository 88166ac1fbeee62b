#include "cell/file/net_files.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/net/description.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

/// Puts the file's content in the place of its name. @return the file that the net now stands in; empty: the scenario.
std::string take_in(Json& place, const std::string& pointer, const std::filesystem::path& folder,
                    Diagnostics& diagnostics) {
  if (!place.is_string()) return {};
  const auto name = place.get<std::string>();
  place = nullptr;
  if (const auto inside = resolve_below(folder, name, pointer); !inside) {
    diagnostics.append(inside.error());
    return {};
  }
  const std::filesystem::path file = folder / name;
  auto content = read_json(file);
  if (content) {
    place = std::move(*content);
  } else {
    diagnostics.append(content.error(), {}, file.string());
  }
  return file.string();
}

}  // namespace

std::vector<NetEntry> read_nets(Json& document, const std::filesystem::path& folder, Diagnostics& diagnostics) {
  std::vector<NetEntry> entries;
  if (!document.is_object() || !document.contains("nets")) return entries;
  if (!document["nets"].is_object()) {
    diagnostics.error(Code::kSyntax, "/nets", short_dump(document["nets"]),
                      "Give an object: name to net, or to the file of one");
    return entries;
  }
  for (auto& [name, place] : document["nets"].items()) {
    const std::string pointer = "/nets" + pointer_segment(name);
    NetEntry entry{name, take_in(place, pointer, folder, diagnostics), nullptr};
    if (place.is_null()) continue;
    auto net = net::net_from_json(place);
    if (net) {
      if (net->name.empty()) net->name = name;
      entry.net = std::make_shared<const net::NetDescription>(std::move(*net));
      entries.push_back(std::move(entry));
    } else {
      diagnostics.append(net.error(), entry.file.empty() ? pointer : std::string(), entry.file);
    }
  }
  return entries;
}

}  // namespace takt::cell
