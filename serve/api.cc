#include "serve/api.h"

#include <charconv>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"

namespace takt::serve {
namespace {

constexpr std::size_t kMostJobs = 256, kLongestKey = 128;

}  // namespace

std::expected<nlohmann::ordered_json, HttpResponse> read_body(const HttpRequest& request) {
  if (request.body.empty()) return nlohmann::ordered_json::object();
  const std::string type = request.header("content-type");
  if (type.substr(0, type.find(';')) != "application/json")
    return std::unexpected(problem(415, "send the body as application/json"));
  auto json = parse_json(request.body);
  if (!json) return std::unexpected(problem(400, "the body is not valid JSON", json.error()));
  if (!json->is_object()) return std::unexpected(problem(422, "the body has to be a JSON object"));
  return std::move(*json);
}

rcc::NetId net_in(const Call& call) {
  const std::string& text = call.path.at("net");
  rcc::NetId net = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), net);
  return error == std::errc() && end == text.data() + text.size() ? net : 0;
}

Api::Api(ServedCell& cell, Access access, PanelFiles page, std::function<void(const std::string& line)> log,
         std::function<void(std::function<void()> work)> post)
    : cell_(cell),
      access_(std::move(access)),
      page_(std::move(page)),
      log_(std::move(log)),
      pictures_(cell),
      streams_(cell, access_, pictures_, log_, std::move(post),
               [this](std::function<void()> job) { return work_elsewhere(std::move(job)); }),
      scene_(make_scene()) {
  routes_.push_back({.method = "GET",
                     .path = "/v1/openapi.json",
                     .id = "openapi",
                     .summary = "This description.",
                     .answer = {{"openapi", "string", "version of OpenAPI"}},
                     .handle = [this](const Call&, const Respond& respond) {
                       respond(json_answer(200, openapi(routes_, StreamSession::messages(), access_.needs_token())));
                     }});
  add_cell_routes();
  add_device_routes();
  add_net_routes();
  add_command_routes();
  add_channel_routes();
  add_watch_routes();
  add_stream_routes();
  add_scene_routes();
  add_lease_routes();
  add_recording_routes();
  add_program_routes();
  worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

Api::~Api() {
  worker_.request_stop();
  for (const auto& [id, one] : watches_) cell_.core().unwatch(one.watch);
}

void Api::work(const std::stop_token& stop) {
  while (true) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return !jobs_.empty(); })) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    job();
  }
}

std::optional<HttpResponse> Api::check_need(const Route& route, Call& call) {
  if (route.need == Need::kLook || route.need == Need::kStop) return {};
  if (call.client.role != Role::kOperator) return problem(403, "observers may look and stop, and nothing else");
  if (route.need == Need::kOperator) return {};
  const std::string text = call.request->header("takt-fence");
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), call.fence);
  if (error != std::errc() || end != text.data() + text.size() || call.fence == 0) {
    Diagnostics why;
    why.error(Code::kMissing, "Takt-Fence", "a command needs the fence of the lease in the header Takt-Fence",
              "Take the lease with POST /v1/lease, and send its fence");
    return problem(400, "no fence", why);
  }
  if (route.need == Need::kHolder && cell_.program() != nullptr) {
    Diagnostics why;
    why.error(Code::kConflict, "", "a program commands this cell",
              "Write its channels, or ask for what /v1/program can do");
    return problem(409, "the cell is commanded by a program", why);
  }
  if (cell_.lease().renew(call.fence)) return {};
  Diagnostics why;
  why.error(Code::kNotPossibleNow, "Takt-Fence",
            fmt::format("{} is not, or no longer, the fence of a holder", call.fence),
            "Take the lease with POST /v1/lease");
  return problem(409, "the lease is not yours", why);
}

