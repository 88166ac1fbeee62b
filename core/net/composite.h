#pragma once

#include <span>

#include "core/net/primitive.h"

namespace takt::net {

/// A resource that is made of others, an arm with its tool: who claims it claims all its parts, and who claims a part
/// keeps others from the whole. Parts may be composites.
class Composite : public Resource {
 public:
  /// None stands twice, none is the composite itself. Thread: any, once the core runs.
  [[nodiscard]] virtual std::span<Resource* const> parts() const = 0;
};

}  // namespace takt::net
