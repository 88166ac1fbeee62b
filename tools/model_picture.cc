#include "tools/model_picture.h"

#include <charconv>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/film/renderer.h"
#include "sim/model/from_model.h"
#include "sim/world/stage.h"
#include "sim/world/world.h"

namespace takt::tools {
namespace {

/// From the right, a little from the front and above: an arm that reaches ahead shows its profile. A long lens keeps
/// the proportions.
constexpr double kAzimuth = 122;
constexpr double kElevation = -14;
constexpr float kLensDeg = 22;
constexpr double kMargin = 1.1;

Result<void> read_size(PictureOptions& options) {
  if (options.size.empty()) return {};
  const auto cross = options.size.find('x');
  const char* begin = options.size.data();
  const char* end = begin + options.size.size();
  if (cross != std::string::npos) {
    const auto width = std::from_chars(begin, begin + cross, options.width);
    const auto height = std::from_chars(begin + cross + 1, end, options.height);
    if (width.ec == std::errc{} && width.ptr == begin + cross && height.ec == std::errc{} && height.ptr == end)
      return {};
  }
  return failure(Code::kInvalidValue, "--size", fmt::format("'{}' is not a size", options.size),
                 "Write WIDTHxHEIGHT in pixels, 16 to 4096 each");
}

/// Home of an arm; of anything else the middle of each joint's range.
std::vector<double> posture(const kinematics::RobotModel& robot) {
  std::vector<double> q;
  for (const kinematics::Joint& joint : robot.joints) {
    if (joint.type == kinematics::JointType::kFixed) continue;
    const double middle = 0.5 * (joint.lower + joint.upper);
    q.push_back(std::isfinite(middle) ? middle : 0.0);
  }
  return q;
}

using Points = std::vector<Eigen::Vector3d>;

void add_geom(const mjModel* model, const mjData* data, int geom, Points& points) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->geom_xmat + 9 * geom);
  const Eigen::Map<const Eigen::Vector3d> p(data->geom_xpos + 3 * geom);
  if (model->geom_type[geom] == mjGEOM_MESH) {
    const int mesh = model->geom_dataid[geom];
    const float* vertex = model->mesh_vert + 3 * model->mesh_vertadr[mesh];
    for (int k = 0; k < model->mesh_vertnum[mesh]; ++k) {
      points.emplace_back(p + R * Eigen::Map<const Eigen::Vector3f>(vertex + 3 * k).cast<double>());
    }
    return;
  }
  const double* aabb = model->geom_aabb + 6 * geom;  // centre, half edges
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d at;
    for (int k = 0; k < 3; ++k) at[k] = aabb[k] + ((corner >> k & 1) != 0 ? aabb[3 + k] : -aabb[3 + k]);
    points.emplace_back(p + R * at);
  }
}

/// What is drawn of the model's bodies, in W: corners of meshes and of the boxes around other shapes.
Points points_of(const mjModel* model, const mjData* data) {
  Points points;
  for (int geom = 0; geom < static_cast<int>(model->ngeom); ++geom) {
    const bool floor = model->geom_bodyid[geom] == 0;
    if (!floor && model->geom_rgba[4 * geom + 3] > 0.0f && model->geom_group[geom] < 3) {
      add_geom(model, data, geom, points);
    }
  }
  return points;
}

