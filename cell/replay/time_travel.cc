#include "cell/replay/time_travel.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/replay/fired_cancels.h"
#include "cell/replay/state_dump.h"
#include "core/net/value_json.h"
#include "record/curves.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

/// Length of an answer in front of it, as text.
constexpr std::size_t kHead = 16;

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

bool send_all(int socket, std::string_view text) {
  while (!text.empty()) {
    const ssize_t sent = send(socket, text.data(), text.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool receive_all(int socket, std::span<char> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = read(socket, bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

/// Texts with their length in front.
bool send_text(int socket, std::string_view text) {
  return send_all(socket, fmt::format("{:<{}}", text.size(), kHead)) && send_all(socket, text);
}

std::optional<std::string> receive_text(int socket) {
  std::array<char, kHead + 1> head{};
  if (!receive_all(socket, std::span(head).first(kHead))) return std::nullopt;
  std::string text(std::strtoull(head.data(), nullptr, 10), '\0');
  if (!receive_all(socket, text)) return std::nullopt;
  return text;
}

/// A question on its way to a process; "leave" is one as well.
Json to_json(const TimeTravel::Question& question) {
  return {{"cycle", question.cycle}, {"ports", question.ports}, {"why", question.why}};
}

TimeTravel::Question question_of(const Json& json) {
  return {.cycle = json["cycle"], .ports = json["ports"], .why = json["why"]};
}

Json ports_of(const net::CompiledNet& net, const std::string& pattern) {
  Json ports = Json::object();
  for (const net::CompiledNet::Port& port : net.ports())
    if (record::matches(pattern, port.name))
      ports[port.name] = net::slot_to_json(port.type, net.slots().data() + port.offset);
  return ports;
}

/// Words of a device or of the simulation, as the doubles that they mostly are.
Json words_of(const DumpedBlock& block, const std::string& pattern) {
  Json words = Json::object();
  for (const DumpedBlock::Place& place : block.places) {
    if (place.size != sizeof(double) || !record::matches(pattern, place.name)) continue;
    double value = 0.0;
    std::memcpy(&value, block.bytes.data() + place.offset, sizeof(value));
    words[place.name] = value;
  }
  return words;
}

}  // namespace

/// The part of it that runs: main process, snapshots and those who go on from them are copies of one.
struct Traveller {
  enum class Role { kMain, kVisitor };

  ReopenedRun& run;
  std::vector<std::uint64_t> digests;  ///< recorded
  std::int64_t every;
  std::vector<int> sockets;  ///< of the snapshots, and last of the end; -1: not ours any more
  bool cut_off = false;      ///< the recording ends before its run did

  Role role = Role::kMain;
  int socket = -1;  ///< of a visitor
  TimeTravel::Question question = {};
  FiredCancels cancels = {};
  std::string step = {};
  std::optional<std::int64_t> first_difference = {};
  std::size_t next = 0;  ///< snapshot

  /// Runs to the end and answers from there on.
  [[noreturn]] void travel() {
    RunOptions options;
    options.measure_times = false;
    options.repeat = false;
    options.keep_blocks = true;
    options.from = run.entry();
    options.tell = [this](const LogEntry& entry) {
      if (entry.source == "program" && entry.name == "begin") step = entry.step;
    };
    options.after_cycle = [this](BuiltCell& built) { return look(built); };
    const RunReport report = run.session().run(options);
    if (role == Role::kMain) socket = sockets.back();
    const bool with_recording = cut_off && report.cycles == static_cast<std::int64_t>(digests.size());
    Json end = {{"cycle", report.cycles - 1},
                {"time", report.sim_time},
                {"ended", with_recording ? "where the recording was cut off" : name_of(report.verdict)}};
    if (report.cycles != static_cast<std::int64_t>(digests.size()) && !first_difference)
      first_difference = std::min(report.cycles, static_cast<std::int64_t>(digests.size()));
    if (role == Role::kMain) {
      // Whoever asks for a cycle that did not come is told so by a closed end.
      for (std::size_t i = next; i + 1 < sockets.size(); ++i) close(sockets[i]);
      if (!hear()) _exit(0);
    }
    do {
      Json answer = end;
      add_common(answer);
      if (!send_text(socket, answer.dump())) _exit(0);
    } while (hear());
    _exit(0);
  }

  /// After each cycle. @return false: it is over
  bool look(BuiltCell& built) {
    const std::int64_t cycle = built.core->cycle() - 1;
    cancels.look(*built.core);
    const auto at = static_cast<std::size_t>(cycle);
    const bool equal = at < digests.size() && digests[at] == built.core->digest().value().low;
    if (!equal && !first_difference) first_difference = cycle;
    if (role == Role::kMain && next + 1 < sockets.size() && cycle == static_cast<std::int64_t>(next) * every)
      make_snapshot();
    const bool goes_on = !cut_off || at + 1 < digests.size();
    if (role == Role::kMain) return goes_on;
    while (question.cycle <= cycle) {
      if (!send_text(socket, answer(built, cycle).dump()) || !hear()) _exit(0);
    }
    return goes_on;
  }

  /// The child waits as it is now; whoever asks it gets a child of its own.
  void make_snapshot() {
    std::fflush(nullptr);
    const pid_t pid = fork();
    if (pid < 0) fail("fork");
    const std::size_t mine = next++;
    if (pid > 0) {
      close(std::exchange(sockets[mine], -1));
      return;
    }
    socket = sockets[mine];
    for (int& other : sockets)
      if (other >= 0 && other != socket) close(std::exchange(other, -1));
    while (hear()) {
      const pid_t visitor = fork();
      if (visitor == 0) {
        role = Role::kVisitor;
        return;
      }
      if (visitor < 0) _exit(1);
      waitpid(visitor, nullptr, 0);
    }
    _exit(0);
  }

  /// Waits for the next question. @return false: nobody asks any more, or this visitor is to leave
  bool hear() {
    const auto text = receive_text(socket);
    if (!text) return false;
    const Json json = Json::parse(*text, nullptr, false);
    if (!json.is_object()) return false;
    question = question_of(json);
    return true;
  }

  void add_common(Json& answer) {
    answer["step"] = step;
    answer["digest_equal"] = !first_difference;
    answer["first_difference"] = first_difference ? Json(*first_difference) : Json(nullptr);
    if (!question.why) return;
    answer["cancels"] = Json::array();
    answer["cancel_texts"] = Json::array();
    for (const FiredCancel& fired : cancels.fired()) {
      answer["cancels"].push_back(cell::to_json(fired));
      answer["cancel_texts"].push_back(to_text(fired, to_seconds(run.session().built().core->period())));
    }
  }

  Json answer(BuiltCell& built, std::int64_t cycle) {
    Json answer = {{"cycle", cycle}, {"time", to_seconds(cycle * built.core->period())}, {"ended", nullptr}};
    add_common(answer);
    answer["nets"] = Json::array();
    for (const rcc::Digest::BlockValue& value : built.core->digest().blocks()) {
      const auto id = static_cast<rcc::NetId>(value.block);
      const rcc::NetHandle net = value.block != 0 && value.block == id ? built.core->net(id) : nullptr;
      if (net) answer["nets"].push_back({{"name", net->name()}, {"ports", ports_of(*net, question.ports)}});
    }
    if (question.ports.empty()) return answer;
    answer["blocks"] = Json::array();
    for (const DumpedBlock& block : dump_state(built)) {
      if (block.name.starts_with("net ")) continue;
      answer["blocks"].push_back({{"name", block.name}, {"values", words_of(block, question.ports)}});
    }
    return answer;
  }
};

struct TimeTravel::Impl {
  std::int64_t cycles = 0, every = 0;
  std::vector<int> sockets;  ///< our ends
  pid_t main = -1;
  std::optional<std::size_t> visited;  ///< snapshot, or the end, that answered last
  std::int64_t at = 0;                 ///< cycle in which its visitor is

  ~Impl() {
    for (const int socket : sockets) close(socket);
    if (main > 0) waitpid(main, nullptr, 0);
  }
  void leave() {
    if (visited && *visited + 1 < sockets.size()) (void)send_text(sockets[*visited], "null");
    visited.reset();
  }
};

TimeTravel::TimeTravel(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TimeTravel::TimeTravel(TimeTravel&&) noexcept = default;
TimeTravel& TimeTravel::operator=(TimeTravel&&) noexcept = default;
TimeTravel::~TimeTravel() = default;

Result<TimeTravel> TimeTravel::begin(const record::Recording& recording, ReopenedRun& run, const Options& options) {
  const auto cycles = whole_cycles(recording);
  if (!cycles) return std::unexpected(cycles.error());
  auto impl = std::make_unique<Impl>();
  impl->cycles = *cycles;
  impl->every = std::max(options.every, (*cycles + kMost - 1) / kMost);
  Traveller traveller{.run = run, .digests = {}, .every = impl->every, .sockets = {}};
  traveller.cut_off = !recording.damage().empty();
  record::DigestCursor cursor(recording);
  for (record::RecordedDigest digest; cursor.next(digest);) traveller.digests.push_back(digest.digest);
  const std::int64_t snapshots = (*cycles + impl->every - 1) / impl->every;
  for (std::int64_t i = 0; i <= snapshots; ++i) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) fail("socketpair");
    impl->sockets.push_back(ends[0]);
    traveller.sockets.push_back(ends[1]);
  }
  std::fflush(nullptr);
  impl->main = fork();
  if (impl->main < 0) fail("fork");
  if (impl->main == 0) {
    for (const int socket : impl->sockets) close(socket);
    // Only the one who asks talks to people.
    const int nowhere = open("/dev/null", O_WRONLY);
    for (const int out : {STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, out);
    traveller.travel();
  }
  for (const int socket : traveller.sockets) close(socket);
  return TimeTravel(std::move(impl));
}

std::int64_t TimeTravel::cycles() const { return impl_->cycles; }
std::int64_t TimeTravel::every() const { return impl_->every; }

Result<nlohmann::ordered_json> TimeTravel::ask(const Question& question) {
  const std::size_t end = impl_->sockets.size() - 1;
  const bool at_end = question.cycle >= impl_->cycles;
  const std::size_t nearest =
      at_end ? end : static_cast<std::size_t>(std::max<std::int64_t>(0, question.cycle) / impl_->every);
  const bool goes_on = impl_->visited == nearest && (at_end || impl_->at <= question.cycle);
  if (!goes_on) impl_->leave();
  impl_->visited = nearest;
  impl_->at = question.cycle;
  std::optional<std::string> answer;
  if (send_text(impl_->sockets[nearest], to_json(question).dump())) answer = receive_text(impl_->sockets[nearest]);
  if (answer) return Json::parse(*answer);
  if (!at_end) {
    impl_->visited.reset();
    return ask({.cycle = impl_->cycles, .ports = question.ports, .why = question.why});
  }
  return failure(Code::kInternal, {}, fmt::format("the process that was to tell of cycle {} is gone", question.cycle),
                 "Provide enough memory and processes");
}

}  // namespace takt::cell
