"""7. Two arms: coroutines beside each other until both are where they meet, then both as one actuator that moves the frame
between them on one path with one clock."""
import numpy as np
import takt


def program(cell: takt.Cell) -> None:
    left, right = cell.arm("left"), cell.arm("right")
    up = []

    async def greet(robot: takt.Arm) -> None:
        """Up, and down again when the other one is up too."""
        await robot.lin.activity(robot.by(z=0.1))
        up.append(robot.name)
        await cell.when(lambda: len(up) == 2)
        await robot.lin.activity(robot.by(z=-0.1))

    cell.step("one beside the other")
    cell.run(greet(left), greet(right))
    cell.wait_for_all()

    cell.step("both as one")
    X_WC = np.linalg.inv(left.frame("world")) @ left.flange
    X_WC[0, 3] = 0.7  # in the middle
    both = cell.two_arms(left, right, X_WC)
    both.lin_by(z=0.1, blend=0.6).begin()
    second = both.lin_by(y=0.1).execute()

    apart = np.linalg.norm(both.centre[:3, 3] - both.centre_by_follower[:3, 3])
    off = np.linalg.norm(both.centre[:3, 3] - X_WC[:3, 3] - (0.0, 0.1, 0.1))
    cell.expect("one motion after the other, blended", second.blended, f"cycle {second.first_cycle}")
    cell.expect("both see the centre at one place", apart < 1e-8, f"{apart:.1e} m apart")
    cell.expect("the centre is at its goal", off < 1e-6, f"{off:.1e} m off")


if __name__ == "__main__":
    raise SystemExit(takt.main("../activities/cells/two_arms.json", program))
