#include "core/net/unit_check.h"

#include <algorithm>
#include <deque>
#include <set>
#include <unordered_map>

#include <fmt/format.h>

#include "core/net/unit.h"

namespace takt::net {
namespace {

/// constant * product of unknowns to powers; = 1 when it is an equation.
struct Product {
  Dimension constant;
  std::vector<std::pair<int, Rational>> powers;  ///< by unknown, without zeros

  void multiply(int unknown, const Rational& power) {
    const auto place = std::ranges::lower_bound(powers, unknown, {}, &std::pair<int, Rational>::first);
    if (place == powers.end() || place->first != unknown) {
      powers.emplace(place, unknown, power);
      return;
    }
    place->second = place->second + power;
    if (place->second.zero()) powers.erase(place);
  }
  [[nodiscard]] bool valid() const {
    return constant.valid() && std::ranges::all_of(powers, [](const auto& p) { return p.second.valid(); });
  }
};

/// Unknowns in classes: each is factor * representative^power, and a representative may be known.
class Unknowns {
 public:
  int add() {
    entries_.push_back({static_cast<int>(entries_.size()), {1, 1}, {}, false, {}});
    return static_cast<int>(entries_.size()) - 1;
  }
  [[nodiscard]] int count() const { return static_cast<int>(entries_.size()); }

  /// Multiplies `product` by unknown^power, in terms of what is known so far.
  void substitute(int unknown, const Rational& power, Product& product) {
    compress(unknown);
    const Entry& entry = at(unknown);
    product.constant = product.constant.times(entry.factor, power);
    const Entry& root = at(entry.parent);
    const Rational root_power = entry.power * power;
    if (root.known) {
      product.constant = product.constant.times(root.value, root_power);
    } else {
      product.multiply(entry.parent, root_power);
    }
  }

  /// The representative, if the unknown equals it outright (power 1, factor 1); -1 otherwise.
  [[nodiscard]] int equal_root(int unknown) {
    compress(unknown);
    const Entry& entry = at(unknown);
    return entry.power == Rational{1, 1} && entry.factor.zero() ? entry.parent : -1;
  }

  /// representative = value
  void fix(int root, const Dimension& value) {
    at(root).known = true;
    at(root).value = value;
  }
  /// root = factor * other^power
  void join(int root, int other, const Rational& power, const Dimension& factor) {
    Entry& entry = at(root);
    entry.parent = other;
    entry.power = power;
    entry.factor = factor;
  }
  [[nodiscard]] bool open(int unknown) const { return at(unknown).parent == unknown && !at(unknown).known; }

 private:
  struct Entry {
    int parent;
    Rational power;
    Dimension factor;
    bool known;
    Dimension value;
  };
  Entry& at(int unknown) { return entries_[static_cast<std::size_t>(unknown)]; }
  [[nodiscard]] const Entry& at(int unknown) const { return entries_[static_cast<std::size_t>(unknown)]; }

  /// Makes the representative the direct parent of everything on the way to it.
  void compress(int unknown) {
    way_.clear();
    for (int u = unknown; at(u).parent != u; u = at(u).parent) way_.push_back(u);
    if (way_.size() < 2) return;
    for (auto u = way_.rbegin() + 1; u != way_.rend(); ++u) {
      Entry& entry = at(*u);
      const Entry& above = at(entry.parent);
      entry.factor = entry.factor.times(above.factor, entry.power);
      entry.power = entry.power * above.power;
      entry.parent = above.parent;
    }
  }

  std::vector<Entry> entries_;
  std::vector<int> way_;
};

class UnitChecker {
 public:
  UnitChecker(const FlatNet& flat, std::vector<NetReport::FreeUnit>& free_units, LoadReport& report)
      : flat_(flat), free_units_(free_units), report_(report) {}

  void run() {
    number_unknowns();
    for (std::size_t p = 0; p < flat_.signals.size(); ++p)
      if (flat_.signals[p] != nullptr) fix_signal(static_cast<int>(p));
    for (std::size_t l = 0; l < flat_.links.size(); ++l) add_link(static_cast<int>(l));
    solve();
    eliminate();
    note_free();
  }

