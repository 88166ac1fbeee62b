#include "core/net/null_paths.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/digraph.h"

namespace takt::net {
namespace {

/// Breadth first from every place where null arises; so the first way to reach an output is a shortest one.
class NullSearch {
 public:
  NullSearch(const FlatNet& flat, NetReport& net_report, LoadReport& report)
      : flat_(flat),
        net_report_(net_report),
        report_(report),
        reached_by_(static_cast<std::size_t>(flat.output_base.back()), kNot),
        input_reason_(flat.input_link.size(), kNot),
        readers_(flat.output_base.back(), links_by_output(flat)) {}

  void run() {
    for (int node = 0; node < flat_.primitive_count(); ++node) start_at(node);
    for (std::size_t head = 0; head < queue_.size(); ++head) leave(queue_[head]);
    for (int node = 0; node < flat_.primitive_count(); ++node) note(node);
    mark_links();
  }

 private:
  static constexpr int kNot = -1;        ///< no null comes here
  static constexpr int kOwn = -2;        ///< it arises here
  static constexpr int kNoInitial = -3;  ///< a delayed link without an initial value
  static constexpr int kConstant = -4;   ///< the constant null
  static constexpr int kResting = -5;    ///< its fragment may rest
  static constexpr std::size_t kMostNotes = 100;

  /// An edge per link; where it leads is in the link itself, so the graph needs nodes for outputs only.
  static std::vector<std::pair<int, int>> links_by_output(const FlatNet& flat) {
    std::vector<std::pair<int, int>> edges;
    edges.reserve(flat.links.size());
    for (const FlatLink& link : flat.links) {
      edges.emplace_back(flat.output_base[static_cast<std::size_t>(link.from)] + link.from_port, link.to);
    }
    return edges;
  }

  struct Output {
    int node, port;
  };

  [[nodiscard]] std::size_t output_number(int node, int port) const {
    return static_cast<std::size_t>(flat_.output_base[static_cast<std::size_t>(node)] + port);
  }
  [[nodiscard]] std::size_t input_number(int node, int port) const {
    return static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(node)] + port);
  }

  void start_at(int node) {
    const bool resting = flat_.fragments[static_cast<std::size_t>(flat_.fragment_of(node))].gated;
    for (int port = 0; port < flat_.output_count(node); ++port) {
      if (flat_.output(node, port).spec.may_be_null) reach({node, port}, kOwn);
      // Inside a fragment nobody reads while it rests; only a reader outside sees that null.
      if (resting) reach_outside(node, port);
    }
    for (int port = 0; port < flat_.input_count(node); ++port) {
      const int link = flat_.input_link[input_number(node, port)];
      if (link >= 0) {
        const FlatLink& l = flat_.links[static_cast<std::size_t>(link)];
        if (l.delayed && flat_.description(l).initial.is_null()) enter(node, port, kNoInitial);
      } else if (const auto* constant = flat_.constant(node, port); constant != nullptr && constant->is_null()) {
        enter(node, port, kConstant);
      }
    }
  }

  void reach_outside(int node, int port) {
    for (const auto& [to, l] : readers_.from(static_cast<int>(output_number(node, port)))) {
      const FlatLink& link = flat_.links[static_cast<std::size_t>(l)];
      if (!flat_.is_gate(link.to) && !within(flat_.fragment_of(link.to), flat_.fragment_of(node))) {
        enter(link.to, link.to_port, kResting);
      }
    }
  }

  [[nodiscard]] bool within(int inner, int outer) const {
    while (inner > outer)
      inner = flat_.fragments[static_cast<std::size_t>(inner)].parent;  // parents are numbered first
    return inner == outer;
  }

  void reach(Output output, int reason) {
    int& reached = reached_by_[output_number(output.node, output.port)];
    if (reached != kNot) return;
    reached = reason;
    queue_.push_back(output);
  }

  /// Null comes to an input, by a link (its number) or for another reason.
  void enter(int node, int port, int reason) {
    int& known = input_reason_[input_number(node, port)];
    if (known != kNot) return;
    known = reason;
    const OnNull on_null = flat_.input(node, port).spec.on_null;
    if (on_null != OnNull::kPropagate && on_null != OnNull::kMayPass) return;
    for (int out = 0; out < flat_.output_count(node); ++out) reach({node, out}, port);
  }

  void leave(Output output) {
    for (const auto& [to, l] : readers_.from(static_cast<int>(output_number(output.node, output.port)))) {
      const FlatLink& link = flat_.links[static_cast<std::size_t>(l)];
      if (!flat_.is_gate(link.to)) enter(link.to, link.to_port, l);
    }
  }

