#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "languages/script/data.h"
#include "languages/scxml/chart.h"

namespace takt::languages {

/// An event of a chart (SCXML 5.10.1).
struct ChartEvent {
  enum class Type { kPlatform, kInternal, kExternal };
  std::string name;
  Type type = Type::kExternal;
  std::string sendid = {}, origin = {}, origintype = {}, invokeid = {};
  Data data = {};
};

/// What a session knows and computes: the data model that its document names (SCXML B). Errors are texts.
class ChartModel {
 public:
  template <class T>
  using Value = std::expected<T, std::string>;

  virtual ~ChartModel() = default;
  virtual Value<bool> condition(const std::string& expression) = 0;
  virtual Value<Data> evaluate(const std::string& expression) = 0;
  virtual Value<void> execute(const std::string& script) = 0;
  virtual Value<void> declare(const std::string& name) = 0;
  virtual Value<void> assign(const std::string& location, const std::string& expression) = 0;
  virtual Value<void> assign(const std::string& location, const Data& value) = 0;
  virtual Value<std::size_t> begin_loop(const std::string& array) = 0;
  virtual Value<void> enter_round(std::size_t round, const std::string& item, const std::string& index) = 0;
  virtual void end_loop() = 0;
  virtual void set_event(const ChartEvent& event) = 0;
  /// True if the last call used up its steps or its memory.
  [[nodiscard]] virtual bool exhausted() const = 0;
};

/// The model of a chart for a session. @param in  whether a state is active
[[nodiscard]] std::unique_ptr<ChartModel> make_model(const Chart& chart, const std::string& session, std::uint64_t seed,
                                                     std::function<bool(const std::string&)> in);

}  // namespace takt::languages
