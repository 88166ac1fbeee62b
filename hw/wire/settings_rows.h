#pragma once

#include <string>

#include "core/base/form.h"
#include "core/base/time.h"

/// Rows that the settings of several drivers have (docs/sites.md). Realtime: setup.
namespace takt::hw {

/// @param in_process  what "virtual" is; @param host  what an address says
[[nodiscard]] Key address_key(const std::string& in_process, const std::string& host);
[[nodiscard]] Key emulated_key();
/// @param what  is late: "wire and core"
[[nodiscard]] Key margin_key(const std::string& what);
/// Of a virtual wire, ms.
[[nodiscard]] Key transport_key(double absent, double most, const std::string& what);
[[nodiscard]] Key jitter_key(double absent, double most);
[[nodiscard]] Key share_key(std::string name, const std::string& what);
[[nodiscard]] Key piece_key();
/// A whole number of ms. @param absent  the default; negative: the doc says it
[[nodiscard]] Key whole_ms_key(std::string name, double absent, const Range& range, std::string doc);

/// The value of a key in ms.
[[nodiscard]] Nanoseconds read_ms(FormReader& from, std::string_view key, std::optional<double> absent = {});

}  // namespace takt::hw
