// Messages, pop-ups, and connections to other machines.
#include <cmath>

#include <fmt/format.h>

#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

using hw::StreamLink;
using urscript::Library;
using urscript::List;
using urscript::Outcome;
using urscript::Value;
using urscript::Wait;

constexpr double kConnectTime = 2.0;  // s, in which socket_open() gives up
constexpr int kMostNumbers = 30;      // of one socket_read_...(): as many as a real controller reads at once
constexpr std::size_t kLongestLine = 4096;

/// What `take` gives at once: the program goes on in the same frame. Else it is asked in each frame until it gives
/// something, or for `seconds` (0: for ever), then `otherwise`.
Outcome wait_for(Controller& c, double seconds, const Value& otherwise, std::function<std::optional<Value>()> take) {
  if (auto value = take()) return *std::move(value);
  const Nanoseconds end = c.time() + static_cast<Nanoseconds>(seconds * 1e9);
  return Wait([=, &c, take = std::move(take)]() -> std::optional<Value> {
    if (auto value = take()) return value;
    if (seconds > 0.0 && c.time() >= end) return otherwise;
    return std::nullopt;
  });
}

bool is_open(Controller& c, const std::string& name) { return c.sockets().state(name) == StreamLink::State::kOpen; }

Outcome open_socket(Controller& c, const Arguments& a) {
  const std::string name = a.text(2);
  if (!c.sockets().open(a.text(0), a.integer(1), name)) return Value(false);
  return wait_for(c, kConnectTime, Value(false), [&c, name]() -> std::optional<Value> {
    const auto state = c.sockets().state(name);
    if (state == StreamLink::State::kConnecting) return std::nullopt;
    return Value(state == StreamLink::State::kOpen);
  });
}

/// "[2, 7, 9]": a list that begins with how many there are.
Value counted(std::vector<Value> values) {
  List list{Value(static_cast<int>(values.size()))};
  list.insert(list.end(), values.begin(), values.end());
  return list;
}
Value nothing_read(int count) {
  List list(static_cast<std::size_t>(count) + 1, Value(-1));
  list[0] = 0;
  return list;
}

Outcome read_integers(Controller& c, const Arguments& a) {
  const int count = a.integer(0, 1, kMostNumbers);
  const std::string name = a.text(1);
  if (!is_open(c, name) && c.sockets().received(name).empty()) return nothing_read(count);
  return wait_for(c, a.real(2), nothing_read(count), [&c, count, name]() -> std::optional<Value> {
    std::string& bytes = c.sockets().received(name);
    const auto size = static_cast<std::size_t>(count) * sizeof(std::int32_t);
    if (bytes.size() < size) return is_open(c, name) ? std::nullopt : std::optional<Value>(nothing_read(count));
    ByteReader reader(bytes);
    std::vector<Value> values;
    for (int i = 0; i < count; ++i) values.emplace_back(reader.take<std::int32_t>());
    bytes.erase(0, size);
    return counted(std::move(values));
  });
}

Outcome read_bytes(Controller& c, const Arguments& a) {
  const int count = a.integer(0, 1, kMostNumbers);
  const std::string name = a.text(1);
  return wait_for(c, a.real(2), nothing_read(count), [&c, count, name]() -> std::optional<Value> {
    std::string& bytes = c.sockets().received(name);
    if (bytes.size() < static_cast<std::size_t>(count)) return std::nullopt;
    std::vector<Value> values;
    for (int i = 0; i < count; ++i)
      values.emplace_back(static_cast<int>(static_cast<std::uint8_t>(bytes[static_cast<std::size_t>(i)])));
    bytes.erase(0, static_cast<std::size_t>(count));
    return counted(std::move(values));
  });
}

/// "(1, 2.5, 3)" with as many numbers as are asked for.
std::optional<Value> parse_numbers(std::string_view text, int count) {
  std::vector<urscript::Token> tokens;
  urscript::ScriptError error;
  if (!urscript::tokenize(text, tokens, error)) return std::nullopt;
  std::vector<Value> values;
  bool minus = false;
  for (const auto& token : tokens) {
    if (token.kind == urscript::Token::Kind::kNumber)
      values.emplace_back(minus ? -*token.value.number() : *token.value.number());
    minus = token.is("-");
  }
  if (values.size() != static_cast<std::size_t>(count)) return std::nullopt;
  return counted(std::move(values));
}

Outcome read_floats(Controller& c, const Arguments& a) {
  const int count = a.integer(0, 1, kMostNumbers);
  const std::string name = a.text(1);
  return wait_for(c, a.real(2), nothing_read(count), [&c, count, name]() -> std::optional<Value> {
    std::string& bytes = c.sockets().received(name);
    const std::size_t end = bytes.find(')');
    if (end == std::string::npos) return std::nullopt;
    const auto values = parse_numbers(bytes.substr(0, end), count);
    bytes.erase(0, end + 1);
    return values.value_or(nothing_read(count));
  });
}

Outcome read_line(Controller& c, const std::string& name, double seconds) {
  return wait_for(c, seconds, Value(""), [&c, name]() -> std::optional<Value> {
    std::string& bytes = c.sockets().received(name);
    const std::size_t end = bytes.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = bytes.substr(0, std::min(end, kLongestLine));
    bytes.erase(0, end + 1);
    if (line.ends_with('\r')) line.pop_back();
    return Value(line);
  });
}

