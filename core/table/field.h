#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/base/object_reader.h"

/// What files may hold, as data: keys with types, units, ranges, defaults and documentation (docs/tables.md). One table
/// serves readers, schemas, reference pages and programs. Realtime: setup.
namespace takt::table {

/// The things that a text of a file can name.
enum class NameOf {
  kArm,
  kSensor,
  kGripper,
  kToolChanger,
  kOutput,
  kObject,
  kNet,
  kDevice,
  kFrame,
  kCamera,
  kMaterial,
  kThread,
  kModel,
  kChannel,
  kStep,
  kBody
};

/// "arm", "force/torque sensor", ... for people.
[[nodiscard]] std::string_view to_text(NameOf what);

/// Number of elements of a list, or of characters of a text.
struct Count {
  std::size_t min = 0;
  std::size_t max = std::numeric_limits<std::size_t>::max();
};

/// A rule about several keys of one object. A group counts as given when all of its keys are there.
struct Rule {
  enum class Kind {
    kOneOf,        ///< exactly one of the groups
    kAnyOf,        ///< at least one of the groups
    kNotTogether,  ///< at most one of the groups
    kNeeds         ///< the first group needs the second one
  };
  Kind kind = Kind::kOneOf;
  std::vector<std::vector<std::string>> groups = {};
  std::string hint = {};        ///< what to do, for the diagnostic
  std::string at = {};          ///< key that the diagnostic names; empty: the object
  Code code = Code::kConflict;  ///< of the diagnostic; nothing given where something must be is Code::kMissing
  bool checked = true;          ///< false: who reads the keys reports it in words of its own
};

/// One key of an object, or any value of a file: what it may be. A tree, immutable once it is made.
struct Field {
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
    kObject,
    kList,    ///< of `items`, which has one element
    kMap,     ///< names to what `items` says, which has one element
    kEither,  ///< one of `items`
    kAny      ///< any JSON
  };

  std::string key = {};  ///< in files
  Type type = Type::kNumber;
  std::string unit = {};                  ///< in files: "N", "deg/s"; empty: none
  bool unit_of_device = false;            ///< the unit is that of a device, an output for instance
  Range range = {};                       ///< of numbers, in that unit
  std::vector<std::string> choices = {};  ///< of kChoice
  NameOf names = NameOf::kArm;            ///< of kName
  std::string definition = {};            ///< its name in the schema, where others refer to it; empty: in place
  std::vector<Field> fields = {};         ///< of kObject: its keys
  bool required = false;
  bool refused = false;       ///< read only so that a diagnostic can say why there is none
  std::string fallback = {};  ///< the default for people; empty: there is none
  std::string doc = {};       ///< one line

  Count count = {};                ///< of kNumbers, kVector, kText, kTexts, kList
  std::string pattern = {};        ///< of kText, and of the names in a kMap: a regular expression
  std::vector<Field> items = {};   ///< of kList, kMap, kEither
  std::vector<Rule> rules = {};    ///< of kObject
  std::string discriminator = {};  ///< of kObject: the key that chooses one of `variants`
  /// Of kObject: more keys, by the value of that key, which is their `key`. With a `definition` each is one of its own.
  std::vector<Field> variants = {};
  bool any_key = false;              ///< of kObject: keys that are not listed are allowed; of kMap: comments
  const Field& (*form)() = nullptr;  ///< with `definition`: what it stands for, where a copy would be endless
  bool or_parameter = false;         ///< "$NAME", a parameter of the file, may take its place
  bool literal = false;              ///< no expression of a program can take its place
};

/// Rows for readers that are not made of a table.
[[nodiscard]] Field field(std::string_view key, Field::Type type, std::string_view doc);
/// The definition `form`, under a key of its own.
[[nodiscard]] Field reference(std::string_view key, std::string_view definition, const Field& (*form)(),
                              std::string_view doc);

/// The rules that `reader`'s object breaks, as diagnostics.
void check_rules(const std::vector<Rule>& rules, ObjectReader& reader);

/// 0.05, [0, 0, 1]: a default as a file would have it.
[[nodiscard]] std::string to_text(double value);
[[nodiscard]] std::string to_text(const Eigen::Vector3d& value);

/// "number in N, above 0, at most 1000", "name of an arm", ...
[[nodiscard]] std::string describe_type(const Field& field);

/// Writes values as a file would have them.
class Writer {
 public:
  Writer();
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void number(const std::string& key, double value);
  void integer(const std::string& key, std::int64_t value);
  void boolean(const std::string& key, bool value);
  void text(const std::string& key, const std::string& value);
  void texts(const std::string& key, const std::vector<std::string>& values);
  void vector(const std::string& key, const Eigen::Vector3d& value);
  void object(const std::string& key, const Writer& members);
  void json(const std::string& key, nlohmann::ordered_json value);
  [[nodiscard]] const nlohmann::ordered_json& result() const { return *json_; }

 private:
  std::unique_ptr<nlohmann::ordered_json> json_;
};

}  // namespace takt::table
