#include "sim/film/render_shapes.h"

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "tests/sim/render_fixture.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

Vector3d position(const ShapeVertex& v) { return Vector3d(v.p[0], v.p[1], v.p[2] + v.sign); }  // stretched by 1

// Volume by the divergence theorem: positive only if the triangles wind outward.
double volume(const Shape& shape) {
  double sum = 0;
  for (std::size_t i = 0; i < shape.indices.size(); i += 3) {
    const Vector3d a = position(shape.vertices[shape.indices[i]]), b = position(shape.vertices[shape.indices[i + 1]]),
                   c = position(shape.vertices[shape.indices[i + 2]]);
    sum += a.dot(b.cross(c)) / 6;
  }
  return sum;
}

// Every edge must be met once in each direction: no hole and no triangle turned around.
bool is_closed(const Shape& shape) {
  using Key = std::tuple<long, long, long>;
  const auto key = [&](std::uint32_t i) {
    const Vector3d p = position(shape.vertices[i]);
    return Key{std::lround(p.x() * 1e4), std::lround(p.y() * 1e4), std::lround(p.z() * 1e4)};
  };
  std::map<std::pair<Key, Key>, int> edges;
  for (std::size_t i = 0; i < shape.indices.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const Key a = key(shape.indices[i + k]), b = key(shape.indices[i + (k + 1) % 3]);
      edges[{a, b}] += 1;
      edges[{b, a}] -= 1;
    }
  return std::ranges::all_of(edges, [](const auto& edge) { return edge.second == 0; });
}

void expect_normals_outward(const Shape& shape) {
  for (std::size_t i = 0; i < shape.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) { return shape.vertices[shape.indices[i + k]]; };
    const Vector3d face = (position(at(1)) - position(at(0))).cross(position(at(2)) - position(at(0))).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d normal(at(k).normal[0], at(k).normal[1], at(k).normal[2]);
      EXPECT_GT(face.dot(normal.normalized()), 0.9);
    }
  }
}

class BuiltInShape : public testing::TestWithParam<std::pair<int, double>> {};

TEST_P(BuiltInShape, IsClosedAndHasTheVolumeOfItsKind) {
  const ModelPtr model = compile_scene(R"(<geom size="1"/>)");
  const ShapeLibrary library(model.get());
  const Shape* shape = library.find(GetParam().first, -1);
  ASSERT_NE(shape, nullptr);
  EXPECT_TRUE(is_closed(*shape));
  EXPECT_NEAR(volume(*shape), GetParam().second, 0.02 * GetParam().second);
  expect_normals_outward(*shape);
}

constexpr double kPi = std::numbers::pi;
INSTANTIATE_TEST_SUITE_P(All, BuiltInShape,
                         testing::Values(std::pair{int{mjGEOM_SPHERE}, 4 * kPi / 3}, std::pair{int{mjGEOM_BOX}, 8.0},
                                         std::pair{int{mjGEOM_CYLINDER}, 2 * kPi},
                                         std::pair{int{mjGEOM_CAPSULE}, 4 * kPi / 3 + 2 * kPi}));

TEST(RenderShapes, MeshesKeepTheirTrianglesAndTheBudgetCountsVisibleGeomsOnly) {
  const ModelPtr model = compile_scene(R"(
    </worldbody><asset><mesh name="rock" builtin="sphere" params="2"/></asset><worldbody>
    <geom type="mesh" mesh="rock"/><geom type="mesh" mesh="rock" group="3"/><geom type="box" size="1 1 1"/>)");
  const ShapeLibrary library(model.get());
  const Shape* rock = library.find(mjGEOM_MESH, 0);
  ASSERT_NE(rock, nullptr);
  EXPECT_EQ(rock->indices.size(), 3u * static_cast<std::size_t>(model->mesh_facenum[0]));
  EXPECT_TRUE(is_closed(*rock));
  EXPECT_GT(volume(*rock), 0);
  EXPECT_EQ(triangle_count(model.get()), model->mesh_facenum[0] + 12);
}

TEST(RenderShapes, HeightFieldsFaceUp) {
  const ModelPtr model = compile_scene(R"(
    </worldbody><asset><hfield name="hill" nrow="3" ncol="4" size="2 1 0.5 0.1"/></asset><worldbody>
    <geom type="hfield" hfield="hill"/>)");
  const ShapeLibrary library(model.get());
  const Shape* hill = library.find(mjGEOM_HFIELD, 0);
  ASSERT_NE(hill, nullptr);
  EXPECT_EQ(hill->indices.size(), 3u * 2 * 2 * 3);
  for (std::size_t i = 0; i < hill->indices.size(); i += 3) {
    const auto at = [&](std::size_t k) { return position(hill->vertices[hill->indices[i + k]]); };
    EXPECT_GT((at(1) - at(0)).cross(at(2) - at(0)).z(), 0);
  }
}

}  // namespace
}  // namespace takt::sim
