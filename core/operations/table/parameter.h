#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"
#include "core/expression/cell.h"
#include "core/net/file_unit.h"

/// What the parameters of operations have in common, whatever their C++ types are (docs/operations.md). Realtime:
/// setup.
namespace takt::operations {

/// The members of a cell that a parameter may name.
enum class NameOf { kArm, kSensor, kGripper, kToolChanger, kOutput, kObject, kNet };

/// "arm", "force/torque sensor", ... for people.
[[nodiscard]] std::string_view to_text(NameOf what);
/// All names of this kind, in order.
[[nodiscard]] std::vector<std::string> names_in(const expression::Cell& cell, NameOf what);

/// One parameter as every form of an operation sees it: files, C++, schema, reference.
struct ParameterInfo {
  enum class Type {
    kBoolean,
    kInteger,
    kNumber,
    kNumbers,
    kVector,
    kText,
    kTexts,
    kChoice,
    kName,
    kCondition,
    kObject
  };

  std::string key = {};  ///< in files
  Type type = Type::kNumber;
  std::string unit = {};                   ///< in files: "N", "deg/s"; empty: none
  bool unit_of_device = false;             ///< the unit is that of a device, an output for instance
  Range range = {};                        ///< of numbers, in that unit
  std::vector<std::string> choices = {};   ///< of kChoice
  NameOf names = NameOf::kArm;             ///< of kName
  std::string definition = {};             ///< of kObject: its name in the schema of scenario files
  std::vector<ParameterInfo> fields = {};  ///< of kObject: its own parameters
  bool required = false;
  bool refused = false;       ///< read only so that a diagnostic can say why the operation does not have it
  std::string fallback = {};  ///< the default for people; empty: there is none
  std::string doc = {};       ///< one line
};

/// 0.05, [0, 0, 1]: a default as a file would have it.
[[nodiscard]] std::string to_text(double value);
[[nodiscard]] std::string to_text(const Eigen::Vector3d& value);

/// "number in N, above 0, at most 1000", "name of an arm", ...
[[nodiscard]] std::string describe_type(const ParameterInfo& parameter);

/// The unit of the number at a JSON pointer below an operation, such as "/compliance/stiffness_N_m" or
/// "/to/position_m/2".
/// @return nothing if the parameters do not say: an unknown key, or the value of a device with a unit of its own
[[nodiscard]] std::optional<net::FileUnit> unit_at(std::span<const ParameterInfo> parameters, std::string_view pointer);

/// The schema of one parameter, without references to other parts of the file's schema but "#/definitions/...".
[[nodiscard]] nlohmann::ordered_json schema_of(const ParameterInfo& parameter);

/// What a table reads from.
struct ReadContext {
  ObjectReader& reader;
  const expression::Cell& cell;
  /// Keys whose values a program has given in a form that files do not have, a state for instance.
  const std::set<std::string, std::less<>>* given = nullptr;

  /// The parameter was given, in a file or by a program.
  [[nodiscard]] bool has(std::string_view key) const {
    return reader.has(key) || (given != nullptr && given->contains(key));
  }
};

/// Writes parameters as a file would have them.
class ParameterWriter {
 public:
  ParameterWriter();
  ~ParameterWriter();
  ParameterWriter(const ParameterWriter&) = delete;
  ParameterWriter& operator=(const ParameterWriter&) = delete;

  void number(const std::string& key, double value);
  void integer(const std::string& key, std::int64_t value);
  void boolean(const std::string& key, bool value);
  void text(const std::string& key, const std::string& value);
  void texts(const std::string& key, const std::vector<std::string>& values);
  void vector(const std::string& key, const Eigen::Vector3d& value);
  void object(const std::string& key, const ParameterWriter& parameters);
  void json(const std::string& key, nlohmann::ordered_json value);
  [[nodiscard]] const nlohmann::ordered_json& result() const { return *json_; }

 private:
  std::unique_ptr<nlohmann::ordered_json> json_;
};

}  // namespace takt::operations
