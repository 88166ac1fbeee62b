#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <expected>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/rcc/watch.h"
#include "serve/panel_files.h"
#include "serve/picture_maker.h"
#include "serve/routes.h"
#include "serve/served_cell.h"
#include "serve/streams.h"

namespace takt::serve {

/// What the server can do, route by route (docs/remote.md). It is called on the thread of the HTTP server; what takes
/// long there (reading a net) goes to a thread of its own, so that STOP never waits for it.
class Api {
 public:
  /// @param page  what "/" hands out
  /// @param log  a line about who took, lost or stopped what
  /// @param post  has something done on the thread of the server
  Api(ServedCell& cell, Access access, PanelFiles page, std::function<void(const std::string& line)> log,
      std::function<void(std::function<void()> work)> post);
  ~Api();
  Api(const Api&) = delete;
  Api& operator=(const Api&) = delete;

  void handle(const HttpRequest& request, const Respond& respond);
  [[nodiscard]] std::expected<Upgrade, HttpResponse> upgrade(const HttpRequest& request);
  [[nodiscard]] const std::vector<Route>& routes() const { return routes_; }

  static constexpr std::int64_t kMostCycles = 100'000;  ///< of one order in lock-step
  static constexpr std::size_t kMostWatches = 64, kKeys = 1024;
  static constexpr std::size_t kWatchesOfOne = 32;    ///< watches of one client
  static constexpr std::size_t kRulesOfOne = 64;      ///< rules of one client that wait
  static constexpr std::size_t kRequestsOfOne = 256;  ///< requests of one client to one cycle
  static constexpr std::size_t kStreamsOfOne = 32;    ///< streams of one client

 private:
  void add_net_routes();
  void add_command_routes();
  void add_cell_routes();
  void add_device_routes();
  void add_channel_routes();
  void add_watch_routes();
  void add_stream_routes();
  void add_scene_routes();
  void add_lease_routes();
  void add_recording_routes();
  void add_program_routes();

  // api.cc
  void dispatch(const Route& route, Call& call, const Respond& respond);
  [[nodiscard]] std::optional<HttpResponse> check_need(const Route& route, Call& call);
  void once_only(const Route& route, const Call& call, const std::string& key, const Respond& respond);
  void work(const std::stop_token& stop);
  [[nodiscard]] bool work_elsewhere(std::function<void()> job);

  // api_nets.cc
  void load(const Call& call, const Respond& respond);
  void load_now(const nlohmann::ordered_json& json, std::uint32_t fence, const Respond& respond);
  [[nodiscard]] HttpResponse list_nets() const;
  [[nodiscard]] HttpResponse net_state(const Call& call) const;
  [[nodiscard]] HttpResponse net_report(const Call& call) const;
  [[nodiscard]] HttpResponse net_graph(const Call& call) const;
  [[nodiscard]] HttpResponse unload(const Call& call);
  [[nodiscard]] HttpResponse command(const Call& call, const std::string& what);
  [[nodiscard]] HttpResponse post_rule(const Call& call);
  [[nodiscard]] HttpResponse schedule(const Call& call);
  [[nodiscard]] HttpResponse posted(rcc::RequestId request) const;
  [[nodiscard]] std::optional<HttpResponse> check_quota(const Call& call, bool waits);
  void note_posted(const Call& call, rcc::RequestId request, bool waits);

  // api_cell.cc
  [[nodiscard]] HttpResponse state() const;
  [[nodiscard]] HttpResponse events(const Call& call) const;
  void steps(const Call& call, const Respond& respond);
  [[nodiscard]] HttpResponse stop(const Call& call);

  // api_devices.cc
  [[nodiscard]] HttpResponse devices() const;
  [[nodiscard]] HttpResponse device_states() const;
  [[nodiscard]] HttpResponse arm(const Call& call) const;

  // api_lease.cc
  [[nodiscard]] HttpResponse leases() const;
  [[nodiscard]] HttpResponse take_lease(const Call& call);
  [[nodiscard]] HttpResponse renew_lease(const Call& call);
  [[nodiscard]] HttpResponse release_lease(const Call& call);

  // api_recording.cc
  void set_recording(const Call& call, const Respond& respond);
  void save_recording(const Call& call, const Respond& respond);

  // api_channels.cc
  [[nodiscard]] HttpResponse channels() const;
  [[nodiscard]] HttpResponse write_channel(const Call& call);
  [[nodiscard]] HttpResponse add_watch(const Call& call);
  [[nodiscard]] HttpResponse read_watch(const Call& call);
  [[nodiscard]] HttpResponse set_watch(const Call& call);
  [[nodiscard]] HttpResponse drop_watch(const Call& call);

  // api_streams.cc
  [[nodiscard]] HttpResponse make_scene() const;
  [[nodiscard]] HttpResponse mesh(const Call& call) const;
  [[nodiscard]] HttpResponse cameras() const;
  [[nodiscard]] HttpResponse layout() const;
  void picture(const Call& call, const Respond& respond);

  /// An answer that was given to a key, or is still to come.
  struct Kept {
    std::size_t body_hash = 0;  ///< of the request: bodies are long, and 1024 of them are kept
    std::optional<HttpResponse> response;
  };

  ServedCell& cell_;
  Access access_;
  const PanelFiles page_;
  std::function<void(const std::string& line)> log_;
  std::vector<Route> routes_;
  struct OwnWatch {
    std::shared_ptr<rcc::Watch> watch;
    std::string client;
  };
  std::map<std::int64_t, OwnWatch> watches_;
  /// What a client has asked of the core.
  struct Asked {
    std::int64_t cycle = -1;                ///< that its requests go to
    std::size_t in_cycle = 0;               ///< of them
    std::set<rcc::RequestId> waiting = {};  ///< rules without an answer
  };
  std::map<std::string, Asked> asked_;
  std::int64_t answers_seen_ = 1;  ///< number of the next event that may answer a rule
  std::int64_t last_watch_ = 0;

  mutable std::mutex mutex_;  ///< names_, kept_, jobs_
  std::map<rcc::NetId, std::string> names_;
  std::map<std::string, Kept> kept_;
  std::deque<std::string> kept_order_;
  std::deque<std::function<void()>> jobs_;
  std::condition_variable_any wake_;
  PictureMaker pictures_;
  Streams streams_;
  HttpResponse scene_;   ///< as the cell was before it ran: a program changes its frames
  std::jthread worker_;  ///< last: it uses what is above
};

/// Reads the JSON object of a request. @return it; or the problem: no JSON, another type, too deep, duplicate keys
[[nodiscard]] std::expected<nlohmann::ordered_json, HttpResponse> read_body(const HttpRequest& request);
/// A number in a path. @return the net; 0: it is none
[[nodiscard]] rcc::NetId net_in(const Call& call);
}  // namespace takt::serve
