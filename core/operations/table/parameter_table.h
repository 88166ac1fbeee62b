#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/expression/condition_state.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/parameter_rows.h"
#include "core/operations/table/parameter_type.h"
#include "core/operations/table/tool_choice.h"

namespace takt::operations {

/// A tool that a program names exists somewhere in the cell; where, is known when it is used.
void check_tool_name(const ToolChoice& choice, const ReadContext& from);

/// Describes the parameters of one operation, row by row: which key fills which member of P, and what is allowed. What
/// is done with the rows is in parameter_rows.h. Made once; immutable then.
///
/// Every row takes an access: a pointer to a member of P, or a function that returns a reference to what P holds. A
/// member that is a std::optional may be left out in files; any other has as its default what a default-constructed P
/// has there, unless required() says that files must give it. Realtime: setup.
template <class P>
class ParameterTable : public ParameterRows<P> {
 public:
  using typename ParameterRows<P>::Read;
  using typename ParameterRows<P>::Write;
  using typename ParameterRows<P>::InPrograms;

  /// A value of one of the types of parameter_type.h.
  template <class Value, class Access>
  ParameterTable& value(std::string_view key, ParameterType<Value> type, Access access, std::string_view doc) {
    ParameterInfo info = std::move(type.info);
    info.key = key;
    info.doc = doc;
    if constexpr (!kOptional<Access>) info.fallback = type.text(default_of(access));
    return add(
        std::move(info),
        [access, read = std::move(type.read)](const ParameterInfo& row, const ReadContext& from, P& p) {
          auto& member = std::invoke(access, p);
          if constexpr (kOptional<Access>) {
            if (from.reader.has(row.key)) member = read(row, from.reader, std::nullopt);
          } else {
            member = read(row, from.reader, row.required ? std::nullopt : std::optional<Value>(member));
          }
        },
        [access, write = std::move(type.write)](const ParameterInfo& row, const P& p, ParameterWriter& to) {
          if_given<Access>(access, p, [&](const Value& value) { write(row, value, to); });
        });
  }

  /// A number; SI in C++, in files in `unit`.
  template <class Access>
  ParameterTable& number(std::string_view key, std::string_view unit, Access access, const Range& range,
                         std::string_view doc) {
    return value(key, number_type(unit, range), access, doc);
  }
  /// A number in the unit of a device, which the table does not know.
  template <class Access>
  ParameterTable& device_number(std::string_view key, Access access, std::string_view doc) {
    number(key, "", access, kAnyNumber, doc);
    this->last().unit_of_device = true;
    return *this;
  }
  template <class Access>
  ParameterTable& integer(std::string_view key, Access access, const Range& range, std::string_view doc) {
    return value(key, integer_type(range), access, doc);
  }
  template <class Access>
  ParameterTable& boolean(std::string_view key, Access access, std::string_view doc) {
    return value(key, boolean_type(), access, doc);
  }
  template <class Access>
  ParameterTable& text(std::string_view key, Access access, std::string_view doc) {
    return value(key, text_type(), access, doc);
  }
  /// A list of texts. Always required.
  template <class Access>
  ParameterTable& texts(std::string_view key, Access access, std::string_view doc) {
    return value(key, texts_type(), access, doc).required();
  }
  /// Three numbers; SI in C++, in files in `unit`.
  template <class Access>
  ParameterTable& vector(std::string_view key, std::string_view unit, Access access, std::string_view doc) {
    return value(key, vector_type(unit), access, doc);
  }
  template <class Access>
  ParameterTable& direction(std::string_view key, Access access, std::string_view doc) {
    return value(key, direction_type(), access, doc);
  }
  /// One of some words, each of which means a value of the member.
  template <class Access, class Value>
  ParameterTable& choice(std::string_view key, Access access, std::vector<std::pair<std::string, Value>> words,
                         std::string_view doc) {
    return value(key, choice_type(std::move(words)), access, doc);
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
          const bool by_program = from.given != nullptr && from.given->contains(row.key);
          std::invoke(access, p) =
              expression::read_condition(from.reader, row.key, from.cell, row.required && !by_program);
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
    this->last().required = true;
    this->last().fallback.clear();
    return *this;
  }

  /// The parameter before this call is one that the operation does not have if `refuse`: a rule says why.
  ParameterTable& refused_if(bool refuse) {
    this->last().refused = refuse;
    return *this;
  }

  /// What the default of the parameter before this call is, where it follows from others.
  ParameterTable& fallback(std::string_view text) {
    this->last().fallback = text;
    return *this;
  }

  /// What concerns several parameters, checked after all have been read, in the order of the calls.
  ParameterTable& rule(std::function<void(P&, const ReadContext&)> check) {
    this->add_rule(std::move(check));
    return *this;
  }

 private:
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
    this->add_row(std::move(info), std::move(read), std::move(write), std::move(in_programs));
    return *this;
  }
};

/// What every operation that moves an arm has beside its own parameters (OperationCommand does it).
template <class P>
void add_common_parameters(ParameterTable<P>& table) {
  table.tool(&P::tool)
      .compliance(&P::compliance)
      .condition("abort_if", &P::abort_if, "Comes to rest and fails when this becomes true.");
}

}  // namespace takt::operations
