#include "scenario/shape_kind.h"

namespace takt::scenario {

/// All shapes of takt: NAME is defined by NAME_shape() (scenario/README.md).
// clang-format off
#define TAKT_SHAPES(add) \
  add(box) \
  add(capsule) \
  add(container) \
  add(cylinder) \
  add(sphere) \
  add(tube)
// clang-format on

#define TAKT_DECLARE_SHAPE(name) ShapeKind name##_shape();
TAKT_SHAPES(TAKT_DECLARE_SHAPE)

table::Kinds<std::vector<world::Object::Part>>& shape_kinds() {
  static auto kinds = [] {
    table::Kinds<std::vector<world::Object::Part>> all("shape");
#define TAKT_ADD_SHAPE(name) all.add(name##_shape());
    TAKT_SHAPES(TAKT_ADD_SHAPE)
#undef TAKT_ADD_SHAPE
    return all;
  }();
  return kinds;
}

}  // namespace takt::scenario