void Api::handle(const HttpRequest& request, const Respond& respond) {
  const Match found = match(routes_, request.method, request.target);
  const bool always = found.route != nullptr && found.route->need == Need::kStop;
  if (request.crowded && !always) return respond(problem(503, "there are too many connections"));
  Refusal refusal;
  // The page itself is for everybody: with it a browser learns nothing of the cell, and its script asks for the token.
  if (auto file = page_.answer(request)) {
    if (!access_.may_look_at_page(request, refusal)) return respond(problem(refusal.status, refusal.detail));
    return respond(std::move(*file));
  }
  auto client = access_.admit(request, always, {}, refusal);
  if (!client) return respond(problem(refusal.status, refusal.detail));
  if (found.allowed.empty()) return respond(problem(404, fmt::format("there is no '{}'", request.target)));
  if (found.route == nullptr) {
    HttpResponse response = problem(405, fmt::format("'{}' is not possible here: {}", request.method, found.allowed));
    response.headers["Allow"] = found.allowed;
    return respond(std::move(response));
  }
  Call call{.request = &request, .client = std::move(*client), .path = found.path, .query = {}, .texts = {}};
  if (const Diagnostics wrong = read_query(*found.route, found.query, call); wrong.has_errors())
    return respond(problem(422, "a parameter of the query is wrong", wrong));
  dispatch(*found.route, call, respond);
}

void Api::dispatch(const Route& route, Call& call, const Respond& respond) {
  const std::string key = call.request->header("idempotency-key");
  if (key.size() > kLongestKey) return respond(problem(422, "the key is longer than 128 characters"));
  try {
    // A repeated request gets its answer even if the lease has changed hands meanwhile: nothing is done twice.
    if (!key.empty() && route.method == "POST") return once_only(route, call, key, respond);
    if (auto refused = check_need(route, call)) return respond(std::move(*refused));
    route.handle(call, respond);
  } catch (const std::exception& error) {
    log_(fmt::format("{} {}: {}", route.method, route.path, error.what()));
    respond(problem(500, "an error of the server: its log says more"));
  }
}

void Api::once_only(const Route& route, const Call& given, const std::string& key, const Respond& respond) {
  const std::string whole = fmt::format("{}\n{}\n{}", given.client.name, given.request->target, key);
  const std::size_t body_hash = std::hash<std::string>()(given.request->body);
  {
    const std::lock_guard lock(mutex_);
    const auto found = kept_.find(whole);
    if (found != kept_.end()) {
      if (found->second.body_hash != body_hash)
        return respond(problem(422, "this key came with another request before"));
      if (!found->second.response) return respond(problem(409, "the first request of this key is not answered yet"));
      return respond(*found->second.response);
    }
  }
  Call call = given;
  if (auto refused = check_need(route, call)) return respond(std::move(*refused));
  {
    const std::lock_guard lock(mutex_);
    kept_[whole].body_hash = body_hash;
    kept_order_.push_back(whole);
    if (kept_order_.size() > kKeys) {
      kept_.erase(kept_order_.front());
      kept_order_.pop_front();
    }
  }
  const auto keep = [this, whole, respond](HttpResponse response) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = kept_.find(whole);
      if (found != kept_.end()) found->second.response = response;
    }
    respond(std::move(response));
  };
  try {
    route.handle(call, keep);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    kept_.erase(whole);
    throw;
  }
}

void Api::load(const Call& call, const Respond& respond) {
  const auto job = [this, request = *call.request, fence = call.fence, respond] {
    try {
      const auto json = read_body(request);
      json ? load_now(*json, fence, respond) : respond(json.error());
    } catch (const std::exception& error) {
      log_(fmt::format("LOAD: {}", error.what()));
      respond(problem(500, "an error of the server: its log says more"));
    }
  };
  if (!work_elsewhere(job)) respond(problem(429, "too many nets are waiting to be read: ask again"));
}

bool Api::work_elsewhere(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    if (jobs_.size() >= kMostJobs) return false;
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
  return true;
}

}  // namespace takt::serve
