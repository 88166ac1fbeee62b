#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/read_parts.h"
#include "core/expression/condition_state.h"
#include "core/operations/compliance.h"
#include "core/operations/parameter.h"
#include "core/operations/tool_choice.h"
#include "core/table/table.h"

namespace takt::activity {

/// A tool that a program names exists somewhere in the cell; where, is known when it is used.
void check_tool_name(const ToolChoice& choice, const ReadContext& from);

/// The table of the parameters of one operation (core/table/table.h), with rows for what belongs to a cell. Realtime:
/// setup.
template <class P>
class ParameterTable final : public table::BasicTable<P, ReadContext, ParameterTable<P>> {
  using Base = table::BasicTable<P, ReadContext, ParameterTable<P>>;
  template <class Access>
  static constexpr bool kOptional = Base::template kOptional<Access>;
  using Base::get;

 public:
  using Base::text;
  using typename Base::Read;
  using typename Base::Write;

  /// Reads the keys "do" and "name", all parameters, and reports keys that do not exist.
  /// @return what could be read; diagnostics of all that is wrong are in the reader
  [[nodiscard]] P read(ObjectReader& reader, const command::Cell& cell) const {
    P p;
    p.pointer = reader.pointer();
    (void)reader.text("do", "");
    p.name = read_name(reader, "");
    this->read_into(p, {reader, cell});
    for (const ParameterInfo& info : this->list()) {
      // Asked for once more, so that all keys of the operation are suggested for one that does not exist.
      if (!info.refused) (void)reader.child(info.key);
    }
    reader.finish();
    return p;
  }

  /// Parameters that a program has set, as if a file had them: names of the only one of its kind are filled in, rules
  /// applied. @return them; or what is wrong, as for a file with these values
  [[nodiscard]] Result<P> accept(P p, const command::Cell& cell) const {
    Diagnostics diagnostics;
    ParameterWriter writer;
    this->write(p, writer);
    ObjectReader reader(writer.result(), "", diagnostics);
    this->settle(p, {reader, cell});
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return p;
  }
  [[nodiscard]] Diagnostics check(const P& p, const command::Cell& cell) const {
    const auto accepted = accept(p, cell);
    return accepted ? Diagnostics() : accepted.error();
  }

  /// The name of something in the cell. Default: the only one of its kind. Of a std::optional: nothing if not given.
  template <class Access>
  ParameterTable& name(std::string_view key, NameOf what, Access access, std::string_view doc) {
    ParameterInfo info = table::field(key, ParameterInfo::Type::kName, doc);
    info.names = what;
    if constexpr (!kOptional<Access>) info.fallback = "the only one of the cell";
    return this->add(
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
          Base::template if_given<Access>(access, p, [&](const std::string& value) {
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
    ParameterInfo info = table::field(key, ParameterInfo::Type::kCondition, doc);
    info.definition = "condition";
    return this->add(std::move(info),
                     [access](const ParameterInfo& row, const ReadContext& from, P& p) {
                       std::invoke(access, p) = command::read_condition(from.reader, row.key, from.cell, row.required);
                     },
                     {}, {.is_given = [access](const P& p) { return get(access, p).has_value(); }});
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
    return this->rule([access](P& p, const ReadContext& from) { check_tool_name(get(access, p), from); });
  }

  /// How the arm yields meanwhile; nothing if the key is not there.
  template <class Access>
  ParameterTable& compliance(Access access) {
    return this->add(compliance_parameter(),
                     [access](const ParameterInfo&, const ReadContext& from, P& p) {
                       std::invoke(access, p) = read_compliance(from.reader);
                     },
                     {}, {.is_given = [access](const P& p) { return get(access, p).has_value(); }});
  }
};

/// What every operation that moves an arm has beside its own parameters (OperationCommand does it).
template <class P>
void add_common_parameters(ParameterTable<P>& table) {
  table.tool(&P::tool)
      .compliance(&P::compliance)
      .condition("abort_if", &P::abort_if, "Comes to rest and fails when this becomes true.");
}

}  // namespace takt::activity
