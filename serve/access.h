#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "serve/http_server.h"

namespace takt::serve {

/// What a client may do: an observer looks and may STOP; an operator may take the lease and command.
enum class Role { kObserver, kOperator };
[[nodiscard]] std::string_view name_of(Role role);

/// One line of the token file: ROLE NAME TOKEN.
struct Token {
  Role role = Role::kObserver;
  std::string name, secret;
};

/// Reads a token file: a line each of "observer|operator NAME TOKEN", '#' begins a comment. The file must belong to
/// this user and be readable by nobody else (mode 0600), tokens have 16 to 256 characters. @return the tokens, or all
/// that is wrong. Realtime: setup.
[[nodiscard]] Result<std::vector<Token>> read_tokens(const std::filesystem::path& file);

/// Why a page cannot have this origin: scheme://host, with a port where it is not the usual one, and nothing behind it.
/// Pointers are `place`. Realtime: setup.
[[nodiscard]] Diagnostics check_origin(const std::string& place, const std::string& origin);
/// Why a machine cannot have this name, without scheme and port.
[[nodiscard]] Diagnostics check_host_name(const std::string& place, const std::string& name);

/// True if both are equal; takes the same time wherever they differ.
[[nodiscard]] bool equal_in_constant_time(std::string_view one, std::string_view other);

/// Who asks.
struct Client {
  Role role = Role::kOperator;
  std::string name;
};

/// 32 hexadecimal digits that nobody can guess.
[[nodiscard]] std::string random_secret();

/// Stands for a token once: a browser cannot send headers with a WebSocket, and an address with a token in it would lie
/// in logs. One thread.
class Tickets {
 public:
  static constexpr std::chrono::seconds kLife{30};
  static constexpr std::size_t kMost = 256;  ///< not used yet; the oldest one goes

  /// A random_secret().
  [[nodiscard]] std::string give(const Client& client);
  /// @return whom it was given to; nothing: nobody, or it was used, or too long ago
  [[nodiscard]] std::optional<Client> take(std::string_view ticket);

 private:
  using Clock = std::chrono::steady_clock;
  struct Given {
    std::string ticket;
    Client client;
    Clock::time_point until;
  };
  std::vector<Given> given_;  ///< the oldest first
};

/// Why a request is turned away.
struct Refusal {
  int status = 401;
  std::string detail;
};

/// Who may ask at all: Host and Origin are compared exactly, so that no web page of another site gets through with a
/// name of its own (DNS rebinding); tokens where there are any; so many requests a second. One thread.
class Access {
 public:
  struct Options {
    std::vector<Token> tokens;                                ///< empty: everybody is an operator, for loopback only
    std::vector<std::string> hosts;                           ///< allowed values of Host, with port
    std::vector<std::string> origins = {};                    ///< of pages elsewhere that may use this server
    double requests_per_second = 10'000.0, burst = 20'000.0;  ///< of one client's address
  };
  explicit Access(Options options) : options_(std::move(options)) {}

  /// @param always  STOP: never refused for its rate
  /// @param ticket  in place of a token, if there is one
  /// @return the client, or nothing and `refusal`
  [[nodiscard]] std::optional<Client> admit(const HttpRequest& request, bool always, std::string_view ticket,
                                            Refusal& refusal);
  /// The same for what is no secret: Host, Origin and rate count, no token is asked for.
  [[nodiscard]] bool may_look_at_page(const HttpRequest& request, Refusal& refusal);
  [[nodiscard]] bool needs_token() const { return !options_.tokens.empty(); }
  [[nodiscard]] Tickets& tickets() { return tickets_; }
  /// Counts a request, or a message, of this address. @return true: there are too many a second
  [[nodiscard]] bool too_fast(const std::string& address);
  [[nodiscard]] double requests_per_second() const { return options_.requests_per_second; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Bucket {
    double left = 0.0;
    Clock::time_point filled;
  };
  [[nodiscard]] bool is_meant_for_us(const HttpRequest& request, Refusal& refusal) const;
  [[nodiscard]] std::optional<Client> client_of(const HttpRequest& request) const;

  Options options_;
  Tickets tickets_;
  std::map<std::string, Bucket, std::less<>> buckets_;  ///< by address without port
};

}  // namespace takt::serve
