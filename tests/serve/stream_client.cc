#include "tests/serve/stream_client.h"

#include <cstring>

#include <fmt/format.h>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

namespace takt::serve::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value > bytes.size()) {
    ADD_FAILURE() << "the frame ends before byte " << at + sizeof value;
    return value;
  }
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void read_values(const std::string& bytes, int entries, Frame& frame) {
  std::size_t at = 16;
  for (int i = 0; i < entries; ++i) {
    FrameEntry entry{.id = number_at<std::uint32_t>(bytes, at),
                     .type = number_at<std::uint8_t>(bytes, at + 4),
                     .null = number_at<std::uint8_t>(bytes, at + 5) == 1,
                     .cycle = number_at<std::int64_t>(bytes, at + 8),
                     .bytes = {}};
    const std::size_t length = number_at<std::uint16_t>(bytes, at + 6);
    if (at + 16 + length > bytes.size()) break;
    entry.bytes = bytes.substr(at + 16, length);
    at += 16 + (length + 7) / 8 * 8;
    frame.values.push_back(std::move(entry));
  }
  EXPECT_EQ(at, bytes.size());
}

void read_poses(const std::string& bytes, Frame& frame) {
  frame.time = number_at<double>(bytes, 16);
  const auto moving = number_at<std::uint32_t>(bytes, 24), commanded = number_at<std::uint32_t>(bytes, 28);
  std::size_t at = 32;
  for (std::uint32_t i = 0; i < moving + commanded; ++i, at += 28) {
    std::vector<float> pose;
    for (std::size_t k = 0; k < 7; ++k) pose.push_back(number_at<float>(bytes, at + 4 * k));
    (i < moving ? frame.moving : frame.commanded).push_back(std::move(pose));
  }
  EXPECT_EQ((at + 7) / 8 * 8, bytes.size());
}

}  // namespace

std::vector<double> FrameEntry::numbers() const {
  std::vector<double> all(bytes.size() / sizeof(double));
  std::memcpy(all.data(), bytes.data(), all.size() * sizeof(double));
  return all;
}

const FrameEntry* Frame::of(std::uint32_t id) const {
  for (const FrameEntry& one : values)
    if (one.id == id) return &one;
  return nullptr;
}

Frame read_frame(const std::string& bytes) {
  Frame frame{.kind = number_at<std::uint8_t>(bytes, 0),
              .version = number_at<std::uint8_t>(bytes, 1),
              .number = number_at<std::uint32_t>(bytes, 4),
              .cycle = number_at<std::int64_t>(bytes, 8),
              .values = {},
              .moving = {},
              .commanded = {}};
  if (frame.kind == 1) read_values(bytes, number_at<std::uint16_t>(bytes, 2), frame);
  if (frame.kind == 2) read_poses(bytes, frame);
  if (frame.kind == 3) {
    frame.time = number_at<double>(bytes, 16);
    const auto size = number_at<std::uint32_t>(bytes, 32);
    EXPECT_EQ(bytes.size(), (40 + size + 7) / 8 * 8);
    frame.picture = bytes.substr(40, size);
  }
  return frame;
}

struct StreamClient::Impl {
  asio::io_context io;
  websocket::stream<beast::tcp_stream> socket{io};
  websocket::response_type response;

  beast::flat_buffer buffer;
  bool reading = false, done = false;
  beast::error_code error;
};

StreamClient::StreamClient(const Served& served, const std::string& target, const std::string& protocol,
                           const std::map<std::string, std::string>& headers)
    : impl_(std::make_unique<Impl>()) {
  auto& socket = impl_->socket;
  const unsigned short port = served.server->port();
  beast::get_lowest_layer(socket).connect({asio::ip::address_v4::loopback(), port});
  socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    if (!protocol.empty()) request.set(beast::http::field::sec_websocket_protocol, protocol);
    for (const auto& [name, value] : headers) request.set(name, value);
  }));
  beast::error_code error;
  socket.handshake(impl_->response, fmt::format("127.0.0.1:{}", port), target, error);
}

StreamClient::~StreamClient() {
  drop();
  impl_->io.restart();
  impl_->io.run();  // what was being read ends
}

int StreamClient::status() const { return static_cast<int>(impl_->response.result_int()); }

void StreamClient::send_text(const std::string& text, bool binary) {
  beast::error_code error;
  impl_->socket.binary(binary);
  impl_->socket.write(asio::buffer(text), error);
}

std::optional<StreamMessage> StreamClient::read(std::chrono::milliseconds longest) {
  Impl& impl = *impl_;
  if (!impl.reading) {
    impl.reading = true;
    impl.done = false;
    impl.socket.async_read(impl.buffer, [&impl](beast::error_code error, std::size_t) {
      impl.error = error;
      impl.done = true;
    });
  }
  const auto until = std::chrono::steady_clock::now() + longest;
  impl.io.restart();
  while (!impl.done && std::chrono::steady_clock::now() < until) impl.io.run_one_until(until);
  if (!impl.done) return {};  // it goes on with the next call
  impl.reading = false;
  if (impl.error) return {};
  StreamMessage message{.binary = impl.socket.got_binary(), .text = beast::buffers_to_string(impl.buffer.data())};
  impl.buffer.consume(impl.buffer.size());
  return message;
}

Json StreamClient::await(const std::string& op) {
  while (const auto message = read()) {
    const Json json = message->json();
    if (json.is_object() && json.value("op", "") == op) return json;
  }
  return {};
}

std::optional<Frame> StreamClient::frame() {
  while (const auto message = read())
    if (message->binary) return read_frame(message->text);
  return {};
}

std::pair<int, std::string> StreamClient::close_reason() const {
  const auto& reason = impl_->socket.reason();
  return {reason.code, std::string(reason.reason.data(), reason.reason.size())};
}

void StreamClient::drop() { beast::get_lowest_layer(impl_->socket).close(); }

}  // namespace takt::serve::test
