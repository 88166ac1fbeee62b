#include "app/remote/server_link.h"

#include <charconv>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "core/base/json.h"

namespace takt::app {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

constexpr std::size_t kLongestAnswer = 64u << 20, kLongestMessage = 16u << 20, kLongestToken = 4096;

struct Place {
  std::string host, port;
};

/// "http://HOST:PORT" and nothing behind it.
Result<Place> parse_url(const std::string& url) {
  const auto refuse = [&url](std::string_view what) {
    return failure(Code::kInvalidValue, "--core", fmt::format("'{}': {}", url, what),
                   "Give the URL that takt serve prints: http://127.0.0.1:8700");
  };
  constexpr std::string_view kScheme = "http://";
  if (url.starts_with("https://"))
    return refuse("programs speak no TLS; let a proxy on this machine do that (docs/remote-tls.md)");
  if (!url.starts_with(kScheme)) return refuse("it does not begin with http://");
  std::string rest = url.substr(kScheme.size());
  if (rest.ends_with('/')) rest.pop_back();
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string::npos || rest.ends_with(']')) return refuse("it has no port");
  Place place{.host = rest.substr(0, colon), .port = rest.substr(colon + 1)};
  int port = 0;
  const auto [end, error] = std::from_chars(place.port.data(), place.port.data() + place.port.size(), port);
  if (error != std::errc() || end != place.port.data() + place.port.size() || port < 1 || port > 65535)
    return refuse("its port is none of 1 to 65535");
  if (place.host.starts_with('[') && place.host.ends_with(']'))
    place.host = place.host.substr(1, place.host.size() - 2);
  if (place.host.empty() || place.host.find_first_of("/?#@") != std::string::npos) return refuse("it has no host");
  return place;
}

Result<std::string> read_token(const std::filesystem::path& file) {
  if (file.empty()) return std::string();
  struct stat status {};
  if (stat(file.c_str(), &status) == 0 && (status.st_mode & 077) != 0)
    return failure(Code::kInvalidValue, "--token",
                   fmt::format("others may read '{}' (mode {:04o})", file.string(), status.st_mode & 07777),
                   "Run chmod 600 on it");
  auto text = read_file(file, kLongestToken);
  if (!text) return std::unexpected(std::move(text.error()));
  while (!text->empty() && (text->back() == '\n' || text->back() == '\r' || text->back() == ' ')) text->pop_back();
  if (text->empty() || text->find_first_of(" \r\n") != std::string::npos)
    return failure(Code::kSyntax, "--token", "the file has to hold one token and nothing else",
                   "Write the third word of a line of the server's token file");
  return text;
}

}  // namespace

struct ServerLink::Impl {
  Options options;
  Place place;
  std::string host, token;

  // HTTP: the caller's thread.
  std::mutex asking;
  asio::io_context http_io;
  beast::tcp_stream http_stream{http_io};
  beast::flat_buffer http_buffer;

  // WebSocket: `thread`, but for the queues.
  asio::io_context io;
  websocket::stream<beast::tcp_stream> socket{io};
  asio::steady_timer timer{io};
  beast::flat_buffer buffer;
  std::deque<std::string> to_send;
  bool writing = false;
  std::mutex mutex;  ///< of what follows
  std::condition_variable came;
  std::deque<Message> messages;
  std::string gone;  ///< why the connection is; empty: it is there
  std::jthread thread;

  [[nodiscard]] Tcp::resolver::results_type resolve(asio::io_context& context, beast::error_code& error) const {
    Tcp::resolver resolver(context);
    return resolver.resolve(place.host, place.port, error);
  }

  /// Blocking calls end after the patience of the link.
  void set_patience(Tcp::socket& of) const {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(options.patience);
    const timeval time{.tv_sec = seconds.count(), .tv_usec = 0};
    for (const int option : {SO_RCVTIMEO, SO_SNDTIMEO})
      (void)setsockopt(of.native_handle(), SOL_SOCKET, option, &time, sizeof(time));
    beast::error_code error;
    of.set_option(Tcp::no_delay(true), error);
  }

  bool open_http(beast::error_code& error) {
    http_buffer.clear();
    http_stream.socket().close(error);
    const auto found = resolve(http_io, error);
    if (!error) asio::connect(http_stream.socket(), found, error);
    if (!error) set_patience(http_stream.socket());
    return !error;
  }

  template <class Request>
  void set_common(Request& request) const {
    request.set(http::field::host, host);
    if (!token.empty()) request.set(http::field::authorization, "Bearer " + token);
  }

  Answer exchange(const http::request<http::string_body>& request, beast::error_code& error) {
    http::write(http_stream, request, error);
    if (error) return {};
    http::response_parser<http::string_body> parser;
    parser.body_limit(kLongestAnswer);
    http::read(http_stream, http_buffer, parser, error);
    if (error) return {};
    return {.status = static_cast<int>(parser.get().result_int()), .body = parser.get().body()};
  }

  void read_next() {
    socket.async_read(buffer, [this](beast::error_code error, std::size_t) {
      if (error) return lose(error);
      Message message{.binary = socket.got_binary(), .bytes = beast::buffers_to_string(buffer.data())};
      buffer.clear();
      {
        const std::lock_guard lock(mutex);
        messages.push_back(std::move(message));
      }
      came.notify_all();
      read_next();
    });
  }

  void write_next() {
    if (writing || to_send.empty()) return;
    writing = true;
    socket.async_write(asio::buffer(to_send.front()), [this](beast::error_code error, std::size_t) {
      writing = false;
      to_send.pop_front();
      if (error) return lose(error);
      write_next();
    });
  }

