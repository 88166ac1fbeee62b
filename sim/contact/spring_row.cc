#include "sim/contact/spring_row.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/contact/body_force.h"

namespace takt::sim {
namespace {

constexpr double kSilentInertia = 1e-10;  // MuJoCo divides by it

/// What is stored of a row's Jacobian: all columns, or those of the joints that move its bodies.
struct StoredRow {
  std::span<double> values;
  const int* columns = nullptr;  ///< of each value; null: all
};

StoredRow stored_row(const mjModel& model, const mjData& data, int row) {
  if (!mj_isSparse(&model)) return {{data.efc_J + row * model.nv, static_cast<std::size_t>(model.nv)}};
  const int first = data.efc_J_rowadr[row];
  return {{data.efc_J + first, static_cast<std::size_t>(data.efc_J_rownnz[row])}, data.efc_J_colind + first};
}

/// @param inertia  that the step adds, kg or kg m^2
void set_force(mjData& data, int row, double inertia, double force) {
  data.efc_D[row] = inertia;
  data.efc_R[row] = 1.0 / inertia;
  data.efc_aref[row] = force / inertia;
}

}  // namespace

int row_of_equality(const mjData& data, int equality) {
  for (int row = 0; row < data.ne; ++row) {
    if (data.efc_type[row] == mjCNSTR_EQUALITY && data.efc_id[row] == equality) return row;
  }
  return -1;
}

double rate_of_row(const mjModel& model, const mjData& data, int row) {
  const auto [values, columns] = stored_row(model, data, row);
  if (columns == nullptr) return mju_dot(values.data(), data.qvel, static_cast<int>(model.nv));
  double rate = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) rate += values[i] * data.qvel[columns[i]];
  return rate;
}

void set_jacobian(const mjModel& model, mjData& data, int row, std::span<const double> jacobian) {
  const auto [values, columns] = stored_row(model, data, row);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = jacobian[columns ? static_cast<std::size_t>(columns[i]) : i];
}

void set_spring(const mjModel& model, mjData& data, int row, const RowSpring& spring, double stretch) {
  const double rate = rate_of_row(model, data, row), h = model.opt.timestep;
  const double inertia = h * (h * spring.stiffness + spring.damping), share = inertia / (inertia + spring.mass);
  data.efc_pos[row] = stretch;
  data.efc_vel[row] = rate;
  set_force(data, row, inertia, -spring.stiffness * stretch - (spring.damping + share * h * spring.stiffness) * rate);
}

void set_inertia(const mjModel& model, mjData& data, int row, double inertia) {
  data.efc_pos[row] = 0.0;
  data.efc_vel[row] = rate_of_row(model, data, row);
  set_force(data, row, inertia, 0.0);
}

void silence_rows(const mjModel& model, mjData& data, int first, int count) {
  for (int row = first; row < first + count; ++row) {
    std::ranges::fill(stored_row(model, data, row).values, 0.0);
    data.efc_pos[row] = data.efc_vel[row] = 0.0;
    set_force(data, row, kSilentInertia, 0.0);
  }
}

void take_weld(mjData& data, int row, int first, int second, const RowWrench& wrench) {
  std::fill_n(data.efc_force + row, 6, 0.0);
  for (const auto& [body, sign] : {std::pair(first, 1.0), std::pair(second, -1.0)}) {
    add_force(data, body, sign * wrench.force, wrench.point);
    add_wrench(data, body, Eigen::Vector3d::Zero(), sign * wrench.torque);
  }
}

}  // namespace takt::sim
