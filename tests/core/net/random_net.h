#pragma once

#include "core/base/random.h"
#include "core/net/description.h"

namespace takt::net {

/// A random well-typed net of the test primitives: mixed types, constants, nulls, delayed links that close loops,
/// inputs that break loops, fragments with every kind of activity, nested. Equal seeds give equal nets.
[[nodiscard]] NetDescription random_net(Random& random, int primitives);

/// The same net with primitives, links, fragments and ports declared in another order.
[[nodiscard]] NetDescription shuffled(const NetDescription& net, Random& random);

}  // namespace takt::net
