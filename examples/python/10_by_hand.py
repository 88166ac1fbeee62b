"""10. A place is taught by hand: the arm goes after whoever leads it, in a control mode of its own, and is stiff again
afterwards. Then it stands there as a spring, and gives way by as much as its stiffness says."""
import numpy as np
import takt


def given_way(cell: takt.Cell, robot: takt.Arm, begin: float, stiffness: float) -> float:
    """How far somebody who leans on the arm from `begin` on pushes it away while it is a spring, m."""
    spring = {"mode": "cartesian_impedance", "stiffness_N_m": 3 * [stiffness]}
    robot.hold.begin(seconds=begin + 3.0 - cell.time, compliance=spring)
    cell.wait(begin - cell.time)
    before = robot.measured_tool[:3, 3]
    cell.wait(1.8)
    way = np.linalg.norm(robot.measured_tool[:3, 3] - before)
    cell.wait_for_all()
    return float(way)


def program(cell: takt.Cell) -> None:
    robot = cell.arm()
    start = robot.tool

    cell.step("led by hand")
    robot.freedrive(seconds=5.0, velocity_m_s=0.1)
    taught = robot.tool
    led = np.linalg.norm(taught[:3, 3] - start[:3, 3])
    cell.expect("the hand has led it", led > 0.05, f"{1e3 * led:.0f} mm")
    cell.expect("stiff again", robot.mode == "position", "mode position")

    cell.step("there again")
    robot.lin(start, velocity_m_s=0.2)
    robot.lin(taught, velocity_m_s=0.2)
    off = np.linalg.norm(robot.tool[:3, 3] - taught[:3, 3])
    cell.expect("at the place that was taught", off < 1e-6, f"{off:.1e} m off")

    cell.step("as a spring")
    robot.control_mode("cartesian_impedance")
    for begin, stiffness in ((14.0, 2000.0), (18.0, 500.0)):
        way, wanted = given_way(cell, robot, begin, stiffness), 20.0 / stiffness
        cell.expect(f"gives way as {stiffness:g} N/m do", abs(way - wanted) < 0.2 * wanted, f"{1e3 * way:.1f} mm under 20 N")
    robot.control_mode("position")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/by_hand.json", program))
