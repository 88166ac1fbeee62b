#include "sim/contact/islands.h"

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

/// Below, dense matrices are faster (`carry`, 28 axes: 8 % of a run; the factory, 80: 4 % slower). An arm has 7 axes, a
/// free part 6.
constexpr int kSparseFrom = 45;

}  // namespace

void choose_matrices(mjModel& model) {
  const bool by_island = (model.opt.disableflags & mjDSBL_ISLAND) == 0;
  model.opt.jacobian = by_island && model.nv >= kSparseFrom ? mjJAC_SPARSE : mjJAC_DENSE;
}

void copy_rows_to_islands(const mjModel&, mjData& data) {
  if (data.nisland == 0) return;
  for (int i = 0; i < data.nefc; ++i) {
    const int row = data.map_iefc2efc[i];
    data.iefc_D[i] = data.efc_D[row];
    data.iefc_R[i] = data.efc_R[row];
  }
}

}  // namespace takt::sim
