#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/net/net_report.h"
#include "core/net/primitive.h"

namespace takt::net {

struct FlatNet;
struct NetPlan;
struct PathStop;
struct StopBound;
class LoadReport;

/// A verified net in its runnable form: one arena of slots in evaluation order, inputs bound to the outputs they read.
/// Created outside the cycle; run by the cycle thread only; destroyed outside it.
class CompiledNet {
 public:
  /// Verifies everything and answers with all errors at once. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<CompiledNet>> compile(const NetDescription& description,
                                                                    Environment& environment);
  ~CompiledNet();

  /// Evaluates every primitive once. `cycle.index_in_net`, `first` and `signals` are filled in by the net; what the
  /// primitives signalled is in signals() afterwards. An exception of a primitive ends as signals().fail (row L7).
  /// Realtime: cyclic.
  /// After a failure it does nothing.
  void evaluate(const Cycle& cycle);
  /// The same, for benchmarks: adds the time that primitives number `first`, `first + stride`, ... in the order of
  /// evaluation take to `nanoseconds`, one entry a primitive, what it costs to look at the clock included. Few at a
  /// time disturb each other less.
  void evaluate_timed(const Cycle& cycle, std::size_t first, std::size_t stride, std::span<std::int64_t> nanoseconds);
  [[nodiscard]] const NetSignals& signals() const;
  /// Back to the state before the first cycle is not offered: a net runs once. Number of cycles run so far:
  [[nodiscard]] std::int64_t cycles() const;

  /// All output slots as one block of bytes, for the digest and for recording.
  [[nodiscard]] std::span<const std::byte> slots() const;

  /// Where each port lies in slots(): the outputs in evaluation order, then the memory of the delayed links.
  struct Port {
    std::string name;  ///< "id.port", or "FROM > TO" for a delayed link
    ValueType type;
    std::size_t offset, size;  ///< bytes in slots()
  };
  [[nodiscard]] const std::vector<Port>& ports() const;

  /// Look-up by "id.port" for tests, monitors and the program layer. Realtime: setup; the slot may be read in the
  /// cycle.
  /// @return nullptr if there is no such output or it has another type.
  template <class T>
  [[nodiscard]] const Slot<T>* find(std::string_view port) const {
    return static_cast<const Slot<T>*>(find_slot(port, kValueType<T>));
  }
  [[nodiscard]] const void* find_slot(std::string_view port, ValueType type) const;

  struct Monitor {
    std::string name;
    ValueType type;
    const void* slot;  ///< const Slot<T>*, T by `type`
  };
  [[nodiscard]] const std::vector<Monitor>& monitors() const;
  [[nodiscard]] const std::vector<Resource*>& claims() const;
  /// What the primitives that drive devices need of them, one entry a primitive, in evaluation order.
  [[nodiscard]] const std::vector<ClaimState>& claim_states() const;
  [[nodiscard]] const NetReport& report() const;
  /// How long the net takes at most from a cancel to its end, if it says so or its structure does (row L6).
  [[nodiscard]] const StopBound* stop_bound() const;
  /// What of its devices comes to rest by itself, and when, once Cycle::stop_requested is set (row S1).
  [[nodiscard]] const PathStop& path_stop() const;
  /// What a cycle costs on the reference machine, ns: the sum of what its primitives declare (row T5).
  [[nodiscard]] double cost_ns() const;
  /// Id of the primitive whose update was begun last; the net must not be destroyed meanwhile. Any thread, wait-free.
  [[nodiscard]] std::string_view progress() const;
  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] int primitive_count() const;

  struct Impl;  ///< private to core/net
  /// The second half of compile(): a net that runs as the plan says, whatever it says. For core/net and its tests.
  [[nodiscard]] static std::unique_ptr<CompiledNet> from_plan(const FlatNet& flat, NetPlan plan,
                                                              Environment& environment, LoadReport& report);

 private:
  CompiledNet();
  void build(const FlatNet& flat, NetPlan plan, Environment& environment, LoadReport& report);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::net
