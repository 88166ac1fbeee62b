#include "serve/streams.h"

#include <algorithm>
#include <utility>

namespace takt::serve {

Streams::Streams(ServedCell& cell, Access& access, PictureMaker& pictures,
                 std::function<void(const std::string& line)> log, std::function<void(std::function<void()> work)> post,
                 std::function<bool(std::function<void()> job)> work_elsewhere)
    : services_{.cell = cell,
                .access = access,
                .pictures = pictures,
                .log = std::move(log),
                .post = std::move(post),
                .work_elsewhere = std::move(work_elsewhere),
                .forget_later = [this](rcc::NetId net) { forget_.push_back(net); }},
      sights_{.view = cell.view(), .watches = WatchPool(cell.core()), .scene = cell::CellScene(cell.built())},
      foxglove_(cell) {
  cell.on_news([this] { wake(); });
  pictures.on_picture([this] { wake(); });
}

Streams::~Streams() {
  services_.pictures.on_picture({});
  services_.cell.on_news({});
}

std::vector<std::string> Streams::protocols() {
  std::vector<std::string> all = {std::string(StreamSession::kProtocol), std::string(FollowSession::kProtocol)};
  all.insert(all.end(), FoxgloveSession::kProtocols.begin(), FoxgloveSession::kProtocols.end());
  return all;
}

std::shared_ptr<SocketUser> Streams::open(const std::string& protocol, const Client& client, const std::string& peer) {
  const auto gone = [this](Stream& stream) {
    streams_.erase(&stream);
    wanted_ = !streams_.empty() || !forget_.empty();
  };
  std::shared_ptr<Stream> stream;
  if (protocol == StreamSession::kProtocol) {
    stream = std::make_shared<StreamSession>(services_, sights_, client, peer, gone);
  } else if (protocol == FollowSession::kProtocol) {
    stream = std::make_shared<FollowSession>(services_, client, peer, gone);
  } else {
    stream = std::make_shared<FoxgloveSession>(services_, sights_, foxglove_, peer, gone);
  }
  streams_[stream.get()] = client.name;
  wanted_ = true;
  sights_.view = services_.cell.view();
  return stream;
}

std::size_t Streams::count(const std::string& client) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(streams_, [&client](const auto& one) { return one.second == client; }));
}

/// Whoever runs the cell only asks for a look, and for one at a time.
void Streams::wake() {
  if (!wanted_ || woken_.exchange(true)) return;
  services_.post([this] {
    woken_ = false;
    look();
  });
}

void Streams::look() {
  sights_.view = services_.cell.view();
  std::vector<Stream*> all;
  for (const auto& [stream, client] : streams_) all.push_back(stream);
  for (Stream* stream : all)
    if (streams_.contains(stream)) stream->look();
  forget_ended_nets();
  wanted_ = !streams_.empty() || !forget_.empty();
}

void Streams::forget_ended_nets() {
  rcc::ControlCore& core = services_.cell.core();
  std::erase_if(forget_, [&core](rcc::NetId net) { return !core.knows(net) || core.unload(net); });
}

}  // namespace takt::serve
