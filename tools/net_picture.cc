#include "tools/net_picture.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::tools {
namespace {

/// More cards than these are no picture any more; fragments are drawn closed before.
constexpr std::size_t kFewCards = 400, kMostCards = 1000;
constexpr std::size_t kMostLines = 5, kLongestLine = 30;

using Json = nlohmann::ordered_json;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

std::string cut(std::string text) {
  if (text.size() <= kLongestLine) return text;
  std::size_t end = kLongestLine - 1;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // no half letter
  return text.substr(0, end) + "…";
}

/// The descriptions of all primitives by full id.
void collect(const net::NetDescription& net, const std::string& prefix,
             std::map<std::string, const net::PrimitiveDescription*>& found) {
  for (const auto& primitive : net.primitives) found.emplace(prefix + primitive.id, &primitive);
  for (const auto& fragment : net.fragments) collect(fragment.net, prefix + fragment.id + "/", found);
}

std::string last_part(const std::string& id) { return shown_id(id.substr(id.rfind('/') + 1)); }

/// Numbers as people write them, texts without quotes; no longer than will be shown.
std::string value_text(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (json.is_number_float()) return fmt::format("{:.4g}", json.get<double>());
  if (!json.is_structured()) return short_dump(json);
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (text.size() > kLongestLine) break;
    text += text.empty() ? "" : ", ";
    text += (json.is_object() ? key + " " : "") + value_text(value);
  }
  return json.is_object() ? text : "[" + text + "]";
}

NetPicture::Role role_of(const net::PrimitiveInfo& info) {
  if (info.monitor) return NetPicture::Role::kMonitor;
  if (!info.claims.empty()) return NetPicture::Role::kDevice;
  if (info.source) return NetPicture::Role::kSource;
  return info.termination || info.outputs.empty() ? NetPicture::Role::kEnd : NetPicture::Role::kPlain;
}

std::string about(const net::PrimitiveInfo::Port& port) {
  return fmt::format("{}{}{}{}", name_of(port.type), port.spec.unit.empty() ? "" : fmt::format(" [{}]", port.spec.unit),
                     port.spec.doc.empty() ? "" : ": ", port.spec.doc);
}

/// Builds the picture of one report.
class Painter {
 public:
  Painter(const net::NetReport& report, const net::NetDescription& description)
      : report_(report), description_(description) {
    collect(description, "", descriptions_);
  }

  Result<NetPicture> paint() {
    choose_depth();
    add_frames();
    for (std::size_t p = 0; p < report_.primitives.size(); ++p) add_primitive(p);
    if (picture_.cards.size() > kMostCards) {
      return failure(Code::kTooLarge, "",
                     fmt::format("{} primitives are too many for a picture", picture_.cards.size()),
                     fmt::format("Put parts into fragments: at most {}, closed fragments counted as one", kMostCards));
    }
    mark_paths();
    for (std::size_t l = 0; l < report_.links.size(); ++l) add_link(l);
    finish_ports();
    describe();
    return std::move(picture_);
  }

 private:
  int depth_of(int fragment) const {
    int depth = 0;
    for (int f = fragment; f > 0; f = report_.fragments[at(f)].parent) ++depth;
    return depth;
  }
  /// The fragment around this one, or itself, that is as deep as `depth`.
  int ancestor(int fragment, int depth) const {
    while (depth_of(fragment) > depth) fragment = report_.fragments[at(fragment)].parent;
    return fragment;
  }

  /// How deep fragments are drawn open: all the way, if few enough cards come of it.
  void choose_depth() {
    std::vector<std::size_t> at_depth;  // cards of primitives, by depth of their fragment
    std::vector<std::size_t> fragments;
    const auto count = [](std::vector<std::size_t>& list, int depth) {
      if (list.size() <= at(depth)) list.resize(at(depth) + 1);
      ++list[at(depth)];
    };
    for (const auto& primitive : report_.primitives) count(at_depth, depth_of(primitive.fragment));
    for (std::size_t f = 1; f < report_.fragments.size(); ++f) count(fragments, depth_of(static_cast<int>(f)));
    fragments.resize(std::max(fragments.size(), at_depth.size()) + 1);
    std::size_t open = 0;
    for (std::size_t depth = 0; depth < at_depth.size(); ++depth) {
      open += at_depth[depth];
      const bool last = depth + 1 == at_depth.size();
      if (depth > 0 && open + (last ? 0 : fragments[depth + 1]) > kFewCards) return;
      open_depth_ = static_cast<int>(depth);
    }
  }

