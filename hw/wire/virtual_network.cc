#include "hw/wire/virtual_network.h"

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "hw/wire/virtual_stream.h"

namespace takt::hw {
namespace {

constexpr Nanoseconds kNeverArrives = VirtualPipe::kNever;
constexpr std::uint16_t kFirstFreePort = 50'000;

struct Datagram {
  std::array<std::byte, DatagramLink::kLargest> bytes;
  std::size_t size = 0;
  Endpoint from;
};

/// What is on its way to one datagram link.
struct Inbox {
  emulation::Wire<Datagram> wire;
  int lose = 0;  // so many of the next
};

struct Waiting {
  std::unique_ptr<VirtualStream> stream;
  Nanoseconds arrival = 0;
};
using Backlog = std::deque<Waiting>;

}  // namespace

/// What all links of a network share; lives as long as one of them.
class VirtualNetwork::Hub : public std::enable_shared_from_this<Hub> {
 public:
  Hub(const Clock& clock, std::uint64_t seed, const VirtualFaults& faults)
      : clock_(clock),
        seed_(seed),
        random_(seed, "virtual network"),
        streams_(std::make_shared<VirtualStreamTiming>()) {
    streams_->clock = &clock;
    streams_->random = Random(seed, "virtual streams");
    set_faults(faults);
  }

  void set_faults(const VirtualFaults& faults) {
    faults_ = faults;
    streams_->transport = faults.wire.transport;
    streams_->jitter = faults.wire.jitter;
    streams_->piece = faults.stream_piece;
    for (auto& [local, inbox] : inboxes_) inbox.wire.set_faults(faults.wire);
  }
  void set_cut(bool cut) {
    streams_->cut = cut;
    if (cut) return;
    for (const auto& pipe : living_pipes()) pipe->release();
  }
  void lose_next(std::uint16_t port, int count) {
    for (auto& [local, inbox] : inboxes_)
      if (local.port == port) inbox.lose = count;
  }

  [[nodiscard]] Nanoseconds now() const { return clock_.read().machine; }
  [[nodiscard]] const VirtualCounts& counts() const { return counts_; }
  [[nodiscard]] Nanoseconds next_arrival() const {
    Nanoseconds next = kNeverArrives;
    for (const auto& [local, inbox] : inboxes_) next = std::min(next, inbox.wire.next_arrival());
    for (const auto& pipe : living_pipes()) next = std::min(next, pipe->next_arrival());
    return next;
  }

  // -- Datagrams
  /// @return with the port that was chosen; port 0 if it is in use
  Endpoint open_inbox(Endpoint local) {
    if (local.port == 0) local.port = free_port();
    const std::string name = fmt::format("{}#{}", to_string(local), opened_++);
    const bool added = inboxes_.try_emplace(local, Inbox{{faults_.wire, seed_, name}}).second;
    return added ? local : Endpoint{local.host, 0};
  }
  void close_inbox(const Endpoint& local) { inboxes_.erase(local); }
  bool send(std::span<const std::byte> bytes, const Endpoint& from, const Endpoint& to);
  std::optional<Datagram> take(const Endpoint& local) {
    emulation::Wire<Datagram>& wire = inboxes_.at(local).wire;
    if (wire.next_arrival() > now()) return std::nullopt;
    return wire.receive();
  }
  [[nodiscard]] bool has_datagram(const Endpoint& local) const {
    return inboxes_.at(local).wire.next_arrival() <= now();
  }

  // -- Streams
  Endpoint open_listener(Endpoint local) {
    if (local.port == 0) local.port = free_port();
    return backlogs_.try_emplace(local).second ? local : Endpoint{local.host, 0};
  }
  void close_listener(const Endpoint& local) { backlogs_.erase(local); }
  Backlog& backlog(const Endpoint& local) { return backlogs_.at(local); }
  std::unique_ptr<StreamLink> connect(const Endpoint& remote);

 private:
  std::uint16_t free_port() { return next_port_++; }
  /// The entry at this endpoint, or at any address with this port.
  template <class Map>
  static auto find(Map& map, const Endpoint& to) {
    const auto exact = map.find(to);
    return exact != map.end() ? exact : map.find(Endpoint{0, to.port});
  }
  void damage(Datagram& datagram);
  [[nodiscard]] std::vector<std::shared_ptr<VirtualPipe>> living_pipes() const {
    std::vector<std::shared_ptr<VirtualPipe>> living;
    for (const auto& pipe : pipes_)
      if (auto held = pipe.lock()) living.push_back(std::move(held));
    return living;
  }

