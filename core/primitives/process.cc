// Family "process": a process that has to run where a path is followed.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/timing.h"

namespace takt::primitives {
namespace {

using namespace net;

/// Starts a process, lets a path clock run only while it runs, and starts it again with an overlap after a break. The
/// clock's outputs come back through delayed links.
class ProcessOnPath final : public Primitive {
 public:
  explicit ProcessOnPath(Setup& setup)
      : running_(
            setup.in<Boolean>("running", {.doc = "the process runs; null: it does not", .on_null = OnNull::kHandled})),
        cancel_(setup.in<Boolean>("cancel", {.doc = "end in order; null counts as true", .on_null = OnNull::kHandled})),
        speed_(setup.in<Real>("speed", {.unit = "1",
                                        .doc = "what people want: above 0 the path is followed as planned, at 0 and "
                                               "null there is a break",
                                        .on_null = OnNull::kHandled})),
        time_(setup.in<Real>("time", {.unit = "s", .doc = "path time, one cycle ago", .on_null = OnNull::kHandled})),
        at_end_(setup.in<Boolean>("at_end",
                                  {.doc = "the path clock is at its end, one cycle ago", .on_null = OnNull::kHandled})),
        standstill_(setup.in<Boolean>("standstill",
                                      {.doc = "the path clock rests, one cycle ago", .on_null = OnNull::kHandled})),
        rate_(setup.out<Real>("rate", {.unit = "1",
                                       .doc = "target rate of the path clock: 1, 0, or -1 on the way "
                                              "back to where the process starts again"})),
        process_(setup.out<Boolean>("process", {.doc = "the process is wanted"})),
        done_(setup.out<Boolean>("done", {.doc = "all is over: the process is off and the clock rests"})),
        not_started_(setup.out<Boolean>("not_started", {.doc = "it did not start in time"})),
        lost_(setup.out<Boolean>("lost", {.doc = "it went out, and was not to start again"})),
        starts_(setup.out<Integer>("starts", {.doc = "how often it has been started"})),
        start_timeout_(setup.parameter<Real>(
            "start_timeout", {.unit = "s", .doc = "within which it has to run", .range = "[0,inf)", .example = "1.0"})),
        finish_time_(setup.parameter<Real>(
            "finish_time", 0.0,
            {.unit = "s", .doc = "that it goes on at rest at the end, and after a cancel", .range = "[0,inf)"})),
        overlap_(setup.parameter<Real>(
            "overlap", 0.0,
            {.unit = "s", .doc = "path time by which it starts again before where it went out", .range = "[0,inf)"})),
        restarts_(setup.parameter<Integer>(
            "restarts", Integer{0}, {.doc = "how often it is started again where it went out", .range = "[0,1000]"})) {
    setup.costs(30.0);
    for (const char* in : {"running", "cancel", "speed", "time", "at_end", "standstill"})
      for (const char* out : {"process", "done", "not_started", "lost", "starts"})
        setup.latency(in, out, {.cycles = 0, .data_dependent = true});
  }

  void update(const Cycle& cycle) override {
    if (cycle.first) state_ = State{};
    dt_ = cycle.dt;
    const bool stop = cycle.stop_requested, cancel = cancel_.value_or(true) || stop;
    const bool held = !(speed_.value_or(0.0) > 0.0);
    step(stop, cancel, held);
    rate_.set(state_.rate);
    process_.set(state_.process);
    done_.set(state_.phase == Phase::kDone);
    not_started_.set(state_.not_started);
    lost_.set(state_.lost);
    starts_.set(state_.starts);
  }

 private:
  enum class Phase : std::uint8_t {
    kWaiting,    ///< a break before a start; the clock rests
    kStarting,   ///< the process is wanted and does not run yet
    kRunning,    ///< the path is followed
    kStopping,   ///< the process is off, the clock comes to rest
    kReturning,  ///< back on the path
    kSettling,   ///< the clock comes to rest where the process starts again
    kBraking,    ///< cancelled: the process runs until the clock rests
    kFinishing,  ///< it goes on at rest
    kEnding,     ///< it is off, the clock comes to rest
    kDone
  };
  struct State {
    Phase phase = Phase::kWaiting;
    double rate = 0.0, timer = 0.0, mark = 0.0;
    bool process = false, not_started = false, lost = false;
    std::int64_t starts = 0, restarts = 0;
  };

