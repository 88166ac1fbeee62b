#include "hw/wire/settings_rows.h"

#include <cmath>

namespace takt::hw {

Key address_key(const std::string& in_process, const std::string& host) {
  return text_key("address", "'virtual': " + in_process + " in the process. " + host).by_default("virtual");
}
Key emulated_key() {
  return boolean_key("emulated", "The other end is known to be an emulator.").optional("true on this machine");
}
Key margin_key(const std::string& what) {
  return number_key("margin_ms", "ms", {.low = 0.0, .high = 100.0},
                    "By which set points are later, for what " + what + " are late.")
      .optional("4; virtual: the jitter");
}
Key transport_key(double absent, double most, const std::string& what) {
  return number_key("transport_ms", "ms", {.low = 0.0, .high = most},
                    "Each " + what + " takes at least this long; virtual only.")
      .by_default(absent);
}
Key jitter_key(double absent, double most) {
  return number_key("jitter_ms", "ms", {.low = 0.0, .high = most}, "And up to this much more.").by_default(absent);
}
Key share_key(std::string name, const std::string& what) {
  return number_key(std::move(name), "", {.low = 0.0, .high = 0.5}, "Share of the messages that " + what + ".")
      .by_default(0.0);
}
Key piece_key() {
  return integer_key("piece_bytes", {.low = 0, .high = 1500},
                     "Bytes arrive in pieces of at most that size; 0: as sent. Virtual only.")
      .by_default(0.0);
}
Key whole_ms_key(std::string name, double absent, const Range& range, std::string doc) {
  Key key = integer_key(std::move(name), range, std::move(doc)).by_default(absent);
  key.unit = "ms";
  return key;
}

Nanoseconds read_ms(FormReader& from, std::string_view key, std::optional<double> absent) {
  if (from.row(key).type == Key::Type::kInteger) return from.integer(key) * kMillisecond;
  return static_cast<Nanoseconds>(std::llround(from.number(key, absent) * kMillisecond));
}

}  // namespace takt::hw
