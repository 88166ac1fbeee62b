#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "core/table/members.h"
#include "core/table/rows.h"
#include "core/table/value_type.h"

namespace takt::table {

template <class Made>
class Kinds;

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

/// Describes the keys of one object, row by row: which key fills which member of P, and what is allowed. What is done
/// with the rows is in rows.h. Made once; immutable then.
///
/// Every row takes an access: a pointer to a member of P, or a function that returns a reference to what P holds. A
/// member that is a std::optional may be left out in files; any other has as its default what a default-constructed P
/// has there, unless required() says that files must give it. Realtime: setup.
/// @tparam Self  the table that derives from this one, so that calls can be chained
template <class P, class C, class Self>
class BasicTable : public Rows<P, C> {
 public:
  using typename Rows<P, C>::Read;
  using typename Rows<P, C>::Write;
  using typename Rows<P, C>::InPrograms;

  /// A value of one of the types of value_type.h.
  template <class Value, class Access>
  Self& value(std::string_view key, ValueType<Value> type, Access access, std::string_view doc) {
    Field info = std::move(type.info);
    info.key = key;
    info.doc = doc;
    if constexpr (!kOptional<Access>) info.fallback = type.text(default_of(access));
    return add(
        std::move(info),
        [access, read = std::move(type.read)](const Field& row, const C& from, P& p) {
          auto& member = std::invoke(access, p);
          if constexpr (kOptional<Access>) {
            if (from.reader.has(row.key)) member = read(row, from.reader, std::nullopt);
          } else {
            member = read(row, from.reader, row.required ? std::nullopt : std::optional<Value>(member));
          }
        },
        [access, write = std::move(type.write)](const Field& row, const P& p, Writer& to) {
          if_given<Access>(access, p, [&](const Value& value) { write(row, value, to); });
        });
  }

  /// A number; SI in C++, in files in `unit`.
  template <class Access>
  Self& number(std::string_view key, std::string_view unit, Access access, const Range& range, std::string_view doc) {
    return value(key, number_type(unit, range), access, doc);
  }
  /// A number in the unit of a device, which the table does not know.
  template <class Access>
  Self& device_number(std::string_view key, Access access, std::string_view doc) {
    number(key, "", access, kAnyNumber, doc);
    this->last().unit_of_device = true;
    return self();
  }
  template <class Access>
  Self& integer(std::string_view key, Access access, const Range& range, std::string_view doc) {
    return value(key, integer_type(range), access, doc);
  }
  template <class Access>
  Self& boolean(std::string_view key, Access access, std::string_view doc) {
    return value(key, boolean_type(), access, doc);
  }
  template <class Access>
  Self& text(std::string_view key, Access access, std::string_view doc) {
    return value(key, text_type(), access, doc);
  }
  /// A list of texts. Always required.
  template <class Access>
  Self& texts(std::string_view key, Access access, std::string_view doc) {
    return value(key, texts_type(), access, doc).required();
  }
  /// Three numbers; SI in C++, in files in `unit`.
  template <class Access>
  Self& vector(std::string_view key, std::string_view unit, Access access, std::string_view doc) {
    return value(key, vector_type(unit), access, doc);
  }
  template <class Access>
  Self& direction(std::string_view key, Access access, std::string_view doc) {
    return value(key, direction_type(), access, doc);
  }
  /// One of some words, each of which means a value of the member.
  template <class Access, class Value>
  Self& choice(std::string_view key, Access access, Words<Value> words, std::string_view doc) {
    return value(key, choice_type(std::move(words)), access, doc);
  }
  /// One of some words, each of which means a value of the member and brings keys of its own.
  template <class Value>
  struct Variant {
    std::string word;
    Value value;
    std::string doc = {};
    const Self* table = nullptr;  ///< null: no more keys. It outlives this one
  };
  template <class Value, class Access>
  Self& choose(std::string_view key, Access access, std::vector<Variant<Value>> variants, std::string_view doc) {
    Words<Value> words;
    std::vector<Field> more;
    for (const Variant<Value>& one : variants) {
      words.emplace_back(one.word, one.value);
      more.push_back(one.table != nullptr ? one.table->form({}, one.doc) : field({}, Field::Type::kObject, one.doc));
      more.back().key = one.word;
    }
    choice(key, access, std::move(words), doc);
    this->set_variants(key, std::move(more));
    return and_then([access, variants = std::move(variants)](const Field& row, const C& from, P& p) {
      // Which keys belong to a word that there is not is unknown.
      const std::optional<std::string> word = word_at(row.key, from.reader);
      if (!word && row.required) return;
      for (const Variant<Value>& one : variants)
        if (word ? *word == one.word : one.value == get(access, p)) return read_variant(one, from, p);
    });
  }
  /// One of some kinds (kinds.h), each with keys of its own. Nothing if the key is not there.
  /// @param use  what is done with what the kind makes of them: void(P&, Made)
  template <class Made, class Use>
  Self& kind(std::string_view key, const Kinds<Made>& kinds, std::string_view doc, Use use) {
    this->set_variants(key, kinds.variants());
    return add(kinds.choice(key, doc),
               [&kinds, use](const Field& row, const C& from, P& p) {
                 if (!row.required && !from.reader.has(row.key)) return;
                 if (const auto* kind = kinds.read(row.key, from.reader)) use(p, kind->read(from.reader));
               },
               {});
  }
  /// A text that names something; whether it exists is checked where the cell is known.
  template <class Access>
  Self& named(std::string_view key, NameOf what, Access access, std::string_view doc) {
    ValueType<std::string> type = text_type();
    type.info.type = Field::Type::kName;
    type.info.names = what;
    return value(key, std::move(type), access, doc);
  }
  /// The keys "position_m", and "rpy_deg" or "quaternion".
  template <class Access>
  Self& pose(Access access, std::string_view position_doc = "Position.") {
    for (Field& one : pose_fields(position_doc)) add(std::move(one), {}, {});
    this->add_rule(one_orientation());
    return attach([access](const C& from, P& p) { std::invoke(access, p) = from.reader.pose(); });
  }

