#pragma once

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/read_parts.h"
#include "core/operations/table/parameter.h"

namespace takt::operations {

/// What is done with the parameters of an operation, whatever they are: they are read from a file, written as a file
/// would have them, and accepted from a program with the same checks. ParameterTable describes them. Realtime: setup.
template <class P>
class ParameterRows {
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

  /// Reads the keys "do" and "name", all parameters, and reports keys that do not exist.
  /// @return what could be read; diagnostics of all that is wrong are in the reader
  [[nodiscard]] P read(ObjectReader& reader, const expression::Cell& cell) const {
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
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].read(infos_[i], from, p);
    for (const auto& check : rules_) check(p, from);
  }

  /// As a file would have it.
  void write(const P& p, ParameterWriter& to) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].write(infos_[i], p, to);
  }

  /// Parameters that a program has set, as if a file had them: names of the only one of its kind are filled in, rules
  /// applied. @return them; or what is wrong, as for a file with these values
  [[nodiscard]] Result<P> accept(P p, const expression::Cell& cell) const {
    Diagnostics diagnostics;
    ParameterWriter writer;
    write(p, writer);
    ObjectReader reader(writer.result(), "", diagnostics);
    settle(p, reader, cell);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return p;
  }
  [[nodiscard]] Diagnostics check(const P& p, const expression::Cell& cell) const {
    const auto accepted = accept(p, cell);
    return accepted ? Diagnostics() : accepted.error();
  }
  /// The same for an object inside of an operation. @param reader  of what write() made of it
  void settle(P& p, ObjectReader& reader, const expression::Cell& cell) const {
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

 protected:
  void add_row(ParameterInfo info, Read read, Write write, InPrograms in_programs) {
    infos_.push_back(std::move(info));
    rows_.push_back({std::move(read), std::move(write), std::move(in_programs)});
  }
  void add_rule(std::function<void(P&, const ReadContext&)> check) { rules_.push_back(std::move(check)); }
  /// The row that was added last.
  [[nodiscard]] ParameterInfo& last() { return infos_.back(); }

 private:
  struct Row {
    Read read;
    Write write;
    InPrograms in_programs;
  };

  std::vector<ParameterInfo> infos_;
  std::vector<Row> rows_;
  std::vector<std::function<void(P&, const ReadContext&)>> rules_;
};

}  // namespace takt::operations
