#include "hw/fri/krl_handshake.h"

#include "hw/fri/protocol/krl_words.h"

namespace takt::hw::fri {
namespace {

class TaktHandshake final : public KrlHandshake {
 public:
  void fill(const KrlRequest& request, const Measurement&, KrlValues& out) override {
    using namespace takt_words;
    out.integer[kWanted] = static_cast<std::int32_t>(request.state);
    out.integer[kStrategy] = strategy_of(request.control);
    out.integer[kRequest] = request.number;
  }
  [[nodiscard]] int first_number(const Measurement& seen) const override {
    return seen.krl.integer[takt_words::kRequest] + 1;
  }
};

/// Programs that take "start" only after "stop": one that fell back thinks that it runs, and has to be told to stop
/// first. `Words` has the numbers.
template <class Words>
class StartStopHandshake final : public KrlHandshake {
 public:
  void fill(const KrlRequest& request, const Measurement& seen, KrlValues& out) override {
    const bool runs = seen.krl.integer[Words::kAnswer] == Words::kRuns;
    if (request.number != number_) {
      number_ = request.number;
      // What ran before this request was made is ended first.
      must_stop_ = runs && seen.state != State::kCommand;
    }
    if (!runs) must_stop_ = false;
    const bool start = request.state == State::kCommand && !must_stop_;
    out.integer[Words::kStrategy] = strategy_of(request.control);
    out.integer[Words::kCommand] = start ? Words::kStart : Words::kStop;
  }

 private:
  int number_ = 0;
  bool must_stop_ = false;
};

struct FriControlWords {
  static constexpr std::size_t kStrategy = fri_control_words::kStrategy, kCommand = fri_control_words::kCommand,
                               kAnswer = fri_control_words::kCommand;
  static constexpr int kStart = fri_control_words::kStart, kStop = fri_control_words::kStop,
                       kRuns = fri_control_words::kStarted;
};

struct RosControlWords {
  static constexpr std::size_t kStrategy = ros_control_words::kStrategy, kCommand = ros_control_words::kCommand,
                               kAnswer = ros_control_words::kCommand;
  static constexpr int kStart = ros_control_words::kStart, kStop = ros_control_words::kStop,
                       kRuns = ros_control_words::kStart;
};

}  // namespace

const std::vector<std::string>& driver_conventions() {
  static const std::vector<std::string> names{"takt", "fri_control", "ros_control"};
  return names;
}

std::unique_ptr<KrlHandshake> make_krl_handshake(std::string_view convention) {
  if (convention == "takt") return std::make_unique<TaktHandshake>();
  if (convention == "fri_control") return std::make_unique<StartStopHandshake<FriControlWords>>();
  if (convention == "ros_control") return std::make_unique<StartStopHandshake<RosControlWords>>();
  return nullptr;
}

}  // namespace takt::hw::fri
