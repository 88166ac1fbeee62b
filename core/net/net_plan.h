#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/net/compiled_net.h"
#include "core/net/flat_net.h"

namespace takt::net {

/// Bytes and alignment of a slot of this type.
struct SlotShape {
  std::size_t size, alignment;
};
[[nodiscard]] SlotShape slot_shape(ValueType type);

/// All that the compiler decides about how an accepted net runs, as plain data: what lies where in the block of values,
/// what each input reads, what runs when, what is carried into the next cycle. Places are offsets in the block of
/// values, nodes and ports are those of the FlatNet. Building a net only follows the plan, so whoever changes the plan
/// changes the net: that is how tests plant faults (tests/proofs). Private to core/net.
struct NetPlan {
  static constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

  /// A constant from the parameters of the primitive, for the input that reads it.
  struct Constant {
    int node, port;
    std::size_t place;
    const nlohmann::ordered_json* value;
  };
  /// A delayed link, by the input at its end. `memory` is what the input reads; after each cycle `size` bytes of
  /// `source` are copied into it; it begins with what is at `initial`.
  struct Delay {
    int node, port;
    std::size_t source, memory, initial, size;
    const nlohmann::ordered_json* initial_value;  ///< what is written at `initial`
    int gate;                                     ///< its memory rests and is reset with this gate; -1: never
  };
  struct Output {
    ValueType type;
    std::size_t place;
  };
  /// A fragment that can rest (row O3).
  struct Gate {
    int parent = -1;                ///< gate of the fragment around it; -1: none, it never rests
    std::size_t active = kNowhere;  ///< the Boolean that switches it; kNowhere: as the fragment around it
    WhenInactive when_inactive = WhenInactive::kReset;
    std::vector<Output> outputs;  ///< null while it rests
  };
  /// A stretch of the schedule: a gate is looked at, or primitives [begin, end) of `order` run under a gate or none.
  struct Step {
    bool is_gate = false;
    int gate = -1;
    std::size_t begin = 0, end = 0;
  };

  std::vector<int> order;  ///< primitives in evaluation order
  std::vector<CompiledNet::Port> ports;
  std::size_t output_count = 0;           ///< the first of `ports`; the rest are memories of delayed links
  std::size_t slots_size = 0;             ///< bytes of all ports
  std::size_t size = 0;                   ///< bytes of all values: ports, initial values, constants
  std::vector<std::size_t> output_place;  ///< per output
  std::vector<std::size_t> input_place;   ///< per input, `active` of gates included: what it reads; kNowhere: null
  std::vector<Constant> constants;
  std::vector<Delay> delays;
  std::vector<Gate> gates;
  std::vector<Step> steps;  ///< empty if there is no gate: `order` as it stands
};

/// @param order  of all nodes, from schedule(). A net with errors gets a plan too, so that building it can find the
/// errors of parameters. Realtime: setup, O(n).
[[nodiscard]] NetPlan plan_net(const FlatNet& flat, const std::vector<int>& order);

}  // namespace takt::net
