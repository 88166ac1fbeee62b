#include "sim/contact/rest.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

constexpr double kStillSpeed = 1e-6;  // m/s, of any point of it
constexpr double kStillTime = 0.1;    // s
/// MuJoCo's number for a tree that has just moved.
constexpr int kAwake = -(1 + mjMINAWAKE);
/// No velocity is below it: MuJoCo puts nothing to sleep by itself.
constexpr double kNever = -1.0;

/// What MuJoCo derives from the state of the trees.
void list_awake(const mjModel& model, mjData& data) {
  data.ntree_awake = data.nbody_awake = data.nparent_awake = data.nv_awake = 0;
  for (int tree = 0; tree < static_cast<int>(model.ntree); ++tree) {
    data.tree_awake[tree] = data.tree_asleep[tree] < 0 ? 1 : 0;
    data.ntree_awake += data.tree_awake[tree];
  }
  for (int body = 0; body < static_cast<int>(model.nbody); ++body) {
    const int tree = model.body_treeid[body];
    data.body_awake[body] = tree < 0 ? mjS_STATIC : data.tree_awake[tree] ? mjS_AWAKE : mjS_ASLEEP;
    if (data.body_awake[body] != mjS_ASLEEP) data.body_awake_ind[data.nbody_awake++] = body;
    if (body > 0 && data.body_awake[model.body_parentid[body]] != mjS_ASLEEP)
      data.parent_awake_ind[data.nparent_awake++] = body;
  }
  for (int dof = 0; dof < static_cast<int>(model.nv); ++dof) {
    if (data.body_awake[model.dof_bodyid[dof]] == mjS_AWAKE) data.dof_awake_ind[data.nv_awake++] = dof;
  }
}

bool is_zero(const double* values, int count) {
  return std::all_of(values, values + count, [](double value) { return value == 0.0; });
}

/// The two bodies that an equality joins; -1: none.
std::pair<int, int> bodies_of_equality(const mjModel& model, int equality) {
  const int first = model.eq_obj1id[equality], second = model.eq_obj2id[equality];
  if (model.eq_type[equality] == mjEQ_JOINT)
    return {model.jnt_bodyid[first], second < 0 ? -1 : model.jnt_bodyid[second]};
  return model.eq_objtype[equality] == mjOBJ_BODY ? std::pair(first, second) : std::pair(-1, -1);
}

/// What moves a base, if nothing else moves with it that is driven; -1: no such tree.
int tree_of_base(const mjModel& model, const SimArmDescription& base) {
  const std::string prefix = base.robot + "/";
  const auto is_own = [&](int joint) {
    const char* name = mj_id2name(&model, mjOBJ_JOINT, joint);
    return name != nullptr && std::string_view(name).starts_with(prefix);
  };
  int tree = -1;
  for (int joint = 0; joint < static_cast<int>(model.njnt); ++joint)
    if (is_own(joint)) tree = model.body_treeid[model.jnt_bodyid[joint]];
  for (int joint = 0; joint < static_cast<int>(model.njnt); ++joint)
    if (model.body_treeid[model.jnt_bodyid[joint]] == tree && !is_own(joint)) return -1;
  return tree;
}

}  // namespace

Rest::Rest(mjModel& model, const WorldDescription& description) {
  const bool by_island = (model.opt.disableflags & mjDSBL_ISLAND) == 0;
  if (!by_island || !description.physics.rest || model.opt.integrator == mjINT_RK4) return;
  const auto trees = static_cast<std::size_t>(model.ntree);
  may_sleep_.assign(trees, 0);
  for (const ObjectDescription& object : description.objects) {
    const int body = object.free ? mj_name2id(&model, mjOBJ_BODY, object.name.c_str()) : -1;
    if (body < 0) continue;
    const int tree = model.body_treeid[body];
    if (model.tree_dofnum[tree] == 6) may_sleep_[static_cast<std::size_t>(tree)] = 1;
  }
  if (std::ranges::count(may_sleep_, 1) == 0) return;
  for (const SimArmDescription& arm : description.arms) {
    const int tree = arm.drive ? tree_of_base(model, arm) : -1;
    if (tree >= 0) may_sleep_[static_cast<std::size_t>(tree)] = 1;
  }
  drive_.assign(trees, nullptr);
  needed_ = std::llround(kStillTime / model.opt.timestep);
  still_.assign(trees, 0);
  next_.assign(trees, -1);
  settling_.assign(trees, false);
  marked_.reserve(static_cast<std::size_t>(model.nbody));
  model.opt.enableflags |= mjENBL_SLEEP;
  model.opt.sleep_tolerance = kNever;
  for (std::size_t i = 0; i < trees; ++i) model.tree_sleep_policy[i] = may_sleep_[i] ? mjSLEEP_ALLOWED : mjSLEEP_NEVER;
}

