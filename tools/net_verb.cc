// net: a net as LOAD sees it (--check), what it costs (--bench), what it looks like (--graph).
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/base/json_lines.h"
#include "core/base/output_file.h"
#include "tools/cli.h"
#include "tools/net_bench.h"
#include "tools/net_file.h"
#include "tools/net_picture.h"
#include "tools/net_text.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

struct NetArguments {
  std::string file, scenario, step, graph, dump;
  bool check = false, bench = false;
  double seconds = 2.0;
};

/// A net with the cell whose devices it names.
struct LoadedNet {
  std::unique_ptr<cell::Session> session;
  rcc::ControlCore no_devices{rcc::ControlCore::Options{}};
  net::NetDescription description;
  std::unique_ptr<net::CompiledNet> net;

  net::Environment& devices() { return session ? session->built().core->environment() : no_devices.environment(); }
};

bool is_net(const Json& document) { return document.is_object() && document.contains("primitives"); }

Diagnostics open_scenario(const std::string& file, const device::ModelLibrary& library, LoadedNet& loaded) {
  auto session = cell::Session::open(file, library);
  if (!session) return session.error();
  loaded.session = std::move(*session);
  return {};
}

Diagnostics compile(const std::string& file, LoadedNet& loaded) {
  auto net = net::CompiledNet::compile(loaded.description, loaded.devices());
  if (!net) {
    net.error().set_file(file);
    return net.error();
  }
  loaded.net = std::move(*net);
  return {};
}

/// The net that a step of the scenario would load.
Diagnostics choose_step(const std::string& step, LoadedNet& loaded) {
  std::vector<std::string> names;
  for (auto& one : loaded.session->nets()) {
    if (one.step == step || one.pointer == step) {
      loaded.description = std::move(one.net);
      return {};
    }
    names.push_back(one.step);
  }
  Diagnostics diagnostics;
  diagnostics.error(Code::kUnknownName, "--step", fmt::format("no step '{}' loads a net", step),
                    nearest_choice(step, names, 40));
  return diagnostics;
}

/// With those inside of its fragments, as the report of the compiled net counts them.
std::size_t primitive_count(const net::NetDescription& net) {
  std::size_t count = net.primitives.size();
  for (const net::FragmentDescription& fragment : net.fragments) count += primitive_count(fragment.net);
  return count;
}

/// What steps of a scenario have a net.
int list_steps(const LoadedNet& loaded, const Common& common) {
  Json steps = Json::array();
  for (const auto& one : loaded.session->nets()) {
    steps.push_back({{"step", one.step},
                     {"pointer", one.pointer},
                     {"net", one.net.name},
                     {"primitives", primitive_count(one.net)}});
  }
  if (common.json) {
    print({{"result", "ready"}, {"steps", std::move(steps)}});
    return kHeld;
  }
  fmt::print("steps with a net; takt net FILE --step NAME shows one\n");
  for (const Json& one : steps) {
    fmt::print("  {:<28} {:<28} {} primitives\n", one["step"].get<std::string>(), one["pointer"].get<std::string>(),
               one["primitives"].get<std::size_t>());
  }
  return kHeld;
}

/// Reads and compiles what the arguments name. @return diagnostics; without an error and without a net it is a scenario
/// whose steps are asked for.
Diagnostics load(const NetArguments& arguments, const device::ModelLibrary& library, LoadedNet& loaded) {
  const auto document = read_json(arguments.file);
  if (!document) return document.error();
  Diagnostics diagnostics;
  if (!is_net(*document)) {
    if (diagnostics = open_scenario(arguments.file, library, loaded); diagnostics.has_errors()) return diagnostics;
    if (arguments.step.empty()) return diagnostics;
    if (diagnostics = choose_step(arguments.step, loaded); diagnostics.has_errors()) return diagnostics;
    return compile(arguments.file, loaded);
  }
  if (!arguments.step.empty()) {
    diagnostics.error(Code::kInvalidValue, "--step", "the file is a net, not a scenario", "Give a scenario file");
    return diagnostics;
  }
  if (!arguments.scenario.empty()) {
    if (diagnostics = open_scenario(arguments.scenario, library, loaded); diagnostics.has_errors()) return diagnostics;
  }
  auto description = net::net_from_json(*document);
  if (!description) {
    description.error().set_file(arguments.file);
    return description.error();
  }
  loaded.description = std::move(*description);
  return compile(arguments.file, loaded);
}

Diagnostics draw(const NetArguments& arguments, const LoadedNet& loaded) {
  const auto picture = picture_of(loaded.net->report(), loaded.description);
  if (!picture) return picture.error();
  const auto placed = place(*picture);
  if (!placed) return placed.error();
  return write_file(arguments.graph, to_svg(*picture, *placed), "--graph");
}

