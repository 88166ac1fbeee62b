#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/diagnostics.h"

namespace takt::net {

/// Fragments may lie in fragments, this many levels at most.
inline constexpr std::size_t kMaxNesting = 32;

/// One primitive of a net as the user wrote it. Parameters may also give a constant to an input port of the same name.
struct PrimitiveDescription {
  std::string id;
  std::string type;
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  /// What null means at inputs that stop or drive (rows N3, N4), by input: true, false, "stop" or {"bridge_cycles": n}.
  nlohmann::ordered_json on_null = nlohmann::ordered_json::object();
  bool operator==(const PrimitiveDescription&) const = default;
};

/// One link: output "id.port" to input "id.port". A port of a fragment is "fragment.port"; what lies inside a fragment
/// may also be named outright, "fragment/id.port". Ids are without '.', '/' and blanks.
struct LinkDescription {
  std::string from;
  std::string to;
  bool delayed = false;
  nlohmann::ordered_json initial = nullptr;  ///< value before the first delayed one; null = null
  bool operator==(const LinkDescription&) const = default;
};

/// A bound that the net demands of itself (rows O6, O7): an event at output `from` arrives at input `to` after at most
/// `maximum_cycles` and, where given, at least `minimum_cycles`. LOAD rejects a net that breaks it.
struct DemandDescription {
  std::string from;
  std::string to;
  std::int64_t maximum_cycles = 0;
  std::optional<std::int64_t> minimum_cycles;
  bool operator==(const DemandDescription&) const = default;
};

/// A named sub-net with ports of its own; flattened at load.
struct FragmentDescription;

/// The fragments of a net. Releases them level by level, so that no depth of nesting needs a deep stack.
struct FragmentList : std::vector<FragmentDescription> {
  using std::vector<FragmentDescription>::vector;
  FragmentList() = default;
  FragmentList(const FragmentList&) = default;
  FragmentList(FragmentList&&) = default;
  FragmentList& operator=(const FragmentList&) = default;
  FragmentList& operator=(FragmentList&&) = default;
  ~FragmentList();
};

/// A net as an object; JSON is one encoding of it. load(dump(net)) == net.
struct NetDescription {
  std::string name;
  std::vector<PrimitiveDescription> primitives;
  std::vector<LinkDescription> links;
  FragmentList fragments;
  std::vector<DemandDescription> demands;

  NetDescription& add(std::string id, std::string type,
                      nlohmann::ordered_json parameters = nlohmann::ordered_json::object());
  NetDescription& link(std::string from, std::string to);
  NetDescription& demand(std::string from, std::string to, std::int64_t maximum_cycles);
  NetDescription& link_delayed(std::string from, std::string to, nlohmann::ordered_json initial = nullptr);
  bool operator==(const NetDescription&) const;
};

/// What an inactive fragment does with its state (row O3).
enum class WhenInactive { kKeep, kReset };

struct FragmentDescription {
  std::string id;
  WhenInactive when_inactive = WhenInactive::kReset;
  NetDescription net;
  /// Ports of the fragment: name -> inner "id.port". The Boolean input "active" always exists; unlinked it is true.
  std::vector<std::pair<std::string, std::string>> inputs;
  std::vector<std::pair<std::string, std::string>> outputs;
  bool operator==(const FragmentDescription&) const;
};

[[nodiscard]] Result<NetDescription> net_from_json(const nlohmann::ordered_json& json);
[[nodiscard]] nlohmann::ordered_json net_to_json(const NetDescription& net);

}  // namespace takt::net