  void add_frames() {
    for (std::size_t f = 0; f < report_.fragments.size(); ++f) {
      const auto& fragment = report_.fragments[f];
      const bool keeps = fragment.when_inactive == net::WhenInactive::kKeep;
      picture_.frames.push_back(
          {fragment.id, last_part(fragment.id),
           fragment.can_rest ? (keeps ? "may rest, keeps its state" : "may rest, begins anew") : "", fragment.parent});
    }
  }

  void add_primitive(std::size_t number) {
    const auto& primitive = report_.primitives[number];
    if (depth_of(primitive.fragment) > open_depth_) return add_to_closed(number);
    NetPicture::Card card;
    card.id = primitive.id;
    card.label = last_part(primitive.id);
    card.type = primitive.info->type;
    card.about = fmt::format("{}: {}", primitive.info->type, primitive.info->doc);
    card.role = role_of(*primitive.info);
    card.frame = primitive.fragment;
    for (const auto& port : primitive.info->inputs) card.inputs.push_back({port.name, "", about(port)});
    for (const auto& port : primitive.info->outputs) card.outputs.push_back({port.name, "", about(port)});
    add_parameters(primitive, card);
    card_of_.push_back(static_cast<int>(picture_.cards.size()));
    picture_.cards.push_back(std::move(card));
  }

  void add_parameters(const net::NetReport::Primitive& primitive, NetPicture::Card& card) {
    const auto found = descriptions_.find(primitive.id);
    if (found == descriptions_.end()) return;
    for (const auto& [name, value] : found->second->parameters.items()) {
      const auto input = std::ranges::find(card.inputs, name, &NetPicture::Port::name);
      if (input != card.inputs.end()) {
        input->constant = cut(value_text(value));
      } else if (card.lines.size() < kMostLines) {
        card.lines.push_back(cut(fmt::format("{} = {}", name, value_text(value))));
      } else {
        card.lines.back() = "…";
      }
    }
  }

  /// A primitive that is not drawn itself, but with the fragment that it lies in.
  void add_to_closed(std::size_t number) {
    const int fragment = ancestor(report_.primitives[number].fragment, open_depth_ + 1);
    const auto known = closed_.find(fragment);
    if (known != closed_.end()) {
      ++closed_count_[fragment];
      return card_of_.push_back(known->second);
    }
    NetPicture::Card card;
    card.id = report_.fragments[at(fragment)].id;
    card.label = last_part(card.id);
    card.role = NetPicture::Role::kClosed;
    card.frame = report_.fragments[at(fragment)].parent;
    closed_[fragment] = static_cast<int>(picture_.cards.size());
    closed_count_[fragment] = 1;
    card_of_.push_back(closed_[fragment]);
    picture_.cards.push_back(std::move(card));
  }

  /// Marks the links of null paths, and those of the slowest reaction.
  void mark_paths() {
    null_.resize(report_.links.size());
    critical_.resize(report_.links.size());
    for (const auto& path : report_.null_paths) {
      for (const int link : path.links) null_[at(link)] = true;
    }
    const auto key = [](const net::NetReport::Reaction& one) {
      return std::pair(one.maximum_cycles, one.links.size());
    };
    const auto slowest = std::ranges::max_element(report_.reactions, {}, key);
    if (slowest == report_.reactions.end() || slowest->links.empty()) return;
    for (const int link : slowest->links) critical_[at(link)] = true;
    picture_.critical = fmt::format("{} → {}: {} to {} cycles{}", shown_id(slowest->source), shown_id(slowest->sink),
                                    slowest->minimum_cycles, slowest->maximum_cycles,
                                    slowest->data_dependent ? " and what depends on data" : "");
  }

  /// The port of a closed card that stands for a port inside; made at its first use.
  static int closed_port(std::vector<NetPicture::Port>& ports, const std::string& name) {
    const auto found = std::ranges::find(ports, name, &NetPicture::Port::name);
    if (found != ports.end()) return static_cast<int>(found - ports.begin());
    ports.push_back({name, "", ""});
    return static_cast<int>(ports.size()) - 1;
  }

  /// The card with the input `active` of a fragment that may rest.
  int gate(int fragment) {
    if (depth_of(fragment) > open_depth_) return closed_.at(ancestor(fragment, open_depth_ + 1));
    if (const auto found = gates_.find(fragment); found != gates_.end()) return found->second;
    NetPicture::Card card;
    card.id = report_.fragments[at(fragment)].id + ".active";
    card.label = "active";
    card.about = "the fragment runs while this is true";
    card.role = NetPicture::Role::kGate;
    card.frame = fragment;
    card.inputs.push_back({"active", "", "Boolean"});
    gates_[fragment] = static_cast<int>(picture_.cards.size());
    picture_.cards.push_back(std::move(card));
    return gates_[fragment];
  }