/// What has come, or what stands between prefix and suffix where they are given.
Outcome read_string(Controller& c, const Arguments& a) {
  const std::string name = a.text(0), prefix = a.text(1), suffix = a.text(2);
  return wait_for(c, a.real(4), Value(""), [=, &c]() -> std::optional<Value> {
    std::string& bytes = c.sockets().received(name);
    const std::size_t begin = prefix.empty() ? 0 : bytes.find(prefix);
    if (bytes.empty() || begin == std::string::npos) return std::nullopt;
    const std::size_t from = begin + prefix.size();
    const std::size_t to = suffix.empty() ? bytes.size() : bytes.find(suffix, from);
    if (to == std::string::npos) return std::nullopt;
    Value text(bytes.substr(from, to - from));
    bytes.erase(0, to + suffix.size());
    return text;
  });
}

template <WireNumber T>
std::string binary(T value) {
  std::string bytes;
  append(bytes, value);
  return bytes;
}

void add_sending(Library& library, Controller& c) {
  const auto add = [&](const char* signature, auto encode) {
    library.add(signature, checked([&c, encode](const Arguments& a) -> Outcome {
                  return Value(c.sockets().send(a.text(1), encode(a)));
                }));
  };
  add("socket_send_int(value, socket_name='socket_0')",
      [](const Arguments& a) { return binary<std::int32_t>(a.integer(0)); });
  add("socket_send_byte(value, socket_name='socket_0')",
      [](const Arguments& a) { return binary<std::uint8_t>(saturated<std::uint8_t>(a.real(0))); });
  add("socket_send_string(str, socket_name='socket_0')", [](const Arguments& a) { return a.text(0); });
  add("socket_send_line(str, socket_name='socket_0')", [](const Arguments& a) { return a.text(0) + "\n"; });
  library.add("socket_set_var(name, value, socket_name='socket_0')", checked([&c](const Arguments& a) -> Outcome {
                return Value(c.sockets().send(a.text(2), fmt::format("SET {} {}\n", a.text(0), a.integer(1))));
              }));
}

}  // namespace

void add_system_functions(Library& library, Controller& c) {
  library.add("textmsg(s1, s2='')", checked([&c](const Arguments& a) -> Outcome {
                c.events().add({.title = {}, .text = a.text(0) + a.text(1), .time = c.time()});
                return Value();
              }));
  library.add("popup(s, title='Popup', warning=False, error=False, blocking=False)",
              checked([&c](const Arguments& a) -> Outcome {
                c.settings().popup = a.text(0);
                c.events().add({.title = {}, .text = a.text(1) + ": " + a.text(0), .time = c.time()});
                if (!a.boolean(4)) return Value();
                return Wait([&c]() -> std::optional<Value> {
                  return c.settings().popup.empty() ? std::optional<Value>(Value()) : std::nullopt;
                });
              }));
  library.add("request_boolean_from_primary_client(message)",
              [](const urscript::Call&) -> Outcome { return Value(false); });
  library.add("time(mode=0)", [&c](const urscript::Call&) -> Outcome { return Value(to_seconds(c.time())); });
  library.add("powerdown()", [&c](const urscript::Call&) -> Outcome {
    c.power_off();
    return Value();
  });
  library.add("get_robot_serial_number()",
              [&c](const urscript::Call&) -> Outcome { return Value(c.options().serial); });
}

void add_socket_functions(Library& library, Controller& c) {
  const auto add = [&](const char* signature, auto run) {
    library.add(signature, checked([&c, run](const Arguments& a) -> Outcome { return run(c, a); }));
  };
  add("socket_open(address, port, socket_name='socket_0')", open_socket);
  add("socket_close(socket_name='socket_0')", [](Controller& k, const Arguments& a) -> Outcome {
    k.sockets().close(a.text(0));
    return Value();
  });
  add("socket_read_binary_integer(number, socket_name='socket_0', timeout=2)", read_integers);
  add("socket_read_byte_list(number, socket_name='socket_0', timeout=2)", read_bytes);
  add("socket_read_ascii_float(number, socket_name='socket_0', timeout=2)", read_floats);
  add("socket_read_string(socket_name='socket_0', prefix='', suffix='', interpret_escape=False, timeout=2)",
      read_string);
  add("socket_read_line(socket_name='socket_0', timeout=2)",
      [](Controller& k, const Arguments& a) { return read_line(k, a.text(0), a.real(1)); });
  add("socket_get_var(name, socket_name='socket_0')", [](Controller& k, const Arguments& a) -> Outcome {
    if (!k.sockets().send(a.text(1), "GET " + a.text(0) + "\n")) return Value(0);
    const std::string name = a.text(1);
    return wait_for(k, kConnectTime, Value(0), [&k, name]() -> std::optional<Value> {
      std::string& bytes = k.sockets().received(name);
      const std::size_t end = bytes.find('\n');
      if (end == std::string::npos) return std::nullopt;
      const auto numbers = parse_numbers(bytes.substr(0, end).substr(bytes.find_last_of(' ', end) + 1), 1);
      bytes.erase(0, end + 1);
      return numbers ? Value(static_cast<int>(*(*numbers->get<List>())[1].number())) : Value(0);
    });
  });
  add_sending(library, c);
}

}  // namespace takt::hw::rtde
