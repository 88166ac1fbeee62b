#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"

/// Forms of objects in files, as data (docs/tables.md): from the same rows a file is read, and its schema and reference
/// are printed. Realtime: setup.
namespace takt {

struct Form;
struct Key;

/// Which names the members of an object may have.
struct NameRule {
  const char* pattern;  ///< of the schema
  bool (*allows)(std::string_view name);
  const char* hint;  ///< what to do about another
};

/// One key of a form. Required unless something else is said.
struct Key {
  enum class Type {
    kNumber,
    kInteger,
    kBoolean,
    kText,
    kChoice,
    kNumbers,  ///< a list
    kObject,   ///< of `form`
    kList,     ///< of `element`
    kMembers,  ///< an object: names to `element`
    kAny
  };
  using Value = std::variant<std::monostate, double, std::string, bool, std::vector<std::string>>;
  std::string name;
  Type type = Type::kAny;
  std::string doc = {};                    ///< one sentence
  std::string unit = {};                   ///< "N", "degrees"; empty: none
  Range range = {};                        ///< of numbers, in that unit
  std::vector<double> values = {};         ///< of kNumber: one of these; empty: any in the range
  std::vector<std::string> choices = {};   ///< of kChoice; of kAny: types of the schema
  std::size_t min_size = 0, max_size = 0;  ///< of texts, lists and members; max_size 0: any
  const NameRule* names = nullptr;         ///< of kMembers; null: any
  bool comments = false;                   ///< of kMembers: "comment" is no member
  bool or_parameter = false;               ///< in files "$NAME" as well, which is written out before it is read
  std::string definition = {};             ///< of the schema, in place of what `type` says; empty: none
  std::shared_ptr<const Form> form = {};
  std::shared_ptr<const Key> element = {};
  bool required = true;
  Value fallback = {};      ///< the value if the key is not there
  std::string absent = {};  ///< what holds then, for people, where that is no value

  /// The key may be left out. @param meaning  what holds then; empty: the doc says it
  [[nodiscard]] Key optional(std::string meaning = {}) && {
    required = false;
    absent = std::move(meaning);
    return std::move(*this);
  }
  [[nodiscard]] Key by_default(Value value) && {
    required = false;
    fallback = std::move(value);
    return std::move(*this);
  }
  /// The same row with another doc.
  [[nodiscard]] Key with_doc(std::string text) const {
    Key key = *this;
    key.doc = std::move(text);
    return key;
  }
  [[nodiscard]] Key with_definition(std::string reference) && {
    definition = std::move(reference);
    return std::move(*this);
  }
  [[nodiscard]] Key with_names(const NameRule& rule) && {
    names = &rule;
    return std::move(*this);
  }
  /// One of these numbers.
  [[nodiscard]] Key with_values(std::vector<double> numbers) && {
    values = std::move(numbers);
    return std::move(*this);
  }
  [[nodiscard]] Key with_parameter() && {
    or_parameter = true;
    return std::move(*this);
  }
  [[nodiscard]] Key with_comments() && {
    comments = true;
    return std::move(*this);
  }
};

/// What concerns several keys of a form. An empty text says nothing.
struct Rule {
  enum class Type { kAtLeastOne, kAtMostOne, kExactlyOne, kNeeds };
  Type type;
  std::vector<std::string> keys;  ///< of kNeeds: what needs the key after it
  std::string hint = {};          ///< empty: the usual one
  bool told = false;              ///< the form's reader finds it by itself
};
[[nodiscard]] Rule at_least_one(std::vector<std::string> keys);
[[nodiscard]] Rule at_most_one(std::vector<std::string> keys, std::string hint = {});
[[nodiscard]] Rule exactly_one(std::vector<std::string> keys);
[[nodiscard]] Rule needs(std::string key, std::string other, std::string hint = {});

struct NamedForm {
  std::string_view name;
  const Form& form;
};

/// A key says of which kind an object is, and the kind which keys it has beside those of the form.
struct Kinds {
  Key key = {};                                   ///< of kChoice, its choices apart
  std::function<std::vector<NamedForm>()> forms;  ///< those there are now; plug-ins bring more
};

/// Keys and what concerns several of them.
struct Form {
  std::string doc;
  std::vector<Key> keys = {};
  std::vector<Rule> rules = {};
  std::shared_ptr<const Key> others = {};  ///< what other keys have, which the form does not know; null: there are none
  std::string definition = {};             ///< its name in the schema; empty: described where it is used
  std::optional<Kinds> kinds = {};
};

[[nodiscard]] Key number_key(std::string name, std::string unit, const Range& range, std::string doc);
[[nodiscard]] Key integer_key(std::string name, const Range& range, std::string doc);
[[nodiscard]] Key boolean_key(std::string name, std::string doc);
/// @param min_size  least length
[[nodiscard]] Key text_key(std::string name, std::string doc, std::size_t min_size = 0);
[[nodiscard]] Key choice_key(std::string name, std::vector<std::string> choices, std::string doc);
/// A list of texts. @param max_size  0: any number
[[nodiscard]] Key texts_key(std::string name, std::string doc, std::size_t min_size = 0, std::size_t max_size = 0);
/// Two texts.
[[nodiscard]] Key pair_key(std::string name, std::string doc);
/// A list of pairs of texts.
[[nodiscard]] Key pairs_key(std::string name, std::string doc);
/// Numbers, so many of them; 0: any.
[[nodiscard]] Key numbers_key(std::string name, std::size_t count, std::string unit, const Range& range,
                              std::string doc);
/// Three numbers: [x, y, z].
[[nodiscard]] Key vector_key(std::string name, std::string unit, std::string doc);
/// An object of a form.
[[nodiscard]] Key object_key(std::string name, Form form, std::string doc);
[[nodiscard]] Key list_key(std::string name, std::size_t min_size, Key element, std::string doc);
/// A list of objects of one form.
[[nodiscard]] Key objects_key(std::string name, std::size_t min_size, Form elements, std::string doc);
/// An object whose members have names that the file gives.
[[nodiscard]] Key members_key(std::string name, Key element, std::string doc);
/// What its reader reads by itself. @param definition  of the schema; empty: any value
[[nodiscard]] Key any_key(std::string name, std::string definition, std::string doc);
/// The same without a definition: values of these types of JSON.
[[nodiscard]] Key any_of_key(std::string name, std::vector<std::string> types, std::string doc);
/// "position_m", "rpy_deg" and "quaternion", as ObjectReader::pose() reads them, and what concerns them.
[[nodiscard]] std::vector<Key> pose_keys();
[[nodiscard]] Rule pose_rule();

/// Reads the keys of a form; types, ranges, choices and defaults are those of its rows. A key without a row is a
/// programming error (abort).
class FormReader {
 public:
  FormReader(const Form& form, ObjectReader& object) : form_(form), object_(object) {}

