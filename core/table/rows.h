#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/table/field.h"

namespace takt::table {

/// What a table reads from. Tables of other layers have more in theirs, a cell for instance.
struct Context {
  ObjectReader& reader;
  /// Keys whose values a program has given in a form that files do not have, a state for instance.
  const std::set<std::string, std::less<>>* given = nullptr;

  /// The key was given, in a file or by a program.
  [[nodiscard]] bool has(std::string_view key) const {
    return reader.has(key) || (given != nullptr && given->contains(key));
  }
  /// The same for an object inside of this one.
  [[nodiscard]] Context inside(ObjectReader& part, const std::set<std::string, std::less<>>* keys = nullptr) const {
    return {part, keys};
  }
};

/// What is done with the rows of a table, whatever they are: they are read from a file, written as a file would have
/// them, and settled for a program with the same checks. Table describes them. Realtime: setup.
template <class P, class C>
class Rows {
 public:
  using Read = std::function<void(const Field&, const C&, P&)>;
  using Write = std::function<void(const Field&, const P&, Writer&)>;
  /// What is different for values that a program has set.
  struct InPrograms {
    /// It is there in a form that files do not have, so it is not read; null: it always has one.
    std::function<bool(const P&)> is_given = {};
    /// Finishes `p` with what was read from its written form; null: nothing is to be done.
    std::function<void(const Field&, const C&, const P& read, P& p)> settle = {};
  };

  /// Reads all keys of the table. Who is done with the object calls ObjectReader::finish().
  void read_into(P& p, const C& from) const {
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (rows_[i].read) rows_[i].read(fields_[i], from, p);
    check(p, from);
  }
  /// A whole object, of which only the keys of the table are allowed.
  [[nodiscard]] P read_object(ObjectReader& reader) const requires std::is_same_v<C, Context> {
    P p;
    read_into(p, {reader});
    reader.finish();
    return p;
  }

  /// As a file would have it.
  void write(const P& p, Writer& to) const {
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (rows_[i].write) rows_[i].write(fields_[i], p, to);
  }

  /// Values that a program has set, as if a file had them. @param from  reads what write() made of `p`
  void settle(P& p, const C& outer) const {
    std::set<std::string, std::less<>> given;
    const C from = outer.inside(outer.reader, &given);
    P read;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (row.in_programs.is_given && row.in_programs.is_given(p)) {
        given.insert(fields_[i].key);
      } else if (row.read) {
        row.read(fields_[i], from, read);
      }
      if (row.in_programs.settle) row.in_programs.settle(fields_[i], from, read, p);
    }
    check(p, from);
  }

  /// The keys, as data.
  [[nodiscard]] const std::vector<Field>& list() const { return fields_; }
  [[nodiscard]] const std::vector<Rule>& rules() const { return rules_; }
  /// The object as a whole, as data. @param definition  its name in schemas
  [[nodiscard]] Field form(std::string_view definition, std::string_view doc = {}) const {
    Field whole = field("", Field::Type::kObject, doc);
    whole.definition = definition;
    whole.fields = fields_;
    whole.rules = rules_;
    whole.discriminator = discriminator_;
    whole.variants = variants_;
    return whole;
  }

 protected:
  void add_row(Field info, Read read, Write write, InPrograms in_programs) {
    fields_.push_back(std::move(info));
    rows_.push_back({std::move(read), std::move(write), std::move(in_programs)});
  }
  /// The row that was added last reads others, too.
  [[nodiscard]] const Read& last_read() const { return rows_.back().read; }
  void set_last_read(Read read) { rows_.back().read = std::move(read); }
  void add_check(std::function<void(P&, const C&)> check) { checks_.push_back(std::move(check)); }
  void add_rule(Rule rule) { rules_.push_back(std::move(rule)); }
  /// More keys, by the word at a key.
  void set_variants(std::string_view key, std::vector<Field> variants) {
    discriminator_ = key;
    variants_ = std::move(variants);
  }
  /// The row that was added last.
  [[nodiscard]] Field& last() { return fields_.back(); }

 private:
  struct Row {
    Read read;
    Write write;
    InPrograms in_programs;
  };

  void check(P& p, const C& from) const {
    check_rules(rules_, from.reader);
    for (const auto& one : checks_) one(p, from);
  }

  std::vector<Field> fields_;
  std::vector<Row> rows_;
  std::vector<Rule> rules_;
  std::string discriminator_;
  std::vector<Field> variants_;
  std::vector<std::function<void(P&, const C&)>> checks_;
};

}  // namespace takt::table