/// The nearest camera whose picture holds all points, in its middle: |r - a| <= tan (D + f) for each point with the
/// coordinates r across and f along the view gives the shift a and the distance D.
sim::FreeCamera camera_for(const Points& points, double fovy_deg, double aspect) {
  sim::FreeCamera camera;
  camera.azimuth = kAzimuth;
  camera.elevation = kElevation;
  const double a = kAzimuth * EIGEN_PI / 180, e = kElevation * EIGEN_PI / 180;
  const Eigen::Vector3d forward(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const double tangent = std::tan(0.5 * fovy_deg * EIGEN_PI / 180) / kMargin;
  Eigen::Vector3d look_at = Eigen::Vector3d::Zero();
  camera.distance = 0.0;
  for (const auto& [axis, tan] : {std::pair{right, tangent * aspect}, std::pair{up, tangent}}) {
    double plus = -INFINITY, minus = -INFINITY;
    for (const Eigen::Vector3d& p : points) {
      plus = std::max(plus, p.dot(axis) / tan - p.dot(forward));
      minus = std::max(minus, -p.dot(axis) / tan - p.dot(forward));
    }
    look_at += axis * (0.5 * tan * (plus - minus));
    camera.distance = std::max(camera.distance, 0.5 * (plus + minus));
  }
  // The point that is looked at stands in the middle of the model, so that near and far are cut where they should be.
  double middle = 0.0;
  for (const Eigen::Vector3d& p : points) middle += p.dot(forward) / static_cast<double>(points.size());
  look_at += middle * forward;
  camera.distance += middle;
  std::copy_n(look_at.data(), 3, camera.look_at.begin());
  return camera;
}

Result<sim::World> build(const kinematics::RobotModel& robot, const device::ArmDescription* arm,
                         const PictureOptions& options, const sim::StageOptions& stage) {
  sim::WorldDescription description;
  const std::string name = "model";
  if (arm != nullptr) {
    description.robots.push_back(sim::arm_body(name, *arm, {}));
  } else {
    description.robots.push_back(sim::plain_body(name, std::make_shared<kinematics::RobotModel>(robot), {}));
    description.robots.back().q = posture(robot);
  }
  std::vector<double>& q = description.robots.back().q;
  if (!options.q.empty() && options.q.size() != q.size()) {
    return failure(Code::kWrongSize, "--posture",
                   fmt::format("{} numbers for {} movable joints", options.q.size(), q.size()));
  }
  if (!options.q.empty()) q = options.q;
  return sim::World::create(description, [&](mjSpec_& spec) {
    sim::add_scene_props(&spec, stage);
    spec.visual.global.fovy = kLensDeg;
  });
}

/// A copy of the state that may be posed.
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Data posed(const sim::World& world) {
  Data data(mj_copyData(nullptr, world.model(), world.data()), mj_deleteData);
  sim::pose_for_drawing(world.model(), data.get());
  return data;
}

/// The stage fits the model: its lights and shadows are made for a radius.
Result<sim::World> build_on_stage(const kinematics::RobotModel& robot, const device::ArmDescription* arm,
                                  const PictureOptions& options, Points& points) {
  sim::StageOptions stage;
  stage.floor_collides = false;
  auto world = build(robot, arm, options, stage);
  if (!world) return world;
  points = points_of(world->model(), posed(*world).get());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  if (points.empty())
    return failure(Code::kMissing, "", "the model has nothing to draw", "Add a visual or a collision shape");
  stage.radius = 0.8 * box.diagonal().norm();
  stage.floor_height = std::min(0.0, box.min().z());
  const Eigen::Vector3d centre = box.center();
  std::copy_n(centre.data(), 3, stage.centre.begin());
  return build(robot, arm, options, stage);
}

}  // namespace

Diagnostics check_build(const kinematics::RobotModel& robot, const device::ArmDescription* arm) {
  const auto world = build(robot, arm, {}, {});
  return world ? Diagnostics{} : world.error();
}

Result<void> draw_model(const kinematics::RobotModel& robot, const device::ArmDescription* arm, PictureOptions& options,
                        const std::filesystem::path& file) {
  if (auto size = read_size(options); !size) return size;
  if (file.extension() != ".png")
    return failure(Code::kInvalidValue, "--image", fmt::format("'{}' is not a .png file", file.string()),
                   "Name a file OUT.png");
  Points points;
  const auto world = build_on_stage(robot, arm, options, points);
  if (!world) return std::unexpected(world.error());
  const sim::RenderOptions render{.width = options.width, .height = options.height, .shadow_size = 2048};
  auto renderer = sim::Renderer::create(world->model(), render);
  if (!renderer) return std::unexpected(renderer.error());
  const Data data = posed(*world);
  if (auto set = renderer->set_state(data.get()); !set) return set;
  const auto camera =
      camera_for(points, world->model()->vis.global.fovy, static_cast<double>(options.width) / options.height);
  sim::Image image;
  if (auto drawn = renderer->draw(camera, options.width, options.height, image); !drawn) return drawn;
  return sim::write_png(image, file);
}

}  // namespace takt::tools