  /// @param absent  the value if the key is not there; nothing: the default of its row
  double number(std::string_view key, std::optional<double> absent = {});
  /// The same up to `high`, which the row does not know.
  double number_up_to(std::string_view key, double high, std::optional<double> absent = {});
  std::int64_t integer(std::string_view key, std::optional<std::int64_t> absent = {});
  bool boolean(std::string_view key, std::optional<bool> absent = {});
  /// Empty if it may be left out and is.
  std::string text(std::string_view key);
  std::string choice(std::string_view key, std::optional<std::string> absent = {});
  /// A text that is one of these names. If the key may be left out, a single name needs none.
  std::string name(std::string_view key, const std::vector<std::string>& names);
  std::vector<std::string> texts(std::string_view key);
  std::vector<double> numbers(std::string_view key, std::optional<std::vector<double>> absent = {});
  Eigen::Vector3d vector(std::string_view key, std::optional<Eigen::Vector3d> absent = {});
  /// Of which kind it is. Nothing: it is not said, or none that is known.
  std::optional<NamedForm> kind();
  /// An object, a list or a value as it is; null if it may be left out and is, or is none.
  const nlohmann::ordered_json* json(std::string_view key);
  /// Calls `read(name, json, pointer)` for each member of a key of kMembers, the names of which are checked.
  void members(std::string_view key, const std::function<void(const std::string& name, const nlohmann::ordered_json&,
                                                              const std::string& pointer)>& read);
  /// Calls `read(json, pointer)` for each element of a list.
  void elements(std::string_view key,
                const std::function<void(const nlohmann::ordered_json&, const std::string& pointer)>& read);

  [[nodiscard]] bool has(std::string_view key) const { return object_.has(key); }
  [[nodiscard]] std::string at(std::string_view key) const { return object_.at(key); }
  [[nodiscard]] const std::string& pointer() const { return object_.pointer(); }
  [[nodiscard]] Diagnostics& diagnostics() { return object_.diagnostics(); }
  /// For keys of type kAny, and lists.
  [[nodiscard]] ObjectReader& object() { return object_; }
  /// The row of a key.
  [[nodiscard]] const Key& row(std::string_view key) const;
  /// Diagnostics for what concerns several keys.
  void check_rules();

 private:
  void check_size(const Key& key, const nlohmann::ordered_json& all);
  const Form& form_;
  ObjectReader& object_;
};

/// Prints forms as JSON Schema (draft-07).
class SchemaWriter {
 public:
  /// @param definitions  get the forms that are referred to by name
  explicit SchemaWriter(nlohmann::ordered_json& definitions) : definitions_(definitions) {}

  /// An object of this form; by reference if the form has a definition.
  nlohmann::ordered_json reference_to(const Form& form);
  /// The form itself.
  nlohmann::ordered_json schema_of(const Form& form);

 private:
  nlohmann::ordered_json schema_of(const Key& key);
  void add_type(const Key& key, nlohmann::ordered_json& schema);
  void add_kinds(const Form& form, nlohmann::ordered_json& schema);

  nlohmann::ordered_json& definitions_;
};

[[nodiscard]] nlohmann::ordered_json schema_of(const Form& form);

/// One second or millisecond of a file ("s", "ms").
[[nodiscard]] double nanoseconds_in(std::string_view unit);

}  // namespace takt
