#pragma once

struct mjModel_;
struct mjData_;

/// How MuJoCo solves a step. An island is what contacts and constraints join: an arm and what it holds, a box and what
/// lies in it. Each is solved by itself, which is exact, as nothing acts between islands within a step. Figures:
/// docs/benchmarks.md, "Physics of each scenario".
namespace takt::sim {

/// Dense or sparse matrices, by the number of joint axes. Realtime: setup.
void choose_matrices(mjModel_& model);

/// After rows of the constraint were set and before they are solved: MuJoCo keeps copies of what it makes of them, by
/// island. Realtime: cyclic.
void copy_rows_to_islands(const mjModel_& model, mjData_& data);

}  // namespace takt::sim
