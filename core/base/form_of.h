#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/form.h"
#include "core/base/time.h"

namespace takt {

template <class T>
class FormOf;

namespace form_detail {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

template <class V>
void read_value(FormReader& from, const Key& key, V& value) {
  const std::string_view name = key.name;
  if (!key.required && !from.has(name)) {
    (void)from.object().child(name);
    return;
  }
  if constexpr (IsOptional<V>::value) {
    value.emplace();
    if constexpr (requires { value->setZero(); }) value->setZero();
    read_value(from, key, *value);
  } else if constexpr (std::same_as<V, bool>) {
    value = from.boolean(name, key.required ? std::nullopt : std::optional(value));
  } else if constexpr (std::floating_point<V>) {
    value = from.number(name, key.required ? std::nullopt : std::optional(value));
  } else if constexpr (std::integral<V>) {
    if (key.type == Key::Type::kNumber) {  // Nanoseconds
      const double unit = takt::nanoseconds_in(key.unit);
      const double read =
          from.number(name, key.required ? std::nullopt : std::optional(static_cast<double>(value) / unit));
      value = static_cast<V>(std::llround(unit * read));
    } else {
      value = static_cast<V>(
          from.integer(name, key.required ? std::nullopt : std::optional(static_cast<std::int64_t>(value))));
    }
  } else if constexpr (std::same_as<V, std::string>) {
    if (key.type == Key::Type::kChoice) {
      value = from.choice(name, key.required ? std::nullopt : std::optional(value));
    } else {
      value = from.text(name);
    }
  } else if constexpr (std::same_as<V, std::vector<std::string>>) {
    value = from.texts(name);
  } else if constexpr (std::same_as<V, std::vector<double>>) {
    value = from.numbers(name, key.required ? std::nullopt : std::optional(value));
  } else if constexpr (std::same_as<V, nlohmann::ordered_json>) {
    if (const auto* json = from.json(name)) value = *json;
  } else {  // a vector of Eigen
    const std::vector<double> absent(value.data(), value.data() + value.size());
    const std::vector<double> read = from.numbers(name, key.required ? std::nullopt : std::optional(absent));
    value = V(read.data());
  }
}

/// What a member that is not set says of a key that may be left out.
template <class V>
[[nodiscard]] Key::Value fallback_of(const Key& key, const V& value) {
  if constexpr (std::same_as<V, bool> || std::floating_point<V>) {
    return value;
  } else if constexpr (std::integral<V>) {
    return static_cast<double>(value) / (key.type == Key::Type::kNumber ? takt::nanoseconds_in(key.unit) : 1.0);
  } else if constexpr (std::same_as<V, std::string>) {
    return value.empty() ? Key::Value() : Key::Value(value);
  } else {
    return {};
  }
}

}  // namespace form_detail

/// A key whose objects have a form of their own.
template <class T>
struct KeyOf {
  Key key;
  const FormOf<T>& form;

  [[nodiscard]] KeyOf optional(std::string meaning = {}) && {
    return {std::move(key).optional(std::move(meaning)), form};
  }
};
template <class T>
[[nodiscard]] KeyOf<T> object_key(std::string name, const FormOf<T>& form, std::string doc) {
  return {object_key(std::move(name), form.form(), std::move(doc)), form};
}
template <class T>
[[nodiscard]] KeyOf<T> objects_key(std::string name, std::size_t min_size, const FormOf<T>& form, std::string doc) {
  return {objects_key(std::move(name), min_size, form.form(), std::move(doc)), form};
}
template <class T>
[[nodiscard]] KeyOf<T> members_key(std::string name, const NameRule& names, const FormOf<T>& form, std::string doc) {
  return {members_key(std::move(name), object_key("", form.form(), ""), std::move(doc)).with_names(names), form};
}

/// A form whose rows say as well which member of T they fill: key, type, unit, range, default, doc and place in one
/// row. The default of a row that may be left out is what a default-constructed T has there.
///
/// A member is a number, a Boolean, a text, a list of texts or numbers, a vector, Nanoseconds (a number in s or ms),
/// JSON as it is, an object with a form of its own, or a std::optional of these. Made once; immutable then.
template <class T>
class FormOf {
 public:
  using Read = std::function<void(FormReader&, T&)>;

  /// @param definition  its name in the schema; empty: described where it is used
  explicit FormOf(std::string definition = {}, std::string doc = {})
      : form_{.doc = std::move(doc), .definition = std::move(definition)} {}

