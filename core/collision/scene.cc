#include "core/collision/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/base/random.h"
#include "core/collision/always_apart.h"
#include "core/collision/body_pair.h"
#include "core/collision/drilled.h"
#include "core/collision/narrow_phase.h"

namespace takt::collision {
namespace {

/// Free joints turn without end; for samples of their range one turn will do.
constexpr double kTurn = 3.14159265358979323846;

void enclose(Body& body) {
  body.box.setEmpty();
  for (const Part& part : body.parts) {
    const Eigen::AlignedBox3d& box = part.solid.box();
    for (int corner = 0; corner < 8; ++corner)
      body.box.extend(part.X_BS * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  body.radius = 0.0;
  if (body.parts.empty()) return;
  const Eigen::Vector3d middle = body.box.center();
  for (const Part& part : body.parts)
    body.radius = std::max(body.radius, (part.X_BS * part.solid.centre() - middle).norm() + part.solid.radius());
}

}  // namespace

void Scene::add_body(Body body, const Fixing& fixing) {
  enclose(body);
  bodies_.push_back(std::move(body));
  start_.fixings.push_back(fixing);
  never_.clear();
  apart_.clear();
}

Diagnostics Scene::add_robot(const std::string& name, const kinematics::RobotModel& model, int parent,
                             const Eigen::Isometry3d& X_P, std::span<const double> q) {
  Diagnostics diagnostics;
  std::map<std::string, int> numbers;
  std::size_t movable = 0;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const kinematics::Link& link = model.links[i];
    Body body{.name = name + "/" + link.name, .owner = name, .parts = {}, .box = {}};
    for (const kinematics::Geometry& geometry : link.collisions) {
      auto solid = convex_of(geometry.shape);
      if (solid) {
        body.parts.push_back({std::move(*solid), geometry.X_LG});
      } else {
        diagnostics.append(solid.error());
      }
    }
    numbers[link.name] = static_cast<int>(bodies_.size());
    Fixing fixing;
    if (i == 0) {
      body.root = true;
      fixing = {parent, X_P};
    } else {
      const kinematics::Joint& joint = model.joints[i - 1];
      body.parent = numbers[joint.parent];
      body.X_PJ = joint.X_PJ;
      body.axis = joint.axis;
      body.prismatic = joint.type == kinematics::JointType::kPrismatic;
      if (joint.type != kinematics::JointType::kFixed) {
        body.joint = static_cast<int>(joints_.size());
        joints_.push_back(name + "/" + joint.name);
        lower_.push_back(std::isfinite(joint.lower) ? joint.lower : -kTurn);
        upper_.push_back(std::isfinite(joint.upper) ? joint.upper : kTurn);
        start_.q.push_back(movable < q.size() ? q[movable] : 0.0);
        ++movable;
      }
    }
    add_body(std::move(body), fixing);
  }
  return diagnostics;
}

void Scene::add_object(const std::string& name, const std::vector<world::Object::Part>& parts, int parent,
                       const Eigen::Isometry3d& X_P) {
  Body body{.name = name, .owner = name, .parts = {}, .root = true, .box = {}};
  for (const world::Object::Part& part : parts)
    for (Part& solid : solids_of(part)) body.parts.push_back(std::move(solid));
  add_body(std::move(body), {parent, X_P});
}

int Scene::find(std::string_view name) const {
  const auto found = std::ranges::find(bodies_, name, &Body::name);
  return found == bodies_.end() ? -1 : static_cast<int>(found - bodies_.begin());
}

int Scene::root_of(std::string_view owner) const {
  const auto found = std::ranges::find_if(bodies_, [&](const Body& body) { return body.root && body.owner == owner; });
  return found == bodies_.end() ? -1 : static_cast<int>(found - bodies_.begin());
}

int Scene::find_joint(std::string_view name) const {
  const auto found = std::ranges::find(joints_, name);
  return found == joints_.end() ? -1 : static_cast<int>(found - joints_.begin());
}

std::vector<int> Scene::parents_first(const State& state) const {
  std::vector<int> order;
  std::vector<bool> placed(bodies_.size(), false);
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const int parent = bodies_[i].root ? state.fixings[i].parent : bodies_[i].parent;
      if (placed[i] || (parent >= 0 && !placed[static_cast<std::size_t>(parent)])) continue;
      order.push_back(static_cast<int>(i));
      placed[i] = progress = true;
    }
  }
  return order;
}

void Scene::place_some(const State& state, std::span<const int> order, Poses& poses) const {
  for (const int number : order) {
    const auto i = static_cast<std::size_t>(number);
    const Body& body = bodies_[i];
    const int parent = body.root ? state.fixings[i].parent : body.parent;
    Eigen::Isometry3d X = body.root ? state.fixings[i].X_P : body.X_PJ;
    if (body.joint >= 0) {
      const double q = state.q[static_cast<std::size_t>(body.joint)];
      if (body.prismatic) {
        X.translation() += X.linear() * (q * body.axis);
      } else {
        X.linear() = X.linear() * Eigen::AngleAxisd(q, body.axis).toRotationMatrix();
      }
    }
    poses[i] = parent < 0 ? X : poses[static_cast<std::size_t>(parent)] * X;
  }
}

