#include "hw/can/socket_can.h"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "core/base/clock.h"

namespace takt::hw {
namespace {

class SocketCan final : public CanLink {
 public:
  explicit SocketCan(int descriptor) : descriptor_(descriptor) {}
  ~SocketCan() override { ::close(descriptor_); }
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  bool send(const CanFrame& frame) override {
    can_frame out{};
    out.can_id = frame.id;
    out.can_dlc = frame.size;
    std::memcpy(out.data, frame.data.data(), frame.size);
    ssize_t sent = 0;
    do sent = ::send(descriptor_, &out, sizeof(out), MSG_DONTWAIT | MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    const bool whole = sent == static_cast<ssize_t>(sizeof(out));
    ++(whole ? counts_.sent : counts_.unsent);
    return whole;
  }

  std::optional<CanFrame> receive() override {
    can_frame in{};
    for (;;) {
      const ssize_t received = ::recv(descriptor_, &in, sizeof(in), MSG_DONTWAIT);
      if (received < 0 && errno == EINTR) continue;
      if (received != static_cast<ssize_t>(sizeof(in))) return std::nullopt;
      if (const auto frame = data_frame(in)) return frame;
      ++counts_.misread;
    }
  }

  bool wait(Nanoseconds timeout) override {
    const Nanoseconds end = MonotonicClock::machine_time() + timeout;
    for (;;) {
      const Nanoseconds left = std::max<Nanoseconds>(0, end - MonotonicClock::machine_time());
      const timespec time{left / kSecond, left % kSecond};
      pollfd waiting{descriptor_, POLLIN, 0};
      const int ready = ::ppoll(&waiting, 1, &time, nullptr);
      if (ready >= 0 || errno != EINTR) return ready > 0;
    }
  }
  [[nodiscard]] CanCounts counts() const override { return counts_; }

 private:
  /// Neither an error report, nor a remote request, nor one with an extended identifier.
  std::optional<CanFrame> data_frame(const can_frame& in) {
    if ((in.can_id & (CAN_ERR_FLAG | CAN_RTR_FLAG | CAN_EFF_FLAG)) != 0 || in.can_dlc > 8) return std::nullopt;
    CanFrame frame{.id = in.can_id & CAN_SFF_MASK, .size = in.can_dlc};
    std::memcpy(frame.data.data(), in.data, frame.size);
    ++counts_.received;
    return frame;
  }

  int descriptor_;
  CanCounts counts_;
};

}  // namespace

bool is_interface_name(std::string_view text) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; };
  return !text.empty() && text.size() < IFNAMSIZ && std::ranges::all_of(text, allowed);
}

Result<std::unique_ptr<CanLink>> open_socket_can(const std::string& interface) {
  const auto failed = [&](const char* what) {
    return failure(Code::kSystem, "", fmt::format("{} '{}': {}", what, interface, std::strerror(errno)),
                   fmt::format("Run ip link set {} up type can bitrate 1000000", interface));
  };
  const int descriptor = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (descriptor < 0) return failed("no CAN socket for");
  auto link = std::make_unique<SocketCan>(descriptor);
  ifreq request{};
  std::strncpy(request.ifr_name, interface.c_str(), IFNAMSIZ - 1);
  if (::ioctl(descriptor, SIOCGIFINDEX, &request) < 0) return failed("there is no CAN interface");
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) < 0)
    return failed("frames cannot be received from");
  return link;
}

}  // namespace takt::hw
