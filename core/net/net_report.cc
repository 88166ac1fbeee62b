#include "core/net/net_report.h"

#include <nlohmann/json.hpp>

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

std::string from_name(const NetReport& report, const NetReport::Link& link) {
  const NetReport::Primitive& p = report.primitives[static_cast<std::size_t>(link.from)];
  return p.id + "." + p.info->outputs[static_cast<std::size_t>(link.from_port)].name;
}

std::string to_name(const NetReport& report, const NetReport::Link& link) {
  if (link.to < 0) return report.fragments[static_cast<std::size_t>(-link.to)].id + ".active";
  const NetReport::Primitive& p = report.primitives[static_cast<std::size_t>(link.to)];
  return p.id + "." + p.info->inputs[static_cast<std::size_t>(link.to_port)].name;
}

/// The ports that a way over links passes, both ends of each link.
Json way(const NetReport& report, const std::vector<int>& links) {
  Json ports = Json::array();
  for (const int number : links) {
    const NetReport::Link& link = report.links[static_cast<std::size_t>(number)];
    ports.push_back(from_name(report, link));
    ports.push_back(to_name(report, link));
  }
  return ports;
}

Json fragments_to_json(const NetReport& report) {
  Json array = Json::array();
  for (std::size_t f = 1; f < report.fragments.size(); ++f) {
    const NetReport::Fragment& fragment = report.fragments[f];
    array.push_back({{"id", fragment.id},
                     {"can_rest", fragment.can_rest},
                     {"when_inactive", fragment.when_inactive == WhenInactive::kKeep ? "keep" : "reset"}});
  }
  return array;
}

Json primitives_to_json(const NetReport& report) {
  Json array = Json::array();
  for (const NetReport::Primitive& p : report.primitives) {
    Json json = {{"id", p.id},
                 {"type", p.info->type},
                 {"fragment", report.fragments[static_cast<std::size_t>(p.fragment)].id},
                 {"order", p.order}};
    for (const auto& entry : p.latencies) {
      json["latencies"].push_back({{"in", entry.in},
                                   {"out", entry.out},
                                   {"cycles", entry.latency.cycles},
                                   {"data_dependent", entry.latency.data_dependent}});
    }
    array.push_back(std::move(json));
  }
  return array;
}

Json reactions_to_json(const NetReport& report) {
  Json array = Json::array();
  for (const NetReport::Reaction& one : report.reactions) {
    array.push_back({{"source", one.source},
                     {"sink", one.sink},
                     {"minimum_cycles", one.minimum_cycles},
                     {"maximum_cycles", one.maximum_cycles},
                     {"data_dependent", one.data_dependent},
                     {"exact", one.exact},
                     {"critical_path", way(report, one.links)}});
  }
  return array;
}

Json demands_to_json(const NetReport& report) {
  Json array = Json::array();
  for (const NetReport::Demand& one : report.demands) {
    array.push_back({{"from", one.from},
                     {"to", one.to},
                     {"demanded_minimum_cycles", one.demanded_minimum},
                     {"demanded_maximum_cycles", one.demanded_maximum},
                     {"minimum_cycles", one.minimum_cycles},
                     {"maximum_cycles", one.maximum_cycles},
                     {"critical_path", way(report, one.links)}});
  }
  return array;
}

}  // namespace

Json report_to_json(const NetReport& report) {
  Json json = {{"order", report.order},
               {"resources", report.resources},
               {"fragments", fragments_to_json(report)},
               {"primitives", primitives_to_json(report)},
               {"links", Json::array()},
               {"reactions", reactions_to_json(report)},
               {"demands", demands_to_json(report)},
               {"null_paths", Json::array()},
               {"free_units", Json::array()},
               {"exclusions", Json::array()}};
  for (const NetReport::Link& link : report.links) {
    json["links"].push_back({{"from", from_name(report, link)},
                             {"to", to_name(report, link)},
                             {"delayed", link.delayed},
                             {"may_be_null", link.may_be_null}});
  }
  for (const NetReport::NullPath& one : report.null_paths) {
    json["null_paths"].push_back(
        {{"at", one.at}, {"null_means", one.meaning}, {"origin", one.origin}, {"path", one.ports}});
  }
  for (const NetReport::FreeUnit& one : report.free_units) {
    json["free_units"].push_back({{"primitive", one.primitive}, {"variable", one.variable}});
  }
  for (const NetReport::Exclusion& one : report.exclusions) {
    json["exclusions"].push_back({{"at", one.at}, {"proven", one.proven}});
  }
  return json;
}

}  // namespace takt::net
