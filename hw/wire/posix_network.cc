#include "hw/wire/posix_network.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/base/clock.h"

namespace takt::hw {
namespace {

/// Owns a file descriptor.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket() { close(); }
  void close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] bool valid() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

/// Repeats a call that a signal interrupted.
template <class Call>
auto without_interrupts(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

bool would_wait() { return errno == EAGAIN || errno == EWOULDBLOCK; }
std::string error_text(int error) { return std::strerror(error); }

sockaddr_in to_system(const Endpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(endpoint.host);
  address.sin_port = htons(endpoint.port);
  return address;
}
Endpoint from_system(const sockaddr_in& address) { return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)}; }
const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }
sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

/// @param name  getsockname or getpeername
template <class Name>
Endpoint name_of_socket(const Socket& socket, const Name& name) {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  if (name(socket.get(), generic(address), &size) != 0) return {};
  return from_system(address);
}

/// The rest of `timeout` is waited for after a signal, too.
bool wait_for(const Socket& socket, short events, Nanoseconds timeout) {
  if (!socket.valid()) return false;
  const Nanoseconds end = MonotonicClock::machine_time() + timeout;
  for (;;) {
    const Nanoseconds left = std::max<Nanoseconds>(0, end - MonotonicClock::machine_time());
    const timespec time{left / kSecond, left % kSecond};
    pollfd waiting{socket.get(), events, 0};
    const int ready = ::ppoll(&waiting, 1, &time, nullptr);
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

void set_option(const Socket& socket, int level, int option) {
  const int on = 1;
  (void)::setsockopt(socket.get(), level, option, &on, sizeof(on));
}

Result<Socket> open_socket(int type, const Endpoint& local) {
  Socket socket(::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const auto failed = [&](const char* what) {
    return failure(Code::kSystem, "", fmt::format("{} at {}: {}", what, to_string(local), error_text(errno)),
                   "Choose a free port, and an address of this machine");
  };
  if (!socket.valid()) return failed("no socket can be opened");
  // A listener that ended a moment ago must not keep its port.
  if (type == SOCK_STREAM) set_option(socket, SOL_SOCKET, SO_REUSEADDR);
  const sockaddr_in address = to_system(local);
  if (::bind(socket.get(), generic(address), sizeof(address)) != 0) return failed("a socket cannot be opened");
  return socket;
}

class PosixDatagrams final : public DatagramLink {
 public:
  explicit PosixDatagrams(Socket socket) : socket_(std::move(socket)) {}

  bool send(std::span<const std::byte> datagram, const Endpoint& to) override {
    const sockaddr_in address = to_system(to);
    const auto sent = without_interrupts([&] {
      return ::sendto(socket_.get(), datagram.data(), datagram.size(), MSG_NOSIGNAL | MSG_DONTWAIT, generic(address),
                      sizeof(address));
    });
    const bool whole = sent == static_cast<ssize_t>(datagram.size());
    ++(whole ? counts_.sent : counts_.unsent);
    return whole;
  }

  std::optional<Received> receive(std::span<std::byte> buffer) override {
    // What an earlier send was answered with ("connection refused") is not what is waited for; a few may be queued.
    constexpr int kErrorsAtOnce = 16;
    for (int i = 0; i < kErrorsAtOnce; ++i) {
      sockaddr_in from{};
      socklen_t size = sizeof(from);
      const auto received = without_interrupts([&] {
        return ::recvfrom(socket_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC, generic(from), &size);
      });
      if (received >= 0) {
        ++counts_.received;
        return Received{static_cast<std::size_t>(received), from_system(from)};
      }
      if (would_wait()) return std::nullopt;
      ++counts_.errors;
    }
    return std::nullopt;
  }

  bool wait(Nanoseconds timeout) override { return wait_for(socket_, POLLIN, timeout); }
  [[nodiscard]] Endpoint local() const override { return name_of_socket(socket_, ::getsockname); }
  [[nodiscard]] DatagramCounts counts() const override { return counts_; }

 private:
  Socket socket_;
  DatagramCounts counts_;
};

class PosixStream final : public StreamLink {
 public:
  PosixStream(Socket socket, State state, const Endpoint& remote)
      : socket_(std::move(socket)), state_(state), remote_(remote) {
    set_option(socket_, IPPROTO_TCP, TCP_NODELAY);
  }

  State state() override {
    if (state_ == State::kConnecting && wait_for(socket_, POLLOUT, 0)) finish_connecting();
    const bool waits = state_ == State::kOpen && !unsent_.empty() && has_received();
    if (state_ != State::kFailed && !unsent_.empty() && !waits) fail(std::exchange(unsent_, {}));
    return state_;
  }

  std::size_t send(std::span<const std::byte> bytes) override {
    if ((state() != State::kOpen && state_ != State::kEnded) || !unsent_.empty()) return 0;
    const auto sent = without_interrupts(
        [&] { return ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT); });
    if (sent >= 0) return static_cast<std::size_t>(sent);
    if (!would_wait()) unsent_ = error_text(errno);
    (void)state();
    return 0;
  }

  std::size_t receive(std::span<std::byte> buffer) override {
    if (state() != State::kOpen || buffer.empty()) return 0;
    const auto received =
        without_interrupts([&] { return ::recv(socket_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT); });
    if (received > 0) return static_cast<std::size_t>(received);
    if (received == 0) {
      state_ = State::kEnded;
    } else if (!would_wait()) {
      fail(error_text(errno));
    }
    return 0;
  }

  bool wait(Nanoseconds timeout) override {
    const bool connecting = state() == State::kConnecting;
    return wait_for(socket_, connecting ? POLLOUT : POLLIN, timeout);
  }

  void close() override {
    if (state_ != State::kFailed) fail("closed here");
  }

  [[nodiscard]] Endpoint local() const override { return name_of_socket(socket_, ::getsockname); }
  [[nodiscard]] Endpoint remote() const override { return remote_; }
  [[nodiscard]] std::string error() const override { return error_; }

 private:
  void finish_connecting() {
    int error = 0;
    socklen_t size = sizeof(error);
    (void)::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error == 0) {
      state_ = State::kOpen;
    } else {
      fail(error_text(error));
    }
  }
  [[nodiscard]] bool has_received() const {
    std::byte first{};
    return without_interrupts([&] { return ::recv(socket_.get(), &first, 1, MSG_PEEK | MSG_DONTWAIT); }) > 0;
  }
  void fail(std::string why) {
    error_ = std::move(why);
    state_ = State::kFailed;
    socket_.close();
  }

  Socket socket_;
  State state_;
  Endpoint remote_;
  std::string error_;
  std::string unsent_;  // why nothing can be sent any more; what the peer has sent before still counts
};

class PosixListener final : public StreamListener {
 public:
  explicit PosixListener(Socket socket) : socket_(std::move(socket)) {}

  std::unique_ptr<StreamLink> accept() override {
    Socket accepted(
        without_interrupts([&] { return ::accept4(socket_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC); }));
    if (!accepted.valid()) return nullptr;
    const Endpoint remote = name_of_socket(accepted, ::getpeername);
    return std::make_unique<PosixStream>(std::move(accepted), StreamLink::State::kOpen, remote);
  }
  bool wait(Nanoseconds timeout) override { return wait_for(socket_, POLLIN, timeout); }
  [[nodiscard]] Endpoint local() const override { return name_of_socket(socket_, ::getsockname); }

 private:
  Socket socket_;
};

}  // namespace

