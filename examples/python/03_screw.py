"""3. A screw is inserted until it is felt, then pressed with a force while the driver turns: one activity out of three,
one net, so what follows an event follows within cycles and not when the program gets to it."""
import takt


def program(cell: takt.Cell) -> None:
    robot, driver = cell.arm(), cell.output("io/driver")
    down = [0, 0, -1]

    cell.step("over the hole")
    robot.ptp(robot.above("hole", 0.005), speed=0.5)
    cell.tare("wrist")

    felt = cell.force("wrist") > 5.0  # N
    tight = cell.input("io/clutch").held_for(2.0)  # s
    insert = robot.lin.activity(robot.by(z=-0.1), velocity_m_s=0.005, until=felt)
    hold = robot.press.activity(direction=down, in_=robot.name, force_N=10.0, until=tight)

    cell.step("insert, then press and turn")
    cell.sequence(insert, cell.parallel(hold, driver.set.activity(True))).execute()
    pressed = cell.pressing(down).now() or 0.0

    cell.step("away")
    driver.set(False)
    robot.lin(robot.by(z=0.1), speed=0.3)
    cell.expect("pressed with 10 N in the end", abs(pressed - 10.0) < 1.0, f"{pressed:.2f} N")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/screw.json", program))