  /// An object with a table of its own. A std::optional is nothing if the key is not there; any other member keeps its
  /// default. @param definition  its name in schemas; empty: it is printed in place
  template <class Part, class Other, class Access>
  Self& part(std::string_view key, std::string_view definition, const BasicTable<Part, C, Other>& table, Access access,
             std::string_view doc) {
    Field info = table.form(definition, doc);
    info.key = key;
    return add(
        std::move(info),
        [&table, access](const Field& row, const C& from, P& p) {
          const auto* json = from.reader.object(row.key, row.required);
          if (json == nullptr) return;
          ObjectReader reader(*json, from.reader.at(row.key), from.reader.diagnostics());
          table.read_into(target(std::invoke(access, p)), from.inside(reader));
          reader.finish();
        },
        [&table, access](const Field& row, const P& p, Writer& to) {
          if_given<Access>(access, p, [&](const Part& value) {
            Writer inner;
            table.write(value, inner);
            to.object(row.key, inner);
          });
        },
        {.is_given = [](const P&) { return true; },
         .settle =
             [&table, access](const Field& row, const C& from, const P&, P& p) {
               auto& member = std::invoke(access, p);
               const auto* json = from.reader.object(row.key, false);
               if (json == nullptr) return;
               if constexpr (kOptional<Access>) {
                 if (!member) return;
               }
               ObjectReader reader(*json, from.reader.at(row.key), from.reader.diagnostics());
               table.settle(present(member), from.inside(reader));
             }});
  }

  /// The keys of another table in the same object. `p` is a part of P.
  template <class Part, class Other, class Access>
  Self& inlined(const BasicTable<Part, C, Other>& table, Access access) {
    for (const Field& one : table.list()) add(Field(one), {}, {});
    for (Rule one : table.rules()) {
      one.checked = false;  // by that table
      this->add_rule(std::move(one));
    }
    const Field whole = table.form({});
    this->set_variants(whole.discriminator, whole.variants);
    return attach([&table, access](const C& from, P& p) { table.read_into(std::invoke(access, p), from); });
  }

  /// A list of objects with a table of their own; nothing if the key is not there.
  template <class Part, class Other, class Access>
  Self& elements(std::string_view key, std::string_view definition, const BasicTable<Part, C, Other>& table,
                 Access access, std::string_view doc, const Count& count = {}) {
    Field info = field(key, Field::Type::kList, doc);
    info.items = {table.form(definition)};
    info.count = count;
    return add(std::move(info),
               [&table, access](const Field& row, const C& from, P& p) {
                 for_each_element(row, from.reader, [&](ObjectReader& element) {
                   table.read_into(std::invoke(access, p).emplace_back(), from.inside(element));
                 });
               },
               {});
  }

  /// Names to objects with a table of their own. The member is a map of them.
  template <class Part, class Other, class Access>
  Self& mapped(std::string_view key, std::string_view definition, const BasicTable<Part, C, Other>& table,
               Access access, std::string_view doc) {
    return add(map_field(key, table.form(definition), doc),
               [&table, access](const Field& row, const C& from, P& p) {
                 for_each_member(row.key, from.reader, [&](const std::string& name, ObjectReader& member) {
                   table.read_into(std::invoke(access, p)[name], from.inside(member));
                 });
               },
               {});
  }

