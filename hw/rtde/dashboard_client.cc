#include "hw/rtde/dashboard_client.h"

#include <utility>

namespace takt::hw::rtde {

void DashboardClient::receive(std::string_view bytes) {
  for (const char c : bytes) {
    if (c != '\n') {
      if (c != '\r' && line_.size() < kLongestLine) line_.push_back(c);
      continue;
    }
    std::string line = std::exchange(line_, {});
    if (!greeted_) {
      greeted_ = true;
    } else if (!asked_.empty()) {
      Answer& answer = answers_.emplace_back();
      answer.command.swap(asked_);
      answer.text = std::move(line);
    }
  }
}

std::optional<DashboardClient::Answer> DashboardClient::next_answer() {
  if (answers_.empty()) return std::nullopt;
  Answer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

std::string DashboardClient::take_out() {
  if (!greeted_ || !asked_.empty() || waiting_.empty()) return {};
  asked_ = std::move(waiting_.front());
  waiting_.pop_front();
  return asked_ + "\n";
}

}  // namespace takt::hw::rtde