/// Lets the devices of the cell take their first samples.
void warm_devices(const LoadedNet& loaded) {
  if (!loaded.session) return;
  const auto& built = loaded.session->built();
  for (int i = 0; i < 5; ++i) {
    built.core->step();
    if (!built.world->step()) return;
  }
}

Json describe(const LoadedNet& loaded) {
  Json json{{"result", "ready"}};
  json.update(net::report_to_json(loaded.net->report()));
  json["diagnostics"] = to_json(loaded.net->report().notes);
  return json;
}

/// Of a scenario without a step there is a list of its nets, and nothing to draw, to keep or to measure.
Diagnostics check_step_is_named(const NetArguments& arguments, const LoadedNet& loaded) {
  Diagnostics diagnostics;
  const std::pair<const char*, bool> asked[] = {
      {"--graph", !arguments.graph.empty()}, {"--dump", !arguments.dump.empty()}, {"--bench", arguments.bench}};
  for (const auto& [option, given] : asked) {
    if (given && !loaded.net)
      diagnostics.error(Code::kRequires, option, "the net of no step was asked for",
                        "Give --step NAME; without these options the steps with a net are listed");
  }
  return diagnostics;
}

int net(const NetArguments& arguments, const Common& common) {
  const device::ModelLibrary library = common.library();
  LoadedNet loaded;
  if (const Diagnostics diagnostics = load(arguments, library, loaded); diagnostics.has_errors())
    return report(diagnostics, common);
  Diagnostics diagnostics = check_step_is_named(arguments, loaded);
  if (diagnostics.has_errors()) return report(diagnostics, common);
  if (!loaded.net) return list_steps(loaded, common);
  if (!arguments.dump.empty()) {
    diagnostics.append(write_file(arguments.dump, in_lines(net::net_to_json(loaded.description)) + "\n", "--dump"));
  }
  if (!arguments.graph.empty()) diagnostics.append(draw(arguments, loaded));
  if (diagnostics.has_errors()) return report(diagnostics, common);

  const bool only_files = !arguments.graph.empty() || !arguments.dump.empty();
  const bool check = arguments.check || (!arguments.bench && !only_files);
  Json json = check ? describe(loaded) : Json{{"result", "ready"}};
  for (const std::string& file : {arguments.graph, arguments.dump}) {
    if (!file.empty()) json["products"].push_back(file);
  }
  if (!common.json && check) {
    fmt::print("{}: ready, {} primitives, {} links\n{}",
               loaded.description.name.empty() ? arguments.file : loaded.description.name,
               loaded.net->primitive_count(), loaded.net->report().links.size(), to_text(loaded.net->report()));
  }
  if (arguments.bench) {
    warm_devices(loaded);
    const auto bench = bench_net(*loaded.net, arguments.seconds);
    if (!bench) return report(bench.error(), common);
    json["bench"] = to_json(*bench);
    if (!common.json) fmt::print("{}", to_text(*bench, 40));
  }
  if (common.json) {
    print(json);
  } else if (only_files) {
    for (const Json& file : json["products"]) fmt::print("wrote {}\n", file.get<std::string>());
  }
  return kHeld;
}

}  // namespace

Result<std::unique_ptr<net::CompiledNet>> load_net_file(const std::filesystem::path& file, net::Environment& devices) {
  const auto document = read_json(file);
  if (!document) return std::unexpected(document.error());
  Result<std::unique_ptr<net::CompiledNet>> net = std::unexpected(Diagnostics{});
  if (const auto description = net::net_from_json(*document)) {
    net = net::CompiledNet::compile(*description, devices);
  } else {
    net = std::unexpected(description.error());
  }
  if (!net) net.error().set_file(file.string());
  return net;
}

std::pair<CLI::App*, Verb> add_net(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<NetArguments>();
  CLI::App* verb = app.add_subcommand("net", "A realtime primitive net: check it, measure it, draw it");
  verb->add_option("FILE", arguments->file, "Net file, or a scenario whose steps make nets (JSON)")->required();
  verb->add_option("--scenario", arguments->scenario, "Scenario whose devices the net may name")->type_name("FILE");
  verb->add_option("--step", arguments->step, "With a scenario: the net of the step of this name")->type_name("NAME");
  verb->add_flag("--check", arguments->check, "Verify and report (the default): certificate, null paths, units, order");
  verb->add_flag("--bench", arguments->bench, "Cost of a cycle and of each primitive on this machine");
  verb->add_option("--seconds", arguments->seconds, "How long --bench measures")
      ->check(CLI::Range(0.05, 600.0))
      ->capture_default_str();
  verb->add_option("--graph", arguments->graph, "The net as a picture")->type_name("OUT.svg");
  verb->add_option("--dump", arguments->dump, "The net as a file")->type_name("OUT.json");
  return {verb, [arguments, &common] { return net(*arguments, common); }};
}

}  // namespace takt::tools
