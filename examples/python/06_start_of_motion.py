"""6. How long it takes to start an activity: the four cases that the 2013 paper measured (section 7.3, figure 11: 50 to
200 ms). Here from the call to a net that is ready to start, CPU time of the program; planning is a part of it."""
import numpy as np
import takt

RUNS = 5
Times = list[tuple[float, float]]


def show(cell: takt.Cell, name: str, times: Times) -> None:
    times = sorted(times, key=lambda one: one[1])
    planning, total = times[len(times) // 2]
    cell.print(f"{name:<18} {len(times):>2} runs  median {1e3 * total:6.2f} ms  longest {1e3 * times[-1][1]:6.2f} ms  "
               f"planning {100 * planning / total:3.0f} %")
    cell.expect(f"{name} starts sooner than the paper's 50 ms", total < 0.05, f"{1e3 * total:.2f} ms")


def program(cell: takt.Cell) -> None:
    left, right = cell.arm("left"), cell.arm("right")
    # As in the paper: by the measured joints the tool is too near to where an obstacle is known to be.
    obstacle = left.tool[:3, 3] + (0.0, 0.25, 0.0)
    too_near = left.tool_pose.position.distance(obstacle) < 0.2
    nearest = 1.0
    ptp: Times = []
    lin: Times = []
    guarded: Times = []
    together: Times = []
    for i in range(RUNS):
        goal = left.home
        goal[0] += 0.05 * (i + 1)
        ptp.append(left.ptp(goal).preparation)
        left.ptp(left.home)
        lin.append(left.lin(left.by(y=0.02 * (i + 1))).preparation)
        left.ptp(left.home)
        goal[0] = left.home[0] + 0.3
        guarded.append(left.ptp(goal, until=too_near, on_end="continue").preparation)
        nearest = min(nearest, float(np.linalg.norm(left.tool[:3, 3] - obstacle)))
        left.ptp(left.home)
    pair = cell.two_arms(left, right, np.linalg.inv(left.frame("world")) @ left.flange)
    for i in range(RUNS):
        together.append(pair.lin_by(z=0.02).execute().preparation)
        together.append(pair.lin_by(z=-0.02).execute().preparation)
    cell.expect("the guard stops before the obstacle", 0.05 < nearest < 0.2, f"{nearest:.3f} m")
    show(cell, "PTP", ptp)
    show(cell, "LIN", lin)
    show(cell, "PTP with a guard", guarded)
    show(cell, "LIN of two arms", together)


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/two_arms.json", program))
