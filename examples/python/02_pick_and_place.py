"""2. Pick and place: the cell and what must come of it are those of scenarios/pick.json, the program is this one."""
import takt


def program(cell: takt.Cell) -> None:
    robot, lamp, hand = cell.arm(), cell.output("io/lamp"), cell.gripper()
    robot.ptp(robot.above("part", 0.1), speed=0.5)
    robot.lin(robot.above("part", 0.01), speed=0.4)
    hand.grip(speed_m_s=0.1, force_N=60)
    robot.carry(1.0)
    lamp.set(True)
    robot.lin(robot.by(z=0.15), speed=0.4)
    robot.lin(robot.above("box", 0.16), speed=0.4)
    robot.lin(robot.above("box", 0.071), velocity_m_s=0.05)
    hand.release(width_m=0.08, speed_m_s=0.1)
    robot.put_down()
    lamp.set(False)
    robot.lin(robot.by(z=0.12), speed=0.4)
    robot.ptp(robot.home, speed=0.5)


if __name__ == "__main__":
    raise SystemExit(takt.main("pick.json", program))