void Scene::place(const State& state, Poses& poses) const {
  poses.resize(bodies_.size());
  place_some(state, parents_first(state), poses);
}

std::vector<bool> Scene::moved_by(const State& state, std::span<const int> joints) const {
  std::vector<bool> moved(bodies_.size(), false);
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (moved[i]) continue;
      const int parent = bodies_[i].root ? state.fixings[i].parent : bodies_[i].parent;
      const bool own = bodies_[i].joint >= 0 && std::ranges::find(joints, bodies_[i].joint) != joints.end();
      if (!own && (parent < 0 || !moved[static_cast<std::size_t>(parent)])) continue;
      moved[i] = progress = true;
    }
  }
  return moved;
}

void Scene::never(int a, int b) {
  const std::size_t n = bodies_.size();
  never_[static_cast<std::size_t>(a) * n + static_cast<std::size_t>(b)] = true;
  never_[static_cast<std::size_t>(b) * n + static_cast<std::size_t>(a)] = true;
}

bool Scene::always_in_contact(int a, int b) const {
  constexpr int kPostures = 64;
  Random random(1, "never meet");
  State state = start_;
  Poses poses;
  for (int i = 0; i < kPostures; ++i) {
    for (std::size_t j = 0; j < state.q.size(); ++j) state.q[j] = lower_[j] + random.unit() * (upper_[j] - lower_[j]);
    place(state, poses);
    if (distance(*this, poses, a, b) > 0.0) return false;
  }
  return true;
}

int Scene::assembly_of(int body) const {
  for (;;) {
    const auto i = static_cast<std::size_t>(body);
    const int parent = bodies_[i].root ? start_.fixings[i].parent : bodies_[i].parent;
    if (parent < 0) return body;
    body = parent;
  }
}

void Scene::accept_as_built(const State& state, double near) {
  Poses poses;
  place(state, poses);
  const int n = static_cast<int>(bodies_.size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (never_meet(a, b) || assembly_of(a) != assembly_of(b) || quick_bound(*this, poses, a, b) > near) continue;
      if (distance(*this, poses, a, b) <= near) never(a, b);
    }
  }
}

void Scene::find_pairs_that_never_meet() {
  const int n = static_cast<int>(bodies_.size());
  never_.assign(bodies_.size() * bodies_.size(), false);
  // The movable joints between a body and the first body of what it is mounted on, nearest last.
  const auto up = [&](int i) {
    const Body& body = bodies_[static_cast<std::size_t>(i)];
    return body.root ? start_.fixings[static_cast<std::size_t>(i)].parent : body.parent;
  };
  // Bodies joined rigidly are one: its first body stands for it.
  std::vector<int> rigid(bodies_.size());
  for (int i = 0; i < n; ++i) {
    int first = i;
    while (up(first) >= 0 && bodies_[static_cast<std::size_t>(first)].joint < 0) first = up(first);
    rigid[static_cast<std::size_t>(i)] = first;
  }
  const auto group = [&](int i) { return rigid[static_cast<std::size_t>(i)]; };
  for (int a = 0; a < n; ++a) {
    never(a, a);
    for (int b = a + 1; b < n; ++b) {
      if (bodies_[static_cast<std::size_t>(a)].parts.empty() || bodies_[static_cast<std::size_t>(b)].parts.empty()) {
        never(a, b);
        continue;
      }
      if (assembly_of(a) != assembly_of(b)) continue;
      const bool adjacent = group(a) == group(b) || (up(group(a)) >= 0 && group(up(group(a))) == group(b)) ||
                            (up(group(b)) >= 0 && group(up(group(b))) == group(a));
      if (adjacent || always_in_contact(a, b)) never(a, b);
    }
  }
  find_proven_apart();
}

void Scene::find_proven_apart() {
  const int n = static_cast<int>(bodies_.size());
  apart_.assign(bodies_.size() * bodies_.size(), false);
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (never_meet(a, b) || body(a).owner != body(b).owner) continue;
      if (!always_apart(*this, a, b, lower_, upper_, kProvenApart)) continue;
      for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)})
        apart_[static_cast<std::size_t>(one) * bodies_.size() + static_cast<std::size_t>(other)] = true;
    }
  }
}

double distance(const Scene& scene, const Poses& poses, int a, int b) {
  BodyPair pair(scene, a, b);
  return pair.distance(poses, std::numeric_limits<double>::infinity());
}

double signed_distance(const Scene& scene, const Poses& poses, int a, int b) {
  BodyPair pair(scene, a, b);
  return pair.signed_distance(poses);
}

}  // namespace takt::collision
