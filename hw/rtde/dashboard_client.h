#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>

namespace takt::hw::rtde {

/// The client's end of the dashboard: a question at a time, a line each. Without its transport. One thread.
class DashboardClient {
 public:
  static constexpr std::size_t kLongestLine = 4096;

  void receive(std::string_view bytes);
  /// The greeting has come.
  [[nodiscard]] bool greeted() const { return greeted_; }
  /// Queues a command.
  void ask(std::string command) { waiting_.push_back(std::move(command)); }
  /// The next answer, with its command.
  struct Answer {
    std::string command, text;
  };
  [[nodiscard]] std::optional<Answer> next_answer();
  /// What is to be sent now.
  [[nodiscard]] std::string take_out();
  /// A new connection.
  void reset() { *this = {}; }

 private:
  std::string line_;
  std::deque<std::string> waiting_;
  std::deque<Answer> answers_;
  std::string asked_;  // without an answer yet; empty: none
  bool greeted_ = false;
};

}  // namespace takt::hw::rtde
