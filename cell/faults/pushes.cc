#include "cell/faults/pushes.h"

#include <algorithm>

namespace takt::cell {

void Pushes::add(const void* owner, int body, const Eigen::Vector3d& force) {
  pushes_.push_back({.owner = owner, .body = body, .force = force});
  exert(body);
}

void Pushes::remove(const void* owner) {
  const auto push = std::ranges::find(pushes_, owner, &Push::owner);
  if (push == pushes_.end()) return;
  const int body = push->body;
  pushes_.erase(push);
  exert(body);
}

/// The sum anew: nothing is left of a force that has been taken away.
void Pushes::exert(int body) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const Push& one : pushes_)
    if (one.body == body) force += one.force;
  built_.world->push(body, force);
}

}  // namespace takt::cell
