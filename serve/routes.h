#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "serve/access.h"
#include "serve/http_server.h"

namespace takt::serve {

/// A named value of a request or an answer: what OpenAPI says about it.
struct Field {
  std::string name;
  std::string type;  ///< of JSON: integer, number, string, boolean, object, array; empty: any
  std::string doc;   ///< meaning and unit
  bool required = true;
  std::optional<std::int64_t> minimum = {}, maximum = {};
};

/// What a route needs of the client that asks.
enum class Need {
  kLook,
  kOperator,
  kHolder,    ///< of devices
  kChannels,  ///< of the lease; where a program commands the devices it is for the channels alone
  kStop
};

/// A request that fits a route.
struct Call {
  const HttpRequest* request = nullptr;
  Client client;
  std::map<std::string, std::string, std::less<>> path;    ///< by name of the parameter
  std::map<std::string, std::int64_t, std::less<>> query;  ///< checked against the fields
  std::map<std::string, std::string, std::less<>> texts;   ///< likewise, of fields of type string
  std::uint32_t fence = 0;                                 ///< Need::kHolder: of the holder
};

/// One row of the table of routes: what is answered, and what OpenAPI says of it. There is no other list.
struct Route {
  std::string method, path;  ///< "/v1/nets/{net}"; a parameter is a whole segment
  std::string id, summary;   ///< operationId; one sentence
  Need need = Need::kLook;
  int status = 200;  ///< of a good answer
  std::vector<Field> query = {}, body = {}, answer = {};
  std::string media = "application/json";  ///< of a good answer
  std::function<void(const Call& call, const Respond& respond)> handle = {};
};

/// The route of a request and the values of its path; `path_known`: another method would fit.
struct Match {
  const Route* route = nullptr;
  std::map<std::string, std::string, std::less<>> path = {};
  std::string query = {};
  std::string allowed = {};  ///< methods of this path, for 405; empty: there is no such path
};
[[nodiscard]] Match match(std::span<const Route> routes, std::string_view method, std::string_view target);

/// Reads the values of a query string that a route knows, within their bounds. @return all that is wrong with it
[[nodiscard]] Diagnostics read_query(const Route& route, std::string_view text, Call& call);

/// One row of the table of messages of the streams: what is read, and what OpenAPI says of it.
struct MessageForm {
  std::string op;
  bool from_client = true;
  std::string doc;
  std::vector<Field> fields = {};
};

/// The description of all routes, OpenAPI 3.1, with the messages as "x-takt-messages".
/// @param needs_token  every request has to have one
[[nodiscard]] nlohmann::ordered_json openapi(std::span<const Route> routes, std::span<const MessageForm> messages,
                                             bool needs_token);

/// An error as RFC 9457 says: type, title, status, detail, and our diagnostics with code and JSON pointer.
[[nodiscard]] nlohmann::ordered_json problem_json(int status, const std::string& detail,
                                                  const Diagnostics& diagnostics = {});
[[nodiscard]] HttpResponse problem(int status, const std::string& detail, const Diagnostics& diagnostics = {});
[[nodiscard]] HttpResponse json_answer(int status, const nlohmann::ordered_json& body);

}  // namespace takt::serve