 private:
  using Terms = std::vector<UnitTerm>;
  struct TypeUnits {
    std::vector<Terms> inputs, outputs;
    std::vector<char> variables;
  };
  struct Equation {
    int link;
    Product product;  ///< = 1, in terms of the representatives of the time it was last looked at
  };

  const TypeUnits& units_of(const PrimitiveInfo* info) {
    const auto [place, fresh] = types_.try_emplace(info);
    if (!fresh) return place->second;
    TypeUnits& units = place->second;
    const auto read = [&](const std::vector<PrimitiveInfo::Port>& ports, std::vector<Terms>& terms) {
      for (const auto& port : ports) {
        terms.push_back(parse_unit(port.spec.unit).value_or(Terms{}));
        for (const UnitTerm& term : terms.back()) {
          for (const auto& [name, power] : term.variables) {
            if (std::ranges::find(units.variables, name) == units.variables.end()) units.variables.push_back(name);
          }
        }
      }
    };
    read(info->inputs, units.inputs);
    read(info->outputs, units.outputs);
    return units;
  }

  void number_unknowns() {
    first_unknown_.resize(flat_.primitives.size());
    for (std::size_t p = 0; p < flat_.primitives.size(); ++p) {
      first_unknown_[p] = unknowns_.count();
      if (flat_.primitives[p].info == nullptr) continue;
      for (const char variable : units_of(flat_.primitives[p].info).variables) {
        owners_.emplace_back(static_cast<int>(p), variable);
        unknowns_.add();
      }
    }
    waiting_.resize(owners_.size());
  }

  /// The unit of a named resource stands for the variables u and v of the primitive; nothing waits for them yet.
  void fix_signal(int node) {
    const auto units = parse_unit(flat_.signals[static_cast<std::size_t>(node)]->unit);
    if (!units || units->empty()) return;
    for (const auto& [variable, term] : {std::pair{'u', units->front()}, std::pair{'v', units->back()}}) {
      const auto& variables = units_of(flat_.primitives[static_cast<std::size_t>(node)].info).variables;
      if (std::ranges::find(variables, variable) != variables.end())
        unknowns_.fix(number_of(node, variable), term.dimension);
    }
  }

  const Terms& terms(int node, int port, bool output) {
    const TypeUnits& units = units_of(flat_.primitives[static_cast<std::size_t>(node)].info);
    return (output ? units.outputs : units.inputs)[static_cast<std::size_t>(port)];
  }

  int number_of(int node, char variable) {
    const auto& variables = units_of(flat_.primitives[static_cast<std::size_t>(node)].info).variables;
    const auto index = std::ranges::find(variables, variable) - variables.begin();
    return first_unknown_[static_cast<std::size_t>(node)] + static_cast<int>(index);
  }

  void multiply(int node, const UnitTerm& term, const Rational& sign, Product& product) {
    product.constant = product.constant.times(term.dimension, sign);
    for (const auto& [name, power] : term.variables) unknowns_.substitute(number_of(node, name), power * sign, product);
  }

  void add_link(int number) {
    const FlatLink& link = flat_.links[static_cast<std::size_t>(number)];
    if (link.from < 0 || flat_.is_gate(link.to)) return;
    const Terms& from = terms(link.from, link.from_port, true);
    const Terms& to = terms(link.to, link.to_port, false);
    if (from.empty() || to.empty()) return;
    if (plainly_equal(link, from, to)) return;
    for (std::size_t i = 0; i < std::max(from.size(), to.size()); ++i) {
      Product product;
      multiply(link.from, from[std::min(i, from.size() - 1)], {1, 1}, product);
      multiply(link.to, to[std::min(i, to.size() - 1)], {-1, 1}, product);
      take({number, std::move(product)});
      solve();
    }
  }