  const Clock& clock_;
  std::uint64_t seed_;
  Random random_;
  VirtualFaults faults_;
  VirtualCounts counts_;
  std::shared_ptr<VirtualStreamTiming> streams_;
  std::map<Endpoint, Inbox> inboxes_;
  std::map<Endpoint, Backlog> backlogs_;
  std::vector<std::weak_ptr<VirtualPipe>> pipes_;
  std::uint16_t next_port_ = kFirstFreePort;
  int opened_ = 0;
};

bool VirtualNetwork::Hub::send(std::span<const std::byte> bytes, const Endpoint& from, const Endpoint& to) {
  if (bytes.size() > DatagramLink::kLargest) return false;
  ++counts_.sent;
  const auto found = find(inboxes_, to);
  if (found == inboxes_.end()) return true;  // nobody is there, and the wire does not say so
  if (streams_->cut) return ++counts_.cut, true;
  Inbox& inbox = found->second;
  if (inbox.lose > 0) return --inbox.lose, ++counts_.dropped, true;
  Datagram datagram;
  std::copy(bytes.begin(), bytes.end(), datagram.bytes.begin());
  datagram.size = bytes.size();
  datagram.from = {from.host == 0 ? kLoopback : from.host, from.port};
  damage(datagram);
  inbox.wire.send(datagram, now());
  return true;
}

/// Draws as many numbers whatever happens, so that one fault does not shift all that follow.
void VirtualNetwork::Hub::damage(Datagram& datagram) {
  const double corrupt = random_.unit(), cut_short = random_.unit();
  const std::uint64_t where = random_.bits();
  if (datagram.size == 0) return;
  if (corrupt < faults_.corrupt) {
    ++counts_.corrupted;
    datagram.bytes[(where >> 3) % datagram.size] ^= std::byte{1} << (where & 7);
  }
  if (cut_short < faults_.truncate) {
    ++counts_.truncated;
    datagram.size = (where >> 16) % datagram.size;
  }
}

std::unique_ptr<StreamLink> VirtualNetwork::Hub::connect(const Endpoint& remote) {
  const auto found = find(backlogs_, remote);
  const auto there = std::make_shared<VirtualPipe>(streams_), back = std::make_shared<VirtualPipe>(streams_);
  std::erase_if(pipes_, [](const auto& pipe) { return pipe.expired(); });
  pipes_.insert(pipes_.end(), {there, back});
  const Endpoint local{kLoopback, free_port()};
  const Nanoseconds arrives = streams_->arrival(), opens = arrives + streams_->transport;
  const bool refused = found == backlogs_.end();
  if (!refused) {
    found->second.push_back(
        {std::make_unique<VirtualStream>(streams_, there, back, remote, local, arrives, false), arrives});
  }
  return std::make_unique<VirtualStream>(streams_, back, there, local, remote, opens, refused);
}

class VirtualNetwork::Datagrams final : public DatagramLink {
 public:
  Datagrams(std::shared_ptr<Hub> hub, const Endpoint& local) : hub_(std::move(hub)), local_(local) {}
  ~Datagrams() override { hub_->close_inbox(local_); }
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;

  bool send(std::span<const std::byte> datagram, const Endpoint& to) override {
    const bool sent = hub_->send(datagram, local_, to);
    ++(sent ? counts_.sent : counts_.unsent);
    return sent;
  }
  std::optional<Received> receive(std::span<std::byte> buffer) override {
    const auto datagram = hub_->take(local_);
    if (!datagram) return std::nullopt;
    ++counts_.received;
    std::copy_n(datagram->bytes.begin(), std::min(datagram->size, buffer.size()), buffer.begin());
    return Received{datagram->size, datagram->from};
  }
  bool wait(Nanoseconds) override { return hub_->has_datagram(local_); }
  [[nodiscard]] Endpoint local() const override { return local_; }
  [[nodiscard]] DatagramCounts counts() const override { return counts_; }

 private:
  std::shared_ptr<Hub> hub_;
  Endpoint local_;
  DatagramCounts counts_;
};

class VirtualNetwork::Listener final : public StreamListener {
 public:
  Listener(std::shared_ptr<Hub> hub, const Endpoint& local) : hub_(std::move(hub)), local_(local) {}
  ~Listener() override { hub_->close_listener(local_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::unique_ptr<StreamLink> accept() override {
    if (!wait(0)) return nullptr;
    auto stream = std::move(hub_->backlog(local_).front().stream);
    hub_->backlog(local_).pop_front();
    return stream;
  }
  bool wait(Nanoseconds) override {
    const Backlog& backlog = hub_->backlog(local_);
    return !backlog.empty() && backlog.front().arrival <= hub_->now();
  }
  [[nodiscard]] Endpoint local() const override { return local_; }

 private:
  std::shared_ptr<Hub> hub_;
  Endpoint local_;
};

VirtualNetwork::VirtualNetwork(const Clock& clock, std::uint64_t seed, const VirtualFaults& faults)
    : hub_(std::make_shared<Hub>(clock, seed, faults)) {}
VirtualNetwork::~VirtualNetwork() = default;

Result<std::unique_ptr<DatagramLink>> VirtualNetwork::open_datagrams(const Endpoint& local) {
  const Endpoint opened = hub_->open_inbox(local);
  if (opened.port == 0)
    return failure(Code::kConflict, "", fmt::format("{} is in use", to_string(local)), "Choose a free port");
  return std::make_unique<Datagrams>(hub_, opened);
}

Result<std::unique_ptr<StreamListener>> VirtualNetwork::listen(const Endpoint& local) {
  const Endpoint opened = hub_->open_listener(local);
  if (opened.port == 0)
    return failure(Code::kConflict, "", fmt::format("{} is in use", to_string(local)), "Choose a free port");
  return std::make_unique<Listener>(hub_, opened);
}

Result<std::unique_ptr<StreamLink>> VirtualNetwork::connect(const Endpoint& remote) { return hub_->connect(remote); }

void VirtualNetwork::set_faults(const VirtualFaults& faults) { hub_->set_faults(faults); }
void VirtualNetwork::set_cut(bool cut) { hub_->set_cut(cut); }
void VirtualNetwork::lose_next(std::uint16_t port, int count) { hub_->lose_next(port, count); }
Nanoseconds VirtualNetwork::next_arrival() const { return hub_->next_arrival(); }
const VirtualCounts& VirtualNetwork::counts() const { return hub_->counts(); }

}  // namespace takt::hw