void Rest::add_driven(const mjModel& model, int root, const SimDevice& device) {
  if (needed_ > 0) drive_[static_cast<std::size_t>(model.body_treeid[root])] = &device;
}

bool Rest::still(const mjModel& model, const mjData& data, int tree) const {
  const int dof = model.tree_dofadr[tree], count = model.tree_dofnum[tree];
  for (int i = dof; i < dof + count; ++i) {
    if (!(std::abs(data.qvel[i]) * model.dof_length[i] < kStillSpeed)) return false;
  }
  const int body = model.tree_bodyadr[tree], bodies = model.tree_bodynum[tree];
  const SimDevice* drive = drive_[static_cast<std::size_t>(tree)];
  if (drive != nullptr) return drive->stands() && is_zero(data.xfrc_applied + 6 * body, 6 * bodies);
  return is_zero(data.qfrc_applied + dof, count) && is_zero(data.xfrc_applied + 6 * body, 6 * bodies);
}

void Rest::count(const mjModel& model, const mjData& data) {
  for (std::size_t i = 0; i < still_.size(); ++i) {
    if (may_sleep_[i] == 0) continue;
    const int tree = static_cast<int>(i);
    if (data.tree_asleep[tree] >= 0) continue;
    if (next_[i] >= 0) still_[i] = 0;  // it has been woken
    next_[i] = -1;
    still_[i] = still(model, data, tree) ? std::min(still_[i] + 1, needed_) : 0;
  }
}

/// No velocity and no force, also none of the zeros with a sign that MuJoCo takes for one.
void Rest::stop(const mjModel& model, mjData& data, int tree) {
  for (double* values : {data.qvel, data.qfrc_applied})
    std::fill_n(values + model.tree_dofadr[tree], model.tree_dofnum[tree], 0.0);
  std::fill_n(data.xfrc_applied + 6 * model.tree_bodyadr[tree], 6 * model.tree_bodynum[tree], 0.0);
}

bool Rest::settle(const mjModel& model, mjData& data) {
  if (needed_ == 0) return false;
  count(model, data);
  bool some = false;
  for (int island = 0; island < data.nisland; ++island) {
    const std::span trees(data.map_itree2tree + data.island_itreeadr[island],
                          static_cast<std::size_t>(data.island_ntree[island]));
    const auto settled = [&](int tree) {
      const auto i = static_cast<std::size_t>(tree);
      return may_sleep_[i] != 0 && still_[i] >= needed_;
    };
    if (!std::ranges::all_of(trees, settled)) continue;
    if (!some) settling_.assign(settling_.size(), false);
    some = true;
    for (std::size_t i = 0; i < trees.size(); ++i) {
      const auto tree = static_cast<std::size_t>(trees[i]);
      settling_[tree] = true;
      next_[tree] = trees[(i + 1) % trees.size()];
      stop(model, data, trees[i]);
    }
  }
  return some;
}

