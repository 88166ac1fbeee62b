// A net as a graph: what a viewer draws and watches.
#include <span>

#include <nlohmann/json.hpp>

#include "core/net/compiled_net.h"
#include "serve/api.h"

namespace takt::serve {
namespace {

using GraphJson = nlohmann::ordered_json;

GraphJson ports_json(std::span<const net::PrimitiveInfo::Port> ports) {
  GraphJson list = GraphJson::array();
  for (const auto& port : ports) list.push_back({{"name", port.name}, {"type", net::name_of(port.type)}});
  return list;
}

}  // namespace

HttpResponse Api::net_graph(const Call& call) const {
  const rcc::NetId id = net_in(call);
  const rcc::NetHandle net = cell_.core().knows(id) ? cell_.core().net(id) : nullptr;
  if (net == nullptr) return problem(404, "there is no such net, or it is still Loading, or was rejected");
  const net::NetReport& report = net->report();
  GraphJson primitives = GraphJson::array(), links = GraphJson::array();
  for (const net::NetReport::Primitive& one : report.primitives)
    primitives.push_back({{"id", one.id},
                          {"type", one.info->type},
                          {"order", one.order},
                          {"inputs", ports_json(one.info->inputs)},
                          {"outputs", ports_json(one.info->outputs)}});
  for (const net::NetReport::Link& link : report.links) {
    if (link.to < 0) continue;  // into `active` of a fragment
    links.push_back({{"from", link.from},
                     {"from_port", link.from_port},
                     {"to", link.to},
                     {"to_port", link.to_port},
                     {"delayed", link.delayed},
                     {"may_be_null", link.may_be_null}});
  }
  return json_answer(200, {{"net", id},
                           {"name", net->name()},
                           {"resources", report.resources},
                           {"primitives", std::move(primitives)},
                           {"links", std::move(links)}});
}

}  // namespace takt::serve
