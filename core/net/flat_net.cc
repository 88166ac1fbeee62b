#include "core/net/flat_net.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

namespace takt::net {

const PrimitiveInfo::Port& active_port() {
  static const PrimitiveInfo::Port kActive{
      "active", ValueType::kBoolean, {.doc = "false or null: the fragment rests", .on_null = OnNull::kCountsAsFalse}};
  return kActive;
}

int FlatNet::fragment_of(int node) const {
  return is_gate(node) ? node - primitive_count() : primitives[static_cast<std::size_t>(node)].fragment;
}

const std::string& FlatNet::id(int node) const {
  return is_gate(node) ? fragments[static_cast<std::size_t>(fragment_of(node))].id
                       : primitives[static_cast<std::size_t>(node)].id;
}

const PrimitiveInfo::Port& FlatNet::output(int node, int port) const {
  return primitives[static_cast<std::size_t>(node)].info->outputs[static_cast<std::size_t>(port)];
}

const PrimitiveInfo::Port& FlatNet::input(int node, int port) const {
  if (is_gate(node)) return active_port();
  return primitives[static_cast<std::size_t>(node)].info->inputs[static_cast<std::size_t>(port)];
}

int FlatNet::input_count(int node) const {
  return input_base[static_cast<std::size_t>(node) + 1] - input_base[static_cast<std::size_t>(node)];
}

int FlatNet::output_count(int node) const {
  return output_base[static_cast<std::size_t>(node) + 1] - output_base[static_cast<std::size_t>(node)];
}

std::string FlatNet::output_name(int node, int port) const { return id(node) + "." + output(node, port).name; }

std::string FlatNet::input_name(int node, int port) const { return id(node) + "." + input(node, port).name; }

std::string FlatNet::primitive_pointer(int primitive) const {
  const FlatPrimitive& p = primitives[static_cast<std::size_t>(primitive)];
  return fragments[static_cast<std::size_t>(p.fragment)].pointer + "/primitives" +
         pointer_segment(static_cast<std::size_t>(p.index));
}

std::string FlatNet::link_pointer(const FlatLink& link) const {
  return fragments[static_cast<std::size_t>(link.fragment)].pointer + "/links" +
         pointer_segment(static_cast<std::size_t>(link.index));
}

const LinkDescription& FlatNet::description(const FlatLink& link) const {
  return fragments[static_cast<std::size_t>(link.fragment)].net->links[static_cast<std::size_t>(link.index)];
}

std::string FlatNet::demand_pointer(const FlatDemand& demand) const {
  return fragments[static_cast<std::size_t>(demand.fragment)].pointer + "/demands" +
         pointer_segment(static_cast<std::size_t>(demand.index));
}

const DemandDescription& FlatNet::description(const FlatDemand& demand) const {
  return fragments[static_cast<std::size_t>(demand.fragment)].net->demands[static_cast<std::size_t>(demand.index)];
}

namespace {

const nlohmann::ordered_json* parameter(const FlatPrimitive& primitive, const std::string& name) {
  if (!primitive.description->parameters.is_object()) return nullptr;
  const auto found = primitive.description->parameters.find(name);
  return found == primitive.description->parameters.end() ? nullptr : &*found;
}

/// JSON text of the default of a parameter; empty if it has none.
std::string fallback(const PrimitiveInfo& info, const std::string& name) {
  const auto found = std::ranges::find(info.parameters, name, &PrimitiveInfo::Parameter::name);
  return found == info.parameters.end() ? std::string() : found->fallback;
}

}  // namespace

const nlohmann::ordered_json* FlatNet::constant(int primitive, int port) const {
  const FlatPrimitive& p = primitives[static_cast<std::size_t>(primitive)];
  return parameter(p, p.info->inputs[static_cast<std::size_t>(port)].name);
}

Latency FlatNet::latency(int primitive, const PrimitiveInfo::LatencyEntry& entry) const {
  if (entry.cycles_parameter.empty()) return entry.latency;
  const FlatPrimitive& p = primitives[static_cast<std::size_t>(primitive)];
  const nlohmann::ordered_json* given = parameter(p, entry.cycles_parameter);
  const auto cycles = given != nullptr
                          ? *given
                          : nlohmann::ordered_json::parse(fallback(*p.info, entry.cycles_parameter), nullptr, false);
  // What is no number of cycles is a diagnostic of the parameter's own.
  return {.cycles = cycles.is_number_integer() ? std::max<std::int64_t>(0, cycles.get<std::int64_t>()) : 0};
}

}  // namespace takt::net
