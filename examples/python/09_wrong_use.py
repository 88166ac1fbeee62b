"""9. What is wrong is said before anything moves, with what would be right: each of these raises a takt.Error."""
from typing import Callable

import takt
from takt import command


def program(cell: takt.Cell) -> None:
    robot = cell.arm()
    before = robot.q

    def refused(what: str, attempt: Callable[[], object]) -> None:
        try:
            attempt()
            cell.expect(what, False, "it was taken")
        except takt.Error as error:
            for one in error.diagnostics:
                cell.print(f"{what}: {one}")
            cell.expect(what, True, "refused")

    def rule() -> None:  # nothing starts it, and `start` hangs on no transaction (rules C1, C9)
        one, other = command.wait(cell, "one", 0.1), command.wait(cell, "other", 0.1)
        one.on_entered(one.completed, command.start(other))
        cell.as_activity(command.Transaction(cell, "both").add(one, other)).execute()

    refused("a name", lambda: cell.arm("amr"))
    refused("a key", lambda: getattr(robot, "lin")(robot.by(y=0.1), velocity=0.1))
    refused("a goal", lambda: robot.lin(robot.by(y=2.0)))
    refused("a blend", lambda: robot.lin(robot.by(y=0.1), blend=0.7, until=cell.gripper_is("holding")))
    refused("a state", lambda: robot.lin(robot.by(y=0.1), until=cell.gripper_is("holding") and cell.gripper_is("open")))
    refused("a rule", rule)
    cell.expect("nothing has moved", (robot.q == before).all(), "the set point is what it was")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/gripper.json", program))
