#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/net/description.h"
#include "core/net/value.h"

namespace takt::net {
class Resource;
}

namespace takt::expression {

/// Something of a command tree that formulas may speak of: whose states and values are in the net, but not at a
/// device. Identity counts; of an actuator its name.
struct Subject {
  enum class Kind : std::uint8_t { kAction, kCommand, kRaised, kActuator };
  Kind kind = Kind::kCommand;
  std::string name;
};
using SubjectPtr = std::shared_ptr<const Subject>;

struct Expression;
using ExpressionPtr = std::shared_ptr<const Expression>;

/// A node of a formula: an output of a primitive whose inputs are other nodes or constants, or a leaf that speaks of a
/// subject. It is what sensors and states are made of (sensor.h, state.h); immutable, shared, any thread.
struct Expression {
  net::ValueType type = net::ValueType::kReal;
  /// What it is in the net: type, parameters, what null means; `id` is the preferred one. A leaf has no type, and its
  /// parameters are those of the state.
  net::PrimitiveDescription primitive;
  std::vector<std::pair<std::string, ExpressionPtr>> inputs;  ///< input port, what feeds it
  std::string output = "value";                               ///< port; of a leaf the name of the state
  SubjectPtr subject;                                         ///< of a leaf
  net::Resource* resource = nullptr;                          ///< that a parameter of the primitive names
  std::string resource_name;                                  ///< its name in the cell
  std::optional<Diagnostic> fault;                            ///< the formula cannot be: a device that is not there
  int depth = 0;                                              ///< of the formula below this node
};

/// Formulas that are deeper are refused: walks over them recurse.
inline constexpr int kMostDepth = 1000;

/// What an input of a formula is fed with: another formula, or a constant as net files write it.
struct Operand {
  ExpressionPtr node;
  nlohmann::ordered_json constant = nullptr;  ///< if there is no node
};

/// An output of a primitive over operands. Realtime: setup.
[[nodiscard]] ExpressionPtr apply(net::ValueType type, std::string primitive,
                                  const std::vector<std::pair<std::string, Operand>>& operands,
                                  nlohmann::ordered_json parameters = nlohmann::ordered_json::object(),
                                  std::string output = "value");

/// What a primitive gives that reads a device or a channel by name (parameter `key`).
/// @param id  preferred id of the primitive
[[nodiscard]] ExpressionPtr read_resource(net::ValueType type, std::string primitive, const char* key,
                                          const std::string& name, net::Resource* resource, std::string output,
                                          std::string id);

/// A state or value of a subject.
[[nodiscard]] ExpressionPtr leaf(net::ValueType type, SubjectPtr subject, std::string name,
                                 nlohmann::ordered_json parameters = nlohmann::ordered_json::object());

/// An error without a location.
[[nodiscard]] Diagnostic fault_of(Code code, std::string message, std::string hint);
/// A formula that is invalid; checks report why and where it is used.
[[nodiscard]] ExpressionPtr broken(Code code, net::ValueType type, std::string message, std::string hint);

/// The same node with another preferred id.
[[nodiscard]] ExpressionPtr named(const ExpressionPtr& node, std::string id);

/// All subjects that a formula speaks of, each once, in order of first use.
[[nodiscard]] std::vector<SubjectPtr> subjects_of(const ExpressionPtr& node);

/// Faults of all nodes of a formula, and whether it is too deep. Pointers are left empty.
[[nodiscard]] Diagnostics faults_of(const ExpressionPtr& node);

/// The devices and channels that a formula names, by name.
[[nodiscard]] std::map<std::string, net::Resource*, std::less<>> resources_of(const ExpressionPtr& node);

}  // namespace takt::expression
