// net: verification of a net file, as LOAD does it.
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "scenario/session.h"
#include "tools/cli.h"
#include "tools/net_file.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

struct NetArguments {
  std::string file, scenario;
};

Json describe(const net::NetReport& about) {
  Json json = net::report_to_json(about);
  json["findings"] = to_json(about.notes);
  return json;
}

void print_report(const net::NetReport& about) {
  fmt::print("order of evaluation\n");
  for (const std::string& id : about.order) fmt::print("  {}\n", id);
  if (!about.reactions.empty()) fmt::print("reactions (cycles from source to sink)\n");
  for (const auto& one : about.reactions) {
    fmt::print("  {} -> {}: {} to {}{}\n", one.source, one.sink, one.minimum_cycles, one.maximum_cycles,
               one.data_dependent ? ", depends on data"
               : one.exact        ? ""
                                  : ", an upper bound");
  }
  if (!about.demands.empty()) fmt::print("demanded bounds, all kept\n");
  for (const auto& one : about.demands) {
    fmt::print("  {} -> {}: {} to {} of {} to {}\n", one.from, one.to, one.minimum_cycles, one.maximum_cycles,
               one.demanded_minimum, one.demanded_maximum);
  }
  if (!about.exclusions.empty()) fmt::print("fragments that take turns\n");
  for (const auto& one : about.exclusions) {
    fmt::print("  at {}: {}\n", one.at, one.proven ? "never two at a time" : "not proven, a conflict fails the net");
  }
  fmt::print("{}", about.notes.to_string());
}

int check_net(const NetArguments& arguments, const Common& common) {
  // The scenario's cell gives the devices that the net names; without one there are none.
  rcc::ControlCore no_devices({});
  const device::ModelLibrary library = common.library();
  std::unique_ptr<scenario::Session> session;
  if (!arguments.scenario.empty()) {
    auto opened = scenario::Session::open(arguments.scenario, library);
    if (!opened) return report(opened.error(), common);
    session = std::move(*opened);
  }
  net::Environment& devices = session ? session->built().core->environment() : no_devices.environment();
  const auto net = load_net_file(arguments.file, devices);
  if (!net) return report(net.error(), common);
  if (common.json) {
    Json json{{"result", "ready"}};
    json.update(describe((*net)->report()));
    print(json);
  } else {
    fmt::print("{}: ready, {} primitives\n", arguments.file, (*net)->primitive_count());
    print_report((*net)->report());
  }
  return kHeld;
}

}  // namespace

Result<std::unique_ptr<net::CompiledNet>> load_net_file(const std::filesystem::path& file, net::Environment& devices) {
  const auto document = read_json(file);
  if (!document) return std::unexpected(document.error());
  Result<std::unique_ptr<net::CompiledNet>> net = std::unexpected(Findings{});
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
  CLI::App* verb = app.add_subcommand("net", "Check a realtime primitive net: order, reactions, all errors at once");
  verb->add_option("FILE", arguments->file, "Net file (JSON)")->required();
  verb->add_option("--scenario", arguments->scenario, "Scenario whose devices the net may name")->type_name("FILE");
  verb->add_flag_callback(
      "--check", [] {}, "Verify and report (the default)");
  return {verb, [arguments, &common] { return check_net(*arguments, common); }};
}

}  // namespace takt::tools
