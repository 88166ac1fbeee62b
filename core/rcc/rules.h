#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "core/net/primitive.h"
#include "core/net/value.h"
#include "core/rcc/net_state.h"

namespace takt::rcc {

/// A request or a rule, by number; given back by the function that posts it and named in its events. 0 is none.
using RequestId = std::uint64_t;

/// A few nets; a fixed capacity keeps requests trivially copyable.
struct NetSet {
  static constexpr int kCapacity = 16;
  std::array<NetId, kCapacity> ids{};
  int size = 0;

  NetSet() = default;
  /// More than there is room for does not compile.
  template <std::convertible_to<NetId>... Ids>
  requires(sizeof...(Ids) > 0 && sizeof...(Ids) <= std::size_t{kCapacity}) NetSet(Ids... list)
      : ids{static_cast<NetId>(list)...}, size(static_cast<int>(sizeof...(Ids))) {}
  /// @return false if there is no room: the net is not in the set.
  [[nodiscard]] bool add(NetId id) {
    if (size == kCapacity) return false;
    ids[static_cast<std::size_t>(size++)] = id;
    return true;
  }
  [[nodiscard]] const NetId* begin() const { return ids.data(); }
  [[nodiscard]] const NetId* end() const { return ids.data() + size; }
  [[nodiscard]] bool contains(NetId id) const {
    for (const NetId one : *this)
      if (one == id) return true;
    return false;
  }
};

/// What happens in one cycle, wholly or not at all: first all aborts, then all cancels, ends and starts (row L2). Nets
/// that are started together run their first cycle together. A net that is to be started and aborted, cancelled or
/// ended in one transaction refuses it: both cannot be.
///
/// A net in `end` has its last cycle: what it proposed is sent, then it is Terminated, cause "taken over", and its
/// devices are free for the nets in `start`. It may be in motion; a device that would go on moving with nobody to hold
/// it makes the whole transaction impossible (row L8).
struct Transaction {
  NetSet abort = {}, cancel = {}, start = {}, end = {};

  [[nodiscard]] bool empty() const { return abort.size + cancel.size + start.size + end.size == 0; }
};

/// One part of a condition: a net is in one of some states, a Boolean port of a net is true, or a Real port lies in a
/// range (null counts as false).
struct Term {
  NetId net = 0;
  std::uint8_t states = 0;                        ///< set of NetState, by bit; 0: the port decides
  const net::Slot<net::Boolean>* port = nullptr;  ///< an output of that net, read while the net is active
  const net::Slot<net::Real>* real = nullptr;     ///< likewise, if there is no Boolean
  double lower = 0.0, upper = 0.0;                ///< both inside

  [[nodiscard]] static Term state(NetId net, std::initializer_list<NetState> states) {
    Term term{.net = net};
    for (const NetState s : states) term.states |= static_cast<std::uint8_t>(1u << static_cast<unsigned>(s));
    return term;
  }
  [[nodiscard]] static Term output(NetId net, const net::Slot<net::Boolean>* port) {
    return {.net = net, .port = port};
  }
  [[nodiscard]] static Term in_range(NetId net, const net::Slot<net::Real>* real, double lower, double upper) {
    return {.net = net, .real = real, .lower = lower, .upper = upper};
  }
};

/// All terms hold. No terms: true at once.
struct Condition {
  /// A blend out of a motion needs two terms, and as many motions as a NetSet holds nets may be left in one cycle.
  static constexpr int kCapacity = 2 * NetSet::kCapacity;
  std::array<Term, kCapacity> terms{};
  int size = 0;

  Condition() = default;
  /// More than there is room for does not compile.
  template <std::same_as<Term>... Terms>
  requires(sizeof...(Terms) > 0 && sizeof...(Terms) <= std::size_t{kCapacity}) Condition(const Terms&... all)
      : terms{all...}, size(static_cast<int>(sizeof...(Terms))) {}
  /// @return false if there is no room: the condition does not hold what it should, and must not be posted.
  [[nodiscard]] bool add(const Term& term) {
    if (size == kCapacity) return false;
    terms[static_cast<std::size_t>(size++)] = term;
    return true;
  }
};

/// A synchronisation rule: in the first cycle in whose snapshot the condition holds, the transaction is carried out,
/// wholly or not at all, and the rule is gone. A refusal is an event with its reason. A start that lacks only a change
/// of control mode at standstill asks for the change and waits for it, at most kAnswerTimeout cycles.
/// A rule may bring a second transaction for the case that the first one is refused, because a seam does not fit or
/// for any other reason (row L3), or that its condition can never hold any more. It is carried out as soon as all
/// devices of the nets that it starts are at rest and held by nobody; if that takes longer than kAnswerTimeout cycles,
/// counted from the end of the nets that the rule is about, it is refused too.
struct Rule {
  static constexpr std::int64_t kAnswerTimeout = 10'000;

  Condition condition = {};
  Transaction action;
  Transaction otherwise = {};
};

/// What happened to a net, a request or an arm in a cycle.
struct Event {
  enum class Kind : std::uint8_t {
    kState,    ///< `net` came into `state`; `cause` says why it ended
    kDone,     ///< `request` was carried out; `cause.text`: why it was its second transaction, if it was
    kRefused,  ///< `request` was not carried out at all; `cause.text` says why, `net` names the net it failed on
    kStopped   ///< an arm began its stop reaction; `cause.text` names it
  };
  Kind kind = Kind::kState;
  NetState state = NetState::kLoading;
  NetId net = 0;
  RequestId request = 0;
  net::Cause cause;
  std::int64_t cycle = -1;  ///< in which it happened
};

}  // namespace takt::rcc
