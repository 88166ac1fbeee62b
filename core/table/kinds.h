#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/registration.h"
#include "core/table/table.h"

/// Objects of which there are kinds, chosen by a key: faults, shapes. Realtime: setup.
namespace takt::table {

/// One kind: what files, the schema and the reference know of it. Defined in a file of its name and listed once.
/// @tparam Made  what it is read into
template <class Made>
struct Kind {
  std::string_view name;   ///< what the key says
  std::string_view doc;    ///< one sentence
  const Field& (*keys)();  ///< beside those that all kinds have
  Made (*read)(ObjectReader& reader);
};

/// The keys of a table, as one object that lives as long as the process.
template <auto table>
const Field& object_of() {
  static const Field whole = table().form({});
  return whole;
}

/// All kinds of the process, in the order of their names.
template <class Made>
class Kinds {
 public:
  /// @param what  for people: "fault"
  explicit Kinds(std::string_view what) : what_(what) {}

  /// A name that is in use is a programming error (abort); plug-ins ask first.
  void add(const Kind<Made>& kind) {
    if (find(kind.name) != nullptr) {
      std::fprintf(stderr, "takt: %s %s is registered twice\n", what_.c_str(), std::string(kind.name).c_str());
      std::abort();
    }
    kinds_.insert(std::ranges::lower_bound(kinds_, kind.name, {}, &Kind<Made>::name), kind);
  }
  /// Null: there is none.
  [[nodiscard]] const Kind<Made>* find(std::string_view name) const {
    const auto found = std::ranges::find(kinds_, name, &Kind<Made>::name);
    return found == kinds_.end() ? nullptr : &*found;
  }
  [[nodiscard]] const std::vector<Kind<Made>>& all() const { return kinds_; }
  [[nodiscard]] const std::string& what() const { return what_; }

  /// The kind that `key` says. @return null: there is none, with a diagnostic
  const Kind<Made>* read(std::string_view key, ObjectReader& reader, std::optional<std::string> fallback = {}) const {
    const std::string word = reader.choice(key, names(), fallback);
    // Which keys belong to a word that there is not is unknown.
    return word_at(key, reader).value_or(word) == word ? find(word) : nullptr;
  }
  /// The key that chooses, as data.
  [[nodiscard]] Field choice(std::string_view key, std::string_view doc) const {
    Field choice = field(key, Field::Type::kChoice, doc);
    choice.choices = names();
    return choice;
  }
  /// The keys of each kind, as data. @param prefix  of their definitions in schemas; empty: they have none
  [[nodiscard]] std::vector<Field> variants(std::string_view prefix = {}) const {
    std::vector<Field> list;
    for (const Kind<Made>& kind : kinds_) {
      list.push_back(kind.keys());
      list.back().key = kind.name;
      list.back().doc = kind.doc;
      if (!prefix.empty()) list.back().definition = std::string(prefix) + std::string(kind.name);
    }
    return list;
  }

 private:
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Kind<Made>& kind : kinds_) names.emplace_back(kind.name);
    return names;
  }

  std::string what_;
  std::vector<Kind<Made>> kinds_;
};

/// A kind of a plug-in, waiting for the loader.
template <class Made>
class KindRegistration final : public Registration {
 public:
  KindRegistration(Registration*& list, Kinds<Made>& kinds, const Kind<Made>& kind)
      : Registration(list), kinds_(kinds), kind_(kind) {}

  [[nodiscard]] std::string_view what() const override { return kinds_.what(); }
  [[nodiscard]] std::string_view name() const override { return kind_.name; }
  [[nodiscard]] Diagnostics check() const override {
    Diagnostics diagnostics;
    if (kind_.name.empty()) diagnostics.error(Code::kMissing, "", "a " + kinds_.what() + " has no name", "Give it one");
    if (kinds_.find(kind_.name) != nullptr)
      diagnostics.error(Code::kDuplicate, "",
                        kinds_.what() + " '" + std::string(kind_.name) + "' is registered already",
                        "Choose another name");
    return diagnostics;
  }
  void add() override { kinds_.add(kind_); }

 private:
  Kinds<Made>& kinds_;
  Kind<Made> kind_;
};

}  // namespace takt::table