  void enter(Phase phase, double rate, bool process) {
    state_.phase = phase;
    state_.rate = rate;
    state_.process = process;
    state_.timer = 0.0;
  }
  [[nodiscard]] bool rests() const { return standstill_.value_or(false); }
  /// The time of this phase is over; it counts this cycle.
  [[nodiscard]] bool over(double time) {
    const bool is_over = state_.timer >= time - 0.5 * dt_;
    state_.timer += dt_;
    return is_over;
  }

  void step(bool stop, bool cancel, bool held) {
    const bool running = running_.value_or(false);
    switch (state_.phase) {
      case Phase::kWaiting:
        if (cancel) return enter(Phase::kDone, 0.0, false);
        if (held) return;
        ++state_.starts;
        enter(Phase::kStarting, 0.0, true);
        [[fallthrough]];
      case Phase::kStarting:
        return start(cancel, held, running);
      case Phase::kRunning:
        return run(stop, cancel, held, running);
      case Phase::kStopping:
        if (cancel) return enter(Phase::kEnding, 0.0, false);
        if (held || !rests()) return;
        return enter(Phase::kReturning, 0.0, false);
      case Phase::kReturning:
        return go_back(cancel, held);
      case Phase::kSettling:
        if (cancel) return enter(Phase::kEnding, 0.0, false);
        if (rests()) enter(Phase::kWaiting, 0.0, false);
        return;
      case Phase::kBraking:
        if (stop || !running) return enter(Phase::kEnding, 0.0, false);
        if (rests()) finish(running);
        return;
      case Phase::kFinishing:
        return finish(running && !stop);
      case Phase::kEnding:
        if (rests()) enter(Phase::kDone, 0.0, false);
        return;
      case Phase::kDone:
        return;
    }
  }

  void start(bool cancel, bool held, bool running) {
    if (cancel) return enter(Phase::kEnding, 0.0, false);
    if (held) return enter(Phase::kWaiting, 0.0, false);
    if (running) return enter(Phase::kRunning, 1.0, true);
    if (!over(start_timeout_)) return;
    state_.not_started = true;
    enter(Phase::kEnding, 0.0, false);
  }

  void run(bool stop, bool cancel, bool held, bool running) {
    state_.mark = time_.value_or(0.0);
    if (stop) return enter(Phase::kEnding, 0.0, false);
    if (at_end_.value_or(false)) {
      enter(Phase::kFinishing, 0.0, true);
      return finish(running);
    }
    if (!running) {
      if (cancel || state_.restarts++ >= restarts_) {
        state_.lost = true;
        return enter(Phase::kEnding, 0.0, false);
      }
      return enter(Phase::kStopping, 0.0, false);
    }
    if (cancel) return enter(Phase::kBraking, 0.0, true);
    if (held) enter(Phase::kStopping, 0.0, false);
  }

  void go_back(bool cancel, bool held) {
    if (cancel) return enter(Phase::kEnding, 0.0, false);
    const double goal = std::max(0.0, state_.mark - overlap_);
    if (time_.value_or(0.0) <= goal) return enter(Phase::kSettling, 0.0, false);
    state_.rate = held ? 0.0 : -1.0;
  }

  void finish(bool running) {
    if (state_.phase != Phase::kFinishing) enter(Phase::kFinishing, 0.0, true);
    if (!running || over(finish_time_)) enter(Phase::kDone, 0.0, false);
  }

  In<Boolean> running_, cancel_;
  In<Real> speed_, time_;
  In<Boolean> at_end_, standstill_;
  Out<Real> rate_;
  Out<Boolean> process_, done_, not_started_, lost_;
  Out<Integer> starts_;
  double start_timeout_, finish_time_, overlap_;
  std::int64_t restarts_;
  State state_;
  double dt_ = 0.0;
};

TAKT_PRIMITIVE(
    ProcessOnPath, "process",
    "Lets a path be followed only while a process runs: an arc, a jet of glue, a spindle. The process is wanted from "
    "the first cycle on (unless there is a break), and the rate is 1 in the very cycle in which it runs. In a break "
    "(speed 0) the process is off at once and the path comes to rest; afterwards the path is followed back by the "
    "overlap, and the process is started again there. Where it goes out by itself it is started again in the same way "
    "as often as it may. At the end, and after a cancel, it goes on at rest for the finishing time. A net that is to "
    "stop switches it off at once.");

}  // namespace
}  // namespace takt::primitives
