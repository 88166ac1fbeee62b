#include "core/device/device.h"

#include "core/base/last_catch.h"
#include "core/net/format_text.h"

namespace takt::device {

void Device::keep_exception() noexcept {
  exception_ = net::format_text("{}: its driver failed: {}", name_, exception_text());
  fresh_exception_ = true;
}

}  // namespace takt::device
