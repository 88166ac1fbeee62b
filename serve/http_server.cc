#include "serve/http_server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace takt::serve {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

struct Shared {
  HttpServer::Options options;
  HttpServer::Handlers handlers;
  asio::io_context io{1};
  std::atomic<std::size_t> connections = 0;
  std::atomic<bool> closed = false;
  std::mutex mutex;               ///< of `open`
  std::set<class OpenOne*> open;  ///< those that live
};

/// A connection that is counted, and dropped when the server ends.
class OpenOne {
 public:
  explicit OpenOne(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {
    ++shared_->connections;
    const std::lock_guard lock(shared_->mutex);
    shared_->open.insert(this);
  }
  virtual ~OpenOne() {
    --shared_->connections;
    const std::lock_guard lock(shared_->mutex);
    shared_->open.erase(this);
  }
  OpenOne(const OpenOne&) = delete;
  OpenOne& operator=(const OpenOne&) = delete;
  /// What is under way is broken off.
  virtual void drop() = 0;

 protected:
  const std::shared_ptr<Shared> shared_;  // outlives the stream
};

/// A WebSocket; it lives as long as something of it is under way.
class BeastSocket final : public OpenOne, public WebSocket, public std::enable_shared_from_this<BeastSocket> {
 public:
  BeastSocket(beast::tcp_stream stream, std::shared_ptr<Shared> shared, std::shared_ptr<SocketUser> user)
      : OpenOne(std::move(shared)), socket_(std::move(stream)), watch_(shared_->io), user_(std::move(user)) {}

  void accept(http::request<http::string_body> request, const std::string& protocol) {
    const auto silence = shared_->options.silence;
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has limits of its own
    socket_.set_option(websocket::stream_base::timeout{
        .handshake_timeout = shared_->options.request_time, .idle_timeout = silence, .keep_alive_pings = true});
    socket_.set_option(websocket::permessage_deflate{});  // neither side: it grows memory
    socket_.set_option(websocket::stream_base::decorator([protocol](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, protocol);
    }));
    socket_.read_message_max(shared_->options.message_bytes);
    socket_.auto_fragment(false);
    request_ = std::move(request);
    socket_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
      if (error) return self->end();
      self->look_at_writing();
      if (const auto user = self->user_) user->opened(*self);
      self->read();
    });
  }

  void send(Kind kind, std::string message) override {
    if (user_ == nullptr || closing_) return;
    queue_.push_back({kind, std::move(message)});
    if (queue_.size() == 1) write();
  }
  [[nodiscard]] std::size_t waiting() const override { return queue_.size(); }
  void close(unsigned short code, const std::string& reason) override {
    if (user_ == nullptr || closing_) return;
    closing_.emplace(code, reason);
    if (queue_.empty()) say_goodbye();
  }
  void drop() override { beast::get_lowest_layer(socket_).close(); }

 private:
  struct Message {
    Kind kind;
    std::string text;
  };
  using Clock = std::chrono::steady_clock;

  void read() {
    if (user_ == nullptr) return;
    reading_ = true;
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      self->reading_ = false;
      if (error) return self->end();
      const auto data = self->buffer_.cdata();
      if (const auto user = self->user_; user != nullptr && !self->closing_)
        user->received(self->socket_.got_binary() ? Kind::kBinary : Kind::kText,
                       {static_cast<const char*>(data.data()), data.size()});
      self->buffer_.consume(self->buffer_.size());
      if (self->queue_.size() < kMostWaiting) self->read();
    });
  }

  void write() {
    write_began_ = Clock::now();
    socket_.binary(queue_.front().kind == Kind::kBinary);
    socket_.async_write(asio::buffer(queue_.front().text),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          if (error) return self->end();
                          self->queue_.pop_front();
                          if (!self->queue_.empty()) return self->write();
                          if (self->closing_) return self->say_goodbye();
                          if (const auto user = self->user_) user->drained();
                          if (!self->reading_) self->read();
                        });
  }

  void say_goodbye() {
    write_began_ = Clock::now();
    websocket::close_reason reason;
    reason.code = closing_->first;
    reason.reason.assign(closing_->second.substr(0, kLongestReason));
    socket_.async_close(reason, [self = shared_from_this()](beast::error_code) { self->end(); });
  }

  /// A client that takes nothing gets nothing more. (One that says nothing is found by Beast's pings.)
  void look_at_writing() {
    watch_.expires_after(shared_->options.silence / 4);
    watch_.async_wait([self = shared_from_this()](beast::error_code error) {
      if (error || self->user_ == nullptr) return;
      const bool writes = !self->queue_.empty() || self->closing_;
      if (writes && Clock::now() - self->write_began_ > self->shared_->options.silence) return self->drop();
      self->look_at_writing();
    });
  }

  void end() {
    watch_.cancel();
    drop();
    if (const auto user = std::exchange(user_, nullptr)) user->closed();
  }

  static constexpr std::size_t kLongestReason = 123;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  http::request<http::string_body> request_;
  asio::steady_timer watch_;
  std::shared_ptr<SocketUser> user_;  ///< null: it has ended
  std::deque<Message> queue_;         ///< the first one is being written
  std::optional<std::pair<unsigned short, std::string>> closing_;
  Clock::time_point write_began_;
  bool reading_ = false;
};

