#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/expression/expression.h"
#include "core/net/description.h"

namespace takt::expression {

/// A Boolean of the net that is being written: a constant, or a port, maybe as it was one cycle ago (false before).
struct Signal {
  std::optional<bool> constant;
  std::string port;
  bool delayed = false;

  [[nodiscard]] static Signal always(bool value) { return {.constant = value, .port = {}}; }
  [[nodiscard]] static Signal at(std::string port) { return {.constant = std::nullopt, .port = std::move(port)}; }
  [[nodiscard]] Signal one_cycle_ago() const { return {.constant = constant, .port = port, .delayed = !constant}; }
  [[nodiscard]] bool is(bool value) const { return constant == value; }
};

/// Writes a net: gates that fold constants, formulas that become their primitives once however many use them, and the
/// knowledge of who depends on whom. Used by the mapping (mapping.h); knows no device. Realtime: setup.
class NetWriter {
 public:
  /// The port of a leaf of a formula in the net; Booleans may be constant.
  using LeafSource = std::function<Signal(const Expression&)>;

  explicit NetWriter(Nanoseconds period = kMillisecond, LeafSource leaves = {})
      : period_(period), leaves_(std::move(leaves)) {}
  NetWriter(const NetWriter&) = delete;
  NetWriter& operator=(const NetWriter&) = delete;

  net::NetDescription net;

  [[nodiscard]] Nanoseconds period() const { return period_; }

  /// An id like the preferred one that no other part of the net has: what ids may not hold becomes '_', and the second
  /// of a name gets a number.
  [[nodiscard]] std::string unique(std::string_view preferred);
  /// Adds a primitive. The id is from unique().
  void add(const std::string& id, std::string type,
           nlohmann::ordered_json parameters = nlohmann::ordered_json::object(),
           nlohmann::ordered_json on_null = nlohmann::ordered_json::object());
  /// Links two ports of the outermost level, or inside of fragments by their full names. By value: a name may be that
  /// of a link of this net, which moves when another one is added.
  void link(std::string from, std::string to);
  /// Links, or sets the constant.
  void feed(const Signal& signal, const std::string& to);
  void feed(const ExpressionPtr& node, const std::string& to);
  /// A signal and the port that it is to feed.
  struct Feed {
    Signal signal;
    std::string to;
  };
  /// Links signals, one after the other, without closing a cycle: where a port depends on what it would feed, the link
  /// is delayed by one cycle.
  void feed_without_cycles(const std::vector<Feed>& feeds);

  // Gates; constants are folded, so there may be none.
  [[nodiscard]] Signal both(const std::string& id, const Signal& a, const Signal& b);
  [[nodiscard]] Signal either(const std::string& id, const Signal& a, const Signal& b);
  [[nodiscard]] Signal opposite(const Signal& a);
  /// All of them one after the other.
  [[nodiscard]] Signal any(const std::string& id, const std::vector<Signal>& signals);
  /// `a`, but false while `condition` is not true; null of `a` stays null.
  [[nodiscard]] Signal only_while(const std::string& id, const Signal& condition, const Signal& a);
  /// Remembers that `set` was true. @param null_sets  what null there counts as
  [[nodiscard]] Signal latch(const std::string& id, const Signal& set, bool null_sets);

  /// The port of a formula, which is written if it is not there yet. No faults, not deeper than kMostDepth.
  std::string port_of(const ExpressionPtr& node);
  /// The same of a Boolean one, which may be constant.
  Signal signal_of(const ExpressionPtr& node);

  /// The node that a port belongs to: the text before '.' or '/'.
  [[nodiscard]] static std::string node_of(const std::string& port);

 private:
  /// Numbers of primitives and fragments by who reads whom in the same cycle.
  [[nodiscard]] int number_of(const std::string& node);
  /// What cannot be reached inside of one strong component is not searched for.
  [[nodiscard]] bool reaches(int from, int to, const std::vector<int>& component) const;
  [[nodiscard]] std::vector<int> components_with(const std::vector<std::pair<int, int>>& more) const;
  Signal gate(const std::string& id, const char* type, const Signal& a, const Signal& b);
  std::string port_of_signal(const Signal& signal);
  std::string write(const ExpressionPtr& node);
  void set_parameter(const std::string& to, nlohmann::ordered_json value);

  Nanoseconds period_;
  LeafSource leaves_;
  std::set<std::string, std::less<>> ids_;
  std::map<const Expression*, std::string> written_;     ///< node, port
  std::map<std::string, std::string> primitives_;        ///< what a primitive says, its id
  std::map<std::string, int, std::less<>> next_number_;  ///< of ids that are like a preferred one
  std::unordered_map<std::string, int> numbers_;
  std::vector<std::vector<int>> followers_;  ///< by number
  std::vector<ExpressionPtr> kept_;          ///< addresses in `written_` stay
};

/// Writes the inside of a fragment.
class FragmentWriter {
 public:
  /// Makes a fragment of this id, from unique(), in the net of the writer.
  FragmentWriter(NetWriter& outside, std::string id, Signal cancel);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] NetWriter& outside() { return outside_; }
  [[nodiscard]] Nanoseconds period() const { return outside_.period(); }
  /// Someone asks for an end; a port of the outside.
  [[nodiscard]] const Signal& cancel() const { return cancel_; }

  void add(const std::string& id, std::string type,
           nlohmann::ordered_json parameters = nlohmann::ordered_json::object());
  void link(const std::string& from, const std::string& to);
  /// One cycle late; `initial` before.
  void link_delayed(const std::string& from, const std::string& to, nlohmann::ordered_json initial);
  /// The same ports of two primitives.
  void link_all(const std::string& from, const std::string& to, std::initializer_list<const char*> ports);
  /// From the outside to an input in here.
  void feed(const Signal& signal, const std::string& to);
  void feed(const ExpressionPtr& node, const std::string& to);
  /// A gate in here over a port in here and the cancel from the outside.
  std::string gate_with_cancel(const std::string& id, const char* type, const std::string& port);
  void set_parameter(const std::string& id, const std::string& name, nlohmann::ordered_json value);
  /// A Boolean that is true while what feeds an input in here is null; never, if that is a constant.
  [[nodiscard]] std::string add_null_test(const std::string& input, net::ValueType type);
  /// Takes out the link inside of here that feeds an input, so that something can be put between. @return what fed it.
  std::string take_link(const std::string& to);
  /// A fragment inside of this one.
  void nest(net::FragmentDescription fragment);
  /// The name of an inner port from the outside.
  [[nodiscard]] std::string outer(const std::string& port) const { return id_ + "/" + port; }
  [[nodiscard]] bool has(const std::string& id) const { return !type_of(id).empty(); }
  /// Of a primitive in here; empty: there is none of this id.
  [[nodiscard]] std::string_view type_of(const std::string& id) const;

 private:
  [[nodiscard]] net::NetDescription& net() { return outside_.net.fragments[place_].net; }

  NetWriter& outside_;
  std::string id_;
  Signal cancel_;
  std::size_t place_;
};

}  // namespace takt::expression
