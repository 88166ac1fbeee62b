// primitives: the library of primitives, from the text of their registration.
#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/base/json_lines.h"
#include "core/net/example.h"
#include "core/net/registry.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using net::OnNull;
using net::PrimitiveInfo;

// -- In words ---------------------------------------------------------------------------------------------------------

/// What an input makes of null; empty where null simply goes on to the outputs.
std::string_view words(OnNull on_null) {
  switch (on_null) {
    case OnNull::kPropagate:
      return "";
    case OnNull::kCountsAsTrue:
      return "null counts as true";
    case OnNull::kCountsAsFalse:
      return "null counts as false";
    case OnNull::kStop:
      return "null stops the net";
    case OnNull::kMayPass:
      return "null may pass";
    case OnNull::kHandled:
      break;
  }
  return "null is allowed";
}

void add_note(std::string& notes, std::string_view note) {
  if (!note.empty()) notes += fmt::format("{}{}", notes.empty() ? "" : "; ", note);
}

/// One row of the table of a primitive.
struct PortRow {
  std::string kind, name, type, unit, frame, text;
};

std::vector<PortRow> rows_of(const PrimitiveInfo& info) {
  std::vector<PortRow> rows;
  const auto& breaking = info.loop_breaking_inputs;
  for (const auto& port : info.inputs) {
    std::string notes;
    add_note(notes, words(port.spec.on_null));
    if (port.spec.optional) add_note(notes, "may be left out");
    if (std::ranges::find(breaking, port.name) != breaking.end()) add_note(notes, "reads the cycle before");
    rows.push_back({"in", port.name, std::string(name_of(port.type)), std::string(port.spec.unit),
                    std::string(port.spec.frame),
                    fmt::format("{}{}", port.spec.doc, notes.empty() ? "" : " [" + notes + "]")});
  }
  for (const auto& port : info.outputs) {
    rows.push_back({"out", port.name, std::string(name_of(port.type)), std::string(port.spec.unit),
                    std::string(port.spec.frame),
                    fmt::format("{}{}", port.spec.doc, port.spec.may_be_null ? " [may be null]" : "")});
  }
  for (const auto& one : info.parameters) {
    std::string notes;
    if (!one.spec.range.empty()) add_note(notes, one.spec.range);
    add_note(notes, one.fallback.empty() ? "must be given" : fmt::format("default {}", one.fallback));
    rows.push_back(
        {"par", one.name, one.type, std::string(one.spec.unit), "", fmt::format("{} [{}]", one.spec.doc, notes)});
  }
  return rows;
}

std::string lateness(const PrimitiveInfo::LatencyEntry& entry) {
  if (!entry.cycles_parameter.empty()) return fmt::format("as many cycles late as '{}' says", entry.cycles_parameter);
  if (entry.latency.data_dependent) return "how late depends on data";
  return fmt::format("{} cycle{} late", entry.latency.cycles, entry.latency.cycles == 1 ? "" : "s");
}

/// Latencies and how null goes through, a sentence each.
std::vector<std::string> remarks_of(const PrimitiveInfo& info) {
  std::vector<std::string> remarks;
  for (const auto& entry : info.latencies)
    remarks.push_back(fmt::format("{} -> {}: {}", entry.in, entry.out, lateness(entry)));
  if (remarks.empty() && !info.inputs.empty() && !info.outputs.empty())
    remarks.emplace_back("Every output belongs to the inputs of the same cycle.");
  const bool propagates = !info.outputs.empty() && std::ranges::any_of(info.inputs, [](const auto& port) {
    return port.spec.on_null == OnNull::kPropagate;
  });
  if (propagates) remarks.emplace_back("Null at an input without a remark makes every output null.");
  if (!info.claims.empty()) remarks.push_back(fmt::format("Drives the device of parameter '{}'.", info.claims));
  return remarks;
}

// -- Types that come for several payloads -----------------------------------------------------------------------------

/// Primitives that differ in the type of their payload only: SelectReal, SelectFrame, ...
struct Kin {
  const PrimitiveInfo* shown;      ///< whose ports are printed
  std::vector<std::string> types;  ///< all of them
  std::string name;                ///< "Select...", or the type where it is alone
};

/// The type without the payload at its end; the type itself if it has none.
std::string stem_of(const std::string& type) {
  for (const char* payload :
       {"Boolean", "Integer", "Real", "String", "Vector", "Rotation", "Frame", "Twist", "Wrench", "Joints"}) {
    if (type.ends_with(payload) && type != payload)
      return type.substr(0, type.size() - std::string_view(payload).size());
  }
  return type;
}

