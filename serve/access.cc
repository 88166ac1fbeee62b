#include "serve/access.h"

#include <algorithm>
#include <charconv>
#include <random>
#include <sstream>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/json.h"

namespace takt::serve {
namespace {

constexpr std::size_t kTokenFileBytes = 64u << 10, kShortest = 16, kLongest = 256, kBuckets = 4096;
constexpr std::string_view kBearer = "Bearer ";

Diagnostics check_file(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return diagnostics;  // reading it says why
  if (status.st_uid != geteuid() && geteuid() != 0)
    diagnostics.error(Code::kInvalidValue, "--tokens", "the token file belongs to another user",
                      "Make a file of your own");
  if ((status.st_mode & 077) != 0)
    diagnostics.error(Code::kInvalidValue, "--tokens",
                      fmt::format("others may read the token file (mode {:04o})", status.st_mode & 07777),
                      "Run chmod 600 on it");
  return diagnostics;
}

}  // namespace

std::string_view name_of(Role role) { return role == Role::kOperator ? "operator" : "observer"; }

Result<std::vector<Token>> read_tokens(const std::filesystem::path& file) {
  Diagnostics diagnostics = check_file(file);
  const auto text = read_file(file, kTokenFileBytes);
  if (!text) {
    diagnostics.append(text.error());
    return std::unexpected(std::move(diagnostics));
  }
  std::vector<Token> tokens;
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string role, more;
    Token token;
    if (!(words >> role)) continue;
    const std::string at = fmt::format("line {}", number);
    if (role != "observer" && role != "operator")
      diagnostics.error(Code::kInvalidValue, at, fmt::format("unknown role '{}'", role),
                        "Begin the line with observer or operator");
    token.role = role == "operator" ? Role::kOperator : Role::kObserver;
    if (!(words >> token.name >> token.secret) || words >> more)
      diagnostics.error(Code::kSyntax, at, "a line is ROLE NAME TOKEN", "Write for example: operator anna TOKEN");
    else if (token.secret.size() < kShortest || token.secret.size() > kLongest)
      diagnostics.error(Code::kWrongSize, at, fmt::format("the token has {} characters", token.secret.size()),
                        "Use 16 to 256 characters, for example of: openssl rand -hex 24");
    tokens.push_back(std::move(token));
  }
  if (tokens.empty())
    diagnostics.error(Code::kMissing, "", "the token file has no tokens", "Add a line ROLE NAME TOKEN");
  diagnostics.set_file(file.string());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return tokens;
}

namespace {

bool is_host(std::string_view text) {
  if (text.starts_with('[') && text.ends_with(']') && text.size() > 2)
    return text.find_first_not_of("0123456789abcdef:.", 1) == text.size() - 1;
  return !text.empty() && text.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz-_.") == std::string_view::npos &&
         !text.starts_with('.') && !text.starts_with('-');
}

bool is_port(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port > 0 && port < 65536 && text.front() != '0';
}

}  // namespace

Diagnostics check_origin(const std::string& place, const std::string& origin) {
  Diagnostics wrong;
  const auto refuse = [&](std::string_view what) {
    wrong.error(Code::kInvalidValue, place, fmt::format("'{}' is no origin: {}", origin, what),
                "Give scheme, host and, if it is not the usual one, port in lower case: https://panel.example:8443");
  };
  std::string_view rest = origin;
  if (rest.starts_with("https://")) {
    rest.remove_prefix(8);
  } else if (rest.starts_with("http://")) {
    rest.remove_prefix(7);
  } else {
    refuse("it begins with neither http:// nor https://");
    return wrong;
  }
  if (rest.find_first_of("/?#@") != std::string_view::npos) {
    refuse("an origin has no path, no query and no user");
    return wrong;
  }
  const std::size_t bracket = rest.rfind(']');
  const std::size_t colon = rest.find(':', rest.starts_with('[') && bracket != std::string_view::npos ? bracket : 0);
  if (!is_host(rest.substr(0, colon))) refuse("its host is none, or is not in lower case");
  if (colon != std::string_view::npos && !is_port(rest.substr(colon + 1))) refuse("its port is none of 1 to 65535");
  return wrong;
}

