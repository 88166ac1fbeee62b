#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/net/primitive.h"

namespace takt::net {

/// What is known of a primitive type without an instance; made by running its constructor once in describing mode.
struct PrimitiveInfo {
  struct Port {
    std::string name;
    ValueType type;
    PortSpec spec;
  };
  struct Parameter {
    std::string name;
    std::string type;  ///< "Real", "Joints", ..., "json", or "device:KIND"
    ParameterSpec spec;
    std::string fallback;  ///< JSON text of the default; empty = must be given
  };
  struct LatencyEntry {
    std::string in, out;
    Latency latency;
  };
  std::string type, family, doc;
  std::vector<Port> inputs, outputs;
  std::vector<Parameter> parameters;
  std::vector<LatencyEntry> latencies;
  std::vector<std::string> loop_breaking_inputs;
  bool termination = false, monitor = false;
  std::string claims;  ///< parameter that names the claimed device; empty = none
};

/// All primitive types of the process, in a fixed order (by name).
class Registry {
 public:
  using Factory = std::function<std::unique_ptr<Primitive>(Setup&)>;

  static Registry& global();
  /// @return true, so that it can initialise a constant. A name registered twice is a programming error (abort).
  bool add(std::string_view type, std::string_view family, std::string_view doc, Factory factory);
  [[nodiscard]] const PrimitiveInfo* find(std::string_view type) const;
  [[nodiscard]] std::vector<const PrimitiveInfo*> all() const;
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] const Factory* factory(std::string_view type) const;

 private:
  struct Entry;
  std::vector<std::unique_ptr<Entry>> entries_;

 public:
  Registry();
  ~Registry();
};

}  // namespace takt::net