/// One connection; it lives as long as something of it is under way.
class Connection final : public OpenOne, public std::enable_shared_from_this<Connection> {
 public:
  Connection(Tcp::socket socket, std::shared_ptr<Shared> shared, bool crowded)
      : OpenOne(std::move(shared)), stream_(std::move(socket)), crowded_(crowded) {
    beast::error_code error;
    const auto peer = stream_.socket().remote_endpoint(error);
    if (!error) peer_ = peer.address().to_string();  // its port changes with each connection
    stream_.socket().set_option(Tcp::no_delay(true), error);
  }

  /// Waits for the first byte of a request as long as a connection may be idle; from then on the whole has its time.
  void await_request() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(shared_->options.header_bytes));
    parser_->body_limit(shared_->options.body_bytes);
    if (buffer_.size() > 0) return read();
    stream_.expires_after(crowded_ ? std::min(kCrowdedTime, shared_->options.idle_time) : shared_->options.idle_time);
    stream_.async_read_some(buffer_.prepare(kChunk),
                            [self = shared_from_this()](beast::error_code error, std::size_t n) {
                              if (error) return;
                              self->buffer_.commit(n);
                              self->read();
                            });
  }

  void drop() override { stream_.close(); }

 private:
  static constexpr std::size_t kChunk = 16u << 10;
  static constexpr std::chrono::seconds kFarewell{1};
  static constexpr std::chrono::milliseconds kCrowdedTime{2000};  ///< for a request beyond the limit to come

  void read() {
    const auto whole = shared_->options.request_time;
    stream_.expires_after(crowded_ ? std::min(kCrowdedTime, whole) : whole);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) { self->on_read(error); });
  }

  void on_read(beast::error_code error) {
    if (error == http::error::end_of_stream) return close();
    if (error == http::error::header_limit) return refuse(431, "the header of the request is too long");
    if (error == http::error::body_limit) return refuse(413, "the body of the request is too long");
    if (error == beast::error::timeout) return;
    if (error && error.category() == http::make_error_code(http::error::bad_method).category())
      return refuse(400, "this is not an HTTP request: " + error.message());
    if (error) return;
    handle();
  }

  void handle() {
    HttpRequest request;
    const auto& message = parser_->get();
    request.method = std::string(message.method_string());
    request.target = std::string(message.target());
    request.body = message.body();
    request.peer = peer_;
    request.crowded = crowded_;
    for (const auto& field : message) {
      std::string name(field.name_string());
      for (char& letter : name)
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
      const auto [old, added] = request.headers.emplace(std::move(name), std::string(field.value()));
      if (!added) old->second += ", " + std::string(field.value());
    }
    keep_alive_ = message.keep_alive() && !crowded_;
    head_ = request.method == "HEAD";
    stream_.expires_never();  // the answer may take its time: it is the cell's
    if (shared_->handlers.upgrade && websocket::is_upgrade(message)) return upgrade(request);
    // Whoever keeps the function for long keeps no connection with it, once it has answered.
    const auto held = std::make_shared<std::shared_ptr<Connection>>(shared_from_this());
    shared_->handlers.handle(request, [held](HttpResponse response) {
      const std::shared_ptr<Connection> self = std::move(*held);
      if (self == nullptr || self->shared_->closed) return;
      asio::dispatch(self->stream_.get_executor(), [self, response = std::move(response)]() mutable {
        self->answer(std::move(response), self->keep_alive_);
      });
    });
  }

  void upgrade(const HttpRequest& request) {
    if (crowded_) return refuse(503, "there are too many connections");
    if (buffer_.size() > 0) return refuse(400, "a WebSocket speaks after the answer, not before");
    auto agreed = shared_->handlers.upgrade(request);
    if (!agreed) return answer(std::move(agreed.error()), false);
    const auto socket = std::make_shared<BeastSocket>(std::move(stream_), shared_, std::move(agreed->user));
    socket->accept(parser_->release(), agreed->protocol);
  }

  void refuse(int status, const std::string& detail) { answer(shared_->handlers.refuse(status, detail), false); }

  void answer(HttpResponse response, bool keep_alive) {
    message_ = {};
    message_.version(11);
    message_.result(static_cast<unsigned>(response.status));
    if (!response.content_type.empty()) message_.set(http::field::content_type, response.content_type);
    message_.set(http::field::cache_control, "no-store");
    message_.set("X-Content-Type-Options", "nosniff");
    for (const auto& [name, value] : response.headers) message_.set(name, value);
    message_.keep_alive(keep_alive);
    const std::size_t length = response.body.size();
    if (!head_) message_.body() = std::move(response.body);
    message_.content_length(length);
    stream_.expires_after(shared_->options.request_time);
    http::async_write(stream_, message_, [self = shared_from_this(), keep_alive](beast::error_code error, std::size_t) {
      if (error) return;
      if (keep_alive) return self->await_request();
      self->close();
    });
  }

  void close() {
    beast::error_code error;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, error);
    stream_.expires_after(kFarewell);
    forget_rest(shared_->options.body_bytes * 2);
  }

  /// What a client still sends is read, for else the system would take its answer away from it.
  void forget_rest(std::size_t most) {
    stream_.async_read_some(asio::buffer(rest_),
                            [self = shared_from_this(), most](beast::error_code error, std::size_t n) {
                              if (!error && n < most) self->forget_rest(most - n);
                            });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> message_;
  std::array<char, 4096> rest_{};
  std::string peer_;
  const bool crowded_;
  bool keep_alive_ = false, head_ = false;
};

}  // namespace