Diagnostics check_host_name(const std::string& place, const std::string& name) {
  Diagnostics wrong;
  if (!is_host(name))
    wrong.error(Code::kInvalidValue, place, fmt::format("'{}' is no name of a machine", name),
                "Give a name without scheme and port, in lower case: robot.example");
  return wrong;
}

bool equal_in_constant_time(std::string_view one, std::string_view other) {
  // The length of a token is no secret; its letters are.
  unsigned differ = one.size() == other.size() ? 0 : 1;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const char against = other.empty() ? '\0' : other[i % other.size()];
    differ |= static_cast<unsigned>(static_cast<unsigned char>(one[i] ^ against));
  }
  return differ == 0;
}

bool Access::too_fast(const std::string& address) {
  const auto now = Clock::now();
  if (buckets_.size() >= kBuckets && !buckets_.contains(address)) buckets_.clear();
  const auto [found, is_new] = buckets_.try_emplace(address, Bucket{options_.burst, now});
  Bucket& bucket = found->second;
  const double since = std::chrono::duration<double>(now - bucket.filled).count();
  bucket.left = std::min(options_.burst, bucket.left + since * options_.requests_per_second);
  bucket.filled = now;
  if (bucket.left < 1.0) return true;
  bucket.left -= 1.0;
  return false;
}

std::string random_secret() {
  std::random_device device;
  std::string secret;
  for (int i = 0; i < 4; ++i) secret += fmt::format("{:08x}", device());
  return secret;
}

std::string Tickets::give(const Client& client) {
  const std::string ticket = random_secret();
  if (given_.size() >= kMost) given_.erase(given_.begin());
  given_.push_back({.ticket = ticket, .client = client, .until = Clock::now() + kLife});
  return ticket;
}

std::optional<Client> Tickets::take(std::string_view ticket) {
  const auto now = Clock::now();
  std::erase_if(given_, [now](const Given& one) { return one.until < now; });
  std::optional<Client> client;
  for (const Given& one : given_)
    if (equal_in_constant_time(one.ticket, ticket)) client = one.client;
  std::erase_if(given_, [ticket](const Given& one) { return one.ticket == ticket; });
  return client;
}

std::optional<Client> Access::client_of(const HttpRequest& request) const {
  if (options_.tokens.empty()) return Client{.role = Role::kOperator, .name = request.peer};
  std::optional<Client> client;
  const std::string given = request.header("authorization");
  for (const Token& token : options_.tokens)
    if (given.starts_with(kBearer) &&
        equal_in_constant_time(std::string_view(given).substr(kBearer.size()), token.secret))
      client = Client{.role = token.role, .name = token.name};
  return client;
}

bool Access::is_meant_for_us(const HttpRequest& request, Refusal& refusal) const {
  const std::string host = request.header("host");
  const std::string origin = request.header("origin");
  const auto allowed = [this](const std::string& one) {
    return std::ranges::find(options_.hosts, one) != options_.hosts.end();
  };
  if (!allowed(host)) {
    refusal = {421, fmt::format("this server is not '{}'", host)};
    return false;
  }
  const bool ours = origin == "http://" + host || origin == "https://" + host;
  if (!origin.empty() && !ours && std::ranges::find(options_.origins, origin) == options_.origins.end()) {
    refusal = {403, fmt::format("pages of '{}' may not use this server", origin)};
    return false;
  }
  return true;
}

bool Access::may_look_at_page(const HttpRequest& request, Refusal& refusal) {
  if (!is_meant_for_us(request, refusal)) return false;
  if (!too_fast(request.peer)) return true;
  refusal = {429, fmt::format("more than {:g} requests a second", options_.requests_per_second)};
  return false;
}

std::optional<Client> Access::admit(const HttpRequest& request, bool always, std::string_view ticket,
                                    Refusal& refusal) {
  if (!is_meant_for_us(request, refusal)) return {};
  std::optional<Client> client = ticket.empty() ? client_of(request) : tickets_.take(ticket);
  if (!client && !ticket.empty()) {
    refusal = {401, "this ticket was used, or is too old: get another one with POST /v1/tickets"};
    return {};
  }
  if (!client) {
    refusal = {401, "a token is needed: Authorization: Bearer TOKEN"};
    return {};
  }
  if (!always && too_fast(request.peer)) {
    refusal = {429, fmt::format("more than {:g} requests a second", options_.requests_per_second)};
    return {};
  }
  return client;
}

}  // namespace takt::serve
