"""1. A cell is opened, an arm is taken by its name, and moves: to a side on a line, back, home."""
import numpy as np
import takt


def program(cell: takt.Cell) -> None:
    robot = cell.arm("arm")
    before = robot.tool

    robot.lin(robot.by(y=0.2), velocity_m_s=0.25)  # m, m/s, in the axes of the arm's base
    way = np.linalg.norm(robot.tool[:3, 3] - before[:3, 3])
    robot.lin(before)
    robot.ptp(robot.home, speed=0.5)

    cell.print(f"It went {1e3 * way:.1f} mm to the side and is home after {cell.time:.3f} s.")
    cell.expect("the way to the side", abs(way - 0.2) < 1e-6, f"{way:.6f} m (0.2)")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/arm.json", program))
