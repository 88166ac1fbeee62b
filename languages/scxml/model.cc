#include "languages/scxml/model.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/script/engine.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

std::string json_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

class EcmascriptModel final : public ChartModel {
 public:
  EcmascriptModel(const Chart& chart, const std::string& session, std::uint64_t seed,
                  std::function<bool(const std::string&)> in)
      : engine_(seed) {
    engine_.set_in(std::move(in));
    const Json processor{{"location", "#_scxml_" + session}};
    (void)engine_.set_constant("_sessionid", Data::of_json(json_of(session)));
    (void)engine_.set_constant("_name", Data::of_json(json_of(chart.name)));
    (void)engine_.set_constant(
        "_ioprocessors", Data::of_json(json_of({{std::string(kScxmlProcessor), processor}, {"scxml", processor}})));
    (void)engine_.set_constant("_x", Data::of_json("{}"));
    (void)engine_.set_constant("_event", {});
  }

  Value<bool> condition(const std::string& expression) override { return engine_.condition(expression); }
  Value<Data> evaluate(const std::string& expression) override { return engine_.evaluate(expression); }
  Value<void> execute(const std::string& script) override { return engine_.execute(script); }
  Value<void> declare(const std::string& name) override { return engine_.declare(name); }
  Value<void> assign(const std::string& location, const std::string& expression) override {
    return engine_.assign(location, expression);
  }
  Value<void> assign(const std::string& location, const Data& value) override {
    return engine_.assign(location, value);
  }
  Value<std::size_t> begin_loop(const std::string& array) override { return engine_.begin_loop(array); }
  Value<void> enter_round(std::size_t round, const std::string& item, const std::string& index) override {
    for (const std::string* name : {&item, &index})
      if (!name->empty() && !is_script_name(*name))
        return std::unexpected(fmt::format("'{}' cannot be a variable", *name));
    return engine_.enter_round(round, item, index);
  }
  void end_loop() override { engine_.end_loop(); }

  void set_event(const ChartEvent& event) override {
    static constexpr const char* kTypes[] = {"platform", "internal", "external"};
    Json fields{{"name", event.name}, {"type", kTypes[static_cast<int>(event.type)]}};
    for (const auto& [key, text] : {std::pair{"sendid", &event.sendid},
                                    {"origin", &event.origin},
                                    {"origintype", &event.origintype},
                                    {"invokeid", &event.invokeid}})
      if (!text->empty()) fields[key] = *text;
    (void)engine_.set_event(json_of(fields), event.data);
  }
  [[nodiscard]] bool exhausted() const override { return engine_.exhausted(); }

 private:
  ScriptEngine engine_;
};

/// Without values: the only expression is In('state').
class NullModel final : public ChartModel {
 public:
  explicit NullModel(std::function<bool(const std::string&)> in) : in_(std::move(in)) {}

  Value<bool> condition(const std::string& expression) override {
    std::string_view text = trimmed(expression);
    if (text.starts_with("In")) {
      text = trimmed(text.substr(2));
      if (text.size() >= 2 && text.front() == '(' && text.back() == ')') {
        text = trimmed(text.substr(1, text.size() - 2));
        const bool quoted =
            text.size() >= 2 && (text.front() == '\'' || text.front() == '"') && text.back() == text.front();
        if (quoted) text = text.substr(1, text.size() - 2);
        return in_(std::string(text));
      }
    }
    return std::unexpected(
        fmt::format("'{}' is not In('state'), the only condition of the null data model", expression));
  }
  Value<Data> evaluate(const std::string&) override { return none(); }
  Value<void> execute(const std::string&) override { return none(); }
  Value<void> declare(const std::string&) override { return none(); }
  Value<void> assign(const std::string&, const std::string&) override { return none(); }
  Value<void> assign(const std::string&, const Data&) override { return none(); }
  Value<std::size_t> begin_loop(const std::string&) override { return none(); }
  Value<void> enter_round(std::size_t, const std::string&, const std::string&) override { return none(); }
  void end_loop() override {}
  void set_event(const ChartEvent&) override {}
  [[nodiscard]] bool exhausted() const override { return false; }

 private:
  static std::unexpected<std::string> none() {
    return std::unexpected(std::string("the null data model has no values"));
  }
  static std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
  }

  std::function<bool(const std::string&)> in_;
};

}  // namespace

std::unique_ptr<ChartModel> make_model(const Chart& chart, const std::string& session, std::uint64_t seed,
                                       std::function<bool(const std::string&)> in) {
  if (chart.model == Chart::Model::kNull) return std::make_unique<NullModel>(std::move(in));
  return std::make_unique<EcmascriptModel>(chart, session, seed, std::move(in));
}

}  // namespace takt::languages