  /// Names to objects with a table of their own. The member is a list of them, each with a member `name`.
  template <class Part, class Other, class Access>
  Self& members(std::string_view key, std::string_view definition, const BasicTable<Part, C, Other>& table,
                Access access, std::string_view doc) {
    Field info = field(key, Field::Type::kMap, doc);
    info.items = {table.form(definition)};
    info.pattern = kMemberName;
    return add(std::move(info),
               [&table, access](const Field& row, const C& from, P& p) {
                 for_each_member(row.key, from.reader, [&](const std::string& name, ObjectReader& member) {
                   Part& part = std::invoke(access, p).emplace_back();
                   part.name = name;
                   table.read_into(part, from.inside(member));
                 });
               },
               {});
  }

  /// An object with a reader of its own, such as a goal. `read` is called whether or not the key is there.
  /// @param write  may be null: programs give this value in a form that files cannot have
  Self& object(Field info, Read read, Write write = {}) {
    if (write) return add(std::move(info), std::move(read), std::move(write));
    return add(std::move(info), std::move(read), {}, {.is_given = [](const P&) { return true; }});
  }

  /// A key that one might expect and that the object does not have. @param why  and what to do, for the diagnostic
  Self& refuse(std::string_view key, std::string_view why, std::string_view hint) {
    Field info = field(key, Field::Type::kAny, {});
    info.refused = true;
    return add(std::move(info),
               [why = std::string(why), hint = std::string(hint)](const Field& row, const C& from, P&) {
                 if (from.reader.has(row.key)) refuse_key(row.key, from.reader, why, hint);
               },
               {});
  }

  /// The row before this call must be given.
  Self& required() {
    this->last().required = true;
    this->last().fallback.clear();
    return self();
  }
  /// The row before this call is one that the object does not have if `refuse`: a check says why.
  Self& refused_if(bool refuse) {
    this->last().refused = refuse;
    return self();
  }
  /// The default of the row before this call, where it follows from others.
  Self& fallback(std::string_view text) {
    this->last().fallback = text;
    return self();
  }

  /// The text of the row before this call is not empty where it is given.
  Self& not_empty() {
    this->last().count.min = 1;
    return self();
  }
  /// The value of the row before this call may be that of a parameter of the file: "$NAME", replaced before it is read.
  Self& or_parameter() {
    this->last().or_parameter = true;
    return self();
  }

  /// A rule about several keys, checked after all rows have been read.
  Self& rule(Rule rule) {
    this->add_rule(std::move(rule));
    return self();
  }
  /// What no rule can say, checked after the rules, in the order of the calls.
  Self& rule(std::function<void(P&, const C&)> check) {
    this->add_check(std::move(check));
    return self();
  }

 protected:
  template <class Access>
  using Member = std::remove_cvref_t<std::invoke_result_t<Access, P&>>;
  template <class Access>
  static constexpr bool kOptional = IsOptional<Member<Access>>::value;

  /// Accesses are written for P&; what is read through them here is not changed.
  template <class Access>
  static const auto& get(const Access& access, const P& p) {
    return std::invoke(access, const_cast<P&>(p));
  }
  template <class Access>
  static auto default_of(const Access& access) {
    P p;
    return std::invoke(access, p);
  }
  template <class Access, class Use>
  static void if_given(const Access& access, const P& p, const Use& use) {
    const auto& member = get(access, p);
    if constexpr (kOptional<Access>) {
      if (member) use(*member);
    } else {
      use(member);
    }
  }
  template <class M>
  static auto& target(M& member) {
    if constexpr (IsOptional<M>::value) {
      return member.emplace();
    } else {
      return member;
    }
  }
  template <class M>
  static auto& present(M& member) {
    if constexpr (IsOptional<M>::value) {
      return *member;
    } else {
      return member;
    }
  }
  Self& add(Field info, Read read, Write write, InPrograms in_programs = {}) {
    this->add_row(std::move(info), std::move(read), std::move(write), std::move(in_programs));
    return self();
  }
  /// Reads several rows at once, with the last of them.
  Self& attach(std::function<void(const C&, P&)> read) {
    this->set_last_read([read = std::move(read)](const Field&, const C& from, P& p) { read(from, p); });
    return self();
  }
  /// Reads more after the row that was added last.
  Self& and_then(Read more) {
    this->set_last_read([first = this->last_read(), more = std::move(more)](const Field& row, const C& from, P& p) {
      first(row, from, p);
      more(row, from, p);
    });
    return self();
  }
  template <class Value>
  static void read_variant(const Variant<Value>& one, const C& from, P& p) {
    if (one.table != nullptr) one.table->read_into(p, from);
  }
  Self& self() { return static_cast<Self&>(*this); }
};

/// The table of an object of a file.
template <class P>
class Table final : public BasicTable<P, Context, Table<P>> {};

}  // namespace takt::table
