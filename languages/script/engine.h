#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "languages/script/data.h"

namespace takt::languages {

/// What a script may use.
struct ScriptLimits {
  std::int64_t steps = 2'000'000;  ///< of one evaluation: instructions, and elements that built-in functions visit
  std::size_t bytes = 8u * 1024 * 1024;  ///< of all that the engine holds
};

/// ECMAScript 5.1 (Duktape) in a box: no clock, no random numbers but those of its seed, nothing of the machine, and
/// bounded steps, memory and recursion. The same calls give the same values. Thread: one at a time. Realtime: setup.
class ScriptEngine {
 public:
  /// What an evaluation comes to, or why it failed.
  template <class T>
  using Value = std::expected<T, std::string>;

  explicit ScriptEngine(std::uint64_t seed = 0, const ScriptLimits& limits = {});
  ~ScriptEngine();
  ScriptEngine(const ScriptEngine&) = delete;
  ScriptEngine& operator=(const ScriptEngine&) = delete;

  /// What In('state') answers.
  void set_in(std::function<bool(const std::string& state)> in);

  [[nodiscard]] Value<Data> evaluate(const std::string& expression);
  [[nodiscard]] Value<bool> condition(const std::string& expression);
  [[nodiscard]] Value<void> execute(const std::string& statements);
  /// A global variable, undefined if it is new.
  [[nodiscard]] Value<void> declare(const std::string& name);
  /// location = expression; the location has to exist.
  [[nodiscard]] Value<void> assign(const std::string& location, const std::string& expression);
  [[nodiscard]] Value<void> assign(const std::string& location, const Data& value);
  /// A global that scripts cannot change.
  [[nodiscard]] Value<void> set_constant(const std::string& name, const Data& value);
  /// The global _event. @param fields  all but its data, as a JSON object
  [[nodiscard]] Value<void> set_event(const std::string& fields, const Data& data);
  /// Takes a copy of an array, to go through it. @return its length
  [[nodiscard]] Value<std::size_t> begin_loop(const std::string& array);
  /// Gives a variable, new or not, the value of an element; `index` too, if it is named.
  [[nodiscard]] Value<void> enter_round(std::size_t round, const std::string& item, const std::string& index);
  void end_loop();

  /// True if the last call ran out of steps or memory.
  [[nodiscard]] bool exhausted() const;
  /// Why a text is no expression, or no sequence of statements; nothing if it is one.
  [[nodiscard]] std::optional<std::string> syntax_error(const std::string& text, bool statements = false);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// True for a name that a variable may have.
[[nodiscard]] bool is_script_name(std::string_view name);

}  // namespace takt::languages