  /// The common link, variable to variable, without the general machinery.
  bool plainly_equal(const FlatLink& link, const Terms& from, const Terms& to) {
    const auto lone = [](const Terms& terms) {
      return terms.size() == 1 && terms[0].variables.size() == 1 && terms[0].variables[0].second == Rational{1, 1} &&
             terms[0].dimension.zero();
    };
    if (!lone(from) || !lone(to)) return false;
    const int a = unknowns_.equal_root(number_of(link.from, from[0].variables[0].first));
    const int b = unknowns_.equal_root(number_of(link.to, to[0].variables[0].first));
    if (a < 0 || b < 0 || !unknowns_.open(a) || !unknowns_.open(b)) return false;
    if (a == b) return true;
    const bool fewer = waiting_[static_cast<std::size_t>(a)].size() <= waiting_[static_cast<std::size_t>(b)].size();
    settle(fewer ? a : b, [&] { unknowns_.join(fewer ? a : b, fewer ? b : a, {1, 1}, {}); });
    solve();
    return true;
  }

  /// Looks at an equation in terms of today's representatives: uses it up, or lets it wait for one of them.
  void take(Equation equation) {
    Product product;
    product.constant = equation.product.constant;
    for (const auto& [unknown, power] : equation.product.powers) unknowns_.substitute(unknown, power, product);
    equation.product = std::move(product);
    const Product& p = equation.product;
    if (!p.valid()) {
      report_.error(Code::kTooLarge, flat_.link_pointer(flat_.links[static_cast<std::size_t>(equation.link)]),
                    "the exponents of the units here grow without bound");
      return;
    }
    const std::size_t open = p.powers.size();
    if (open == 0) {
      if (!p.constant.zero()) contradiction(equation.link);
    } else if (open == 1) {
      const auto [root, power] = *p.powers.begin();
      settle(root, [&] { unknowns_.fix(root, inverse(p.constant, power)); });
    } else if (open == 2) {
      use_pair(p);
    } else {
      wait(std::move(equation));
    }
  }

  /// constant^(-1/power)
  static Dimension inverse(const Dimension& constant, const Rational& power) {
    return Dimension{}.times(constant, Rational{-1, 1} / power);
  }

  /// a^p * b^q * c = 1: the one that fewer equations wait for goes into the other.
  void use_pair(const Product& product) {
    auto [a, p] = *product.powers.begin();
    auto [b, q] = *product.powers.rbegin();
    if (waiting_[static_cast<std::size_t>(a)].size() > waiting_[static_cast<std::size_t>(b)].size()) {
      std::swap(a, b);
      std::swap(p, q);
    }
    const Rational power = -(q / p);
    const Dimension factor = inverse(product.constant, p);
    settle(a, [&] { unknowns_.join(a, b, power, factor); });
  }

  template <class Change>
  void settle(int root, Change change) {
    change();
    auto& list = waiting_[static_cast<std::size_t>(root)];
    for (const int equation : list) due_.push_back(equation);
    list.clear();
    list.shrink_to_fit();
  }

  void wait(Equation equation) {
    const int number = static_cast<int>(deferred_.size());
    for (const auto& [root, power] : equation.product.powers)
      waiting_[static_cast<std::size_t>(root)].push_back(number);
    deferred_.push_back(std::move(equation));
  }

  void solve() {
    while (!due_.empty()) {
      const int number = due_.front();
      due_.pop_front();
      Equation& equation = deferred_[static_cast<std::size_t>(number)];
      if (equation.link < 0) continue;  // taken already through another unknown
      Equation taken = std::move(equation);
      equation.link = -1;
      take(std::move(taken));
    }
  }