  std::string inside(int primitive, const std::string& port, int card) const {
    return shown_id(report_.primitives[at(primitive)].id.substr(picture_.cards[at(card)].id.size() + 1)) + "." + port;
  }

  void add_link(std::size_t number) {
    const auto& link = report_.links[number];
    NetPicture::Wire wire{.delayed = link.delayed, .null_path = null_[number], .critical = critical_[number]};
    wire.from = card_of_[at(link.from)];
    wire.from_port = link.from_port;
    const auto& source = report_.primitives[at(link.from)].info->outputs[at(link.from_port)];
    wire.to = link.to < 0 ? gate(-link.to) : card_of_[at(link.to)];
    wire.to_port = link.to < 0 ? 0 : link.to_port;
    if (picture_.cards[at(wire.from)].role == NetPicture::Role::kClosed) {
      if (wire.from == wire.to) return;  // inside of it
      wire.from_port = closed_port(picture_.cards[at(wire.from)].outputs, inside(link.from, source.name, wire.from));
    }
    if (picture_.cards[at(wire.to)].role == NetPicture::Role::kClosed) {
      const std::string name =
          link.to < 0 ? std::string("active")
                      : inside(link.to, report_.primitives[at(link.to)].info->inputs[at(link.to_port)].name, wire.to);
      wire.to_port = closed_port(picture_.cards[at(wire.to)].inputs, name);
    }
    picture_.wires.push_back(wire);
  }

  /// Ports without wire and constant are left out, where others of the card have one: the card stays small.
  void finish_ports() {
    for (std::size_t c = 0; c < picture_.cards.size(); ++c) {
      NetPicture::Card& card = picture_.cards[c];
      drop_unused(card.inputs, static_cast<int>(c), &NetPicture::Wire::to, &NetPicture::Wire::to_port);
      drop_unused(card.outputs, static_cast<int>(c), &NetPicture::Wire::from, &NetPicture::Wire::from_port);
    }
    for (const auto& [fragment, card] : closed_) {
      picture_.cards[at(card)].type = fmt::format("fragment of {} primitives", closed_count_[fragment]);
    }
  }

  void drop_unused(std::vector<NetPicture::Port>& ports, int card, int NetPicture::Wire::*end,
                   int NetPicture::Wire::*port) {
    std::vector<bool> used(ports.size());
    bool any = false;
    for (const auto& wire : picture_.wires) {
      if (wire.*end == card) used[at(wire.*port)] = true;
    }
    for (std::size_t i = 0; i < ports.size(); ++i) any = any || used[i] || !ports[i].constant.empty();
    std::vector<int> place(ports.size(), -1);
    std::vector<NetPicture::Port> kept;
    for (std::size_t i = 0; i < ports.size(); ++i) {
      if (any && !used[i] && ports[i].constant.empty()) continue;
      place[i] = static_cast<int>(kept.size());
      if (used[i]) ports[i].constant.clear();
      kept.push_back(std::move(ports[i]));
    }
    for (auto& wire : picture_.wires) {
      if (wire.*end == card) wire.*port = place[at(wire.*port)];
    }
    ports = std::move(kept);
  }

  void describe() {
    picture_.title = description_.name.empty() ? "net" : description_.name;
    std::string drives;
    for (const std::string& resource : report_.resources) drives += (drives.empty() ? "drives " : ", ") + resource;
    picture_.subtitle = fmt::format("{} primitives, {} links{}{}", report_.primitives.size(), report_.links.size(),
                                    drives.empty() ? "" : "; ", drives);
  }

  const net::NetReport& report_;
  const net::NetDescription& description_;
  std::map<std::string, const net::PrimitiveDescription*> descriptions_;
  int open_depth_ = 0;
  std::vector<int> card_of_;                          ///< per primitive
  std::map<int, int> closed_, closed_count_, gates_;  ///< by fragment
  std::vector<bool> null_, critical_;                 ///< per link
  NetPicture picture_;
};

}  // namespace

std::string shown_id(std::string_view id) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  std::string text;
  for (std::size_t i = 0; i < id.size(); ++i) {
    const bool escaped = id[i] == '%' && i + 2 < id.size() && is_digit(id[i + 1]) && is_digit(id[i + 2]);
    const char meant = escaped ? static_cast<char>(16 * digit(id[i + 1]) + digit(id[i + 2])) : id[i];
    const bool printable = meant >= 0x20 && meant != 0x7f;
    text += escaped && printable ? meant : id[i];
    if (escaped && printable) i += 2;
  }
  return text;
}

Result<NetPicture> picture_of(const net::NetReport& report, const net::NetDescription& description) {
  return Painter(report, description).paint();
}

}  // namespace takt::tools
