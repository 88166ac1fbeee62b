#pragma once

#include <memory>
#include <string_view>
#include <utility>

#include "core/collision/cell_shapes.h"
#include "core/net/primitive.h"

namespace takt::primitives {

/// The solids of a cell, for primitives that look at distances. Immutable; any thread.
class CellSolids final : public net::Resource {
 public:
  static constexpr std::string_view kKind = "cell_solids";

  explicit CellSolids(std::shared_ptr<const collision::CellShapes> shapes) : shapes_(std::move(shapes)) {}
  [[nodiscard]] std::string_view kind() const override { return kKind; }
  [[nodiscard]] const collision::CellShapes& shapes() const { return *shapes_; }

 private:
  std::shared_ptr<const collision::CellShapes> shapes_;
};

}  // namespace takt::primitives
