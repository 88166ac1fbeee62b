#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/net/description.h"
#include "core/net/registry.h"

namespace takt::net {

/// The plain reading of a net, written a second time: values lie in a map by name, order is found anew in each cycle by
/// asking what a primitive still waits for, delays are kept beside. It shares the primitives with the compiled form and
/// nothing else: not the order, not the transport of values and nulls, not the delays, not the fragments. Slow, and for
/// accepted nets only.
class ReferenceNet {
 public:
  explicit ReferenceNet(const NetDescription& description);
  ~ReferenceNet();

  void evaluate(const Cycle& cycle);

  /// JSON text with every bit of the payload, by "id.port": hexadecimal bytes, or "null".
  [[nodiscard]] std::map<std::string, std::string> outputs() const;

  /// Where an output lies: a Slot<T> by `type`, padding zero; valid as long as the net.
  struct Output {
    std::string port;
    ValueType type;
    const void* slot;
  };
  [[nodiscard]] std::vector<Output> output_slots() const;
  [[nodiscard]] const NetSignals& signals() const { return signals_; }

 private:
  struct Node;
  struct Group;
  struct Link;
  void build(const NetDescription& description, const std::string& scope, int group);
  void connect(const NetDescription& description, const std::string& scope, int group);
  [[nodiscard]] std::string output_port(const std::string& scope, const std::string& port) const;
  [[nodiscard]] std::vector<std::string> input_ports(const std::string& scope, const std::string& port) const;
  [[nodiscard]] bool ready(const Node& node) const;
  void look_at(Group& group, const Cycle& cycle);
  void update(Node& node, const Cycle& cycle);
  void find_feeds();

  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::unique_ptr<Link>> links_;
  std::map<std::string, const FragmentDescription*> fragments_;
  std::map<std::string, Link*> link_into_;  ///< by input "id.port"
  NetSignals signals_;
};

}  // namespace takt::net
