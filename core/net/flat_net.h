#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/net/description.h"
#include "core/net/load_report.h"
#include "core/net/registry.h"

namespace takt::net {

/// A primitive with its full id ("fragment/id") and its type. Everything points into the description.
struct FlatPrimitive {
  std::string id;
  const PrimitiveDescription* description = nullptr;
  const PrimitiveInfo* info = nullptr;  ///< nullptr: unknown type (reported)
  const Maker* maker = nullptr;
  int fragment = 0;
  int index = 0;  ///< in its net's list
};

/// A fragment; number 0 is the net itself.
struct FlatFragment {
  std::string id;       ///< full id; empty for the net itself
  std::string pointer;  ///< JSON pointer of its net
  const FragmentDescription* description = nullptr;
  const NetDescription* net = nullptr;
  int parent = -1;
  bool gated = false;   ///< it, or one around it, has a linked `active`
  bool broken = false;  ///< its ports are declared wrongly (reported)
  /// (name, index) of its ports, sorted.
  std::vector<std::pair<std::string_view, int>> inputs, outputs;
};

/// A link from an output to one input (a link into a fragment port that feeds several inputs becomes several).
struct FlatLink {
  int from = -1, from_port = 0;  ///< node and output
  int to = -1, to_port = 0;      ///< node and input
  bool delayed = false;          ///< marked, or into an input that breaks loops
  int fragment = 0, index = 0;   ///< where it is written
};

/// A demanded bound with its ends resolved (one into a fragment port that feeds several inputs becomes several).
struct FlatDemand {
  int from = -1, from_port = 0;
  int to = -1, to_port = 0;
  int fragment = 0, index = 0;
};

/// A description with the fragments flattened and all names resolved. Nodes are numbered: first the primitives, then
/// one gate per fragment, whose only input is `active`. Private to core/net.
struct FlatNet {
  std::vector<FlatPrimitive> primitives;
  std::vector<FlatFragment> fragments;
  std::vector<FlatLink> links;
  std::vector<FlatDemand> demands;           ///< those whose ends were found
  std::vector<int> input_base, output_base;  ///< number of a node's first input and output; one entry past the end
  std::vector<int> input_link;               ///< per input: its link, or -1
  std::vector<const Signal*> signals;  ///< per primitive: of the resource that it names, or nullptr; empty: not bound

  [[nodiscard]] int primitive_count() const { return static_cast<int>(primitives.size()); }
  [[nodiscard]] int node_count() const { return static_cast<int>(primitives.size() + fragments.size()); }
  [[nodiscard]] bool is_gate(int node) const { return node >= primitive_count(); }
  [[nodiscard]] int fragment_of(int node) const;
  /// Full id of a primitive, or of the fragment of a gate.
  [[nodiscard]] const std::string& id(int node) const;
  [[nodiscard]] const PrimitiveInfo::Port& output(int node, int port) const;
  [[nodiscard]] const PrimitiveInfo::Port& input(int node, int port) const;
  [[nodiscard]] int input_count(int node) const;
  [[nodiscard]] int output_count(int node) const;
  /// "id.port"
  [[nodiscard]] std::string output_name(int node, int port) const;
  [[nodiscard]] std::string input_name(int node, int port) const;
  /// " ('speed' is declared as m/s)" for a primitive that names a resource with a signal; else empty.
  [[nodiscard]] std::string declared_unit(int node) const;
  [[nodiscard]] std::string declared_frame(int node) const;
  [[nodiscard]] std::string primitive_pointer(int primitive) const;
  [[nodiscard]] std::string link_pointer(const FlatLink& link) const;
  [[nodiscard]] const LinkDescription& description(const FlatLink& link) const;
  [[nodiscard]] std::string demand_pointer(const FlatDemand& demand) const;
  [[nodiscard]] const DemandDescription& description(const FlatDemand& demand) const;
  /// The JSON constant that the primitive's parameters give an input; nullptr if none.
  [[nodiscard]] const nlohmann::ordered_json* constant(int primitive, int port) const;
  /// What an entry of its type means for this primitive, whose parameters may say how many cycles.
  [[nodiscard]] Latency latency(int primitive, const PrimitiveInfo::LatencyEntry& entry) const;
};

/// Finds the signals of the resources that primitives name (Resource::signal). Realtime: setup.
void bind_signals(FlatNet& flat, Environment& environment);

/// The input that every fragment has by itself.
[[nodiscard]] const PrimitiveInfo::Port& active_port();

/// Flattens and resolves; reports unknown types, bad and duplicate ids, unknown parameters, dangling link ends, types
/// that differ, inputs fed twice and inputs fed by nothing. What could be resolved is there even if something was not.
[[nodiscard]] FlatNet flatten(const NetDescription& net, LoadReport& report);

}  // namespace takt::net
