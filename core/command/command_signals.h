#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/command/awaited_starts.h"
#include "core/command/mapping_context.h"

namespace takt::command {

class CommandFragments;
class HandlerSignals;

/// The life of each command as signals of the net: started, active, cancelled, done ... A signal is written when it is
/// first asked for. Its port has a name before what it depends on is written, so loops through delayed links need no
/// order. Part of the mapping. Realtime: setup.
class CommandSignals {
 public:
  /// The references may be to parts that are not constructed yet.
  CommandSignals(MappingContext& context, CommandFragments& fragments, HandlerSignals& handlers);

  [[nodiscard]] expression::Signal started(int i);
  /// Started, and not by a cancel of its transaction.
  [[nodiscard]] expression::Signal begun(int i);
  /// Started, and not ended in a cycle before.
  [[nodiscard]] expression::Signal running(int i);
  /// Running, and not stopped.
  [[nodiscard]] expression::Signal wants(int i);
  /// It wants to run, and no earlier command has its devices.
  [[nodiscard]] expression::Signal active(int i);
  [[nodiscard]] expression::Signal stop(int i);
  /// The request; null counts as true.
  [[nodiscard]] expression::Signal cancel(int i);
  /// What brings its action to rest: a cancel, and a stop of what moves.
  [[nodiscard]] expression::Signal brake(int i);
  /// It was requested while the command ran.
  [[nodiscard]] expression::Signal cancelled(int i);
  [[nodiscard]] expression::Signal done(int i);
  /// It is done, or a stop has ended it.
  [[nodiscard]] expression::Signal ends(int i, const char* what = "ends");
  [[nodiscard]] expression::Signal ended(int i);
  /// The tree is over: the end of the net.
  [[nodiscard]] expression::Signal over();
  /// It was started by what a cancel of its transaction has led to, so that the cancel does not concern it (rule C4).
  [[nodiscard]] expression::Signal cleans_up(int i);
  /// Something runs, or may still start, that a cancel of the tree does not end.
  [[nodiscard]] expression::Signal goes_on();
  /// By name: "started", "active", "stopped", "cancelled", "failed", "timed_out", "completed".
  [[nodiscard]] expression::Signal state(int i, const std::string& name);

  /// Commands with actions that share a device with this one and come before it.
  [[nodiscard]] std::vector<int> rivals_before(int i) const;

 private:
  struct Ports {
    std::optional<expression::Signal> started, begun, ended, stop, cancel, cancelled, active, done, met, failed,
        cleans_up;
  };
  /// The commands on one device in their order, and as far as it is written: one of the first so many is active.
  struct Turns {
    std::vector<int> commands;
    std::vector<expression::Signal> taken{expression::Signal::always(false)};
  };
  [[nodiscard]] Ports& at(int i) { return ports_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const CommandNode& node(int i) const { return context_.node(i); }
  [[nodiscard]] int parent(int i) const { return context_.tree.at(i).parent; }
  [[nodiscard]] int rank(int i) const { return ranks_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool moves(int i) const;
  [[nodiscard]] bool brakes_when_stopped(int i) const;

  [[nodiscard]] expression::Signal taken_before(int i, Turns& turns);
  [[nodiscard]] expression::Signal busy(int i);
  [[nodiscard]] expression::Signal stopped(int i);
  [[nodiscard]] expression::Signal memory(int i, const char* what, const expression::Signal& request);
  [[nodiscard]] expression::Signal forwarded(int i);
  [[nodiscard]] bool has_timeout(int i) const { return node(i).until && node(i).seconds; }
  [[nodiscard]] expression::Signal ended_in_order(int i);
  [[nodiscard]] expression::Signal completed(int i);
  [[nodiscard]] expression::Signal failed(int i);
  [[nodiscard]] expression::Signal failed_itself(int i);
  [[nodiscard]] expression::Signal met(int i);
  [[nodiscard]] expression::Signal timed_out(int i);
  [[nodiscard]] expression::Signal wait_done(int i);
  [[nodiscard]] expression::Signal transaction_done(int i);
  [[nodiscard]] bool is_delayed_start_in(int transaction, const EventHandler& handler) const;

  MappingContext& context_;
  expression::NetWriter& writer_;
  CommandFragments& fragments_;
  HandlerSignals& handlers_;
  AwaitedStarts awaited_;
  std::vector<int> ranks_;
  std::set<int> heard_ends_;
  std::map<std::string, Turns> turns_;  ///< by device
  std::vector<Ports> ports_;
};

}  // namespace takt::command
