#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/net/description.h"

namespace takt::test {

/// A way from a source to a sink: the parts it passes, each with the input by which it comes in.
struct Step {
  int part = 0;
  int input = 0;  ///< of the part; kActivity: the part's fragment is switched
};
using Way = std::vector<Step>;

/// What a plain search over all ways that pass no port twice has found.
struct Ways {
  Way shortest, longest;  ///< empty: there is none
  bool complete = true;   ///< false: given up, there are too many
};

/// A random net in which events run along many ways: parts with two inputs of which a parameter picks one, declared
/// latencies, delayed links inside and outside of fragments, inputs that break loops, loops, fragments that an event
/// switches on or off. It keeps its own plain list of what leads where, apart from core/net.
class RandomWays {
 public:
  static constexpr int kActivity = -1;

  explicit RandomWays(Random& random);

  net::NetDescription net;  ///< changed by the members below: parameters only
  bool has_loop = false;
  int switched_fragments = 0;

  /// The part of this id ("e0" a source, "m0" a monitor).
  [[nodiscard]] int number_of(const std::string& id) const;
  /// Shortest and longest way, by trying them all.
  [[nodiscard]] Ways search(int source, int sink) const;
  /// Lets every part pick an input, and every switch its direction; never so that the net may blink.
  void choose_at_random(Random& random);
  /// Lets the parts along the way pick the input by which it comes in.
  void choose(const Way& way);
  /// A switch that leads back to itself switches off: once the event has come, its fragment may come and go for ever,
  /// and what comes and goes holds other reactions back.
  [[nodiscard]] bool may_blink();
  /// The cycle of the event; -1: none.
  void set_event(int source, std::int64_t cycle);
  /// The net as JSON, for messages.
  [[nodiscard]] std::string text() const;

 private:
  struct Feed {
    int from = 0;
    int cycles = 0;  ///< of the link
  };
  struct Part {
    std::string id;  ///< full
    std::string type;
    int fragment = 0;
    int latency = 0;
    std::vector<Feed> inputs;
  };
  struct Fragment {
    std::string id;
    int parent = -1;
    int switch_part = -1;   ///< -1: always active
    int switch_cycles = 0;  ///< of the link into `active`
  };
  struct Edge {
    int to, input, cycles;
  };

  void add_part(Random& random, int fragment);
  void add_fragment(Random& random, int parent);
  int add(std::string type, int fragment, int latency, int inputs, Random& random);
  void feed(int part, Random& random);
  void close_loops(Random& random);
  void describe(Random& random);
  void list_edges();
  net::NetDescription& net_of(int fragment);
  nlohmann::ordered_json& parameters(int part);
  [[nodiscard]] bool leads_to_itself(int part) const;
  [[nodiscard]] bool is_switched(int part, int by) const;
  [[nodiscard]] std::string local_id(const Part& part) const;

  std::vector<Part> parts_;
  std::vector<Fragment> fragments_;
  std::vector<std::pair<int, int>> open_;  ///< inputs that wait for a source anywhere
  std::vector<std::vector<Edge>> edges_;   ///< by part
};

}  // namespace takt::test
