#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "hw/rtde/message.h"

namespace takt::hw::rtde {

/// What a client of RTDE wants of a controller.
struct ClientRequest {
  std::vector<std::string> outputs;              ///< at the full rate of the controller
  std::vector<std::string> optional_outputs;     ///< left out where the controller's version lacks them
  std::vector<std::vector<std::string>> inputs;  ///< a recipe each
  Version oldest = {3, 4, 0, 0};
};

/// The client's end of one RTDE connection, without its transport: negotiates, sets up recipes one by one, and then
/// reads and writes data. What the controller refuses becomes diagnostics that say what to change. One thread.
/// Realtime: cyclic once it runs, while buffers have room.
class Client {
 public:
  enum class State : std::uint8_t {
    kIdle,       ///< begin() has not been called
    kSettingUp,  ///< waits for an answer
    kRunning,
    kRefused  ///< problems() says why; the connection is of no use any more
  };

  explicit Client(ClientRequest request) : request_(std::move(request)) {}

  /// The connection is open.
  void begin();
  /// Bytes of the controller. @return how many data packages were in them; values() are those of the last one.
  int receive(std::string_view bytes);
  /// What is to be sent; whoever sends takes it from the front.
  std::string& out() { return out_; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const Diagnostics& problems() const { return problems_; }
  /// Of the controller, once it has told it.
  [[nodiscard]] const Version& version() const { return version_; }
  [[nodiscard]] int protocol() const { return protocol_; }

  /// Of the newest data package: fields as in the request, the optional ones behind. Those that were left out are 0.
  [[nodiscard]] const std::vector<FieldValue>& values() const { return values_; }
  [[nodiscard]] bool has_optional(std::size_t i) const { return offered_[i]; }
  /// A package for an input recipe; only while it runs. @param values  one for each field
  void send(std::size_t recipe, const std::vector<FieldValue>& values);
  /// Packages that were not of the length that was agreed on, and text messages.
  [[nodiscard]] std::uint64_t misshapen() const { return misshapen_; }
  /// Takes what the controller has written.
  [[nodiscard]] std::vector<TextMessage> take_messages() { return std::exchange(messages_, {}); }

 private:
  enum class Step : std::uint8_t { kProtocol, kVersion, kInputs, kOutputs, kStart, kDone };

  void handle(const Package& package, int& data);
  void handle_protocol(std::string_view payload);
  void handle_version(std::string_view payload);
  void handle_setup(std::string_view payload);
  void handle_start(std::string_view payload);
  bool handle_data(std::string_view payload);
  void ask_protocol();
  void ask_next_setup();
  bool check_words(const SetupReply& reply, const FieldTable& table, const std::vector<std::string>& names);
  void refuse(Code code, std::string text, std::string hint);
  void complain_about(std::string_view word, const Field* field, const std::string& name);
  [[nodiscard]] const std::vector<std::string>& wanted() const;

  static constexpr std::size_t kMostMessages = 32;

  ClientRequest request_;
  PackageParser parser_;
  std::string out_;
  State state_ = State::kIdle;
  Step step_ = Step::kProtocol;
  int protocol_ = 2;
  std::size_t next_input_ = 0;
  Version version_;
  Diagnostics problems_;
  std::vector<std::string> output_names_;  // that are asked for
  std::vector<std::size_t> places_;        // of them in values_
  std::vector<bool> offered_;              // of the optional ones
  Recipe outputs_;
  std::vector<Recipe> inputs_;
  std::vector<FieldValue> values_;
  std::vector<TextMessage> messages_;
  std::uint64_t misshapen_ = 0;
};

}  // namespace takt::hw::rtde
