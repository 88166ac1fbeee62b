// Streams, and what viewers need: tickets, the WebSocket, the scene with its meshes, pictures.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "serve/api.h"
#include "serve/layout.h"

namespace takt::serve {
namespace {

using SceneJson = nlohmann::ordered_json;

constexpr std::string_view kStreamRoute = "stream";

SceneJson pose_json(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const auto& p = X.translation();
  return {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
}

/// The figures of a shape, by their names.
SceneJson shape_json(const cell::SceneShape& shape) {
  using enum cell::SceneShape::Kind;
  const auto [a, b, c] = shape.size;
  SceneJson json;
  switch (shape.kind) {
    case kPlane:
      json = {{"kind", "plane"}, {"size", {2 * a, 2 * b}}};
      break;
    case kSphere:
      json = {{"kind", "sphere"}, {"radius", a}};
      break;
    case kCapsule:
      json = {{"kind", "capsule"}, {"radius", a}, {"length", 2 * b}};
      break;
    case kEllipsoid:
      json = {{"kind", "ellipsoid"}, {"radii", {a, b, c}}};
      break;
    case kCylinder:
      json = {{"kind", "cylinder"}, {"radius", a}, {"length", 2 * b}};
      break;
    case kBox:
      json = {{"kind", "box"}, {"size", {2 * a, 2 * b, 2 * c}}};
      break;
    case kMesh:
      json = {{"kind", "mesh"}, {"mesh", shape.mesh}};
      break;
  }
  json["pose"] = pose_json(shape.X_BS);
  json["rgba"] = shape.rgba;
  return json;
}

/// Frames whose place nobody knows are left out.
SceneJson frames_json(const world::FrameGraph& frames) {
  const std::vector<std::string> moving = frames.moving();
  const auto moves = [&](std::string_view one) {
    return std::ranges::any_of(moving, [&](const auto& other) { return frames.depends_on(one, other); });
  };
  SceneJson list = SceneJson::array();
  for (const std::string& name : frames.names())
    if (const auto X_WF = frames.pose(name))
      list.push_back({{"name", name}, {"pose", pose_json(*X_WF)}, {"fixed", !moves(name)}});
  return list;
}

SceneJson sensors_json(const expression::Cell& cell) {
  SceneJson list = SceneJson::array();
  for (const auto& [name, sensor] : cell.sensors)
    list.push_back({{"name", name}, {"arm", sensor.arm}, {"pose", pose_json(sensor.X_FS)}});
  return list;
}

std::string mesh_bytes(const cell::SceneMesh& mesh) {
  std::string bytes;
  append_number(bytes, static_cast<std::uint32_t>(mesh.points.size()));
  append_number(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& point : mesh.points)
    for (const float part : point) append_number(bytes, part);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) append_number(bytes, corner);
  return bytes;
}

/// Whether a list of sub-protocols, as a header has it, has this one.
bool offers(std::string_view list, std::string_view protocol) {
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    std::string_view one = list.substr(0, comma);
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    if (one == protocol) return true;
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return false;
}

/// Foxglove's clients ask for the root.
std::string stream_target(const std::string& target) {
  const bool is_root = target == "/" || target.starts_with("/?");
  return is_root ? "/v1/stream" + target.substr(1) : target;
}

HttpResponse upgrade_needed() {
  HttpResponse response = problem(
      426, fmt::format("connect with a WebSocket and a sub-protocol: {}", fmt::join(Streams::protocols(), ", ")));
  response.headers["Upgrade"] = "websocket";
  return response;
}

}  // namespace

void Api::add_stream_routes() {
  routes_.push_back({.method = "POST",
                     .path = "/v1/tickets",
                     .id = "give_ticket",
                     .summary = "A ticket for one WebSocket, for clients that cannot send headers with it.",
                     .status = 201,
                     .answer = {{"ticket", "string", "good once"}, {"seconds", "integer", "for so long"}},
                     .handle = [this](const Call& call, const Respond& respond) {
                       const auto json = read_body(*call.request);
                       if (!json) return respond(json.error());
                       Diagnostics diagnostics;
                       ObjectReader(*json, "", diagnostics).finish();
                       if (diagnostics.has_errors())
                         return respond(problem(422, "the request cannot be read", diagnostics));
                       respond(json_answer(201, {{"ticket", access_.tickets().give(call.client)},
                                                 {"seconds", Tickets::kLife.count()}}));
                     }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/stream",
                     .id = std::string(kStreamRoute),
                     .summary = "Becomes a WebSocket with the sub-protocol takt.v1 (x-takt-messages), or Foxglove's.",
                     .status = 101,
                     .query = {{"ticket", "string", "in place of a token", false}},
                     .media = "",
                     .handle = [](const Call&, const Respond& respond) { respond(upgrade_needed()); }});
}

std::expected<Upgrade, HttpResponse> Api::upgrade(const HttpRequest& request) {
  const Match found = match(routes_, request.method, stream_target(request.target));
  Call call{.request = &request, .client = {}, .path = {}, .query = {}, .texts = {}};
  Diagnostics wrong;
  if (found.route != nullptr) wrong = read_query(*found.route, found.query, call);
  const auto ticket = call.texts.find("ticket");
  Refusal refusal;
  const auto client = access_.admit(request, false, ticket == call.texts.end() ? "" : ticket->second, refusal);
  if (!client) return std::unexpected(problem(refusal.status, refusal.detail));
  if (found.route == nullptr || found.route->id != kStreamRoute)
    return std::unexpected(problem(404, fmt::format("there is no WebSocket at '{}'", request.target)));
  if (wrong.has_errors()) return std::unexpected(problem(422, "a parameter of the query is wrong", wrong));
  if (streams_.count(client->name) >= kStreamsOfOne)
    return std::unexpected(problem(429, fmt::format("'{}' has {} streams: close some", client->name, kStreamsOfOne)));
  const std::string offered = request.header("sec-websocket-protocol");
  for (const std::string& protocol : Streams::protocols()) {
    if (!offers(offered, protocol)) continue;
    log_(fmt::format("'{}' has a stream ({})", client->name, protocol));
    return Upgrade{.protocol = protocol, .user = streams_.open(protocol, *client, request.peer)};
  }
  return std::unexpected(upgrade_needed());
}

void Api::add_scene_routes() {
  routes_.push_back(
      {.method = "GET",
       .path = "/v1/scene",
       .id = "scene",
       .summary = "What the cell looks like: bodies with their shapes; it does not change.",
       .answer = {{"bodies", "array", "name, parent, pose, shapes of each"},
                  {"moving", "array", "indices of those that may move"},
                  {"commanded", "array", "indices of those that set points move"},
                  {"meshes", "array", "vertices, triangles and bytes of each"},
                  {"cameras", "array", "names"},
                  {"frames", "array", "name, pose in the world as the server began, and whether it stays"},
                  {"sensors", "array", "force/torque sensors: name, arm, and pose in its flange"}},
       .handle = [this](const Call&, const Respond& respond) { respond(scene_); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/scene/meshes/{mesh}",
                     .id = "mesh",
                     .summary = "A mesh of the scene: numbers of vertices and triangles (u32), positions (f32, m), "
                                "corners (u32), little-endian.",
                     .media = "application/octet-stream",
                     .handle = [this](const Call& call, const Respond& respond) { respond(mesh(call)); }});
  routes_.push_back(
      {.method = "GET",
       .path = "/v1/layout",
       .id = "layout",
       .summary = "The layout of the page for this cell: the file NAME.layout beside NAME.json.",
       .answer = {{"layout", "", "as in docs/panel.md; null: there is none, or it is broken"},
                  {"diagnostics", "array", "what is wrong with it: code, pointer, message, hint of each"}},
       .handle = [this](const Call&, const Respond& respond) { respond(layout()); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/cameras",
                     .id = "cameras",
                     .summary = "The cameras of the cell as pinhole cameras: their pictures have no distortion.",
                     .answer = {{"cameras", "array",
                                 "name; fovy_rad, vertical; focal, focal length over height of the picture; its "
                                 "centre is the middle of the picture"}},
                     .handle = [this](const Call&, const Respond& respond) { respond(cameras()); }});
  routes_.push_back({.method = "GET",
                     .path = "/v1/cameras/{camera}/picture",
                     .id = "picture",
                     .summary = "What a camera of the cell, or 'overview', sees now, as PNG; the header Takt-Cycle "
                                "has the cycle of the state. Pictures all the time: monitor of a camera (streams).",
                     .query = {{"width", "integer", "pixels (default 640)", false, cell::CellCamera::kLeast,
                                cell::CellCamera::kMostWidth},
                               {"height", "integer", "pixels (default 360)", false, cell::CellCamera::kLeast,
                                cell::CellCamera::kMostHeight}},
                     .media = "image/png",
                     .handle = [this](const Call& call, const Respond& respond) { picture(call, respond); }});
}

HttpResponse Api::make_scene() const {
  const cell::CellScene& scene = streams_.scene();
  SceneJson bodies = SceneJson::array(), meshes = SceneJson::array();
  for (const cell::SceneBody& body : scene.bodies()) {
    SceneJson shapes = SceneJson::array();
    for (const cell::SceneShape& shape : body.shapes) shapes.push_back(shape_json(shape));
    bodies.push_back(
        {{"name", body.name}, {"parent", body.parent}, {"pose", pose_json(body.X_WB)}, {"shapes", std::move(shapes)}});
  }
  for (const cell::SceneMesh& mesh : scene.meshes())
    meshes.push_back({{"vertices", mesh.points.size()},
                      {"triangles", mesh.triangles.size()},
                      {"bytes", 8 + 12 * (mesh.points.size() + mesh.triangles.size())}});
  return json_answer(200, {{"bodies", std::move(bodies)},
                           {"moving", scene.moving()},
                           {"commanded", scene.commanded()},
                           {"meshes", std::move(meshes)},
                           {"cameras", scene.cameras()},
                           {"frames", frames_json(cell_.built().cell.frames)},
                           {"sensors", sensors_json(cell_.built().cell)}});
}

HttpResponse Api::mesh(const Call& call) const {
  const std::string& text = call.path.at("mesh");
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const auto& meshes = streams_.scene().meshes();
  if (error != std::errc() || end != text.data() + text.size() || number >= meshes.size())
    return problem(404, fmt::format("there is no mesh '{}'", text));
  HttpResponse response{.content_type = "application/octet-stream"};
  response.body = mesh_bytes(meshes[number]);
  return response;
}

HttpResponse Api::layout() const {
  const Layout read = read_layout(cell_.description().file, cell_.built(), streams_.scene().cameras());
  SceneJson wrong = problem_json(422, "", read.diagnostics).value("diagnostics", SceneJson::array());
  return json_answer(200, {{"layout", SceneJson::parse(read.json)}, {"diagnostics", std::move(wrong)}});
}

HttpResponse Api::cameras() const {
  SceneJson list = SceneJson::array();
  for (const cell::CameraEntry& camera : cell_.description().cameras) {
    const double fovy = camera.fovy_deg * std::numbers::pi / 180.0;
    list.push_back({{"name", camera.name}, {"fovy_rad", fovy}, {"focal", 0.5 / std::tan(0.5 * fovy)}});
  }
  return json_answer(200, {{"cameras", std::move(list)}});
}

void Api::picture(const Call& call, const Respond& respond) {
  const std::string& camera = call.path.at("camera");
  if (const Diagnostics why = check_camera(streams_.scene(), camera, ""); why.has_errors())
    return respond(problem(404, "there is no such camera", why));
  const auto size = [&call](const char* name, int fallback) {
    const auto found = call.query.find(name);
    return found == call.query.end() ? fallback : static_cast<int>(found->second);
  };
  const auto done = [respond](const Result<CameraPicture>& picture) {
    if (!picture) return respond(problem(500, "the picture cannot be drawn", picture.error()));
    HttpResponse response{.content_type = "image/png", .body = picture->png};
    response.headers["Takt-Cycle"] = fmt::format("{}", picture->cycle - 1);
    respond(std::move(response));
  };
  const bool taken = pictures_.draw(
      {.format = {.camera = camera, .width = size("width", 640), .height = size("height", 360)}, .done = done});
  if (!taken) respond(problem(429, "a picture is being drawn just now: ask again"));
}

}  // namespace takt::serve