std::string HttpRequest::header(std::string_view name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? std::string() : found->second;
}

struct HttpServer::Impl {
  std::shared_ptr<Shared> shared = std::make_shared<Shared>();
  Tcp::acceptor acceptor{shared->io};
  std::jthread thread;

  void accept() {
    acceptor.async_accept([this](beast::error_code error, Tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        const bool full = shared->connections >= shared->options.connections;
        const bool flooded = shared->connections >= 2 * shared->options.connections;
        if (!flooded) {
          std::make_shared<Connection>(std::move(socket), shared, full)->await_request();
        }
      }
      accept();
    });
  }
};

Result<std::unique_ptr<HttpServer>> HttpServer::open(const Options& options, Handlers handlers) {
  std::unique_ptr<HttpServer> server(new HttpServer);
  server->impl_ = std::make_shared<Impl>();
  Impl& impl = *server->impl_;
  impl.shared->options = options;
  impl.shared->handlers = std::move(handlers);
  beast::error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error)
    return failure(Code::kInvalidValue, "--address", fmt::format("'{}' is no IP address", options.address),
                   "Give an address of this machine, such as 127.0.0.1 or ::1");
  const Tcp::endpoint endpoint(address, options.port);
  impl.acceptor.open(endpoint.protocol(), error);
  if (!error) impl.acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) impl.acceptor.bind(endpoint, error);
  if (!error) impl.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    return failure(Code::kSystem, "--port",
                   fmt::format("cannot listen at {} port {}: {}", options.address, options.port, error.message()),
                   "Choose another port with --port, or 0 for any that is free");
  impl.accept();
  impl.thread = std::jthread([&impl] { impl.shared->io.run(); });
  return server;
}

HttpServer::~HttpServer() {
  if (!impl_) return;
  // Whatever is under way ends by an error, and with that the thread has nothing to do any more.
  asio::post(impl_->shared->io, [impl = impl_.get()] {
    beast::error_code error;
    impl->acceptor.close(error);
    const std::lock_guard lock(impl->shared->mutex);
    for (OpenOne* one : impl->shared->open) one->drop();
  });
  if (impl_->thread.joinable()) impl_->thread.join();
  impl_->shared->closed = true;
}

unsigned short HttpServer::port() const {
  beast::error_code error;
  return impl_->acceptor.local_endpoint(error).port();
}

std::function<void(std::function<void()> work)> HttpServer::poster() const {
  return [shared = impl_->shared](std::function<void()> work) {
    if (!shared->closed) asio::post(shared->io, std::move(work));
  };
}

std::size_t HttpServer::connections() const { return impl_->shared->connections; }

}  // namespace takt::serve
