"""4. Motions that go over into each other: the first one is begun and may be left at 70 % of its time, so the second one
takes it over in motion; what is executed comes to its natural end."""
import numpy as np
import takt


def program(cell: takt.Cell) -> None:
    robot = cell.arm()
    start = robot.tool

    def beside(x: float, y: float, z: float) -> np.ndarray:
        goal = start.copy()
        goal[:3, 3] += (x, y, z)
        return goal

    first = robot.lin.begin(beside(0.0, 0.15, 0.0), blend=0.7)
    second = robot.lin(beside(-0.1, 0.15, 0.0))
    third = robot.lin(beside(-0.1, 0.15, 0.1))

    cell.print(f"The second motion took over in cycle {second.first_cycle}, the third began at rest in cycle "
               f"{third.first_cycle}.")
    cell.expect("the second is blended", second.blended, "in motion")
    cell.expect("without an empty cycle", second.first_cycle == first.last_cycle + 1,
                f"{second.first_cycle} after {first.last_cycle}")
    cell.expect("the third is not", not third.blended, "at rest")
    off = np.linalg.norm(robot.tool[:3, 3] - beside(-0.1, 0.15, 0.1)[:3, 3])
    cell.expect("at the last goal", off < 1e-6, f"{off:.1e} m off")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/arm.json", program))
