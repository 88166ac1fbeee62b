// What the resources that primitives name say of the value that they carry.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/flat_net.h"

namespace takt::net {
namespace {

/// The name in the first parameter that names a resource; empty if there is none.
std::string_view resource_name(const FlatPrimitive& primitive) {
  if (primitive.info == nullptr || !primitive.description->parameters.is_object()) return {};
  for (const PrimitiveInfo::Parameter& parameter : primitive.info->parameters) {
    if (!parameter.type.starts_with("device:")) continue;
    const auto given = primitive.description->parameters.find(parameter.name);
    if (given == primitive.description->parameters.end() || !given->is_string()) return {};
    return given->get_ref<const std::string&>();
  }
  return {};
}

std::string declared(const FlatNet& flat, int node, std::string Signal::*what) {
  if (flat.signals.empty() || flat.is_gate(node)) return {};
  const Signal* signal = flat.signals[static_cast<std::size_t>(node)];
  if (signal == nullptr || (signal->*what).empty()) return {};
  const auto name = resource_name(flat.primitives[static_cast<std::size_t>(node)]);
  return fmt::format(" ('{}' is declared as {})", name, signal->*what);
}

}  // namespace

void bind_signals(FlatNet& flat, Environment& environment) {
  flat.signals.assign(flat.primitives.size(), nullptr);
  for (std::size_t p = 0; p < flat.primitives.size(); ++p) {
    const std::string_view name = resource_name(flat.primitives[p]);
    const Resource* resource = name.empty() ? nullptr : environment.find(name);
    if (resource != nullptr) flat.signals[p] = resource->signal();
  }
}

std::string FlatNet::declared_unit(int node) const { return declared(*this, node, &Signal::unit); }
std::string FlatNet::declared_frame(int node) const { return declared(*this, node, &Signal::frame); }

}  // namespace takt::net
