#include "hw/cia402/protocol/objects.h"

namespace takt::hw::cia402 {
namespace {

/// A range of codes. The rows go from the general to the special: the last one that fits counts.
struct ErrorText {
  std::uint16_t mask, code;
  std::string_view text;
};
constexpr ErrorText kErrorTexts[] = {
    {0x0000, 0x0000, "an error of the drive"},
    {0xF000, 0x2000, "current"},
    {0xFF00, 0x2300, "over-current at the output"},
    {0xF000, 0x3000, "voltage"},
    {0xFFFF, 0x3210, "over-voltage of the DC link"},
    {0xFFFF, 0x3220, "under-voltage of the DC link"},
    {0xF000, 0x4000, "temperature"},
    {0xF000, 0x5000, "the drive's hardware"},
    {0xFFFF, 0x5441, "safe torque off"},
    {0xF000, 0x6000, "the drive's software"},
    {0xF000, 0x7000, "a module of the drive"},
    {0xFF00, 0x7300, "the position sensor"},
    {0xFF00, 0x8100, "communication"},
    {0xFFFF, 0x8130, "no heartbeat of the master"},
    {0xFF00, 0x8200, "a message of the wrong length or at the wrong time"},
    {0xFFFF, 0x8250, "set points are missing"},
    {0xFF00, 0x8400, "the velocity is beyond its limits"},
    {0xFF00, 0x8500, "the position is beyond its limits"},
    {0xFFFF, 0x8611, "following error"},
    {0xFFFF, 0x8700, "SYNC is missing"},
};

}  // namespace

std::string_view text_of_error(std::uint16_t code) {
  std::string_view text = "";
  for (const ErrorText& row : kErrorTexts)
    if ((code & row.mask) == row.code) text = row.text;
  return text;
}

}  // namespace takt::hw::cia402