  /// @param access  a pointer to a member, or a function that returns a reference to what T holds
  template <class Access>
  requires std::invocable<Access, T&> FormOf& add(Key key, Access access) {
    using Member = std::remove_cvref_t<std::invoke_result_t<Access, T&>>;
    if (!key.required && key.absent.empty()) {
      T unset{};
      key.fallback = form_detail::fallback_of<Member>(key, std::invoke(access, unset));
    }
    reads_.push_back(
        [key, access](FormReader& from, T& to) { form_detail::read_value(from, key, std::invoke(access, to)); });
    form_.keys.push_back(std::move(key));
    return *this;
  }
  /// A key that is read in a way of its own.
  FormOf& add(Key key, Read read) {
    form_.keys.push_back(std::move(key));
    reads_.push_back(std::move(read));
    return *this;
  }
  /// A key that is read elsewhere.
  FormOf& add(Key key) {
    return add(key, [name = key.name](FormReader& from, T&) { (void)from.object().child(name); });
  }
  /// An object, a list of them, or objects by names that they get as `name`.
  template <class Inner, class Access>
  FormOf& add(KeyOf<Inner> row, Access access) {
    return add(row.key, [key = row.key, &form = row.form, access](FormReader& from, T& to) {
      auto& member = std::invoke(access, to);
      using Member = std::remove_cvref_t<decltype(member)>;
      Diagnostics& diagnostics = from.diagnostics();
      if constexpr (std::same_as<Member, Inner> || std::same_as<Member, std::optional<Inner>>) {
        if (const auto* json = from.json(key.name)) member = form.read(*json, from.at(key.name), diagnostics);
      } else if constexpr (requires { typename Member::mapped_type; }) {
        from.members(key.name, [&](const std::string& name, const auto& json, const std::string& pointer) {
          member[name] = form.read(json, pointer, diagnostics);
        });
      } else if (key.type == Key::Type::kMembers) {
        from.members(key.name, [&](const std::string& name, const auto& json, const std::string& pointer) {
          member.push_back(form.read(json, pointer, diagnostics));
          if constexpr (requires { member.back().name = name; }) member.back().name = name;
        });
      } else {
        from.elements(key.name, [&](const auto& json, const std::string& pointer) {
          member.push_back(form.read(json, pointer, diagnostics));
        });
      }
    });
  }
  /// "position_m", "rpy_deg" and "quaternion". @param access  an Eigen::Isometry3d, m
  template <class Access>
  FormOf& pose(Access access) {
    for (Key& key : pose_keys()) form_.keys.push_back(std::move(key));
    form_.rules.push_back(pose_rule());
    return then([access](FormReader& from, T& to) { std::invoke(access, to) = from.object().pose(); });
  }
  /// One of some words, each of which means a value of the member.
  template <class Access, class Value>
  FormOf& choice(Key key, Access access, std::vector<std::pair<std::string, Value>> words) {
    T unset{};
    for (const auto& [word, value] : words) {
      key.choices.push_back(word);
      if (!key.required && value == std::invoke(access, unset)) key.fallback = word;
    }
    return add(key, [name = key.name, access, words](FormReader& from, T& to) {
      const std::string word = from.choice(name);
      const auto found = std::ranges::find(words, word, &std::pair<std::string, Value>::first);
      if (found != words.end()) std::invoke(access, to) = found->second;
    });
  }
  /// One of some words, each of which means a value and has a form with more keys.
  template <class Value>
  struct Kind {
    std::string name;
    Value value;
    FormOf form;
  };
  template <class Value>
  using KindList = std::vector<Kind<Value>>;
  /// @param key  with its default, if it may be left out
  template <class Access, class Value>
  FormOf& kinds(Key key, Access access, std::vector<Kind<Value>> kinds) {
    const auto known = std::make_shared<const std::vector<Kind<Value>>>(std::move(kinds));
    form_.kinds = {.key = std::move(key), .forms = [known] {
                     std::vector<NamedForm> forms;
                     for (const Kind<Value>& kind : *known) forms.push_back({kind.name, kind.form.form()});
                     return forms;
                   }};
    return then([access, known](FormReader& from, T& to) {
      const auto chosen = from.kind();
      if (!chosen) return;
      const auto kind = std::ranges::find(*known, chosen->name, &Kind<Value>::name);
      std::invoke(access, to) = kind->value;
      kind->form.read_into(from.object(), to);
    });
  }
  /// The same of a registry. @param read  reads what FormReader::kind() says
  FormOf& kinds(Kinds kinds, Read read) {
    form_.kinds = std::move(kinds);
    return then(std::move(read));
  }
  FormOf& rule(Rule rule) {
    form_.rules.push_back(std::move(rule));
    return *this;
  }
  /// What is done after the rows before it.
  FormOf& then(Read step) {
    reads_.push_back(std::move(step));
    return *this;
  }

  [[nodiscard]] const Form& form() const { return form_; }
  /// All diagnostics at once, with fallbacks in the place of what is wrong.
  [[nodiscard]] T read(const nlohmann::ordered_json& json, const std::string& pointer, Diagnostics& diagnostics) const {
    ObjectReader object(json, pointer, diagnostics);
    T read{};
    read_into(object, read);
    object.finish();
    return read;
  }
  void read_into(ObjectReader& object, T& to) const {
    FormReader from(form_, object);
    for (const Read& step : reads_) step(from, to);
    from.check_rules();
  }

 private:
  Form form_;
  std::vector<Read> reads_;
};

}  // namespace takt
