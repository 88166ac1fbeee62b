#include "core/net/exclusion.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/activity.h"

namespace takt::net {
namespace {

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
  static constexpr std::size_t kMostDrivers = 16;      ///< of one device that are compared with each other
  static constexpr std::size_t kMostWork = 2'000'000;  ///< of all proofs of a net: less than a second

  /// Two that may be active together, and when; no text if the bounds did not suffice.
  struct Conflict {
    std::size_t one, other;
    std::string when;
  };

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

  /// The first pair that is not proven to exclude each other. `when`: activity of number i as a function.
  template <class When>
  std::optional<Conflict> conflict_among(std::size_t count, When when) {
    Activity activity(flat_);
    std::vector<Bdd::Ref> active;
    for (std::size_t i = 0; i < count; ++i) active.push_back(work_ < kMostWork ? when(activity, i) : Bdd::kTrue);
    std::optional<Conflict> conflict;
    for (std::size_t other = 1; other < count && !conflict; ++other) {
      for (std::size_t one = 0; one < other && !conflict; ++one) {
        if (activity.exclude(active[one], active[other])) continue;
        const bool cut_short = activity.gave_up() || work_ >= kMostWork;
        conflict = Conflict{one, other, cut_short ? "" : activity.example(active[one], active[other])};
        if (cut_short) conflict->when = "the net is too tangled for a proof";
      }
    }
    work_ += activity.work();
    return conflict;
  }

  void check_device(const std::string& device, const std::vector<int>& primitives) {
    const std::size_t count = std::min(primitives.size(), kMostDrivers);
    const auto conflict =
        conflict_among(count, [&](Activity& activity, std::size_t i) { return activity.running(primitives[i]); });
    if (!conflict && count == primitives.size()) {
      net_report_.exclusions.push_back({device, true});
      return;
    }
    const int one = primitives[conflict ? conflict->one : 0], other = primitives[conflict ? conflict->other : count];
    const std::string& claims = flat_.primitives[static_cast<std::size_t>(other)].info->claims;
    report_.error(Code::kResourceConflict, flat_.primitive_pointer(other) + "/parameters" + pointer_segment(claims),
                  fmt::format("device '{}' is driven by both '{}' and '{}'{}", shown(device), flat_.id(one),
                              flat_.id(other), when(conflict)),
                  "one primitive drives a device: put each into a fragment of its own whose activations exclude each "
                  "other, or let the fragments share one driver through a Merge");
  }

  void check_merge(int primitive) {
    std::vector<int> ports;
    for (int port = 0; port < flat_.input_count(primitive); ++port) {
      const bool linked =
          flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(primitive)] + port)] >= 0;
      if (linked || flat_.constant(primitive, port) != nullptr) ports.push_back(port);
    }
    const auto conflict = conflict_among(
        ports.size(), [&](Activity& activity, std::size_t i) { return activity.present_at(primitive, ports[i]); });
    net_report_.exclusions.push_back({flat_.id(primitive), !conflict});
    if (!conflict) return;
    report_.note(flat_.primitive_pointer(primitive),
                 fmt::format("nothing proves that only one of '{}' and '{}' has a value{}",
                             flat_.input_name(primitive, ports[conflict->one]),
                             flat_.input_name(primitive, ports[conflict->other]), when(conflict)),
                 "two values in one cycle fail the net (conflict); lead them from fragments whose activations exclude "
                 "each other, such as x and Not x");
  }

  static std::string when(const std::optional<Conflict>& conflict) {
    if (!conflict || conflict->when.empty()) return {};
    return fmt::format(": {}", conflict->when);
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
