#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/net/bdd.h"
#include "core/net/flat_net.h"
#include "core/net/formula.h"

namespace takt::net {

/// What LOAD can say about when fragments run and values are there, as Boolean functions of what it cannot look into:
/// sensors, states, comparisons with numbers (row O4). Made for one question at a time, so that its size is bounded by
/// the question and not by the net. Private to core/net.
///
/// Every function is an upper bound: where it is false, the thing cannot be. What exceeds a bound of this class
/// becomes "may be anything", so two functions that exclude each other always do so in the running net too. Delayed
/// links are followed into the cycles before. Realtime: setup.
class Activation {
 public:
  explicit Activation(const FlatNet& flat);

  /// When the primitive runs: its fragment and all around it are active.
  [[nodiscard]] Bdd::Ref running(int primitive);
  /// When a value other than null can arrive at the input.
  [[nodiscard]] Bdd::Ref present_at(int primitive, int port);

  /// Whether the two can never be at the same time. False also where the bounds do not suffice.
  [[nodiscard]] bool exclude(Bdd::Ref a, Bdd::Ref b);
  /// When both can be, in words: "'x.value' is true and 'y.value' is null".
  [[nodiscard]] std::string example(Bdd::Ref a, Bdd::Ref b);
  [[nodiscard]] bool gave_up() const { return bdd_.overflowed() || memo_.size() > kMostItems; }
  [[nodiscard]] std::size_t work() const { return bdd_.work() + memo_.size(); }

 private:
  static constexpr std::size_t kMostItems = 4000;
  static constexpr std::size_t kMostNodes = 100'000;
  static constexpr int kMostCyclesBack = 4;

  /// When a Boolean can be true, false and null.
  struct Tristate {
    Bdd::Ref yes = Bdd::kTrue, no = Bdd::kTrue, null = Bdd::kTrue;
  };
  enum class What { kSignal, kRunning, kPresent };
  /// What is asked for: an output (kSignal, kPresent) or a fragment, so many cycles back.
  struct Item {
    What what;
    int index, back;
    auto operator<=>(const Item&) const = default;
  };
  /// Something LOAD cannot look into: an output, or the memory of a delayed link.
  struct Origin {
    int output = -1, back = 0;
    int owner = -1;       ///< of a delayed link: its fragment; of an unknown part of a meaning: kPart
    std::string initial;  ///< of a delayed link
    auto operator<=>(const Origin&) const = default;
  };
  static constexpr int kPart = -2;
  using Number = std::pair<Origin, Origin>;  ///< a number, or the difference of two
  using Cut = std::pair<double, int>;        ///< {c, 0}: below c; {c, 1}: at most c
  struct Cuts {
    Bdd::Ref null;
    std::map<Cut, Bdd::Ref> below;
  };
  struct Operand {
    std::optional<double> constant;
    std::optional<Origin> origin;
    int node = -1;  ///< that gives it in this cycle; -1: a memory
    bool integer = false;
  };

  const Tristate& resolve(const Item& item);
  Tristate evaluate(const Item& item);
  const Tristate& look(const Item& item);

  Tristate signal(int output, int back);
  Tristate running_fragment(int fragment, int back);
  Tristate present(int output, int back);

  Tristate read(int node, int port, int back);
  Bdd::Ref present_input(int node, int port, int back);
  Tristate meaning(const Formula& formula, int node, int output, int back);
  Tristate step(const Formula::Step& step, int node, int output, int back, std::vector<Tristate>& stack);
  Tristate compare(const Formula::Step& step, int node, int back);
  Tristate is_null(int node, int port, int back);
  Operand operand(const FormulaNumber& number, int node, int back);
  Tristate merged(int node, int back);

  Tristate atom(const Origin& origin);
  Cuts& cuts(const Number& number);
  Bdd::Ref cut(Cuts& cuts, Cut at, bool integer);
  void keep_exclusive(const Origin& origin);
  Bdd::Ref first(int back);
  const Formula* formula_of(int node, int port);

  Tristate both(const Tristate& a, const Tristate& b);
  Tristate either(const Tristate& a, const Tristate& b);
  Tristate otherwise(const Tristate& a, const Tristate& b);
  static Tristate opposite(const Tristate& a) { return {a.no, a.yes, a.null}; }
  static Tristate constant(bool value) { return {value, !value, Bdd::kFalse}; }
  Tristate gated(Tristate value, const Tristate& running);

  [[nodiscard]] int node_of(int output) const;
  [[nodiscard]] const FlatLink* link_into(int node, int port) const;
  [[nodiscard]] Origin memory(const FlatLink& link, int back) const;
  [[nodiscard]] bool ever_rests(int fragment) const {
    return flat_.fragments[static_cast<std::size_t>(fragment)].gated;
  }
  [[nodiscard]] int output_number(int node, int port) const {
    return flat_.output_base[static_cast<std::size_t>(node)] + port;
  }

  const FlatNet& flat_;
  Bdd bdd_;
  Bdd::Ref world_ = Bdd::kTrue;  ///< what always holds: cuts are nested, exclusive outputs exclude each other
  std::map<Item, Tristate> memo_;
  std::vector<Item> missing_;
  std::map<Origin, std::pair<Bdd::Ref, Bdd::Ref>> atoms_;  ///< null, value
  std::map<Number, Cuts> numbers_;
  std::map<int, Bdd::Ref> first_;
  std::map<std::pair<const PrimitiveInfo*, int>, std::optional<Formula>> formulas_;
  /// Per variable: what it says when true and when false.
  std::map<int, std::pair<std::string, std::string>> words_;
};

}  // namespace takt::net
