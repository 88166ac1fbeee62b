#include "cell/run/film_marks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <mujoco/mujoco.h>

#include "core/expression/tool_settings.h"
#include "sim/machines/torch.h"

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
constexpr double kBead = 0.4e-3;                          ///< m, between two beads
constexpr float kBeadRadius = 3e-3F, kArcRadius = 3e-3F;  ///< m
constexpr double kCooling = 3.0;                          ///< s, in which a bead grows dark
constexpr int kSparks = 7;
constexpr std::array<float, 4> kBeamColour = {1.0F, 0.12F, 0.12F, 0.6F};

std::array<float, 3> corner(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// As hot as it is `age` s after the arc: from yellow to steel.
std::array<float, 4> bead_colour(double age) {
  const auto heat = static_cast<float>(std::clamp(1.0 - age / kCooling, 0.0, 1.0));
  return {0.36F + 0.64F * heat, 0.35F + 0.30F * heat * heat, 0.36F - 0.21F * heat, 1.0F};
}

/// The same sparks for the same time: a number from 0 to 1.
double spark(Nanoseconds time, int number, int which) {
  auto x = static_cast<std::uint64_t>(time / kMillisecond) * 0x9E3779B97F4A7C15U +
           static_cast<std::uint64_t>(number * 8 + which) * 0xBF58476D1CE4E5B9U;
  x ^= x >> 31U;
  x *= 0x94D049BB133111EBU;
  x ^= x >> 29U;
  return static_cast<double>(x >> 11U) * 0x1.0p-53;
}

void add_arc(const Eigen::Vector3d& tip, const Eigen::Vector3d& spot, Nanoseconds time, sim::Marks& marks) {
  const auto rod = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, float radius,
                       std::array<float, 4> colour) {
    marks.shapes.push_back({.from = corner(from), .to = corner(to), .radius = radius, .rgba = colour, .on_top = true});
  };
  const Eigen::Vector3d out = (tip - spot).normalized(), side = out.unitOrthogonal();
  rod(tip, spot, 0.8e-3F, {0.75F, 0.85F, 1.0F, 1.0F});
  rod(spot, spot + 0.3 * (tip - spot), kArcRadius, {0.85F, 0.93F, 1.0F, 0.85F});
  for (int i = 0; i < kSparks; ++i) {
    const double angle = 2.0 * M_PI * spark(time, i, 0), rise = 0.2 + 0.8 * spark(time, i, 1);
    const Eigen::Vector3d across = Eigen::AngleAxisd(angle, out) * side;
    const Eigen::Vector3d way = (across + rise * out).normalized();
    const double begin = 0.004 + 0.012 * spark(time, i, 2), length = 0.006 + 0.022 * spark(time, i, 3);
    rod(spot + begin * way, spot + (begin + length) * way, 0.5e-3F, {1.0F, 0.82F, 0.35F, 0.95F});
  }
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
  for (const auto& [name, tool] : built.cell.tools) {
    const auto* torch = dynamic_cast<const sim::SimTorch*>(built.world->device(name));
    if (torch == nullptr) continue;
    torches_.push_back({.body = torch->body(), .X_BT = torch->X_LT()});
    torch_signals_.push_back(name + "/" + device::torch_terminal::kEstablished);
  }
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
  add_seams(state, marks);
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

/// A bead where the wire meets a surface, if the last one of this torch is far enough away.
void FilmMarks::add_bead(Torch& torch, Nanoseconds time, sim::Marks& marks) const {
  constexpr std::array<mjtByte, mjNGROUP> kStopsLight = {1, 1, 0, 1, 0, 0};
  const Eigen::Isometry3d X = body_pose(torch.body) * torch.X_BT;
  const Eigen::Vector3d at = X.translation(), along = X.linear().col(2);
  int geom = -1;
  const double met =
      mj_ray(&model_, data_.get(), at.data(), along.data(), kStopsLight.data(), 1, torch.body, &geom, nullptr);
  if (met < 0.0 || geom < 0) return;
  const int body = model_.geom_bodyid[geom];
  const Eigen::Vector3d spot = at + met * along, p_B = body_pose(body).inverse() * spot;
  add_arc(at, spot, time, marks);
  const bool joined = torch.burned && !torch.beads.empty() && torch.beads.back().body == body;
  if (!joined || (torch.beads.back().p_B - p_B).norm() > kBead)
    torch.beads.push_back({.body = body, .p_B = p_B, .time = time, .joined = joined});
  else
    torch.beads.back().time = time;
}

void FilmMarks::add_seams(const MarkedState& state, sim::Marks& marks) {
  for (std::size_t i = 0; i < torches_.size(); ++i) {
    Torch& torch = torches_[i];
    const bool burns = i < state.torches.size() && state.torches[i] != 0.0;
    if (burns) add_bead(torch, state.time, marks);
    torch.burned = burns;
    for (std::size_t k = 0; k < torch.beads.size(); ++k) {
      const Torch::Bead& bead = torch.beads[k];
      const Eigen::Vector3d to = body_pose(bead.body) * bead.p_B;
      const Eigen::Vector3d from = bead.joined ? Eigen::Vector3d(body_pose(bead.body) * torch.beads[k - 1].p_B)
                                               : Eigen::Vector3d(to + Eigen::Vector3d(0.0, 0.0, 1e-4));
      marks.shapes.push_back({.from = corner(from),
                              .to = corner(to),
                              .radius = kBeadRadius,
                              .rgba = bead_colour(to_seconds(state.time - bead.time))});
    }
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
