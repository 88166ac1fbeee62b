#include "hw/emulators/rtde/script_sockets.h"

#include <array>

namespace takt::hw::rtde {

using hw::StreamLink;

bool ScriptSockets::open(const std::string& host, int port, const std::string& name) {
  if (network_ == nullptr || port <= 0 || port > 65'535 || (sockets_.size() >= kMost && !sockets_.contains(name)))
    return false;
  const auto endpoint = hw::parse_endpoint(host, static_cast<std::uint16_t>(port));
  if (!endpoint) return false;
  auto link = network_->connect(*endpoint);
  if (!link) return false;
  sockets_[name] = {.link = std::move(*link), .in = {}, .out = {}};
  return true;
}

StreamLink::State ScriptSockets::state(const std::string& name) {
  const auto at = sockets_.find(name);
  if (at == sockets_.end()) return StreamLink::State::kFailed;
  pump(at->second);
  return at->second.link->state();
}

bool ScriptSockets::send(const std::string& name, std::string_view bytes) {
  if (state(name) != StreamLink::State::kOpen) return false;
  Socket& socket = sockets_[name];
  if (socket.out.size() + bytes.size() > kLargestBuffer) return false;
  socket.out.append(bytes);
  pump(socket);
  return true;
}

std::string& ScriptSockets::received(const std::string& name) {
  const auto at = sockets_.find(name);
  if (at == sockets_.end()) {
    none_.clear();
    return none_;
  }
  pump(at->second);
  return at->second.in;
}

void ScriptSockets::pump(Socket& socket) {
  if (!socket.out.empty()) socket.out.erase(0, socket.link->send(std::as_bytes(std::span(socket.out))));
  std::array<std::byte, 4096> chunk;
  while (socket.in.size() < kLargestBuffer) {
    const std::size_t count = socket.link->receive(chunk);
    if (count == 0) return;
    socket.in.append(reinterpret_cast<const char*>(chunk.data()), count);
  }
}

}  // namespace takt::hw::rtde
