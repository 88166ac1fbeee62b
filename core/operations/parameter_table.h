#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/read_parts.h"
#include "core/expression/condition_state.h"
#include "core/operations/compliance.h"
#include "core/operations/parameter.h"
#include "core/operations/tool_choice.h"

namespace takt::activity {

/// A tool that a program names exists somewhere in the cell; where, is known when it is used.
void check_tool_name(const ToolChoice& choice, const ReadContext& from);

/// The parameters of one operation: which key fills which member of P, and what is allowed. Made once; immutable then.
///
/// Every row takes an access: a pointer to a member of P, or a function that returns a reference to what P holds. A
/// member that is a std::optional may be left out in files; any other has as its default what a default-constructed P
/// has there, unless required() says that files must give it. Realtime: setup.
template <class P>
class ParameterTable {
 public:
  using Read = std::function<void(const ParameterInfo&, const ReadContext&, P&)>;
  using Write = std::function<void(const ParameterInfo&, const P&, ParameterWriter&)>;
  /// What is different for parameters that a program has set.
  struct InPrograms {
    /// It is there in a form that files do not have, so it is not read; null: it always has one.
    std::function<bool(const P&)> is_given = {};
    /// Finishes `p` with what was read from its written form; null: nothing is to be done.
    std::function<void(const ParameterInfo&, const ReadContext&, const P& read, P& p)> settle = {};
  };

  /// A number; SI inside, in files in `unit`.
  template <class Access>
  ParameterTable& number(std::string_view key, std::string_view unit, Access access, const Range& range,
                         std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kNumber, doc);
    info.unit = unit;
    info.range = range;
    const double si = file_unit(unit).si_per_unit;
    if constexpr (!kOptional<Access>) info.fallback = to_text(default_of(access) / si);
    return add(
        std::move(info),
        [access, si](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          if constexpr (kOptional<Access>) {
            if (from.reader.has(row.key)) member = si * from.reader.number(row.key, {}, row.range);
          } else {
            member = si * from.reader.number(row.key, fallback_of(row, member / si), row.range);
          }
        },
        [access, si](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          if_given<Access>(access, p, [&](double value) { to.number(row.key, value / si); });
        });
  }

  /// A number in the unit of a device, which the table does not know.
  template <class Access>
  ParameterTable& device_number(std::string_view key, Access access, std::string_view doc) {
    number(key, "", access, kAnyNumber, doc);
    infos_.back().unit_of_device = true;
    return *this;
  }