std::map<std::string, std::vector<Kin>> families(const std::vector<const PrimitiveInfo*>& all) {
  std::map<std::string, std::map<std::pair<std::string, std::string>, Kin>> sorted;
  for (const PrimitiveInfo* info : all) {
    auto [place, fresh] = sorted[info->family].try_emplace({stem_of(info->type), info->doc}, Kin{info, {}, info->type});
    Kin& kin = place->second;
    kin.types.push_back(info->type);
    if (info->type.ends_with("Real")) kin.shown = info;
    if (!fresh) kin.name = stem_of(info->type) + "...";
  }
  std::map<std::string, std::vector<Kin>> lists;
  for (auto& [family, kins] : sorted)
    for (auto& [key, kin] : kins) lists[family].push_back(std::move(kin));
  return lists;
}

/// The payloads of kin, "Boolean, Integer, ...".
std::string payloads_of(const Kin& kin) {
  std::string text;
  for (const std::string& type : kin.types) {
    const std::string stem = stem_of(type);
    text += fmt::format("{}{}", text.empty() ? "" : ", ", type == stem ? type : type.substr(stem.size()));
  }
  return text;
}

// -- For a terminal ---------------------------------------------------------------------------------------------------

std::size_t width_of(const std::vector<PortRow>& rows, std::string PortRow::*column) {
  std::size_t width = 0;
  for (const PortRow& row : rows) width = std::max(width, (row.*column).size());
  return width;
}

void print_primitive(const PrimitiveInfo& info) {
  fmt::print("{} ({})\n  {}\n\n", info.type, info.family, info.doc);
  const std::vector<PortRow> rows = rows_of(info);
  const std::size_t name = width_of(rows, &PortRow::name), type = width_of(rows, &PortRow::type),
                    unit = width_of(rows, &PortRow::unit), frame = width_of(rows, &PortRow::frame);
  for (const PortRow& row : rows) {
    fmt::print("  {:<3}  {:<{}}  {:<{}}  {:<{}}  ", row.kind, row.name, name, row.type, type, row.unit, unit);
    if (frame > 0) fmt::print("{:<{}}  ", row.frame, frame);
    fmt::print("{}\n", row.text);
  }
  fmt::print("\n");
  for (const std::string& remark : remarks_of(info)) fmt::print("  {}\n", remark);
  fmt::print("\n  a minimal net:\n{}\n", in_lines(net_to_json(net::example_net(info))));
}

void print_list(const std::vector<const PrimitiveInfo*>& all) {
  for (const auto& [family, kins] : families(all)) {
    std::size_t width = 0;
    for (const Kin& kin : kins) width = std::max(width, kin.name.size());
    fmt::print("{}\n", family);
    for (const Kin& kin : kins) {
      fmt::print("  {:<{}}  {}\n", kin.name, width, kin.shown->doc.substr(0, kin.shown->doc.find(". ") + 1));
      if (kin.types.size() > 1) fmt::print("  {:<{}}  for {}\n", "", width, payloads_of(kin));
    }
  }
}

// -- The page of the documentation ------------------------------------------------------------------------------------

/// Text inside a cell of a table.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '*' || c == '_') out += '\\';
    out += c;
  }
  return out;
}

void print_kin(const Kin& kin) {
  fmt::print("### {}\n{}\n", kin.name, cell(kin.shown->doc));
  if (kin.types.size() > 1) fmt::print("\nFor {}; here as {}.\n", payloads_of(kin), kin.shown->type);
  const std::vector<PortRow> rows = rows_of(*kin.shown);
  if (!rows.empty()) fmt::print("\n| | name | type | unit | frame | what |\n|---|---|---|---|---|---|\n");
  for (const PortRow& row : rows) {
    fmt::print("| {} | `{}` | {} | {} | {} | {} |\n", row.kind, row.name, row.type, cell(row.unit), cell(row.frame),
               cell(row.text));
  }
  const std::vector<std::string> remarks = remarks_of(*kin.shown);
  if (!remarks.empty()) fmt::print("\n");
  for (const std::string& remark : remarks) fmt::print("- {}\n", cell(remark));
  fmt::print("\n");
}

