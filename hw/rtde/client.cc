#include "hw/rtde/client.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    if (!list.empty()) list += ',';
    list += name;
  }
  return list;
}

bool is_yes(std::string_view payload) { return payload == std::string_view("\1", 1); }

}  // namespace

void Client::begin() {
  state_ = State::kSettingUp;
  values_.assign(request_.outputs.size() + request_.optional_outputs.size(), {});
  offered_.assign(request_.optional_outputs.size(), false);
  ask_protocol();
}

void Client::ask_protocol() {
  std::string payload;
  append(payload, static_cast<std::uint16_t>(protocol_));
  append_package(out_, PackageType::kProtocolVersion, payload);
}

int Client::receive(std::string_view bytes) {
  int data = 0;
  (void)parser_.feed(bytes);
  while (state_ == State::kSettingUp || state_ == State::kRunning) {
    const auto package = parser_.next();
    if (!package) break;
    handle(*package, data);
  }
  if (parser_.broken() && state_ != State::kRefused)
    refuse(Code::kIncompatible, "what answers sends no RTDE packages",
           "Give the address of the controller, with its port 30004");
  return data;
}

void Client::handle(const Package& package, int& data) {
  if (package.type == PackageType::kText) {
    auto message = decode_text(package.payload, protocol_);
    if (message && messages_.size() < kMostMessages) messages_.push_back(std::move(*message));
    return;
  }
  if (package.type == PackageType::kData) {
    if (step_ == Step::kDone && handle_data(package.payload)) ++data;
    return;
  }
  switch (step_) {
    case Step::kProtocol:
      if (package.type == PackageType::kProtocolVersion) return handle_protocol(package.payload);
      break;
    case Step::kVersion:
      if (package.type == PackageType::kControllerVersion) return handle_version(package.payload);
      break;
    case Step::kInputs:
      if (package.type == PackageType::kSetupInputs) return handle_setup(package.payload);
      break;
    case Step::kOutputs:
      if (package.type == PackageType::kSetupOutputs) return handle_setup(package.payload);
      break;
    case Step::kStart:
      if (package.type == PackageType::kStart) return handle_start(package.payload);
      break;
    case Step::kDone:
      break;
  }
  ++misshapen_;
}

void Client::handle_protocol(std::string_view payload) {
  if (!is_yes(payload)) {
    if (protocol_ == 1)
      return refuse(Code::kIncompatible, "the controller knows neither version 2 nor version 1 of RTDE",
                    "Update its software to 3.4 or newer");
    protocol_ = 1;
    return ask_protocol();
  }
  step_ = Step::kVersion;
  append_package(out_, PackageType::kControllerVersion, {});
}

void Client::handle_version(std::string_view payload) {
  const auto version = decode_version(payload);
  if (!version)
    return refuse(Code::kIncompatible, "the controller's version cannot be read",
                  "Check that a UR controller has this address");
  version_ = *version;
  if (version_.major != 3 && version_.major != 5)
    return refuse(Code::kIncompatible, fmt::format("the controller has software {}", to_string(version_)),
                  "Use a controller with software 3.x (CB3) or 5.x (e-Series)");
  if (version_.major == request_.oldest.major && version_ < request_.oldest)
    return refuse(Code::kIncompatible, fmt::format("the controller has software {}", to_string(version_)),
                  fmt::format("Update it to {} or newer", to_string(request_.oldest)));
  output_names_ = request_.outputs;
  places_.resize(output_names_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i] = i;
  for (std::size_t i = 0; i < request_.optional_outputs.size(); ++i) {
    const std::string& name = request_.optional_outputs[i];
    const auto id = output_fields().find(name);
    offered_[i] = id && output_fields()[*id].offered_by(version_);
    if (!offered_[i]) continue;
    output_names_.push_back(name);
    places_.push_back(request_.outputs.size() + i);
  }
  step_ = Step::kInputs;
  ask_next_setup();
}

void Client::ask_next_setup() {
  if (next_input_ < request_.inputs.size())
    return append_package(out_, PackageType::kSetupInputs, joined(request_.inputs[next_input_]));
  step_ = Step::kOutputs;
  out_ += encode_output_request(version_.frequency(), joined(output_names_), protocol_);
}

