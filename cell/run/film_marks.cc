#include "cell/run/film_marks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <mujoco/mujoco.h>

#include "core/expression/tool_settings.h"

namespace takt::cell {
namespace {

using sim::Mark;

constexpr double kStep = 2e-3;           ///< m, between two points of a trace
constexpr float kTraceRadius = 2.2e-3F;  ///< m, of its newest point
constexpr float kBeamRadius = 1.5e-3F;   ///< m
constexpr double kAxisLength = 0.08;     ///< m, of a frame
// A force F has an arrow of kLongest * F / (F + kHalf): 5 N can be seen, 500 N stay in the picture.
constexpr double kLongest = 0.3, kHalf = 50.0;         ///< m, N
constexpr double kApartAngle = 0.0175, kApart = 0.01;  ///< rad, m

// Told apart by colour-blind eyes, too (Okabe and Ito's palette).
constexpr std::array<std::array<float, 3>, 4> kColours = {
    {{0.34F, 0.71F, 0.91F}, {0.90F, 0.60F, 0.0F}, {0.0F, 0.62F, 0.45F}, {0.94F, 0.89F, 0.26F}}};
constexpr std::array<float, 4> kForceColour = {0.84F, 0.37F, 0.0F, 1};
constexpr std::array<float, 4> kBeamColour = {1.0F, 0.12F, 0.12F, 0.6F};

std::array<float, 3> corner(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

int body_number(const mjModel& model, const std::string& name) {
  return name.empty() ? 0 : mj_name2id(&model, mjOBJ_BODY, name.c_str());
}

/// In space, so that the arrow ends where the force acts and comes from where it comes from.
Mark arrow_of(const ContactForce& contact) {
  const double force = contact.force_W.norm();
  const double length = kLongest * force / (force + kHalf);
  const Eigen::Vector3d tail = contact.point_W - length / force * contact.force_W;
  return {.shape = Mark::Shape::kArrow,
          .from = corner(tail),
          .to = corner(contact.point_W),
          .radius = 6e-3F,
          .rgba = kForceColour,
          .on_top = true};
}

CommandedPositions::Machine machine_of(const std::string& name, const device::ArmDescription& arm,
                                       const mjModel& model) {
  CommandedPositions::Machine machine{.name = name, .joints = arm.joint_names, .addresses = {}, .bodies = {}};
  for (const std::string& joint : arm.joint_names) {
    const int id = mj_name2id(&model, mjOBJ_JOINT, (name + "/" + joint).c_str());
    machine.addresses.push_back(id < 0 ? -1 : model.jnt_qposadr[id]);
  }
  for (int body = 0; body < static_cast<int>(model.nbody); ++body) {
    const char* text = mj_id2name(&model, mjOBJ_BODY, body);
    machine.bodies.push_back(text != nullptr && std::string_view(text).starts_with(name + "/"));
  }
  return machine;
}

}  // namespace

CommandedPositions::CommandedPositions(const BuiltCell& built) : built_(built) {
  for (const auto& [name, arm] : built.cell.arms)
    machines_.push_back(machine_of(name, arm.device->description(), *built.world->model()));
}

void CommandedPositions::put(const Machine& machine, std::span<const double> set_point, std::vector<double>& qpos) {
  for (std::size_t i = 0; i < std::min(set_point.size(), machine.addresses.size()); ++i)
    if (machine.addresses[i] >= 0 && std::isfinite(set_point[i]))
      qpos[static_cast<std::size_t>(machine.addresses[i])] = set_point[i];
}

std::vector<double> CommandedPositions::now(std::span<const double> qpos) const {
  std::vector<double> commanded(qpos.begin(), qpos.end());
  for (const Machine& machine : machines_) {
    const device::JointVector& q = built_.cell.arms.find(machine.name)->second.device->set_point().q;
    put(machine, {q.data(), static_cast<std::size_t>(q.size())}, commanded);
  }
  return commanded;
}

std::vector<bool> CommandedPositions::apart(std::span<const double> qpos, std::span<const double> commanded) const {
  const mjModel& model = *built_.world->model();
  std::vector<bool> bodies(static_cast<std::size_t>(model.nbody), false);
  for (const Machine& machine : machines_) {
    const bool far = std::ranges::any_of(machine.joints, [&](const std::string& joint) {
      const int id = mj_name2id(&model, mjOBJ_JOINT, (machine.name + "/" + joint).c_str());
      if (id < 0) return false;
      const auto at = static_cast<std::size_t>(model.jnt_qposadr[id]);
      return std::abs(qpos[at] - commanded[at]) > (model.jnt_type[id] == mjJNT_SLIDE ? kApart : kApartAngle);
    });
    for (std::size_t body = 0; far && body < bodies.size(); ++body)
      if (machine.bodies[body]) bodies[body] = true;
  }
  return bodies;
}

void FilmMarks::DataDeleter::operator()(mjData_* data) const { mj_deleteData(data); }

FilmMarks::FilmMarks(const BuiltCell& built, const FilmShow& show)
    : show_(show), model_(*built.world->model()), data_(mj_makeData(&model_)), commanded_(built) {
  for (const auto& [name, arm] : built.cell.arms) {
    const int body = body_number(model_, name + "/" + arm.device->description().flange_link);
    if (body > 0)
      traces_.push_back(
          {.body = body, .X_BT = default_tcp(built.cell, name), .colour = kColours[traces_.size() % kColours.size()]});
  }
  for (const auto& [name, mount] : built.frames_on)
    if (const int body = body_number(model_, mount.parent); body >= 0) frames_.push_back({body, mount.X_P});
  for (const sim::SimBeamDescription& beam : built.beams)
    if (const int body = body_number(model_, beam.body); body > 0) beams_.push_back({body, beam.range_max});
}

void FilmMarks::pose(std::span<const double> qpos) {
  std::ranges::copy(qpos, data_->qpos);
  sim::pose_for_drawing(&model_, data_.get());
}

Eigen::Isometry3d FilmMarks::body_pose(int body) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data_->xpos + 3 * body);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * body);
  return X;
}

