#pragma once

#include <cstddef>
#include <cstdint>
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

/// One key of a form. Required unless something else is said.
struct Key {
  enum class Type { kNumber, kInteger, kBoolean, kText, kChoice, kTexts, kPairs, kVector, kObjects, kAny };
  std::string name;
  Type type = Type::kAny;
  std::string doc = {};                       ///< one sentence
  std::string unit = {};                      ///< "N", "degrees"; empty: none
  Range range = {};                           ///< of numbers, in that unit
  std::vector<std::string> choices = {};      ///< of kChoice
  std::size_t min_size = 0, max_size = 0;     ///< of texts and lists; max_size 0: any
  std::string definition = {};                ///< of the schema, in place of what `type` says; empty: none
  std::shared_ptr<const Form> elements = {};  ///< of kObjects
  bool required = true;
  std::variant<std::monostate, double, std::string> fallback = {};  ///< the value if the key is not there
  std::string absent = {};  ///< what holds then, for people, where that is no value

  /// The key may be left out. @param meaning  what holds then; empty: the doc says it
  [[nodiscard]] Key optional(std::string meaning = {}) && {
    required = false;
    absent = std::move(meaning);
    return std::move(*this);
  }
  [[nodiscard]] Key by_default(std::variant<std::monostate, double, std::string> value) && {
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
};

/// Keys and what concerns several of them.
struct Form {
  std::string doc;
  std::vector<Key> keys = {};
  std::vector<std::string> at_least_one = {};                       ///< of these keys
  std::vector<std::pair<std::string, std::string>> exclusive = {};  ///< keys that exclude each other
  std::vector<std::string> definitions = {};                        ///< of the schema, which hold as well
};

[[nodiscard]] Key number_key(std::string name, std::string unit, const Range& range, std::string doc);
[[nodiscard]] Key integer_key(std::string name, const Range& range, std::string doc);
[[nodiscard]] Key boolean_key(std::string name, std::string doc);
/// @param min_size  least length
[[nodiscard]] Key text_key(std::string name, std::string doc, std::size_t min_size = 0);
[[nodiscard]] Key choice_key(std::string name, std::vector<std::string> choices, std::string doc);
/// Two texts.
[[nodiscard]] Key pair_key(std::string name, std::string doc);
/// A list of pairs of texts.
[[nodiscard]] Key pairs_key(std::string name, std::string doc);
/// Three numbers: [x, y, z].
[[nodiscard]] Key vector_key(std::string name, std::string unit, std::string doc);
/// A list of objects of one form.
[[nodiscard]] Key objects_key(std::string name, std::size_t min_size, Form elements, std::string doc);
/// What its reader reads by itself. @param definition  of the schema; empty: any value
[[nodiscard]] Key any_key(std::string name, std::string definition, std::string doc);

/// Reads the keys of a form; types, ranges, choices and defaults are those of its rows. A key without a row is a
/// programming error (abort).
class FormReader {
 public:
  FormReader(const Form& form, ObjectReader& object) : form_(form), object_(object) {}

  /// @param absent  the value if the key is not there and its row has no default
  double number(std::string_view key, std::optional<double> absent = {});
  std::int64_t integer(std::string_view key, std::optional<std::int64_t> absent = {});
  bool boolean(std::string_view key);
  /// Empty if it may be left out and is.
  std::string text(std::string_view key);
  std::string choice(std::string_view key);
  /// A text that is one of these names. If the key may be left out, a single name needs none.
  std::string name(std::string_view key, const std::vector<std::string>& names);
  std::vector<std::string> texts(std::string_view key);
  Eigen::Vector3d vector(std::string_view key, std::optional<Eigen::Vector3d> absent = {});

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
  const Form& form_;
  ObjectReader& object_;
};

/// The schema of an object of this form.
[[nodiscard]] nlohmann::ordered_json schema_of(const Form& form);

struct NamedForm {
  std::string_view name;
  const Form& form;
};
/// The alternatives ("allOf") of the schema of an object of which a key says of which kind it is.
/// @param fallback  the kind without that key; empty: the key is required
/// @param common  keys that every kind has: their schema stands beside the alternatives
[[nodiscard]] nlohmann::ordered_json schema_of_kinds(const std::vector<NamedForm>& kinds, const std::string& key,
                                                     std::string_view fallback, const std::vector<std::string>& common);

}  // namespace takt
