#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/net/description.h"
#include "core/net/registry.h"

namespace takt::net {

/// What LOAD knows about an accepted net, as data for tools. Primitives, fragments and links are named by their place
/// in the lists below. Owned by the CompiledNet; strings and infos live as long as the process or this.
struct NetReport {
  Diagnostics notes;  ///< null paths, free units, latencies that depend on data, exclusions without a proof
  std::vector<std::string> order;      ///< ids in evaluation order
  std::vector<std::string> resources;  ///< devices this net drives

  struct Fragment {
    std::string id;         ///< full id; empty for the net itself, which is number 0
    int parent = -1;        ///< -1: the net itself
    bool can_rest = false;  ///< it, or one around it, has a linked `active`
    WhenInactive when_inactive = WhenInactive::kReset;
  };
  std::vector<Fragment> fragments;

  struct Primitive {
    std::string id;  ///< full id
    const PrimitiveInfo* info = nullptr;
    int fragment = 0;
    int order = 0;                                            ///< place in the order of evaluation
    std::vector<PrimitiveInfo::LatencyEntry> latencies = {};  ///< of this instance; pairs without one: the same cycle
  };
  std::vector<Primitive> primitives;  ///< in the order of the description, fragment by fragment

  struct Link {
    int from = 0, from_port = 0;  ///< primitive and its output
    int to = 0, to_port = 0;      ///< primitive and its input; -f: input `active` of fragment f
    bool delayed = false;
    bool may_be_null = false;  ///< null can come this way
  };
  std::vector<Link> links;  ///< flattened: a link into a port of a fragment that feeds two inputs stands here twice

  /// A way by which null reaches an input that stops or drives (rows N3, N4).
  struct NullPath {
    std::string at;                  ///< "id.port"
    std::string meaning;             ///< "true", "stop", or as the net declares: "false", "bridge 5 cycles"
    std::string origin;              ///< what makes it null, if not the first port itself
    std::vector<std::string> ports;  ///< from where the null arises to `at`: outputs, then the input
    std::vector<int> links = {};     ///< the same way; empty if it arises at `at`
  };
  std::vector<NullPath> null_paths;

  /// A line of the reaction certificate (rows O6, O7).
  struct Reaction {
    std::string source, sink;
    std::int64_t minimum_cycles = 0, maximum_cycles = 0;
    bool data_dependent = false;  ///< the maximum is without the cycles that depend on data
    bool exact = true;            ///< false: the maximum is an upper bound (a tangled loop); then there is no path
    std::vector<int> links = {};  ///< the critical path: a way that takes maximum_cycles
  };
  std::vector<Reaction> reactions;

  /// A demand of the net with what it gets.
  struct Demand {
    std::string from, to;
    std::int64_t demanded_maximum = 0, demanded_minimum = 0;  ///< no minimum demanded: 0
    std::int64_t minimum_cycles = 0, maximum_cycles = 0;
    std::vector<int> links = {};  ///< the critical path
  };
  std::vector<Demand> demands;

  struct FreeUnit {
    std::string primitive;
    std::string variable;
  };
  std::vector<FreeUnit> free_units;  ///< units that nothing fixes; taken as 1

  /// Fragments that share a device or meet at a Merge (row O4).
  struct Exclusion {
    std::string at;       ///< id of the Merge, or name of the device
    bool proven = false;  ///< no two are ever active together; a device is shared only with a proof
  };
  std::vector<Exclusion> exclusions;
};

/// The report as JSON, without the notes: what `takt net --json` prints (docs/nets.md). Realtime: setup.
[[nodiscard]] nlohmann::ordered_json report_to_json(const NetReport& report);

}  // namespace takt::net
