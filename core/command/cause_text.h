#pragma once

#include <string>

#include "core/expression/cell.h"
#include "core/net/primitive.h"

namespace takt::command {

/// Why a net ended, for people: the text of the cause, with the words of the device in place of the number of its fault
/// ("arm: stopped by category 1: controlled stop, then brakes"). Thread: the one that steps the core. Realtime: setup.
[[nodiscard]] std::string cause_text(const net::Cause& cause, const expression::Cell& cell);

}  // namespace takt::command