sim::FreeCamera FilmMarks::fitting_camera(std::span<const double> qpos, double aspect) {
  pose(qpos);
  return sim::fitting_camera(&model_, data_.get(), aspect);
}

sim::Marks FilmMarks::at(const MarkedState& state) {
  pose(state.qpos);
  sim::Marks marks;
  if (show_.traces) add_traces(state.time, marks);
  if (show_.beams) add_beams(marks);
  if (show_.frames) add_frames(marks);
  if (show_.forces)
    for (const ContactForce& contact : state.contacts) marks.shapes.push_back(arrow_of(contact));
  if (!show_.commanded || state.commanded.empty()) return marks;
  marks.ghost.bodies = commanded_.apart(state.qpos, state.commanded);
  if (std::ranges::find(marks.ghost.bodies, true) != marks.ghost.bodies.end()) {
    marks.ghost.qpos = state.commanded;
  } else {
    marks.ghost.bodies.clear();
  }
  return marks;
}

/// Thinner where it is older. The last piece leads to where the point is now.
void FilmMarks::add_traces(Nanoseconds time, sim::Marks& marks) {
  const auto span = static_cast<Nanoseconds>(std::llround(1e9 * show_.trace_s));
  for (Trace& trace : traces_) {
    const Eigen::Vector3d now = (body_pose(trace.body) * trace.X_BT).translation();
    auto& points = trace.points;
    if (points.empty() || (points.back().second - now).norm() > kStep) points.emplace_back(time, now);
    while (points.size() > 1 && points.front().first < time - span) points.pop_front();
    const auto& [r, g, b] = trace.colour;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d to = i + 1 < points.size() ? points[i + 1].second : now;
      const double age =
          static_cast<double>(time - points[i].first) / static_cast<double>(std::max<Nanoseconds>(span, 1));
      const float radius = kTraceRadius * static_cast<float>(std::clamp(1.0 - 0.75 * age, 0.25, 1.0));
      marks.shapes.push_back(
          {.from = corner(points[i].second), .to = corner(to), .radius = radius, .rgba = {r, g, b, 1}});
    }
  }
}

/// To the first surface that stops light, else to the end of the range.
void FilmMarks::add_beams(sim::Marks& marks) const {
  constexpr std::array<mjtByte, mjNGROUP> kStopsLight = {1, 1, 0, 1, 0, 0};
  for (const Beam& beam : beams_) {
    const Eigen::Isometry3d X = body_pose(beam.body);
    const Eigen::Vector3d at = X.translation(), along = X.linear().col(2);
    int geom = -1;
    const double met =
        mj_ray(&model_, data_.get(), at.data(), along.data(), kStopsLight.data(), 1, beam.body, &geom, nullptr);
    const double length = met >= 0.0 ? std::min(met, beam.range) : beam.range;
    marks.shapes.push_back(
        {.from = corner(at), .to = corner(at + length * along), .radius = kBeamRadius, .rgba = kBeamColour});
  }
}

void FilmMarks::add_frames(sim::Marks& marks) const {
  const auto add = [&](const Eigen::Isometry3d& X) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::array<float, 4> colour = {0.15F, 0.15F, 0.15F, 1};
      colour[static_cast<std::size_t>(axis)] = 0.9F;
      marks.shapes.push_back({.shape = Mark::Shape::kArrow,
                              .from = corner(X.translation()),
                              .to = corner(X.translation() + kAxisLength * X.linear().col(axis)),
                              .radius = 3e-3F,
                              .rgba = colour,
                              .on_top = true});
    }
  };
  for (const Frame& frame : frames_) add(body_pose(frame.body) * frame.X_BF);
  for (const Trace& trace : traces_) add(body_pose(trace.body) * trace.X_BT);
}

}  // namespace takt::cell