const std::vector<std::string>& Client::wanted() const {
  return step_ == Step::kInputs ? request_.inputs[next_input_] : output_names_;
}

void Client::handle_setup(std::string_view payload) {
  const bool inputs = step_ == Step::kInputs;
  const FieldTable& table = inputs ? input_fields() : output_fields();
  const auto reply = decode_setup_reply(payload, inputs || protocol_ >= 2);
  if (!reply || !check_words(*reply, table, wanted()) || problems_.has_errors()) {
    if (!problems_.has_errors())
      refuse(Code::kIncompatible, "the answer to a set-up cannot be read",
             "Check that a UR controller has this address");
    state_ = State::kRefused;
    return;
  }
  Recipe recipe{reply->id, {}};
  for (const std::string& name : wanted()) recipe.fields.push_back(table.at(name));
  if (!inputs) {
    outputs_ = std::move(recipe);
    step_ = Step::kStart;
    return append_package(out_, PackageType::kStart, {});
  }
  inputs_.push_back(std::move(recipe));
  ++next_input_;
  ask_next_setup();
}

/// Every word that is wrong becomes a diagnostic. @return false: the answer is no list for these names
bool Client::check_words(const SetupReply& reply, const FieldTable& table, const std::vector<std::string>& names) {
  if (reply.words.size() != names.size()) return false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto id = table.find(names[i]);
    const Field* field = id ? &table[*id] : nullptr;
    if (field == nullptr || reply.words[i] != name_of(field->type)) complain_about(reply.words[i], field, names[i]);
  }
  if (reply.id == 0 && !problems_.has_errors())
    problems_.error(Code::kIncompatible, {}, "the controller refuses the list of fields", "See the controller's log");
  return true;
}

void Client::complain_about(std::string_view word, const Field* field, const std::string& name) {
  if (word == kInUse) {
    problems_.error(
        Code::kConflict, {}, fmt::format("another client writes the input '{}'", name),
        "End that client (a field bus claims registers as well), or use the other half: registers=lower or upper");
  } else if (word == kNotFound) {
    const Version since = field == nullptr ? Version{} : version_.major >= 5 ? field->since_e : field->since_cb3;
    problems_.error(
        Code::kUnknownName, {}, fmt::format("the controller ({}) has no field '{}'", to_string(version_), name),
        since.major > 0
            ? fmt::format("Update the controller (the field came with {}), or use registers=lower", to_string(since))
            : std::string("Leave out what needs it: this series does not have the field"));
  } else {
    problems_.error(Code::kTypeMismatch, {}, fmt::format("the controller says that '{}' is {}", name, word),
                    field != nullptr
                        ? fmt::format("Check the version of the controller: {} is expected", name_of(field->type))
                        : std::string());
  }
}

void Client::handle_start(std::string_view payload) {
  if (!is_yes(payload))
    return refuse(Code::kIncompatible, "the controller does not start to send", "See the controller's log");
  step_ = Step::kDone;
  state_ = State::kRunning;
}

bool Client::handle_data(std::string_view payload) {
  ByteReader reader(payload);
  const bool right = protocol_ < 2 || reader.take<std::uint8_t>() == outputs_.id;
  if (!right || reader.left() != outputs_.size(output_fields())) {
    ++misshapen_;
    return false;
  }
  for (std::size_t i = 0; i < outputs_.fields.size(); ++i)
    values_[places_[i]] = take_value(reader, output_fields()[outputs_.fields[i]].type);
  return true;
}

void Client::send(std::size_t recipe, const std::vector<FieldValue>& values) {
  if (state_ != State::kRunning) return;
  const Recipe& into = inputs_[recipe];
  append(out_, static_cast<std::uint16_t>(kHeaderSize + 1 + into.size(input_fields())));
  append(out_, static_cast<std::uint8_t>(PackageType::kData));
  append(out_, into.id);
  for (std::size_t i = 0; i < into.fields.size(); ++i)
    append_value(out_, input_fields()[into.fields[i]].type, values[i]);
}

void Client::refuse(Code code, std::string text, std::string hint) {
  problems_.error(code, {}, std::move(text), std::move(hint));
  state_ = State::kRefused;
}

}  // namespace takt::hw::rtde
