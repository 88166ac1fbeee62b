#include "core/net/exclusion.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/activation.h"
#include "core/net/implications.h"

namespace takt::net {
namespace {

/// Of some things that are active at times, two that may be so together, and when; no text if nothing is known of that.
struct Conflict {
  std::size_t one, other;
  std::string when;
};

/// Asks decision diagrams about pairs. All pairs share one set of diagrams as long as it keeps its bounds; then each
/// has one of its own. What is not settled within the work that is left counts as a conflict.
class PairProof {
 public:
  /// When number i is active, as a function.
  using When = std::function<Bdd::Ref(Activation&, std::size_t)>;

  PairProof(const FlatNet& flat, When when, std::size_t& work) : flat_(flat), when_(std::move(when)), work_(work) {
    renew();
  }
  ~PairProof() { work_ += activation_->work(); }
  PairProof(const PairProof&) = delete;
  PairProof& operator=(const PairProof&) = delete;

  [[nodiscard]] std::optional<Conflict> check(std::size_t one, std::size_t other) {
    if (work_ + activation_->work() >= kMostWork) return Conflict{one, other, kTangled};
    if (exclude(one, other)) return std::nullopt;
    if (activation_->gave_up()) {
      renew();
      if (exclude(one, other)) return std::nullopt;
    }
    return Conflict{one, other, activation_->gave_up() ? kTangled : activation_->example(of(one), of(other))};
  }
  static constexpr const char* kTangled = "the net is too tangled for a proof";

 private:
  static constexpr std::size_t kMostWork = 2'000'000;  ///< of all proofs of a net: less than a second

  [[nodiscard]] Bdd::Ref of(std::size_t i) {
    const auto [known, fresh] = active_.try_emplace(i, Bdd::kTrue);
    if (fresh) known->second = when_(*activation_, i);
    return known->second;
  }
  [[nodiscard]] bool exclude(std::size_t one, std::size_t other) {
    const Bdd::Ref a = of(one);
    return activation_->exclude(a, of(other));
  }
  void renew() {
    if (activation_) work_ += activation_->work();
    activation_ = std::make_unique<Activation>(flat_);
    active_.clear();
  }

  const FlatNet& flat_;
  When when_;
  std::size_t& work_;
  std::unique_ptr<Activation> activation_;
  std::map<std::size_t, Bdd::Ref> active_;
};

class ExclusionCheck {
 public:
  ExclusionCheck(const FlatNet& flat, NetReport& net_report, LoadReport& report)
      : flat_(flat), net_report_(net_report), report_(report) {}

  void run() {
    collect_drivers();
    for (const auto& [device, primitives] : drivers_) {
      net_report_.resources.push_back(device);
      if (primitives.size() > 1) check_device(device, primitives);
    }
    for (int p = 0; p < flat_.primitive_count(); ++p) {
      const PrimitiveInfo* info = flat_.primitives[static_cast<std::size_t>(p)].info;
      if (info != nullptr && info->merge) check_merge(p);
    }
  }

 private:
  void collect_drivers() {
    for (int p = 0; p < flat_.primitive_count(); ++p) {
      const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(p)];
      if (primitive.info == nullptr || primitive.info->claims.empty() || !primitive.description->parameters.is_object())
        continue;
      const auto device = primitive.description->parameters.find(primitive.info->claims);
      if (device == primitive.description->parameters.end() || !device->is_string()) continue;
      drivers_[device->get<std::string>()].push_back(p);
    }
  }

  /// Two of the primitives that are not proven to exclude each other.
  std::optional<Conflict> conflict_of_drivers(const std::vector<int>& primitives) {
    const Implications implications(flat_, primitives);
    PairProof proof(
        flat_, [&](Activation& activation, std::size_t i) { return activation.running(primitives[i]); }, work_);
    for (const auto& [one, other] : implications.open_pairs())
      if (auto conflict = proof.check(one, other)) return conflict;
    if (!implications.has_more()) return std::nullopt;
    const auto& [one, other] = implications.open_pairs().back();
    return Conflict{one, other, PairProof::kTangled};
  }

  /// Two inputs of the Merge that are not proven to exclude each other.
  std::optional<Conflict> conflict_of_inputs(int primitive, const std::vector<int>& ports) {
    PairProof proof(
        flat_, [&](Activation& activation, std::size_t i) { return activation.present_at(primitive, ports[i]); },
        work_);
    for (std::size_t other = 1; other < ports.size(); ++other)
      for (std::size_t one = 0; one < other; ++one)
        if (auto conflict = proof.check(one, other)) return conflict;
    return std::nullopt;
  }

  void check_device(const std::string& device, const std::vector<int>& primitives) {
    const auto conflict = conflict_of_drivers(primitives);
    if (!conflict) {
      net_report_.exclusions.push_back({device, true});
      return;
    }
    const int one = primitives[conflict->one], other = primitives[conflict->other];
    const std::string& claims = flat_.primitives[static_cast<std::size_t>(other)].info->claims;
    report_.error(Code::kResourceConflict, flat_.primitive_pointer(other) + "/parameters" + pointer_segment(claims),
                  fmt::format("device '{}' is driven by both '{}' and '{}'{}", shown(device), flat_.id(one),
                              flat_.id(other), when(*conflict)),
                  "Put each into a fragment of its own whose activations exclude each other, or let the fragments "
                  "share one driver through a Merge");
  }

  void check_merge(int primitive) {
    std::vector<int> ports;
    for (int port = 0; port < flat_.input_count(primitive); ++port) {
      const bool linked =
          flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(primitive)] + port)] >= 0;
      if (linked || flat_.constant(primitive, port) != nullptr) ports.push_back(port);
    }
    const auto conflict = conflict_of_inputs(primitive, ports);
    net_report_.exclusions.push_back({flat_.id(primitive), !conflict});
    if (!conflict) return;
    report_.note(flat_.primitive_pointer(primitive),
                 fmt::format("nothing proves that only one of '{}' and '{}' has a value{}",
                             flat_.input_name(primitive, ports[conflict->one]),
                             flat_.input_name(primitive, ports[conflict->other]), when(*conflict)),
                 "two values in one cycle fail the net (conflict); lead them from fragments whose activations exclude "
                 "each other, such as x and Not x");
  }

  static std::string when(const Conflict& conflict) {
    return conflict.when.empty() ? std::string() : fmt::format(": {}", conflict.when);
  }

  const FlatNet& flat_;
  NetReport& net_report_;
  LoadReport& report_;
  std::map<std::string, std::vector<int>> drivers_;
  std::size_t work_ = 0;
};

}  // namespace

void check_exclusions(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  ExclusionCheck(flat, net_report, report).run();
}

}  // namespace takt::net
