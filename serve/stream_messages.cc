// The messages of the protocol takt.v1: what is read, and what OpenAPI says of them. There is no other list.
#include <nlohmann/json.hpp>

#include "serve/stream_session.h"

namespace takt::serve {
namespace {

constexpr std::int64_t kGreatestNumber = 4'294'967'295;

Field number_field(std::string name, std::string doc, bool required = true) {
  return {.name = std::move(name),
          .type = "integer",
          .doc = std::move(doc),
          .required = required,
          .minimum = 0,
          .maximum = kGreatestNumber};
}

MessageForm from_client(std::string op, std::string doc, std::vector<Field> fields) {
  fields.insert(fields.begin(), {"op", "string", op});
  return {.op = std::move(op), .from_client = true, .doc = std::move(doc), .fields = std::move(fields)};
}

MessageForm from_server(std::string op, std::string doc, std::vector<Field> fields) {
  MessageForm form = from_client(std::move(op), std::move(doc), std::move(fields));
  form.from_client = false;
  return form;
}

const Field& every_field() {
  static const Field field = {.name = "every",
                              .type = "integer",
                              .doc = "cycles between two values (default 1); 0: none for now",
                              .required = false,
                              .minimum = 0,
                              .maximum = StreamSession::kMostEvery};
  return field;
}

std::vector<MessageForm> server_messages() {
  return {from_server("hello", "The first message.",
                      {{"protocol", "string", "takt.v1"},
                       {"name", "string", "of the client"},
                       {"role", "string", "observer or operator"},
                       {"realtime", "boolean", "the wall clock's pace"},
                       {"period_s", "number", "of a cycle, s"},
                       {"cycle", "integer", "the next one to be run"},
                       {"next", "integer", "number that the next event will have"}}),
          from_server("problem", "A message was not carried out; like a problem answer.",
                      {{"for", "string", "op of that message"},
                       {"id", "integer", "its id or jog, if it had one", false},
                       {"title", "string", ""},
                       {"status", "integer", "as of HTTP"},
                       {"detail", "string", ""},
                       {"diagnostics", "array", "code, pointer, message, hint of each", false}}),
          from_server("events", "Events in order, none left out.",
                      {{"events", "array", "as of GET /v1/events"}, {"next", "integer", "where to go on"}}),
          from_server("monitored", "A monitor runs, or has another rate.",
                      {{"id", "integer", "of the monitor"},
                       {"type", "string", "of its values"},
                       {"every", "integer", "cycles between two values"}}),
          from_server("ended", "A monitor has ended.",
                      {{"id", "integer", "of the monitor"}, {"reason", "string", "asked, or net: its net has ended"}}),
          from_server("jogging", "The net of a jogging runs.",
                      {{"jog", "integer", "the client's number"},
                       {"net", "integer", "its net"},
                       {"timeout_cycles", "integer", "of silence, then it comes to rest"}}),
          from_server("moved", "A velocity was handed to the core.",
                      {{"jog", "integer", "the client's number"},
                       {"sequence", "integer", "of the move"},
                       {"cycle", "integer", "from which it counts, at the earliest"}}),
          from_server("jog_ended", "The arm is at rest, and free.",
                      {{"jog", "integer", "the client's number"},
                       {"net", "integer", "its net"},
                       {"reason", "string", "released, silent, lease or stopped"}})};
}

}  // namespace

const std::vector<StreamSession::ClientMessage>& StreamSession::client_messages() {
  static const std::vector<ClientMessage> all = {
      {from_client("events", "Begins the stream of events, or begins again elsewhere.",
                   {{"from", "integer", "number of the first (default: what is new)", false, 1}}),
       &StreamSession::begin_events},
      {from_client("monitor", "Shows a value: of net and port, of a channel, an arm, a sensor, a camera, or all poses.",
                   {number_field("id", "the client's choice"),
                    {"net", "integer", "number of a net", false, 1, kGreatestNumber},
                    {"port", "string", "monitor or id.port of the net", false},
                    {"channel", "string", "name of a channel", false},
                    {"arm", "string", "name of an arm", false},
                    {"value", "string", "of the arm: q_measured, q_commanded, dq_measured, tau_measured", false},
                    {"sensor", "string", "name of a force/torque sensor: its wrench as measured", false},
                    {"camera", "string", "name of a camera, or overview: its pictures", false},
                    {"width", "integer", "of its pictures, pixels (default 320)", false, cell::CellCamera::kLeast,
                     cell::CellCamera::kMostWidth},
                    {"height", "integer", "likewise (default 240)", false, cell::CellCamera::kLeast,
                     cell::CellCamera::kMostHeight},
                    {"poses", "boolean", "true: of all bodies that move", false},
                    every_field()}),
       &StreamSession::add_monitor},
      {from_client("rate", "Changes the rate of a monitor.", {number_field("id", "of the monitor"), every_field()}),
       &StreamSession::set_rate},
      {from_client("unmonitor", "Ends a monitor.", {number_field("id", "of the monitor")}),
       &StreamSession::end_monitor},
      {from_client("ack", "All frames up to this one are worked up.", {number_field("frame", "its number")}),
       &StreamSession::acknowledge},
      {from_client("window", "How many frames may be on their way without an ack.",
                   {{"frames", "integer", "at first 8", true, 1, 64}}),
       &StreamSession::set_window},
      {from_client("jog", "Takes an arm to move it by hand.",
                   {number_field("jog", "the client's choice"),
                    number_field("fence", "of the lease"),
                    {"arm", "string", "name of the arm"},
                    {"space", "string", "tool or joints"},
                    {"in", "string", "of the tool: frame of the cell, or tcp (default world)", false},
                    {"timeout_cycles", "integer", "of silence, then it comes to rest (default 100)", false, 10, 1000},
                    {"linear_max_m_s", "number", "of the tool, m/s (default 0.1)", false},
                    {"angular_max_deg_s", "number", "of the tool, deg/s (default 30)", false}}),
       &StreamSession::begin_jog},
      {from_client("move", "The velocity from now on, and a sign of life.",
                   {number_field("jog", "the client's number"),
                    {"sequence", "integer", "greater than the last one", true, 0},
                    {"linear", "array", "m/s, of the tool", false},
                    {"angular", "array", "rad/s, of the tool", false},
                    {"rates", "array", "rad/s or m/s, of each joint", false}}),
       &StreamSession::move_jog},
      {from_client("unjog", "The arm comes to rest and is free.", {number_field("jog", "the client's number")}),
       &StreamSession::end_jog}};
  return all;
}

std::vector<MessageForm> StreamSession::messages() {
  std::vector<MessageForm> all;
  for (const ClientMessage& one : client_messages()) all.push_back(one.form);
  for (MessageForm& one : server_messages()) all.push_back(std::move(one));
  return all;
}

}  // namespace takt::serve
