"""Plans random paths with toppra and compares durations with ours.

Argument: the program that exports the paths (export_random_paths). Our planner has to be, with jerk lifted, at most 5 %
longer than toppra on the same path and limits; with jerk never shorter than that, and at most 1.2 a/j per ramp longer,
where a ramp is a stretch of speeding up or slowing down of toppra's own law.
"""
import json
import subprocess
import sys

import numpy as np
import toppra as ta
import toppra.algorithm as algo
import toppra.constraint as constraint

CASES = 60  # half of them begin at rest, half take a running motion over
SEED = 5
LIFTED_AT_MOST = 1.05
RAMPS = 1.2
# What the grids of both tools leave open.
GRID = 0.02

ta.setup_logging("ERROR")


def shortest(case):
    """Duration by toppra, and its number of ramps."""
    s = np.array(case["s"])
    path = ta.SplineInterpolator(s, np.array(case["q"]))
    velocity = np.array(case["velocity"])
    acceleration = np.array(case["acceleration"])
    limits = [constraint.JointVelocityConstraint(np.stack([-velocity, velocity]).T),
              constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration]).T)]
    grid = np.unique(np.concatenate([s, np.linspace(0, 1, 401)]))
    grid = grid[np.concatenate([[True], np.diff(grid) > 1e-9])]
    grid[-1] = s[-1]
    instance = algo.TOPPRA(limits, path, gridpoints=grid, solver_wrapper="seidel")
    data = instance.compute_parameterization(case["begin_rate"], 0, return_data=True)
    rate = np.asarray(data[1] if isinstance(data, tuple) else instance.problem_data.sd_vec)
    if np.any(np.isnan(rate)):
        return None, 0
    return float(np.sum(2 * np.diff(grid) / (rate[1:] + rate[:-1]))), ramps(rate)


def ramps(rate):
    """Stretches of speeding up or slowing down that change the speed by more than a twentieth of the largest."""
    least = 0.05 * np.max(rate)
    count = 1
    rising = True
    turn = rate[0]
    for value in rate:
        if (value > turn) == rising:
            turn = value
        elif abs(value - turn) > least:
            count += 1
            rising = not rising
            turn = value
    return count


def main():
    exported = subprocess.run([sys.argv[1], str(CASES), str(SEED)], check=True, capture_output=True, text=True)
    cases = json.loads(exported.stdout)
    if len(cases) < CASES:
        sys.exit(f"only {len(cases)} paths were exported")
    failures = []
    lifted_shares, jerk_shares, relay_shares, compared = [], [], [], 0
    for number, case in enumerate(cases):
        duration, count = shortest(case)
        if duration is None:
            continue
        compared += 1
        lifted = case["lifted"] / duration
        if case["begin_rate"] > 0:
            relay_shares.append(lifted)
            print(f"{number:3d}: taken over, toppra {duration:.3f} s, jerk lifted {lifted:.3f} times")
            if not 1.0 - GRID <= lifted <= LIFTED_AT_MOST:
                failures.append(f"path {number}: {lifted:.3f} times toppra's duration, in motion, jerk lifted")
            continue
        above = (case["with_jerk"] - duration) / (count * case["longest_ramp"])
        lifted_shares.append(lifted)
        jerk_shares.append(above)
        print(f"{number:3d}: {case['motions']} motions, toppra {duration:.3f} s, jerk lifted {lifted:.3f} times, with jerk "
              f"{case['with_jerk']:.3f} s: {above:.2f} a/j for each of {count} ramps (a/j {case['longest_ramp']:.3f} s)")
        if not 1.0 - GRID <= lifted <= LIFTED_AT_MOST:
            failures.append(f"path {number}: {lifted:.3f} times toppra's duration with jerk lifted")
        if case["with_jerk"] < duration * (1.0 - GRID):
            failures.append(f"path {number}: with jerk shorter than without")
        if above > RAMPS:
            failures.append(f"path {number}: {above:.2f} a/j per ramp above the time without jerk")
    if compared < 0.9 * CASES:
        failures.append(f"toppra solved only {compared} of {len(cases)}")
    print(f"jerk lifted: mean {np.mean(lifted_shares):.4f}, largest {np.max(lifted_shares):.4f}; "
          f"with jerk: mean {np.mean(jerk_shares):.2f} a/j per ramp, largest {np.max(jerk_shares):.2f}")
    print(f"taken over, jerk lifted: mean {np.mean(relay_shares):.4f}, largest {np.max(relay_shares):.4f}")
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    main()