  /// What is left has three and more unknowns in every equation: Gaussian elimination, with an end to the work.
  void eliminate() {
    std::size_t work = 0;
    std::unordered_map<int, Product> pivots;  // unknown = product
    for (Equation& equation : deferred_) {
      if (equation.link < 0) continue;
      Product product;
      product.constant = equation.product.constant;
      std::vector<std::pair<int, Rational>> pending(equation.product.powers.begin(), equation.product.powers.end());
      while (!pending.empty() && work < kMostWork) {
        const auto [unknown, power] = pending.back();
        pending.pop_back();
        const auto pivot = pivots.find(unknown);
        if (pivot == pivots.end()) {
          product.multiply(unknown, power);
          ++work;
          continue;
        }
        product.constant = product.constant.times(pivot->second.constant, power);
        for (const auto& [other, other_power] : pivot->second.powers) pending.emplace_back(other, other_power * power);
        work += pivot->second.powers.size();
      }
      if (work >= kMostWork || !product.valid()) {
        report_.note({}, "the units of this net are too entangled: some products of units were not checked");
        return;
      }
      if (product.powers.empty()) {
        if (!product.constant.zero()) contradiction(equation.link);
        continue;
      }
      const auto [unknown, power] = *product.powers.rbegin();
      Product solved;
      solved.constant = inverse(product.constant, power);
      for (const auto& [other, other_power] : product.powers) {
        if (other != unknown) solved.multiply(other, -(other_power / power));
      }
      // A later pivot never stands in an earlier solution's place: substitution above replaces it on use.
      pivots.emplace(unknown, std::move(solved));
    }
  }

  /// The unit of one end as far as it is known: "m/s", or "m * unit of 'x.out'"-like with what stays open.
  std::string unit_text(int node, const Terms& all) {
    std::string text;
    for (const UnitTerm& term : all) {
      Product product;
      multiply(node, term, {1, 1}, product);
      text += (text.empty() ? "" : ",") + to_string(product.constant);
      for (const auto& [root, power] : product.powers) {
        const auto& [owner, variable] = owners_[static_cast<std::size_t>(root)];
        text += fmt::format(" * {} of '{}'", variable, flat_.id(owner));
        if (power != Rational{1, 1}) text += fmt::format(" ^ {}/{}", power.numerator, power.denominator);
      }
    }
    return text;
  }

  void contradiction(int number) {
    const FlatLink& link = flat_.links[static_cast<std::size_t>(number)];
    if (!reported_.insert(number).second) return;
    report_.error(
        Code::kUnitMismatch, flat_.link_pointer(link),
        fmt::format("unit mismatch: '{}' is {}{}, but '{}' accepts {}{}", flat_.output_name(link.from, link.from_port),
                    unit_text(link.from, terms(link.from, link.from_port, true)), flat_.declared_unit(link.from),
                    flat_.input_name(link.to, link.to_port), unit_text(link.to, terms(link.to, link.to_port, false)),
                    flat_.declared_unit(link.to)),
        "Link ports of one unit, or convert on purpose");
  }

  void note_free() {
    constexpr std::size_t kMostNotes = 16;
    std::size_t count = 0;
    for (int u = 0; u < unknowns_.count(); ++u) {
      if (!unknowns_.open(u)) continue;
      const auto& [owner, variable] = owners_[static_cast<std::size_t>(u)];
      free_units_.push_back({flat_.id(owner), std::string(1, variable)});
      if (++count > kMostNotes) continue;
      report_.note(flat_.primitive_pointer(owner),
                   fmt::format("nothing fixes the unit {} of '{}': dimensionless", variable, flat_.id(owner)));
    }
    if (count > kMostNotes) report_.note({}, fmt::format("{} more free units", count - kMostNotes));
  }

  static constexpr std::size_t kMostWork = 2'000'000;
  const FlatNet& flat_;
  std::vector<NetReport::FreeUnit>& free_units_;
  LoadReport& report_;
  std::unordered_map<const PrimitiveInfo*, TypeUnits> types_;
  std::vector<int> first_unknown_;
  std::vector<std::pair<int, char>> owners_;  ///< primitive and variable of each unknown
  Unknowns unknowns_;
  std::vector<Equation> deferred_;         ///< link -1: used up
  std::vector<std::vector<int>> waiting_;  ///< per unknown: numbers in deferred_
  std::deque<int> due_;
  std::set<int> reported_;
};

}  // namespace

void check_units(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  UnitChecker(flat, net_report.free_units, report).run();
}

}  // namespace takt::net
