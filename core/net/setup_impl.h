#pragma once

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::net {

/// What stands behind a Setup: either the info of a type that is being described, or one primitive that is being built.
/// Private to core/net.
struct Setup::Impl {
  PrimitiveInfo* describing = nullptr;  ///< set while describing

  // While building:
  const PrimitiveInfo* info = nullptr;
  const std::string* id = nullptr;
  const nlohmann::ordered_json* parameters = nullptr;  ///< a JSON object
  const nlohmann::ordered_json* on_null = nullptr;     ///< a JSON object or nullptr; checked already
  std::span<const void* const> inputs;                 ///< slot per input of `info`
  std::span<void* const> outputs;
  Environment* environment = nullptr;
  Diagnostics diagnostics;  ///< pointers relative to the primitive's parameters
  std::vector<Resource*> claims;
  std::vector<ClaimState> claim_states;
  std::size_t next_input = 0, next_output = 0;

  /// Index of the port `name`: nearly always the next one, since the same constructor declared the info.
  std::size_t port_index(const std::vector<PrimitiveInfo::Port>& ports, std::size_t& next, std::string_view name,
                         ValueType type);
  const nlohmann::ordered_json* given(std::string_view name) const;
  const nlohmann::ordered_json* declared_null(std::string_view name) const;
  void describe_parameter(std::string_view name, std::string type, const ParameterSpec& spec, std::string fallback);
};

/// Where a primitive of a broken declaration ends: message on stderr, abort.
[[noreturn]] void programming_error(const std::string& message);

}  // namespace takt::net
