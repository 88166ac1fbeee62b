"""5. Activities of different devices run beside each other: the gripper closes while the arm moves; only what the same
device does has an order."""
import takt


def program(cell: takt.Cell) -> None:
    robot, gripper = cell.arm(), cell.gripper()
    goal = robot.tool
    goal[:3, 3] += (0.0, 0.2, 0.0)
    goal2 = robot.tool
    goal2[:3, 3] += (0.0, 0.2, 0.1)

    first = robot.lin.begin(goal, speed=0.5, blend=0.7)
    grip = gripper.grip.begin(expect="nothing")
    second = robot.lin(goal2, speed=0.5)
    grip.wait()

    cell.print(f"The arm moved in cycles {first.first_cycle} to {second.last_cycle}, the gripper in {grip.first_cycle} to "
               f"{grip.last_cycle}.")
    cell.expect("the gripper began during the first motion",
                first.first_cycle < grip.first_cycle < first.last_cycle, f"cycle {grip.first_cycle}")
    cell.expect("the motions are blended", second.blended, "in motion")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/gripper.json", program))
