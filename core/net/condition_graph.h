#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/net/flat_net.h"
#include "core/net/formula.h"

namespace takt::net {

/// The conditions that activate fragments as a graph of gates over what LOAD cannot analyse, of one cycle. Built for
/// the fragments that are asked for and what they depend on in the same cycle. Private to core/net. Realtime: setup.
class ConditionGraph {
 public:
  /// Each condition is true, false or null; and of each pair of operands `a` comes first.
  struct Condition {
    enum class Kind {
      kUnknown,  ///< a sensor, a latch, a comparison, a delayed link: anything
      kTrue,
      kFalse,
      kSame,    ///< a
      kNot,     ///< of a
      kAnd,     ///< Kleene's, of a and b
      kOr,      ///< likewise
      kWhile,   ///< a; null unless b is true
      kActive,  ///< true if both are true, else false
    };
    Kind kind = Kind::kUnknown;
    int a = -1, b = -1;
  };

  explicit ConditionGraph(const FlatNet& flat);

  /// The condition that is true while the primitive runs: its fragment and all around it are active.
  [[nodiscard]] int running(int primitive);
  [[nodiscard]] const std::vector<Condition>& conditions() const { return conditions_; }
  /// All conditions, operands before what they are operands of (as far as there are no cycles).
  [[nodiscard]] std::vector<int> in_order() const;

 private:
  using Kind = Condition::Kind;

  int add(const Condition& condition);
  int constant(bool value) { return add({.kind = value ? Kind::kTrue : Kind::kFalse}); }
  int running_fragment(int fragment);
  int signal(int output);
  int input(int node, int port);
  int memory(const FlatLink& link);
  void expand_pending();
  void expand(int output);
  int formula(const Formula& formula, int node);
  int step(const Formula::Step& step, int node, std::vector<int>& stack);
  const Formula* formula_of(int node, int port);

  const FlatNet& flat_;
  std::vector<Condition> conditions_;
  std::vector<int> signals_, fragments_;  ///< condition of each output and fragment; -1: not there yet
  std::vector<int> pending_;              ///< outputs whose condition is there and not expanded yet
  std::map<std::pair<std::pair<int, int>, std::string>, int>
      memories_;  ///< of delayed links: source, fragment, initial
  std::map<std::pair<const PrimitiveInfo*, int>, std::optional<Formula>> formulas_;
};

}  // namespace takt::net
