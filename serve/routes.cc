#include "serve/routes.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/judge/run_report.h"
#include "core/base/version.h"

namespace takt::serve {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::map<std::string, std::string, std::less<>>;

const std::vector<std::pair<int, std::string>>& titles() {
  static const std::vector<std::pair<int, std::string>> all = {
      {400, "Bad request"},       {401, "No valid token"},     {403, "Not allowed"},
      {404, "Not found"},         {405, "Method not allowed"}, {409, "Conflict"},
      {413, "Request too large"}, {415, "Not JSON"},           {421, "Wrong host"},
      {422, "Invalid input"},     {426, "Upgrade required"},   {429, "Too many requests"},
      {431, "Header too large"},  {500, "Internal error"},     {503, "Busy"}};
  return all;
}

std::string title_of(int status) {
  for (const auto& [one, title] : titles())
    if (one == status) return title;
  return "Error";
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(at);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::optional<std::string> unescape(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    unsigned value = 0;
    if (i + 2 >= text.size()) return {};
    const auto [end, error] = std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
    if (error != std::errc() || end != text.data() + i + 3) return {};
    plain += static_cast<char>(value);
    i += 2;
  }
  return plain;
}

bool fits(std::string_view pattern, std::string_view path, Values& values) {
  const auto wanted = split(pattern, '/'), given = split(path, '/');
  if (wanted.size() != given.size()) return false;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i].starts_with('{')) {
      if (wanted[i] != given[i]) return false;
      continue;
    }
    auto value = unescape(given[i]);
    if (!value || value->empty()) return false;
    values[std::string(wanted[i].substr(1, wanted[i].size() - 2))] = std::move(*value);
  }
  return true;
}

Json schema_of(const Field& field) {
  Json schema = Json::object();
  if (!field.type.empty()) schema["type"] = field.type;
  if (!field.doc.empty()) schema["description"] = field.doc;
  if (field.minimum) schema["minimum"] = *field.minimum;
  if (field.maximum) schema["maximum"] = *field.maximum;
  return schema;
}

Json object_of(const std::vector<Field>& fields, bool closed) {
  Json properties = Json::object(), required = Json::array();
  for (const Field& field : fields) {
    properties[field.name] = schema_of(field);
    if (field.required) required.push_back(field.name);
  }
  Json schema = {{"type", "object"}, {"properties", properties}};
  if (!required.empty()) schema["required"] = required;
  // Keys that begin with "comment" or "$" are allowed everywhere, as in files.
  if (closed) {
    schema["patternProperties"] = {{"^(comment|\\$)", Json::object()}};
    schema["additionalProperties"] = false;
  }
  return schema;
}

std::string need_text(Need need) {
  switch (need) {
    case Need::kLook:
      return "Any client.";
    case Need::kOperator:
      return "Operators.";
    case Need::kHolder:
      return "The holder of the lease, with its fence in the header Takt-Fence.";
    case Need::kChannels:
      return "The holder of the lease, with its fence in the header Takt-Fence, also beside a program.";
    case Need::kStop:
      return "Any client, at any time, whoever holds the lease.";
  }
  return {};
}

Json parameters_of(const Route& route) {
  Json parameters = Json::array();
  for (const std::string_view part : split(route.path, '/'))
    if (part.starts_with('{'))
      parameters.push_back({{"name", part.substr(1, part.size() - 2)},
                            {"in", "path"},
                            {"required", true},
                            {"schema", {{"type", "string"}, {"minLength", 1}}}});
  for (const Field& field : route.query)
    parameters.push_back({{"name", field.name},
                          {"in", "query"},
                          {"required", field.required},
                          {"description", field.doc},
                          {"schema", schema_of(field)}});
  if (route.need == Need::kHolder || route.need == Need::kChannels)
    parameters.push_back({{"name", "Takt-Fence"},
                          {"in", "header"},
                          {"required", true},
                          {"schema", {{"type", "integer"}, {"minimum", 1}}}});
  if (route.method == "POST")
    parameters.push_back(
        {{"name", "Idempotency-Key"},
         {"in", "header"},
         {"required", false},
         {"description", "A repeated request with the same key gets the first answer and does nothing."},
         {"schema", {{"type", "string"}, {"minLength", 1}, {"maxLength", 128}}}});
  return parameters;
}

Json operation_of(const Route& route) {
  Json operation = {{"operationId", route.id},
                    {"summary", route.summary},
                    {"description", need_text(route.need)},
                    {"parameters", parameters_of(route)}};
  if (route.method == "POST" || route.method == "PUT")
    operation["requestBody"] = {{"required", std::ranges::any_of(route.body, &Field::required)},
                                {"content", {{"application/json", {{"schema", object_of(route.body, true)}}}}}};
  Json responses = Json::object();
  const bool is_json = route.media == "application/json";
  Json& good = responses[std::to_string(route.status)] = {{"description", "As asked."}};
  if (!route.media.empty())
    good["content"] = {{route.media, {{"schema", is_json ? object_of(route.answer, false) : Json::object()}}}};
  for (const auto& [status, title] : titles())
    responses[std::to_string(status)] = {
        {"description", title},
        {"content", {{"application/problem+json", {{"schema", {{"$ref", "#/components/schemas/Problem"}}}}}}}};
  operation["responses"] = responses;
  return operation;
}

