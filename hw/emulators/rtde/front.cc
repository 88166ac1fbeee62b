#include "hw/emulators/rtde/front.h"

#include <array>

#include "hw/emulators/rtde/dashboard_service.h"
#include "hw/emulators/rtde/rtde_service.h"
#include "hw/emulators/rtde/script_service.h"

namespace takt::hw::rtde {

namespace {

constexpr std::uint16_t kReadOnly = 10;  // 30011 to 30013 are as 30001 to 30003, and take nothing
constexpr int kMostChunks = 16;          // of one client in one exchange: the others have their turn too

}  // namespace

Result<std::unique_ptr<Front>> Front::open(hw::Network& network, std::uint32_t host, Controller& controller) {
  std::unique_ptr<Front> front(new Front(controller));
  Diagnostics diagnostics;
  const auto add = [&](std::uint16_t port, std::unique_ptr<Service> service) {
    front->add(port, std::move(service), network, host, diagnostics);
  };
  using Stream = ScriptService::Stream;
  add(kRtdePort, std::make_unique<RtdeService>(controller));
  add(kDashboardPort, std::make_unique<DashboardService>(controller));
  for (const auto stream : {Stream::kPrimary, Stream::kSecondary, Stream::kRealtime}) {
    const auto port = static_cast<std::uint16_t>(kPrimaryPort + static_cast<int>(stream));
    add(port, std::make_unique<ScriptService>(controller, stream, true));
    add(static_cast<std::uint16_t>(port + kReadOnly), std::make_unique<ScriptService>(controller, stream, false));
  }
  if (diagnostics.has_errors()) return std::unexpected(diagnostics);
  return front;
}

void Front::add(std::uint16_t port, std::unique_ptr<Service> service, hw::Network& network, std::uint32_t host,
                Diagnostics& diagnostics) {
  auto listener = network.listen({host, port});
  if (!listener) return diagnostics.append(listener.error());
  ports_.push_back({std::move(*listener), std::move(service), {}});
}

void Front::exchange() {
  for (Port& port : ports_) {
    accept(port);
    for (Client& client : port.clients) receive(client);
    std::erase_if(port.clients, [this](Client& client) { return !send(client); });
  }
}

void Front::end_frame() {
  for (Port& port : ports_) {
    for (Client& client : port.clients) client.session->end_frame();
    std::erase_if(port.clients, [this](Client& client) { return !send(client); });
  }
}

void Front::drop_clients() {
  for (Port& port : ports_) port.clients.clear();
}

std::size_t Front::clients() const {
  std::size_t count = 0;
  for (const Port& port : ports_) count += port.clients.size();
  return count;
}

void Front::accept(Port& port) {
  while (auto link = port.listener->accept())
    if (port.clients.size() < kMostClients) port.clients.push_back({std::move(link), port.service->open()});
}

void Front::receive(Client& client) {
  std::array<std::byte, 8192> chunk;
  for (int i = 0; i < kMostChunks && !client.session->closing(); ++i) {
    const std::size_t count = client.link->receive(chunk);
    if (count == 0) return;
    client.session->receive({reinterpret_cast<const char*>(chunk.data()), count});
  }
}

/// @return false: the connection is over.
bool Front::send(Client& client) const {
  std::string& out = client.session->out();
  const std::size_t sent = out.empty() ? 0 : client.link->send(std::as_bytes(std::span(out)));
  out.erase(0, sent);
  if (sent > 0 || out.empty()) client.stuck_since = -1;
  if (!out.empty() && client.stuck_since < 0) client.stuck_since = controller_.time();
  const bool stuck = client.stuck_since >= 0 && controller_.time() - client.stuck_since > kAnswerTimeout;
  if (stuck || (client.session->closing() && out.empty())) return false;
  const auto state = client.link->state();
  return state == hw::StreamLink::State::kOpen || state == hw::StreamLink::State::kConnecting;
}

}  // namespace takt::hw::rtde