  void repeat(const std::string& text, std::chrono::milliseconds every) {
    timer.expires_after(every);
    timer.async_wait([this, text, every](beast::error_code error) {
      if (error) return;
      to_send.push_back(text);
      write_next();
      repeat(text, every);
    });
  }

  void lose(beast::error_code error) {
    const std::string reason(socket.reason().reason.data(), socket.reason().reason.size());
    {
      const std::lock_guard lock(mutex);
      if (gone.empty()) gone = reason.empty() ? error.message() : reason;
    }
    timer.cancel();
    came.notify_all();
  }
};

Result<std::unique_ptr<ServerLink>> ServerLink::open(const Options& options) {
  Diagnostics wrong;
  auto place = parse_url(options.url);
  if (!place) wrong.append(place.error());
  auto token = read_token(options.token);
  if (!token) wrong.append(token.error());
  if (wrong.has_errors()) return std::unexpected(std::move(wrong));
  std::unique_ptr<ServerLink> link(new ServerLink);
  link->impl_ = std::make_unique<Impl>();
  Impl& impl = *link->impl_;
  impl.options = options;
  impl.place = std::move(*place);
  impl.token = std::move(*token);
  const bool is_ipv6 = impl.place.host.find(':') != std::string::npos;
  impl.host = fmt::format("{}:{}", is_ipv6 ? "[" + impl.place.host + "]" : impl.place.host, impl.place.port);
  beast::error_code error;
  if (!impl.open_http(error))
    return failure(Code::kSystem, "--core", fmt::format("nobody answers at {}: {}", options.url, error.message()),
                   "Start takt serve there, or check the URL");
  return link;
}

ServerLink::~ServerLink() {
  if (!impl_ || !impl_->thread.joinable()) return;
  asio::post(impl_->io, [impl = impl_.get()] {
    impl->timer.cancel();
    beast::error_code error;
    auto& socket = beast::get_lowest_layer(impl->socket).socket();
    socket.shutdown(Tcp::socket::shutdown_both, error);
    socket.close(error);
  });
  impl_->thread.join();
}

ServerLink::Answer ServerLink::ask(const std::string& method, const std::string& target, const std::string& body,
                                   std::uint32_t fence) {
  const std::lock_guard lock(impl_->asking);
  http::request<http::string_body> request{http::string_to_verb(method), target, 11};
  impl_->set_common(request);
  if (fence != 0) request.set("Takt-Fence", std::to_string(fence));
  if (!body.empty()) request.set(http::field::content_type, "application/json");
  request.body() = body;
  request.prepare_payload();
  request.keep_alive(true);
  beast::error_code error;
  Answer answer = impl_->exchange(request, error);
  // A connection that was idle for long was closed; what was asked there was not heard.
  const bool closed = error == http::error::end_of_stream || error == asio::error::broken_pipe ||
                      error == asio::error::connection_reset;
  if (closed && impl_->open_http(error)) answer = impl_->exchange(request, error);
  if (error) throw LinkError(fmt::format("{} {}: {}", method, target, error.message()));
  return answer;
}

Diagnostics ServerLink::connect(const std::string& protocol) {
  Impl& impl = *impl_;
  Diagnostics wrong;
  beast::error_code error;
  const auto found = impl.resolve(impl.io, error);
  if (!error) asio::connect(beast::get_lowest_layer(impl.socket).socket(), found, error);
  if (!error) {
    impl.set_patience(beast::get_lowest_layer(impl.socket).socket());
    impl.socket.read_message_max(kLongestMessage);
    impl.socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      impl.set_common(request);
      request.set(http::field::sec_websocket_protocol, protocol);
    }));
    websocket::response_type response;
    impl.socket.handshake(response, impl.host, "/v1/stream", error);
    if (error == websocket::error::upgrade_declined)
      wrong.error(Code::kNotPossibleNow, "--core",
                  fmt::format("the server refuses a stream: status {}", response.result_int()),
                  "Use a server of the same version of takt, with a token of an operator");
  }
  if (error && !wrong.has_errors())
    wrong.error(Code::kSystem, "--core", fmt::format("no stream to the server: {}", error.message()),
                "Check the URL, and that this is takt serve");
  if (wrong.has_errors()) return wrong;
  impl.read_next();
  impl.thread = std::jthread([&impl] { impl.io.run(); });
  return wrong;
}

void ServerLink::repeat(const std::string& text, std::chrono::milliseconds every) {
  asio::post(impl_->io, [impl = impl_.get(), text, every] { impl->repeat(text, every); });
}

void ServerLink::send(std::string text) {
  asio::post(impl_->io, [impl = impl_.get(), text = std::move(text)]() mutable {
    impl->to_send.push_back(std::move(text));
    impl->write_next();
  });
}

ServerLink::Message ServerLink::receive() {
  std::unique_lock lock(impl_->mutex);
  const bool there = impl_->came.wait_for(lock, impl_->options.patience,
                                          [this] { return !impl_->messages.empty() || !impl_->gone.empty(); });
  if (impl_->messages.empty())
    throw LinkError(there ? "the connection is gone: " + impl_->gone : "the server does not answer");
  Message message = std::move(impl_->messages.front());
  impl_->messages.pop_front();
  return message;
}

std::optional<ServerLink::Message> ServerLink::poll() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->messages.empty()) return std::nullopt;
  std::optional<Message> message(std::move(impl_->messages.front()));
  impl_->messages.pop_front();
  return message;
}

}  // namespace takt::app