void read_parameter(const Field& field, std::string_view given, Call& call, Diagnostics& diagnostics) {
  if (field.type == "string") {
    const auto plain = unescape(given);
    if (plain) {
      call.texts.emplace(field.name, *plain);
    } else {
      diagnostics.error(Code::kSyntax, "?" + field.name, fmt::format("'{}' cannot be read", given),
                        "Write % and two hexadecimal digits");
    }
    return;
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value);
  const bool is_number = error == std::errc() && end == given.data() + given.size() && !given.empty();
  if (is_number && (!field.minimum || value >= *field.minimum) && (!field.maximum || value <= *field.maximum)) {
    call.query.emplace(field.name, value);
    return;
  }
  diagnostics.error(is_number ? Code::kOutOfRange : Code::kWrongType, "?" + field.name,
                    fmt::format("'{}' is not possible for '{}'", given, field.name),
                    fmt::format("Give an integer from {} to {}", field.minimum.value_or(0),
                                field.maximum.value_or(std::numeric_limits<std::int64_t>::max())));
}

}  // namespace

Match match(std::span<const Route> routes, std::string_view method, std::string_view target) {
  Match found;
  const std::size_t question = target.find('?');
  if (question != std::string_view::npos) found.query = target.substr(question + 1);
  const std::string_view path = target.substr(0, question);
  for (const Route& route : routes) {
    Values values;
    if (!fits(route.path, path, values)) continue;
    found.allowed += (found.allowed.empty() ? "" : ", ") + route.method;
    if (route.method != method) continue;
    found.route = &route;
    found.path = std::move(values);
  }
  return found;
}

Diagnostics read_query(const Route& route, std::string_view text, Call& call) {
  Diagnostics diagnostics;
  std::vector<std::string> names;
  for (const Field& field : route.query) names.push_back(field.name);
  for (const std::string_view part : split(text, '&')) {
    if (part.empty()) continue;
    const std::string name(part.substr(0, part.find('=')));
    const std::string_view given = part.size() > name.size() ? part.substr(name.size() + 1) : std::string_view();
    const auto field = std::ranges::find(route.query, name, &Field::name);
    if (field == route.query.end()) {
      diagnostics.error(Code::kUnknownKey, "?" + name, fmt::format("unknown parameter '{}'", name),
                        nearest_choice(name, names));
    } else if (call.query.contains(name) || call.texts.contains(name)) {
      diagnostics.error(Code::kDuplicate, "?" + name, fmt::format("duplicate parameter '{}'", name), "Give it once");
    } else {
      read_parameter(*field, given, call, diagnostics);
    }
  }
  for (const Field& field : route.query)
    if (field.required && !call.query.contains(field.name) && !call.texts.contains(field.name) &&
        !diagnostics.has_errors())
      diagnostics.error(Code::kMissing, "?" + field.name, fmt::format("parameter '{}' is missing", field.name),
                        "Add it: " + field.doc);
  return diagnostics;
}

Json messages_json(std::span<const MessageForm> messages) {
  Json list = Json::array();
  for (const MessageForm& one : messages)
    list.push_back({{"op", one.op},
                    {"from", one.from_client ? "client" : "server"},
                    {"description", one.doc},
                    {"schema", object_of(one.fields, one.from_client)}});
  return list;
}

Json openapi(std::span<const Route> routes, std::span<const MessageForm> messages, bool needs_token) {
  Json security = Json::array({Json{{"token", Json::array()}}});
  if (!needs_token) security.push_back(Json::object());
  Json paths = Json::object();
  for (const Route& route : routes) {
    std::string method = route.method;
    for (char& letter : method) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    paths[route.path][method] = operation_of(route);
  }
  const Json diagnostic = object_of({{"severity", "string", "error, warning or note"},
                                     {"code", "string", "stable name of the kind of error"},
                                     {"pointer", "string", "JSON pointer into the input"},
                                     {"message", "string", "what is wrong"},
                                     {"hint", "string", "how to fix it"}},
                                    false);
  Json reduced = diagnostic;
  reduced["required"] = {"code", "message"};
  const Json problem_schema = {{"type", "object"},
                               {"properties",
                                {{"type", {{"type", "string"}}},
                                 {"title", {{"type", "string"}}},
                                 {"status", {{"type", "integer"}}},
                                 {"detail", {{"type", "string"}}},
                                 {"diagnostics", {{"type", "array"}, {"items", reduced}}}}},
                               {"required", {"type", "title", "status", "detail"}}};
  return {{"openapi", "3.1.0"},
          {"info",
           {{"title", "takt: a robot control core by network"},
            {"version", fmt::format("{}.{}.{}", TAKT_VERSION_MAJOR, TAKT_VERSION_MINOR, TAKT_VERSION_PATCH)}}},
          {"paths", paths},
          {"x-takt-messages", messages_json(messages)},
          {"components",
           {{"schemas", {{"Problem", problem_schema}}},
            {"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}},
          {"security", security}};
}

HttpResponse json_answer(int status, const Json& body) {
  return {.status = status, .body = body.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

Json problem_json(int status, const std::string& detail, const Diagnostics& diagnostics) {
  Json body = {{"type", "about:blank"}, {"title", title_of(status)}, {"status", status}, {"detail", detail}};
  if (!diagnostics.empty()) body["diagnostics"] = cell::to_json(diagnostics);
  return body;
}

HttpResponse problem(int status, const std::string& detail, const Diagnostics& diagnostics) {
  HttpResponse response = json_answer(status, problem_json(status, detail, diagnostics));
  response.content_type = "application/problem+json";
  if (status == 401) response.headers["WWW-Authenticate"] = "Bearer";
  return response;
}

}  // namespace takt::serve
