#pragma once

#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/net/compiled_net.h"
#include "core/net/net_plan.h"
#include "core/net/stop_bound.h"

namespace takt::net {

/// Zeroed memory whose start is aligned for any payload.
class Block {
 public:
  static constexpr std::size_t kAlignment = 64;

  explicit Block(std::size_t size = 0) : size_(size) {
    if (size == 0) return;
    bytes_.reset(static_cast<std::byte*>(::operator new (size, std::align_val_t{kAlignment})));
    std::memset(bytes_.get(), 0, size);
  }
  [[nodiscard]] std::byte* at(std::size_t offset) const { return bytes_.get() + offset; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(std::byte* bytes) const { ::operator delete (bytes, std::align_val_t{kAlignment}); }
  };
  std::unique_ptr<std::byte, Free> bytes_;
  std::size_t size_;
};

/// The runnable form. `values` holds, in this order: the outputs in evaluation order, the memory of delayed links (both
/// together are slots()), the initial values of delayed links, constants. Private to core/net.
struct CompiledNet::Impl {
  /// Bytes that a delayed link carries into the next cycle.
  struct Delay {
    const std::byte* source;
    std::byte* memory;
    const std::byte* initial;
    std::size_t size;
  };
  /// A fragment that can rest (row O3).
  struct Gate {
    const Slot<Boolean>* active = nullptr;  ///< nullptr: as the fragment around it
    int parent = -1;                        ///< gate of the fragment around it; -1: none, it never rests
    WhenInactive when_inactive = WhenInactive::kReset;
    std::vector<std::pair<ValueType, std::byte*>> outputs;  ///< null while it rests
    std::vector<Delay> delays;                              ///< of the links written in it
    // State:
    bool running = false;
    bool begun = false;      ///< its state belongs to an activation that it goes on from
    bool restarted = false;  ///< began anew in this cycle
    Cycle cycle;
    std::int64_t cycles = 0;  ///< run since it began
  };
  ~Impl() {
    for (auto p = primitives.rbegin(); p != primitives.rend(); ++p) (*p)->~Primitive();
  }

  /// One cycle; `run(place, cycle)` updates one primitive.
  template <class Run>
  void evaluate(const Cycle& outer, const Run& run);
  template <class Run>
  void run_steps(Cycle& cycle, std::size_t& at, const Run& run);
  void look_at(Gate& gate, const Cycle& cycle);

  std::string name;
  Block values, objects;
  std::size_t slots_size = 0;
  std::vector<Primitive*> primitives;   ///< in evaluation order
  std::vector<std::string> ids;         ///< likewise
  std::atomic<std::size_t> newest = 0;  ///< the primitive that was begun last, for the watchdog
  std::vector<Delay> delays;            ///< outside all gates
  std::vector<Gate> gates;
  std::vector<NetPlan::Step> steps;  ///< empty if there is no gate
  std::vector<Port> ports;
  std::unordered_map<std::string_view, std::size_t> port_by_name;  ///< output ports only
  std::vector<Monitor> monitors;
  std::vector<Resource*> claims;
  std::vector<ClaimState> claim_states;
  NetReport report;
  std::optional<StopBound> stop_bound;
  PathStop path_stop;
  std::vector<int> numbers;                        ///< of the primitives in the flat net; likewise
  std::vector<std::pair<Resource*, int>> drivers;  ///< devices, each with the number of a primitive that drives it
  double cost_ns = 0.0;
  NetSignals signals;
  std::int64_t cycles = 0;
};

}  // namespace takt::net
