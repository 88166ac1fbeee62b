#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/serve/served.h"

namespace takt::serve::test {

/// One message of a server.
struct StreamMessage {
  bool binary = false;
  std::string text;
  [[nodiscard]] Json json() const { return binary ? Json() : Json::parse(text, nullptr, false); }
};

/// An entry of a frame of values, or the frame's head.
struct FrameEntry {
  std::uint32_t id = 0;
  int type = 0;
  bool null = false;
  std::int64_t cycle = 0;
  std::string bytes;
  [[nodiscard]] std::vector<double> numbers() const;
};
struct Frame {
  int kind = 0, version = 0;
  std::uint32_t number = 0;
  std::int64_t cycle = 0;
  std::vector<FrameEntry> values;                     ///< kind 1
  double time = 0.0;                                  ///< kind 2, s
  std::vector<std::vector<float>> moving, commanded;  ///< kind 2
  std::string picture = {};                           ///< kind 3: PNG
  [[nodiscard]] const FrameEntry* of(std::uint32_t id) const;
};
/// Reads a frame by the page that describes it; fails the test if it is longer or shorter than it says.
[[nodiscard]] Frame read_frame(const std::string& bytes);

/// A client of the streams that waits for each answer: Boost.Beast's, with nothing of the server in it.
class StreamClient {
 public:
  /// @param target  with the ticket, if there is one.
  explicit StreamClient(const Served& served, const std::string& target = "/v1/stream",
                        const std::string& protocol = "takt.v1",
                        const std::map<std::string, std::string>& headers = {});
  ~StreamClient();
  StreamClient(const StreamClient&) = delete;
  StreamClient& operator=(const StreamClient&) = delete;

  [[nodiscard]] int status() const;  ///< 101: it is open; else it is not
  void send(const Json& message) { send_text(message.dump()); }
  void send_text(const std::string& text, bool binary = false);
  /// The next message. Nothing: the connection is closed, or nothing comes for so long.
  [[nodiscard]] std::optional<StreamMessage> read(std::chrono::milliseconds longest = std::chrono::seconds(10));
  /// The next text with this op; what comes before it is left aside. Null: none comes.
  [[nodiscard]] Json await(const std::string& op);
  /// The next frame; texts before it are left aside.
  [[nodiscard]] std::optional<Frame> frame();
  /// Code and reason with which the server has closed it.
  [[nodiscard]] std::pair<int, std::string> close_reason() const;
  /// Without a word.
  void drop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::serve::test
