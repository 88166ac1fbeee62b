#include "serve/layout.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/keys_of.h"
#include "core/base/object_reader.h"
#include "core/net/value.h"

namespace takt::serve {
namespace {

using LayoutJson = nlohmann::ordered_json;
using net::ValueType;

constexpr Range kShareOfRoom{.low = 0.1, .high = 20.0};
constexpr Range kAboveZero{.low = 0.0, .high = 1e6, .low_open = true};

/// What a key of a pane holds.
enum class PaneValue { kCamera, kSensor, kArm, kChannel, kAmount, kOptions, kLamps, kTabs };
struct PaneKey {
  std::string_view name;
  PaneValue value;
  ValueType channel = ValueType::kReal;  ///< of kChannel
  bool required = true;
};
struct PaneKind {
  std::string_view show;
  std::vector<PaneKey> keys;
};

/// All panes that a layout can show. The page draws each of them (panel/src/station.ts).
const std::vector<PaneKind>& pane_kinds() {
  using enum PaneValue;
  static const std::vector<PaneKind> all = {
      {"view3d", {}},
      {"camera", {{"camera", kCamera}}},
      {"force", {{"sensor", kSensor}, {"max_N", kAmount}}},
      {"posture", {{"arm", kArm}}},
      {"control", {}},
      {"choice", {{"channel", kChannel}, {"options", kOptions}}},
      {"sticks",
       {{"channel", kChannel, ValueType::kTwist},
        {"enable", kChannel, ValueType::kBoolean},
        {"linear_max_m_s", kAmount},
        {"angular_max_deg_s", kAmount}}},
      {"orbit",
       {{"azimuth", kChannel},
        {"elevation", kChannel},
        {"distance", kChannel},
        {"distance_min_m", kAmount},
        {"distance_max_m", kAmount}}},
      {"hold", {{"channel", kChannel, ValueType::kBoolean}}},
      {"lamps", {{"lamps", kLamps}}},
      {"messages", {}},
      {"tabs", {{"tabs", kTabs}}},
  };
  return all;
}

/// Of the tabs that the page has.
const std::vector<std::string> kTabNames = {"jog",    "program", "nets",     "cameras",
                                            "faults", "plots",   "timeline", "events"};

class LayoutReader {
 public:
  LayoutReader(const cell::BuiltCell& built, const std::vector<std::string>& cameras, Diagnostics& diagnostics)
      : built_(built), cameras_(cameras), diagnostics_(diagnostics) {}

  void read(const LayoutJson& json) {
    ObjectReader reader(json, "", diagnostics_);
    (void)reader.text("title", "");
    each(reader, "columns", [this](ObjectReader& column) {
      (void)column.number("width", 1.0, kShareOfRoom);
      each(column, "panes", [this](ObjectReader& pane) { read_pane(pane); });
    });
    reader.finish();
  }

 private:
  template <class Read>
  void each(ObjectReader& reader, const char* key, const Read& read) {
    const LayoutJson* list = reader.array(key);
    if (list == nullptr) return;
    if (list->empty())
      diagnostics_.error(Code::kMissing, reader.at(key), "the list is empty", "Give at least one object");
    for (std::size_t i = 0; i < list->size(); ++i) {
      ObjectReader one((*list)[i], reader.at(key) + pointer_segment(i), diagnostics_);
      if (!(*list)[i].is_object()) continue;  // which the reader has reported
      read(one);
      one.finish();
    }
  }

  void read_pane(ObjectReader& pane) {
    (void)pane.text("title", "");
    (void)pane.number("height", 1.0, kShareOfRoom);
    std::vector<std::string> shows;
    for (const PaneKind& kind : pane_kinds()) shows.emplace_back(kind.show);
    const std::string show = pane.choice("show", shows);
    const auto kind = std::ranges::find(pane_kinds(), show, &PaneKind::show);
    if (kind == pane_kinds().end()) return;
    for (const PaneKey& key : kind->keys) read_key(pane, key);
  }

  void read_key(ObjectReader& pane, const PaneKey& key) {
    switch (key.value) {
      case PaneValue::kCamera: {
        std::vector<std::string> names = cameras_;
        names.emplace_back("overview");
        (void)pane.choice(key.name, names);
        break;
      }
      case PaneValue::kSensor:
        (void)pane.choice(key.name, keys_of(built_.cell.sensors));
        break;
      case PaneValue::kArm:
        (void)pane.choice(key.name, keys_of(built_.cell.arms));
        break;
      case PaneValue::kChannel:
        (void)pane.choice(key.name, channels_of(key.channel));
        break;
      case PaneValue::kAmount:
        (void)pane.number(key.name, {}, kAboveZero);
        break;
      case PaneValue::kOptions:
        each(pane, "options", [](ObjectReader& option) {
          (void)option.text("text");
          (void)option.number("value");
        });
        break;
      case PaneValue::kLamps:
        each(pane, "lamps", [this](ObjectReader& lamp) {
          (void)lamp.text("text");
          (void)lamp.choice("channel", channels_of(ValueType::kBoolean));
        });
        break;
      case PaneValue::kTabs:
        read_tabs(pane);
        break;
    }
  }

  void read_tabs(ObjectReader& pane) {
    const auto tabs = pane.texts("tabs");
    for (std::size_t i = 0; i < tabs.size(); ++i)
      if (std::ranges::find(kTabNames, tabs[i]) == kTabNames.end())
        diagnostics_.error(Code::kUnknownName, pane.at("tabs") + pointer_segment(i),
                           fmt::format("the page has no tab '{}'", tabs[i]), nearest_choice(tabs[i], kTabNames));
  }

  [[nodiscard]] std::vector<std::string> channels_of(ValueType type) const {
    std::vector<std::string> names;
    for (const auto& [name, channel] : built_.cell.channels)
      if (channel->description().type == type) names.push_back(name);
    return names;
  }

  const cell::BuiltCell& built_;
  const std::vector<std::string>& cameras_;
  Diagnostics& diagnostics_;
};

}  // namespace

Layout read_layout(const std::filesystem::path& scenario, const cell::BuiltCell& built,
                   const std::vector<std::string>& cameras) {
  std::filesystem::path file = scenario;
  file.replace_extension(".layout");
  Layout layout;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return layout;
  auto json = read_json(file);
  if (json) {
    LayoutReader(built, cameras, layout.diagnostics).read(*json);
  } else {
    layout.diagnostics = std::move(json.error());
  }
  layout.diagnostics.set_file(file.filename().string());
  if (!layout.diagnostics.has_errors()) layout.json = json->dump();
  return layout;
}

}  // namespace takt::serve