void print_page(const std::vector<const PrimitiveInfo*>& all) {
  const auto lists = families(all);
  fmt::print(
      "# The library of primitives\n\n"
      "This page is printed by `takt primitives --markdown` from what the primitives say of themselves when they "
      "register; "
      "a test holds it\nto that. `takt primitives NAME` shows one with a net to try. How nets are written: "
      "[nets.md](nets.md).\n\n"
      "`in` and `out` are ports, `par` parameters, which are set once; a parameter may also give a constant to an "
      "input "
      "of its name. A\nlower-case letter in a unit (`u`, `u/s`) and a capital in a frame (`A>B`: the pose of B in A) "
      "are "
      "variables: what is linked\ndecides, and all ports of one primitive must agree.\n\n");
  for (const auto& [family, kins] : lists) {
    fmt::print("- {}:", family);
    for (const Kin& kin : kins) fmt::print(" {}{}", kin.name, &kin == &kins.back() ? "\n" : ",");
  }
  for (const auto& [family, kins] : lists) {
    fmt::print("\n## {}\n\n", family);
    for (const Kin& kin : kins) print_kin(kin);
  }
}

// -- For programs -----------------------------------------------------------------------------------------------------

Json describe_port(const PrimitiveInfo::Port& port, bool output) {
  Json json{{"name", port.name},
            {"type", name_of(port.type)},
            {"unit", port.spec.unit},
            {"frame", port.spec.frame},
            {"doc", port.spec.doc}};
  if (output) {
    json["may_be_null"] = port.spec.may_be_null;
  } else {
    const std::string_view on_null = words(port.spec.on_null);
    json["on_null"] = on_null.empty() ? "null makes the outputs null" : on_null;
    json["optional"] = port.spec.optional;
  }
  return json;
}

Json describe(const PrimitiveInfo& info) {
  Json inputs = Json::array(), outputs = Json::array(), parameters = Json::array(), latencies = Json::array();
  for (const auto& port : info.inputs) inputs.push_back(describe_port(port, false));
  for (const auto& port : info.outputs) outputs.push_back(describe_port(port, true));
  for (const auto& one : info.parameters) {
    parameters.push_back({{"name", one.name},
                          {"type", one.type},
                          {"unit", one.spec.unit},
                          {"range", one.spec.range},
                          {"default", one.fallback.empty() ? Json() : Json::parse(one.fallback)},
                          {"required", one.fallback.empty()},
                          {"doc", one.spec.doc}});
  }
  for (const auto& entry : info.latencies) {
    Json& latency = latencies.emplace_back(Json{{"in", entry.in}, {"out", entry.out}});
    if (entry.cycles_parameter.empty()) {
      latency["cycles"] = entry.latency.cycles;
    } else {
      latency["cycles_parameter"] = entry.cycles_parameter;
    }
    latency["data_dependent"] = entry.latency.data_dependent;
  }
  return {{"type", info.type},
          {"family", info.family},
          {"doc", info.doc},
          {"inputs", inputs},
          {"outputs", outputs},
          {"parameters", parameters},
          {"latencies", latencies},
          {"drives_device", !info.claims.empty()},
          {"example", net_to_json(net::example_net(info))}};
}

struct PrimitivesArguments {
  std::string name;
  bool markdown = false;
};

/// The types that a name means: one, or a whole family. Empty if there is no such name.
std::vector<const PrimitiveInfo*> choose(const std::string& name) {
  std::vector<const PrimitiveInfo*> all = net::Registry::global().all();
  if (name.empty()) return all;
  if (const PrimitiveInfo* info = net::Registry::global().find(name)) return {info};
  std::erase_if(all, [&name](const PrimitiveInfo* info) { return info->family != name; });
  return all;
}

int primitives(const PrimitivesArguments& arguments, const Common& common) {
  const auto chosen = choose(arguments.name);
  if (chosen.empty()) {
    std::vector<std::string> names = net::Registry::global().names();
    std::set<std::string> groups;
    for (const PrimitiveInfo* info : net::Registry::global().all()) groups.insert(info->family);
    names.insert(names.end(), groups.begin(), groups.end());
    Diagnostics diagnostics;
    diagnostics.error(Code::kUnknownName, "", fmt::format("there is no primitive or family '{}'", arguments.name),
                      nearest_choice(arguments.name, names));
    return report(diagnostics, common);
  }
  if (common.json) {
    Json list = Json::array();
    for (const auto* info : chosen) list.push_back(describe(*info));
    print({{"primitives", list}});
  } else if (arguments.markdown) {
    print_page(chosen);
  } else if (chosen.size() == 1 && chosen.front()->type == arguments.name) {
    print_primitive(*chosen.front());
  } else {
    print_list(chosen);
  }
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_primitives(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<PrimitivesArguments>();
  CLI::App* verb = app.add_subcommand("primitives", "Print the primitives with ports, parameters and documentation");
  verb->add_option("NAME", arguments->name, "One primitive, with a net to try, or one family");
  verb->add_flag("--markdown", arguments->markdown, "As a page: docs/primitives.md");
  return {verb, [arguments, &common] { return primitives(*arguments, common); }};
}

}  // namespace takt::tools