void Rest::fall_asleep(const mjModel& model, mjData& data) {
  if (needed_ == 0) return;
  for (int tree = 0; tree < static_cast<int>(model.ntree); ++tree) {
    const auto i = static_cast<std::size_t>(tree);
    if (next_[i] < 0) continue;
    data.tree_asleep[tree] = static_cast<int>(next_[i]);
    // The solver starts from the better of two accelerations of all bodies: what sleeps has none.
    for (double* values : {data.qacc, data.qacc_warmstart, data.qacc_smooth, data.qfrc_smooth})
      std::fill_n(values + model.tree_dofadr[tree], model.tree_dofnum[tree], 0.0);
  }
  list_awake(model, data);
}

/// MuJoCo wakes what a force is applied to, be it a zero with another sign.
bool Rest::mark(const mjModel& model, mjData& data, int body) {
  const int tree = body < 0 ? -1 : model.body_treeid[body];
  if (tree < 0 || data.tree_awake[tree]) return false;
  const int first = model.tree_bodyadr[tree];
  double& force = data.xfrc_applied[6 * first];
  if (force == 0.0) {
    force = -0.0;
    marked_.push_back(first);
  }
  return true;
}

bool Rest::wake_touched(const mjModel& model, mjData& data) {
  if (needed_ == 0 || data.ntree_awake == static_cast<int>(model.ntree)) return false;
  bool some = false;
  const auto meet = [&](int first, int second) {
    const auto moves = [&](int body) { return body >= 0 && data.body_awake[body] == mjS_AWAKE; };
    if (moves(first)) some = mark(model, data, second) || some;
    if (moves(second)) some = mark(model, data, first) || some;
  };
  for (const mjContact& contact : std::span(data.contact, static_cast<std::size_t>(data.ncon))) {
    if (contact.geom[0] >= 0 && contact.geom[1] >= 0)
      meet(model.geom_bodyid[contact.geom[0]], model.geom_bodyid[contact.geom[1]]);
  }
  for (int equality = 0; equality < static_cast<int>(model.neq); ++equality) {
    if (!data.eq_active[equality]) continue;
    const auto [first, second] = bodies_of_equality(model, equality);
    meet(first, second);
  }
  return some;
}

bool Rest::pushed(const mjModel& model, const mjData& data) const {
  if (needed_ == 0 || data.ntree_awake == static_cast<int>(model.ntree)) return false;
  for (int tree = 0; tree < static_cast<int>(model.ntree); ++tree) {
    if (data.tree_awake[tree]) continue;
    if (!is_zero(data.xfrc_applied + 6 * model.tree_bodyadr[tree], 6 * model.tree_bodynum[tree])) return true;
    if (!is_zero(data.qfrc_applied + model.tree_dofadr[tree], model.tree_dofnum[tree])) return true;
  }
  return false;
}

void Rest::woken(mjData& data) {
  for (const int body : marked_) data.xfrc_applied[6 * body] = 0.0;
  marked_.clear();
}

bool Rest::both_rest(const mjModel& model, const mjData& data, int body1, int body2) {
  const auto rests = [&](int body) { return data.body_awake[body] != mjS_AWAKE; };
  return rests(body1) && rests(body2) && (model.body_treeid[body1] >= 0 || model.body_treeid[body2] >= 0);
}

bool Rest::both_settle(const mjModel& model, int body1, int body2) const {
  const int first = model.body_treeid[body1], second = model.body_treeid[body2];
  const auto settles = [&](int tree) { return tree < 0 || settling_[static_cast<std::size_t>(tree)]; };
  return settles(first) && settles(second) && (first >= 0 || second >= 0);
}

void Rest::stream(StateStream& state, mjData& data) {
  if (needed_ == 0) return;
  for (std::size_t i = 0; i < next_.size(); ++i) {
    if (may_sleep_[i] == 0) continue;
    // What was woken in this step still has its old number here.
    if (data.tree_asleep[i] < 0 && next_[i] >= 0) {
      next_[i] = -1;
      still_[i] = 0;
    }
    state(still_[i]);
    state(next_[i]);
  }
}

void Rest::wake_all(const mjModel& model, mjData& data) {
  if (needed_ == 0) return;
  std::fill_n(data.tree_asleep, model.ntree, kAwake);
  list_awake(model, data);
}

}  // namespace takt::sim
