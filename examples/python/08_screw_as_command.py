"""8. The screw again, a layer below: a transaction of commands with event handlers, as figure 3 of the 2013 paper draws it.
Who starts and cancels whom is written out; the cell carries it out as one activity."""
import takt
from takt import command


def program(cell: takt.Cell) -> None:
    robot, driver = cell.arm(), cell.output("io/driver")
    robot.ptp(robot.above("hole", 0.005), speed=0.5)
    cell.tare()

    down = [0, 0, -1]
    insert_screw = command.runtime("insertScrew", robot, command.lin(robot, robot.above("hole", -0.08), velocity_m_s=0.005))
    maintain_force = command.runtime("maintainForce", robot, command.hold_force(cell.pressing(down), down, cell=cell))
    tighten_screw = command.runtime("tightenScrew", driver, command.set_value(driver, True))
    insert_screw.on_entered(cell.force() > 5.0, command.cancel(insert_screw))
    maintain_force.on_entered(cell.input("io/clutch").held_for(2.0), command.cancel(maintain_force))
    screwing = command.Transaction(cell, "screwing")
    screwing.add_started(insert_screw).add(maintain_force).add(tighten_screw)
    screwing.on_entered(insert_screw.completed, command.start(maintain_force))
    screwing.on_entered(insert_screw.completed, command.start(tighten_screw))

    run = cell.as_activity(screwing).execute()
    for one in run.reactions:
        cell.print(f"{one.event}: 5 N in cycle {one.event_cycle}, the arm brakes in cycle {one.braking_cycle} (certified: "
                   f"{one.least} to {one.most} cycles later)")
    driver.set(False)
    robot.lin(robot.by(z=0.1), speed=0.3)


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/screw.json", program))
