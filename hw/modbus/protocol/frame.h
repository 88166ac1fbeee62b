#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Frames of Modbus TCP: transaction, protocol (0), length, unit, and a request or an answer. Big endian.
/// Realtime: cyclic while strings have room, unless it says otherwise.
namespace takt::hw::modbus {

inline constexpr std::uint16_t kPort = 502;
inline constexpr std::size_t kHeaderSize = 7, kLargestPdu = 253;

struct Frame {
  std::uint16_t transaction = 0;
  std::uint8_t unit = 0;
  std::string pdu;  ///< function and its data
};
void append_frame(std::string& out, const Frame& frame);

/// Cuts a byte stream into frames. A stream has no marks to find the next frame by: after a header that cannot be, it
/// is broken. Keeps at most one frame besides what it was fed last.
class FrameParser {
 public:
  void feed(std::string_view bytes) { buffer_.append(bytes); }
  /// @return the next frame; nothing: more bytes are needed, or it is broken.
  [[nodiscard]] std::optional<Frame> next();
  [[nodiscard]] bool broken() const { return broken_; }
  [[nodiscard]] std::size_t waiting() const { return buffer_.size(); }
  void reset() {
    buffer_.clear();
    broken_ = false;
  }

 private:
  std::string buffer_;
  bool broken_ = false;
};

enum class Function : std::uint8_t {
  kReadCoils = 1,
  kReadDiscreteInputs = 2,
  kReadHoldingRegisters = 3,
  kReadInputRegisters = 4,
  kWriteCoil = 5,
  kWriteRegister = 6,
  kWriteCoils = 15,
  kWriteRegisters = 16
};

/// What a server answers in place of data.
enum class Exception : std::uint8_t {
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kServerFailure = 4,
  kBusy = 6
};
/// For people: "illegal address". Realtime: any thread.
[[nodiscard]] std::string_view name_of(Exception exception);

/// A request: reads and writes of tables. `values` has a word for each coil (0 or 1) or register that is written.
struct Request {
  Function function = Function::kReadCoils;
  std::uint16_t address = 0, count = 0;
  std::vector<std::uint16_t> values = {};

  [[nodiscard]] bool of_bits() const {
    return function == Function::kReadCoils || function == Function::kReadDiscreteInputs ||
           function == Function::kWriteCoil || function == Function::kWriteCoils;
  }
  [[nodiscard]] bool writes() const {
    return function == Function::kWriteCoil || function == Function::kWriteRegister ||
           function == Function::kWriteCoils || function == Function::kWriteRegisters;
  }
};
/// How many values a request of this function may have.
[[nodiscard]] std::uint16_t most_values(Function function);
[[nodiscard]] std::string encode(const Request& request);
/// @return the request, or what a server answers to it. Realtime: setup.
[[nodiscard]] std::expected<Request, Exception> parse_request(std::string_view pdu);

/// The answer to a request. @param values  as of Request; of a read
[[nodiscard]] std::string encode_answer(const Request& request, std::span<const std::uint16_t> values);
[[nodiscard]] std::string encode_exception(std::uint8_t function, Exception exception);

/// Why an answer has no values.
struct Refusal {
  std::optional<Exception> exception;  ///< nothing: it is no answer to that request
};
/// @param[out] values  of a read, as many as asked for; those of a write stay
[[nodiscard]] std::expected<void, Refusal> parse_answer(const Request& request, std::string_view pdu,
                                                        std::span<std::uint16_t> values);

}  // namespace takt::hw::modbus
