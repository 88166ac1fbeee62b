#include "hw/emulators/rtde/external_control.h"

#include <array>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

using State = hw::StreamLink::State;

constexpr std::string_view kRequest = "request_program\n", kLastLine = "# NODE_CONTROL_LOOP_ENDS";
constexpr Nanoseconds kTimeout = 5 * kSecond;
constexpr std::size_t kLongest = 1u << 20;

}  // namespace

bool ExternalControl::begin(Nanoseconds now) {
  link_.reset();
  if (network_ == nullptr || !client_) return false;
  auto link = network_->connect(*client_);
  if (!link) return false;
  link_ = std::move(*link);
  out_ = kRequest;
  body_.clear();
  deadline_ = now + kTimeout;
  return true;
}

std::optional<Result<std::string>> ExternalControl::poll(Nanoseconds now) {
  if (!link_) return std::nullopt;
  const State state = link_->state();
  exchange();
  // The client keeps its connection open: the end is a line of the text.
  const std::size_t end = body_.find(kLastLine);
  if (end != std::string::npos) {
    link_.reset();
    return fmt::format("def external_control():\n{}\nend\n", body_.substr(0, end));
  }
  if (state == State::kFailed) return failed(link_->error());
  if (state == State::kEnded) return failed("it ended before the program was complete");
  if (body_.size() > kLongest) return failed("the program is longer than 1 MiB");
  if (now > deadline_) return failed("no program came within 5 s");
  return std::nullopt;
}

void ExternalControl::exchange() {
  out_.erase(0, link_->send(std::as_bytes(std::span(out_))));
  std::array<std::byte, 4096> chunk;
  while (body_.size() <= kLongest) {
    const std::size_t count = link_->receive(chunk);
    if (count == 0) return;
    body_.append(reinterpret_cast<const char*>(chunk.data()), count);
  }
}

Result<std::string> ExternalControl::failed(std::string_view why) {
  std::string text = fmt::format("External Control: connection to {}: {}", hw::to_string(*client_), why);
  link_.reset();
  return failure(Code::kDeviceFault, {}, std::move(text));
}

}  // namespace takt::hw::rtde