  /// What null means at an input that stops or drives; empty at all others.
  [[nodiscard]] std::string meaning(int node, int port) const {
    const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(node)];
    const PrimitiveInfo::Port& input = flat_.input(node, port);
    const OnNull on_null = input.spec.on_null;
    const auto declared = primitive.description->on_null.find(input.name);
    const bool found = declared != primitive.description->on_null.end();
    if (found && declared->is_boolean()) return declared->get<bool>() ? "true" : "false";
    if (found && declared->is_object()) return fmt::format("bridge {} cycles", declared->front().get<Integer>());
    if (on_null == OnNull::kCountsAsTrue) return "true";
    const bool drives = !primitive.info->claims.empty() && on_null == OnNull::kPropagate;
    return on_null == OnNull::kStop || drives ? "stop" : "";
  }

  static std::string rule(const std::string& meaning) {
    if (meaning == "stop") return "null stops here (row N4)";
    if (meaning.starts_with("bridge")) return fmt::format("null here: {}, then stop (row N4)", meaning);
    return fmt::format("null counts as {} here (row N3)", meaning);
  }

  void note(int node) {
    for (int port = 0; port < flat_.input_count(node); ++port) {
      if (input_reason_[input_number(node, port)] == kNot) continue;
      const std::string means = meaning(node, port);
      if (means.empty() || ++notes_ > kMostNotes) continue;
      NetReport::NullPath path = path_to(node, port);
      path.meaning = means;
      report_.note(flat_.primitive_pointer(node), fmt::format("null can reach '{}': {}", path.at, in_words(path)),
                   rule(means));
      net_report_.null_paths.push_back(std::move(path));
    }
  }

  static std::string in_words(const NetReport::NullPath& path) {
    constexpr std::size_t kMostShown = 12;
    std::vector<std::string> steps = path.ports;
    if (steps.size() > kMostShown) {
      const std::string left_out = fmt::format("... ({} more)", steps.size() - kMostShown);
      steps.erase(steps.begin() + 1, steps.end() - (kMostShown - 1));
      steps.insert(steps.begin() + 1, left_out);
    }
    if (!path.origin.empty()) steps.front() += fmt::format(" ({})", path.origin);
    return fmt::format("{}", fmt::join(steps, " -> "));
  }

  /// From the place where the null arises to the input.
  [[nodiscard]] NetReport::NullPath path_to(int node, int port) const {
    NetReport::NullPath path{.at = flat_.input_name(node, port), .meaning = {}, .origin = {}, .ports = {}, .links = {}};
    path.ports.push_back(path.at);
    for (std::size_t length = 0; length <= reached_by_.size(); ++length) {
      const int reason = input_reason_[input_number(node, port)];
      if (reason == kConstant) {
        path.origin = "the constant null";
        break;
      }
      const int number = reason >= 0 ? reason : flat_.input_link[input_number(node, port)];
      const FlatLink& link = flat_.links[static_cast<std::size_t>(number)];
      path.links.push_back(number);
      path.ports.push_back(flat_.output_name(link.from, link.from_port));
      if (reason < 0) {
        path.origin = reason == kNoInitial ? "delayed, without an initial value" : "null while its fragment rests";
        break;
      }
      node = link.from;
      port = reached_by_[output_number(link.from, link.from_port)];
      if (port < 0) break;  // it arises at this output
    }
    std::ranges::reverse(path.ports);
    std::ranges::reverse(path.links);
    return path;
  }

  void mark_links() {
    for (std::size_t l = 0; l < flat_.links.size(); ++l) {
      const FlatLink& link = flat_.links[l];
      const bool reached = reached_by_[output_number(link.from, link.from_port)] != kNot;
      const bool resting = flat_.fragments[static_cast<std::size_t>(flat_.fragment_of(link.from))].gated &&
                           !within(flat_.fragment_of(link.to), flat_.fragment_of(link.from));
      const bool begins = link.delayed && flat_.description(link).initial.is_null();
      net_report_.links[l].may_be_null = reached || resting || begins;
    }
  }

  const FlatNet& flat_;
  NetReport& net_report_;
  LoadReport& report_;
  std::vector<int> reached_by_;    ///< per output: input port of its primitive by which null came, or a reason
  std::vector<int> input_reason_;  ///< per input: link by which null came, or a reason
  Digraph readers_;                ///< from outputs to nodes; labels are links
  std::vector<Output> queue_;
  std::size_t notes_ = 0;
};

}  // namespace

void note_null_paths(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  NullSearch(flat, net_report, report).run();
}

}  // namespace takt::net
