#include "core/net/frame_check.h"

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

class FrameChecker {
 public:
  FrameChecker(const FlatNet& flat, LoadReport& report) : flat_(flat), report_(report) {}

  void run() {
    for (const FlatLink& link : flat_.links) {
      if (link.from < 0 || flat_.is_gate(link.to)) continue;
      const std::vector<int> from = classes(link.from, flat_.output(link.from, link.from_port));
      const std::vector<int> to = classes(link.to, flat_.input(link.to, link.to_port));
      if (!from.empty() && !to.empty()) unify(link, from, to);
    }
  }

 private:
  struct Class {
    int parent;
    std::string name;  ///< empty: not known yet
  };

  int find(int number) {
    while (classes_[static_cast<std::size_t>(number)].parent != number) {
      int& parent = classes_[static_cast<std::size_t>(number)].parent;
      parent = classes_[static_cast<std::size_t>(parent)].parent;
      number = parent;
    }
    return number;
  }

  int add(std::string name) {
    classes_.push_back({static_cast<int>(classes_.size()), std::move(name)});
    return static_cast<int>(classes_.size()) - 1;
  }

  /// The class of a variable or parameter of one primitive ("7:A"), or of a literal name ("=flange").
  int class_of(const std::string& key, const std::string& name) {
    const auto [place, fresh] = numbers_.try_emplace(key, 0);
    if (fresh) place->second = add(name);
    return place->second;
  }

  /// Text of a String parameter, its default if it is not given.
  std::string parameter_text(const FlatPrimitive& primitive, std::string_view name) const {
    const Json& given = primitive.description->parameters;
    const auto value = given.find(name);
    if (value != given.end()) return value->is_string() ? value->get<std::string>() : std::string();
    const auto parameter = std::ranges::find(primitive.info->parameters, name, &PrimitiveInfo::Parameter::name);
    const Json fallback = Json::parse(parameter->fallback, nullptr, false);
    return fallback.is_string() ? fallback.get<std::string>() : std::string();
  }

  /// The name that the resource of the primitive gives to its variable A or B; empty: none.
  std::string_view signal_frame(int node, const FrameName& name) const {
    const Signal* signal = flat_.signals.empty() ? nullptr : flat_.signals[static_cast<std::size_t>(node)];
    if (signal == nullptr || name.kind != FrameName::Kind::kVariable) return {};
    const std::string_view frame = signal->frame;
    const std::size_t sign = frame.find('>');
    if (name.text == "A") return frame.substr(0, sign);
    return name.text == "B" && sign != std::string_view::npos ? frame.substr(sign + 1) : std::string_view();
  }

  std::vector<int> classes(int node, const PrimitiveInfo::Port& port) {
    std::vector<int> numbers;
    if (port.spec.frame.empty()) return numbers;
    const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(node)];
    const auto names = parse_frame_names(port.spec.frame, *primitive.info);
    for (const FrameName& name : *names) {
      const std::string text(name.text);
      if (name.kind == FrameName::Kind::kLiteral) {
        numbers.push_back(class_of("=" + text, text));
      } else if (const auto fixed = signal_frame(node, name); !fixed.empty()) {
        numbers.push_back(class_of(fmt::format("={}", fixed), std::string(fixed)));
      } else if (name.kind == FrameName::Kind::kVariable) {
        numbers.push_back(class_of(fmt::format("{}:{}", node, text), {}));
      } else {
        const std::string given = parameter_text(primitive, name.text);
        numbers.push_back(given.empty() ? class_of(fmt::format("{}:@{}", node, text), {})
                                        : class_of("=" + given, given));
      }
    }
    return numbers;
  }

  std::string words(const std::vector<int>& numbers) {
    std::string text;
    for (const int number : numbers) {
      const std::string& name = classes_[static_cast<std::size_t>(find(number))].name;
      text += fmt::format("{}{}", text.empty() ? "" : ">", name.empty() ? "?" : shown(name));
    }
    return text;
  }

  void unify(const FlatLink& link, const std::vector<int>& from, const std::vector<int>& to) {
    bool fits = from.size() == to.size();
    for (std::size_t i = 0; fits && i < from.size(); ++i) {
      const std::string &a = classes_[static_cast<std::size_t>(find(from[i]))].name,
                        &b = classes_[static_cast<std::size_t>(find(to[i]))].name;
      fits = a.empty() || b.empty() || a == b;
    }
    if (!fits) {
      report_.error(
          Code::kFrameMismatch, flat_.link_pointer(link),
          fmt::format("frame mismatch: '{}' is {}{}, but '{}' accepts {}{}",
                      flat_.output_name(link.from, link.from_port), words(from), flat_.declared_frame(link.from),
                      flat_.input_name(link.to, link.to_port), words(to), flat_.declared_frame(link.to)),
          "Feed the pose that the port names: A>B is the pose of B in A, a single name the frame a value is expressed "
          "in");
      return;
    }
    for (std::size_t i = 0; i < from.size(); ++i) join(find(from[i]), find(to[i]));
  }

  void join(int a, int b) {
    if (a == b) return;
    Class &keep = classes_[static_cast<std::size_t>(a)], &gone = classes_[static_cast<std::size_t>(b)];
    if (keep.name.empty()) keep.name = gone.name;
    gone.parent = a;
  }

  const FlatNet& flat_;
  LoadReport& report_;
  std::vector<Class> classes_;
  std::unordered_map<std::string, int> numbers_;
};

}  // namespace

std::optional<std::vector<FrameName>> parse_frame_names(std::string_view text, const PrimitiveInfo& info) {
  std::vector<FrameName> names;
  for (std::size_t start = 0; !text.empty() && start <= text.size();) {
    const std::size_t end = std::min(text.find('>', start), text.size());
    const std::string_view name = text.substr(start, end - start);
    start = end + 1;
    if (name.empty()) return std::nullopt;
    if (name.size() == 1 && name[0] >= 'A' && name[0] <= 'Z') {
      names.push_back({FrameName::Kind::kVariable, name});
    } else if (name[0] == '@') {
      const auto parameter = std::ranges::find(info.parameters, name.substr(1), &PrimitiveInfo::Parameter::name);
      if (parameter == info.parameters.end() || parameter->type != "String") return std::nullopt;
      names.push_back({FrameName::Kind::kParameter, name.substr(1)});
    } else {
      names.push_back({FrameName::Kind::kLiteral, name});
    }
  }
  return names;
}

void check_frames(const FlatNet& flat, LoadReport& report) { FrameChecker(flat, report).run(); }

}  // namespace takt::net
