#include "hw/emulators/rtde/rtde_service.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

constexpr std::size_t kMostRecipes = 255;
constexpr int kProtocol = 2;

}  // namespace

/// A client of port 30004. Text messages go out only after START: during the set-up clients take whatever comes next
/// for their answer.
class RtdeService::Client final : public Session {
 public:
  Client(RtdeService& service, std::uint64_t number) : service_(service), number_(number) {}
  ~Client() override {
    std::erase_if(service_.claims_, [this](const auto& claim) { return claim.second == number_; });
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void receive(std::string_view bytes) override {
    (void)parser_.feed(bytes);
    while (!closing()) {
      const auto package = parser_.next();
      if (!package) break;
      handle(*package);
    }
    if (parser_.broken() && !closing()) {
      ++service_.counts_.broken;
      close();
    }
  }

  void end_frame() override {
    if (!started_ || controller().frame() % every_ != 0) return;
    if (!reads()) {
      ++service_.counts_.left_out;
      return;
    }
    if (!repeats()) {
      payload_.clear();
      if (protocol_ >= 2) append(payload_, outputs_->id);
      for (const FieldTable::Id id : outputs_->fields)
        append_value(payload_, output_fields()[id].type, controller().fields()[id]);
    }
    append_package(out(), PackageType::kData, payload_);
  }

 private:
  /// Whether a fault of the controller makes it send the package of before in place of a new one.
  [[nodiscard]] bool repeats() {
    if (payload_.empty()) return false;
    if (controller().stuck()) return true;
    const int limit = controller().options().fresh_packages;
    if (limit == 0 || fresh_++ < limit) return false;
    fresh_ = 0;
    return true;
  }
  [[nodiscard]] Controller& controller() const { return service_.controller_; }
  [[nodiscard]] const Version& version() const { return controller().options().version; }

  void handle(const Package& package) {
    switch (package.type) {
      case PackageType::kProtocolVersion:
        return answer_protocol(package.payload);
      case PackageType::kControllerVersion:
        out() += encode_version(version());
        return;
      case PackageType::kSetupOutputs:
        return set_up_outputs(package.payload);
      case PackageType::kSetupInputs:
        return set_up_inputs(package.payload);
      case PackageType::kData:
        return take_data(package.payload);
      case PackageType::kStart:
        return answer(PackageType::kStart, start());
      case PackageType::kPause:
        started_ = false;
        return answer(PackageType::kPause, true);
      case PackageType::kText:
        return;  // for the log of a real controller
    }
    complain(fmt::format("package of unknown type {}", static_cast<int>(package.type)));
  }

  void answer(PackageType type, bool accepted) {
    if (!accepted) ++service_.counts_.refused;
    append_package(out(), type, std::string_view(accepted ? "\1" : "\0", 1));
  }

  void answer_protocol(std::string_view payload) {
    ByteReader reader(payload);
    const auto wanted = reader.take<std::uint16_t>();
    const bool known = reader.ok() && wanted >= 1 && wanted <= kProtocol;
    if (known) protocol_ = wanted;
    answer(PackageType::kProtocolVersion, known);
  }

  bool start() {
    if (!outputs_) return false;
    started_ = true;
    return true;
  }

  void set_up_outputs(std::string_view payload) {
    started_ = false;
    outputs_.reset();
    const auto request = decode_output_request(payload, protocol_);
    if (!request) return complain("SETUP_OUTPUTS is too short");
    const double most = version().frequency();
    const double frequency = protocol_ >= 2 ? request->frequency : most;
    Recipe recipe{1, {}};
    bool valid = std::isfinite(frequency) && frequency > 0.0 && frequency <= most;
    std::string words;
    for (const std::string_view name : request->names) {
      const auto id = output_fields().find(name);
      const bool found = id && output_fields()[*id].offered_by(version());
      add_word(words, found ? name_of(output_fields()[*id].type) : kNotFound);
      valid = valid && found;
      if (found) recipe.fields.push_back(*id);
    }
    valid = valid && recipe.size(output_fields()) < kLargestPackage - kHeaderSize;
    if (valid) {
      outputs_ = std::move(recipe);
      every_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::lround(most / frequency)));
    }
    send_setup(PackageType::kSetupOutputs, outputs_ ? 1 : 0, words, protocol_ >= 2);
  }

  void set_up_inputs(std::string_view payload) {
    Recipe recipe;
    bool valid = inputs_.size() < kMostRecipes;
    std::string words;
    for (const std::string_view name : split_names(payload)) {
      const auto id = input_fields().find(name);
      const bool found = id && input_fields()[*id].offered_by(version());
      const auto claim = found ? service_.claims_.find(*id) : service_.claims_.end();
      const bool free = found && (claim == service_.claims_.end() || claim->second == number_);
      add_word(words, !found ? kNotFound : !free ? kInUse : name_of(input_fields()[*id].type));
      valid = valid && free;
      if (free) recipe.fields.push_back(*id);
    }
    if (valid) {
      recipe.id = static_cast<std::uint8_t>(inputs_.size() + 1);
      for (const FieldTable::Id id : recipe.fields) service_.claims_[id] = number_;
      inputs_.push_back(recipe);
    }
    send_setup(PackageType::kSetupInputs, recipe.id, words, true);
  }

  static void add_word(std::string& words, std::string_view word) {
    if (!words.empty()) words += ',';
    words += word;
  }
  void send_setup(PackageType type, std::uint8_t id, std::string_view words, bool with_id) {
    if (id == 0) ++service_.counts_.refused;
    out() += encode_setup_reply(type, id, words, with_id);
  }

  /// Longer than its recipe: the rest is ignored. Shorter: the fields that are whole count.
  void take_data(std::string_view payload) {
    ByteReader reader(payload);
    const auto id = reader.take<std::uint8_t>();
    if (id == 0 || id > inputs_.size()) {
      ++service_.counts_.misshapen;
      return complain(fmt::format("input data for recipe {}, which is not set up", id));
    }
    std::vector<std::pair<FieldTable::Id, FieldValue>> values;
    for (const FieldTable::Id field : inputs_[id - 1u].fields) {
      const FieldType type = input_fields()[field].type;
      if (reader.left() < wire_size(type)) break;
      values.emplace_back(field, take_value(reader, type));
    }
    if (values.size() != inputs_[id - 1u].fields.size() || reader.left() > 0) ++service_.counts_.misshapen;
    controller().apply_inputs(values);
  }

  void complain(const std::string& text) {
    if (started_ && reads()) out() += encode(TextMessage{TextMessage::Level::kError, text, "RTDE"}, protocol_);
  }

  RtdeService& service_;
  const std::uint64_t number_;
  PackageParser parser_;
  int protocol_ = 1;
  bool started_ = false;
  std::string payload_;      ///< of the newest package of data
  int fresh_ = 0;            ///< packages since the last repetition
  std::uint64_t every_ = 1;  // frames between two packages
  std::optional<Recipe> outputs_;
  std::vector<Recipe> inputs_;
};

std::unique_ptr<Session> RtdeService::open() { return std::make_unique<Client>(*this, ++counts_.sessions); }

}  // namespace takt::hw::rtde
