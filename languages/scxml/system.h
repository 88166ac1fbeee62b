#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "languages/scxml/session.h"

namespace takt::languages {

/// Charts that run together on one clock and send each other events: "#_scxml_NAME" is the session of that name. The
/// same calls give the same states. Thread: one at a time.
class ChartSystem {
 public:
  explicit ChartSystem(ChartSurroundings surroundings = {}, std::uint64_t seed = 0)
      : surroundings_(std::move(surroundings)), seed_(seed) {}
  ChartSystem(const ChartSystem&) = delete;
  ChartSystem& operator=(const ChartSystem&) = delete;

  /// A chart that begins with the next advance(). Names are unique.
  ChartSession& add(std::shared_ptr<const Chart> chart, const std::string& name);
  /// Runs all charts until they wait. @param now_ns  never less than before
  void advance(std::int64_t now_ns);
  /// An event from outside. @return false if no session of this name runs
  bool post(std::string_view session, ChartEvent event);
  /// What was begun by ChartSurroundings::begin is over: `event` tells its session.
  bool end_call(std::string_view session, const std::string& id, ChartEvent event);
  /// Ends all charts in order.
  void cancel();

  [[nodiscard]] ChartSession* find(std::string_view name) const;
  /// The charts that were added, without those that they invoked.
  [[nodiscard]] const std::vector<ChartSession*>& charts() const { return charts_; }
  /// No chart that was added runs any more.
  [[nodiscard]] bool over() const;
  /// When something is due next, if nothing comes from outside; -1: nothing is.
  [[nodiscard]] std::int64_t next_ns() const;
  [[nodiscard]] std::int64_t now_ns() const { return now_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  [[nodiscard]] const ChartSurroundings& surroundings() const { return surroundings_; }

 private:
  friend class ChartSession;

  /// An event that is sent later.
  struct Delayed {
    ChartSession* from;
    std::string target;
    ChartEvent event;
  };

  /// @return an error event's name and reason, both empty if it went
  std::pair<std::string_view, std::string> send(ChartSession& from, const std::string& target, ChartEvent event);
  bool send_later(ChartSession& from, std::int64_t delay_ns, std::string target, ChartEvent event);
  void cancel_later(const ChartSession& from, const std::string& sendid);
  ChartSession* add_child(ChartSession& parent, std::shared_ptr<const Chart> chart, const std::string& invoke_id,
                          std::map<std::string, Data> given);
  void session_over(ChartSession& session, bool in_order);
  void run_ready();

  ChartSurroundings surroundings_;
  std::uint64_t seed_;
  std::int64_t now_ = 0;
  std::int64_t sent_ = 0;
  int children_ = 0;
  std::vector<std::unique_ptr<ChartSession>> sessions_;
  std::map<const ChartSession*, std::map<std::string, Data>> given_;  ///< of sessions that have not begun
  std::vector<ChartSession*> charts_;
  std::map<std::pair<std::int64_t, std::int64_t>, Delayed> delayed_;  ///< by time and number
};

}  // namespace takt::languages