Result<std::unique_ptr<DatagramLink>> PosixNetwork::open_datagrams(const Endpoint& local) {
  auto socket = open_socket(SOCK_DGRAM, local);
  if (!socket) return std::unexpected(socket.error());
  return std::make_unique<PosixDatagrams>(std::move(*socket));
}

Result<std::unique_ptr<StreamListener>> PosixNetwork::listen(const Endpoint& local) {
  constexpr int kWaiting = 8;  // connections that the system keeps until they are accepted
  auto socket = open_socket(SOCK_STREAM, local);
  if (!socket) return std::unexpected(socket.error());
  if (::listen(socket->get(), kWaiting) != 0) {
    return failure(Code::kSystem, "",
                   fmt::format("nothing can be accepted at {}: {}", to_string(local), error_text(errno)));
  }
  return std::make_unique<PosixListener>(std::move(*socket));
}

Result<std::unique_ptr<StreamLink>> PosixNetwork::connect(const Endpoint& remote) {
  Socket socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.valid()) return failure(Code::kSystem, "", fmt::format("no socket can be opened: {}", error_text(errno)));
  const sockaddr_in address = to_system(remote);
  // Of a connection that a signal interrupts the system goes on with by itself.
  const int connected = ::connect(socket.get(), generic(address), sizeof(address));
  if (connected != 0 && errno != EINPROGRESS && errno != EINTR) {
    return failure(Code::kSystem, "", fmt::format("no connection to {}: {}", to_string(remote), error_text(errno)),
                   "Check the controller's address, and the route to it");
  }
  const auto state = connected == 0 ? StreamLink::State::kOpen : StreamLink::State::kConnecting;
  return std::make_unique<PosixStream>(std::move(socket), state, remote);
}

}  // namespace takt::hw