  template <class Access>
  ParameterTable& integer(std::string_view key, Access access, const Range& range, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kInteger, doc);
    info.range = range;
    info.fallback = std::to_string(default_of(access));
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          member = from.reader.integer(row.key, fallback_of<std::int64_t>(row, member), row.range);
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) { to.integer(row.key, get(access, p)); });
  }

  template <class Access>
  ParameterTable& boolean(std::string_view key, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kBoolean, doc);
    info.fallback = default_of(access) ? "true" : "false";
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          member = from.reader.boolean(row.key, fallback_of<bool>(row, member));
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) { to.boolean(row.key, get(access, p)); });
  }

  template <class Access>
  ParameterTable& text(std::string_view key, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kText, doc);
    info.fallback = default_of(access);
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          member = from.reader.text(row.key, fallback_of<std::string>(row, member));
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) { to.text(row.key, get(access, p)); });
  }

  /// A text that may be left out.
  template <class Access>
  ParameterTable& optional_text(std::string_view key, Access access, std::string_view doc) {
    return add(
        make(key, ParameterInfo::Type::kText, doc),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          if (from.reader.has(row.key)) std::invoke(access, p) = from.reader.text(row.key);
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          if_given<Access>(access, p, [&](const std::string& value) { to.text(row.key, value); });
        });
  }

  /// A list of texts. Always required.
  template <class Access>
  ParameterTable& texts(std::string_view key, Access access, std::string_view doc) {
    return add(
               make(key, ParameterInfo::Type::kTexts, doc),
               [access](const ParameterInfo& row, const ReadContext& from, P& p) {
                 std::invoke(access, p) = from.reader.texts(row.key);
               },
               [access](const ParameterInfo& row, const P& p, ParameterWriter& to) {
                 to.texts(row.key, get(access, p));
               })
        .required();
  }

  /// Three numbers; SI inside, in files in `unit`.
  template <class Access>
  ParameterTable& vector(std::string_view key, std::string_view unit, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kVector, doc);
    info.unit = unit;
    const double si = file_unit(unit).si_per_unit;
    if constexpr (!kOptional<Access>) info.fallback = to_text(Eigen::Vector3d(default_of(access) / si));
    return add(
        std::move(info),
        [access, si](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          if constexpr (kOptional<Access>) {
            if (from.reader.has(row.key)) member = Eigen::Vector3d(si * from.reader.vector(row.key));
          } else {
            member = si * from.reader.vector(row.key, fallback_of<Eigen::Vector3d>(row, member / si));
          }
        },
        [access, si](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          if_given<Access>(access, p, [&](const Eigen::Vector3d& value) { to.vector(row.key, value / si); });
        });
  }

  /// A vector of which only the direction counts, in files of any length but 0; inside as it was written.
  template <class Access>
  ParameterTable& direction(std::string_view key, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kVector, doc);
    info.fallback = to_text(Eigen::Vector3d(default_of(access)));
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          member = read_direction(from.reader, row.key, member);
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) { to.vector(row.key, get(access, p)); });
  }

  /// One of some words, each of which means a value of the member.
  template <class Access, class Value>
  ParameterTable& choice(std::string_view key, Access access, std::vector<std::pair<std::string, Value>> words,
                         std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kChoice, doc);
    for (const auto& [word, value] : words) info.choices.push_back(word);
    const auto word_of = [words](const Value& value) {
      for (const auto& [word, meant] : words)
        if (meant == value) return word;
      return std::string();
    };
    info.fallback = word_of(default_of(access));
    return add(
        std::move(info),
        [access, words, word_of](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          const std::string given =
              from.reader.choice(row.key, row.choices, fallback_of<std::string>(row, word_of(member)));
          for (const auto& [word, value] : words)
            if (word == given) member = value;
        },
        [access, word_of](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          to.text(row.key, word_of(get(access, p)));
        });
  }

  /// The name of something in the cell. Default: the only one of its kind. Of a std::optional: nothing if not given.
  template <class Access>
  ParameterTable& name(std::string_view key, NameOf what, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kName, doc);
    info.names = what;
    if constexpr (!kOptional<Access>) info.fallback = "the only one of the cell";
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          if constexpr (kOptional<Access>) {
            if (!from.reader.has(row.key)) return;
          }
          const auto names = names_in(from.cell, row.names);
          const bool only_one = !kOptional<Access> && !row.required && names.size() == 1;
          std::invoke(access, p) =
              from.reader.choice(row.key, names, only_one ? std::optional(names.front()) : std::nullopt);
        },
        [access](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          // An empty name means "the only one of the cell", as a key that is not there does.
          if_given<Access>(access, p, [&](const std::string& value) {
            if (!value.empty()) to.text(row.key, value);
          });
        },
        {.settle = [access](const ParameterInfo&, const ReadContext&, const P& read, P& p) {
          std::invoke(access, p) = get(access, read);
        }});
  }

  /// A condition over sensors and inputs, or a state of a program; nothing if the key is not there.
  template <class Access>
  ParameterTable& condition(std::string_view key, Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kCondition, doc);
    info.definition = "condition";
    return add(
        std::move(info),
        [access](const ParameterInfo& row, const ReadContext& from, P& p) {
          std::invoke(access, p) = command::read_condition(from.reader, row.key, from.cell, row.required);
        },
        [](const ParameterInfo&, const P&, ParameterWriter&) {},
        {.is_given = [access](const P& p) { return get(access, p).has_value(); }});
  }

  /// The tool of its arm that it works with: the keys "tool" and "tcp", of a member ToolChoice.
  template <class Access>
  ParameterTable& tool(Access access) {
    text(
        "tool", [access](P & p) -> auto& { return std::invoke(access, p).tool; },
        "Tool of the arm that it works with: the one that the cell declares.");
    text(
        "tcp", [access](P & p) -> auto& { return std::invoke(access, p).tcp; },
        "Tool centre point of that tool, or a frame of what the arm holds: that of the tool.");
    return rule([access](P& p, const ReadContext& from) { check_tool_name(get(access, p), from); });
  }

  /// How the arm yields meanwhile; nothing if the key is not there.
  template <class Access>
  ParameterTable& compliance(Access access) {
    return add(
        compliance_parameter(),
        [access](const ParameterInfo&, const ReadContext& from, P& p) {
          std::invoke(access, p) = read_compliance(from.reader);
        },
        [](const ParameterInfo&, const P&, ParameterWriter&) {},
        {.is_given = [access](const P& p) { return get(access, p).has_value(); }});
  }

  /// An object with a table of its own; nothing if the key is not there. @param definition  in the schema of scenario
  /// files
  template <class Part, class Access>
  ParameterTable& part(std::string_view key, std::string_view definition, const ParameterTable<Part>& table,
                       Access access, std::string_view doc) {
    ParameterInfo info = make(key, ParameterInfo::Type::kObject, doc);
    info.definition = definition;
    info.fields = table.list();
    return add(
        std::move(info),
        [&table, access](const ParameterInfo& row, const ReadContext& from, P& p) {
          const auto* json = from.reader.object(row.key, false);
          if (json == nullptr) return;
          ObjectReader reader(*json, from.reader.at(row.key), from.reader.diagnostics());
          auto& member = std::invoke(access, p);
          table.read_into(member.emplace(), {reader, from.cell});
          reader.finish();
        },
        [&table, access](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          if_given<Access>(access, p, [&](const Part& value) {
            ParameterWriter inner;
            table.write(value, inner);
            to.object(row.key, inner);
          });
        },
        {.is_given = [](const P&) { return true; },
         .settle =
             [&table, access](const ParameterInfo& row, const ReadContext& from, const P&, P& p) {
               auto& member = std::invoke(access, p);
               const auto* json = from.reader.object(row.key, false);
               if (!member || json == nullptr) return;
               ObjectReader reader(*json, from.reader.at(row.key), from.reader.diagnostics());
               table.settle(*member, reader, from.cell);
             }});
  }

  /// An object with a reader of its own, such as a goal. `read` is called whether or not the key is there.
  /// @param write  may be null: programs give this parameter in a form that files cannot have
  ParameterTable& object(ParameterInfo info, Read read, Write write = {}) {
    if (write) return add(std::move(info), std::move(read), std::move(write));
    return add(std::move(info), std::move(read), [](const ParameterInfo&, const P&, ParameterWriter&) {},
               {.is_given = [](const P&) { return true; }});
  }

  /// The parameter before this call must be given.
  ParameterTable& required() {
    infos_.back().required = true;
    infos_.back().fallback.clear();
    return *this;
  }

  /// The parameter before this call is one that the operation does not have if `refuse`: a rule says why.
  ParameterTable& refused_if(bool refuse) {
    infos_.back().refused = refuse;
    return *this;
  }

  /// What the default of the parameter before this call is, where it follows from others.
  ParameterTable& fallback(std::string_view text) {
    infos_.back().fallback = text;
    return *this;
  }

  /// What concerns several parameters, checked after all have been read, in the order of the calls.
  ParameterTable& rule(std::function<void(P&, const ReadContext&)> check) {
    rules_.push_back(std::move(check));
    return *this;
  }

  /// Reads the keys "do" and "name", all parameters, and reports keys that do not exist.
  /// @return what could be read; diagnostics of all that is wrong are in the reader
  [[nodiscard]] P read(ObjectReader& reader, const command::Cell& cell) const {
    P p;
    p.pointer = reader.pointer();
    (void)reader.text("do", "");
    p.name = read_name(reader, "");
    read_into(p, {reader, cell});
    for (const ParameterInfo& info : infos_) {
      // Asked for once more, so that all keys of the operation are suggested for one that does not exist.
      if (!info.refused) (void)reader.child(info.key);
    }
    reader.finish();
    return p;
  }
  /// The parameters alone, of an object inside of an operation.
  void read_into(P& p, const ReadContext& from) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) read_row(i, from, p);
    for (const auto& check : rules_) check(p, from);
  }
  void read_row(std::size_t i, const ReadContext& from, P& p) const { rows_[i].read(infos_[i], from, p); }

  /// As a file would have it.
  void write(const P& p, ParameterWriter& to) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) write_row(i, p, to);
  }
  void write_row(std::size_t i, const P& p, ParameterWriter& to) const { rows_[i].write(infos_[i], p, to); }

  /// Parameters that a program has set, as if a file had them: names of the only one of its kind are filled in, rules
  /// applied. @return them; or what is wrong, as a file with these values would be told
  [[nodiscard]] Result<P> accept(P p, const command::Cell& cell) const {
    Diagnostics diagnostics;
    ParameterWriter writer;
    write(p, writer);
    ObjectReader reader(writer.result(), "", diagnostics);
    settle(p, reader, cell);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return p;
  }
  [[nodiscard]] Diagnostics check(const P& p, const command::Cell& cell) const {
    const auto accepted = accept(p, cell);
    return accepted ? Diagnostics() : accepted.error();
  }
  /// The same for an object inside of an operation. @param reader  of what write() made of it
  void settle(P& p, ObjectReader& reader, const command::Cell& cell) const {
    std::set<std::string, std::less<>> given;
    const ReadContext from{reader, cell, &given};
    P read;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (row.in_programs.is_given && row.in_programs.is_given(p)) {
        given.insert(infos_[i].key);
      } else {
        row.read(infos_[i], from, read);
      }
      if (row.in_programs.settle) row.in_programs.settle(infos_[i], from, read, p);
    }
    for (const auto& check : rules_) check(p, from);
  }

  [[nodiscard]] const std::vector<ParameterInfo>& list() const { return infos_; }

 private:
  struct Row {
    Read read;
    Write write;
    InPrograms in_programs;
  };

  template <class Access>
  using Member = std::remove_cvref_t<std::invoke_result_t<Access, P&>>;
  template <class T>
  struct IsOptional : std::false_type {};
  template <class T>
  struct IsOptional<std::optional<T>> : std::true_type {};
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
  template <class T>
  static std::optional<T> fallback_of(const ParameterInfo& row, const T& value) {
    return row.required ? std::nullopt : std::optional<T>(value);
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
  static ParameterInfo make(std::string_view key, ParameterInfo::Type type, std::string_view doc) {
    ParameterInfo info;
    info.key = key;
    info.type = type;
    info.doc = doc;
    return info;
  }
  ParameterTable& add(ParameterInfo info, Read read, Write write, InPrograms in_programs = {}) {
    infos_.push_back(std::move(info));
    rows_.push_back({std::move(read), std::move(write), std::move(in_programs)});
    return *this;
  }

  std::vector<ParameterInfo> infos_;
  std::vector<Row> rows_;
  std::vector<std::function<void(P&, const ReadContext&)>> rules_;
};

/// What every operation that moves an arm has beside its own parameters (OperationCommand does it).
template <class P>
void add_common_parameters(ParameterTable<P>& table) {
  table.tool(&P::tool)
      .compliance(&P::compliance)
      .condition("abort_if", &P::abort_if, "Comes to rest and fails when this becomes true.");
}

}  // namespace takt::activity
