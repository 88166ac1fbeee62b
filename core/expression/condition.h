#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/expression/cell.h"
#include "core/net/file_unit.h"

namespace takt {
class ObjectReader;
}

namespace takt::expression {

/// What of a force/torque sensor is compared: the length of a vector or one component, in the measuring frame, with
/// the tool's weight and the tared bias taken out.
enum class Quantity { kForce, kForceX, kForceY, kForceZ, kTorque, kTorqueX, kTorqueY, kTorqueZ };

/// A condition over sensors, evaluated in every cycle inside the net.
///   {"sensor": "wrist", "quantity": "force", "above_N": 5}        also below_N, above_Nm, below_Nm
///   {"internal_force": ["left wrist", "right wrist"], "above_N": 40}   of two arms that hold one part; also below_N
///   {"input": "barrier", "is": true}                              a digital input
///   {"input": "distance", "below_m": 0.3}                         an analog input, in its own unit
///   {"gripper": "gripper", "is": "holding"}                       also lost, moving, open, closed
///   {"distance": ["arm", "table"], "below_m": 0.05}               of two devices, objects or bodies; also above_m
///   {"channel": "enable", "is": true}                             a Boolean channel
///   {"channel": "level", "above": 0.5}                            a Real channel, in its own unit; also below
///   {"all": [...]}, {"any": [...]}, {"not": {...}}
/// A comparison with a sensor that does not answer is null; a condition that is null as a whole counts as true (rows
/// N2, N3).
struct Condition {
  enum class Kind {
    kForce,
    kInternalForce,
    kDigital,
    kAnalog,
    kGripper,
    kBooleanChannel,
    kRealChannel,
    kDistance,
    kAll,
    kAny,
    kNot
  };
  Kind kind = Kind::kForce;
  std::string device;                    ///< of all but the last three: the device that it is about
  std::string other;                     ///< of kInternalForce: the second sensor; of kDistance: the second side
  Quantity quantity = Quantity::kForce;  ///< of kForce
  bool above = true;                     ///< of what is compared
  double threshold = 0.0;                ///< N, Nm or m; or in the unit of the analog input or channel
  bool level = true;                     ///< of what is true or false
  std::string state;                     ///< of kGripper: a Boolean output of the primitive GripperState
  std::vector<Condition> operands;       ///< of kAll and kAny at least one, of kNot exactly one
};

/// @param pointer  of `json` in its file
/// @return the condition, or all diagnostics: unknown device (nearest), unknown quantity, no or two thresholds, a unit
/// that does not fit the quantity. Realtime: setup.
[[nodiscard]] Result<Condition> parse_condition(const nlohmann::ordered_json& json, const std::string& pointer,
                                                const Cell& cell);
/// The condition at a key of an object; nothing: it is not there, or is none, with diagnostics. Realtime: setup.
[[nodiscard]] std::optional<Condition> read_condition(ObjectReader& reader, std::string_view key, const Cell& cell,
                                                      bool required = false);

/// The unit of the number at a JSON pointer inside a condition: its key names it ("above_N"). Nothing: the device's
/// own.
[[nodiscard]] std::optional<net::FileUnit> unit_in_condition(std::string_view pointer);

/// Names of all force/torque sensors in a condition, each once, in order of first use. Realtime: setup.
[[nodiscard]] std::vector<std::string> sensors_of(const Condition& condition);

[[nodiscard]] bool is_torque(Quantity quantity);

/// The key "quantity" of an object; default: force.
[[nodiscard]] Quantity read_quantity(ObjectReader& reader);

}  // namespace takt::expression
