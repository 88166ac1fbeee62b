#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/net/digraph.h"
#include "core/net/flat_net.h"

namespace takt::net {

/// How long an event takes from some outputs to every input of a net. Ports are the nodes; edges are links (0 or 1
/// cycle), ways through primitives (their declared latency) and from `active` of a fragment to the outputs inside.
/// For nets whose links are sound. Private to core/net. Realtime: setup.
class ReactionGraph {
 public:
  static constexpr std::int64_t kNever = -1;
  static constexpr int kStart = -1;

  /// When the event is there: the fewest cycles by the shortest way, the most by the longest way that passes no port
  /// twice.
  struct Arrival {
    std::int64_t first = kNever, last = kNever;
    bool data_dependent = false;  ///< a way may take longer, depending on data; `last` is without that
    bool exact = true;            ///< false: `last` is an upper bound, from a loop too tangled to try every way
    int first_via = kStart, last_via = kStart;  ///< edge by which it came; inside a loop a number of ways_
  };

  explicit ReactionGraph(const FlatNet& flat);

  /// Follows an event from these outputs (numbers as in FlatNet::output_base). O(edges), and a bounded search in loops.
  void follow(std::span<const int> outputs);
  /// After follow(): at an input (number as in FlatNet::input_base).
  [[nodiscard]] const Arrival& at(int input) const { return arrivals_[static_cast<std::size_t>(input)]; }

  /// A way as a chain of edges, for words and pictures.
  using Way = std::vector<int>;
  [[nodiscard]] Way longest_way(int input) const;
  [[nodiscard]] Way shortest_way(int input) const;
  /// A way from the outputs followed to an input that passes a latency that depends on data; empty if there is none.
  [[nodiscard]] Way data_dependent_way(std::span<const int> outputs, int input) const;
  /// The links among the edges of a way.
  [[nodiscard]] std::vector<int> links_of(const Way& way) const;
  /// "a.out -> b.in (delayed), through b 2 cycles, b.out -> c.in"
  [[nodiscard]] std::string words_of(const Way& way) const;

  [[nodiscard]] std::size_t size() const { return edges_.size() + static_cast<std::size_t>(node_count()); }

 private:
  static constexpr int kNotYet = -2;
  static constexpr std::size_t kMostSteps = 200'000;  ///< of the search inside loops, for all of follow()

  struct Edge {
    int from, to;
    Latency latency;
    int link;  ///< -1: through a primitive, or from a gate
  };
  /// A step of the search inside a loop: the edge into a node, and the step before; at the entry, `edge` is how the
  /// event came to the loop.
  struct LoopStep {
    int edge, previous;
  };

  [[nodiscard]] int node_count() const { return input_count_ + flat_.output_base.back(); }
  [[nodiscard]] std::size_t component(int node) const {
    return static_cast<std::size_t>(components_.of[static_cast<std::size_t>(node)]);
  }
  [[nodiscard]] Arrival& arrival(int node) { return arrivals_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const Edge& edge(int number) const { return edges_[static_cast<std::size_t>(number)]; }

  std::vector<std::pair<int, int>> collect_edges();
  void add_primitive_edges(int primitive);
  void add_gate_edges(int primitive, int output);
  void index_components();
  void shortest(std::span<const int> outputs);
  void arrive(int node, const Arrival& from, const Latency& latency, int via);
  void leave(int node);
  void through_loop(std::span<const int> members);
  bool walk(int entry, const Arrival& arrival);

  const FlatNet& flat_;
  int input_count_;
  std::vector<Edge> edges_;
  Digraph graph_;
  Components components_;
  std::vector<int> members_;  ///< nodes by component; those of c are [first_member_[c], first_member_[c + 1])
  std::vector<std::size_t> first_member_;
  std::vector<std::int64_t> loop_bound_;  ///< per component: more cycles than this no way inside it takes
  std::vector<bool> on_way_;
  std::vector<Arrival> arrivals_;
  std::vector<LoopStep> ways_;
  std::size_t steps_ = 0;
};

}  // namespace takt::net
