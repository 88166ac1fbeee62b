// A gamepad: its left stick moves along x and y, its right one along z and about it. It moves only while the left
// shoulder button is held: a stick may stick.
const DEAD_SHARE = 0.15;
const LOOK_MS = 25;
const DEAD_MAN_BUTTON = 4;
/** Axis of the pad: axis of the tool, direction. */
const AXES: [number, number, number][] = [
  [1, 0, -1],
  [0, 1, -1],
  [3, 2, -1],
  [2, 5, -1],
];

export class Gamepads {
  private timer = 0;
  private readonly pushed = new Set<number>();

  /** @param press  axis of the tool, and -1 to 1 of the speed */
  constructor(private readonly press: (axis: number, share: number) => void) {}

  begin(): void {
    if (this.timer === 0) this.timer = window.setInterval(() => this.look(), LOOK_MS);
  }

  end(): void {
    clearInterval(this.timer);
    this.timer = 0;
    this.letGo();
  }

  private look(): void {
    const pad = navigator.getGamepads().find((one) => one?.connected);
    if (!pad?.buttons[DEAD_MAN_BUTTON]?.pressed) return this.letGo();
    for (const [from, axis, direction] of AXES) {
      const value = pad.axes[from] ?? 0;
      const share = Math.abs(value) < DEAD_SHARE ? 0 : direction * value;
      if (share === 0 && !this.pushed.delete(axis)) continue;
      if (share !== 0) this.pushed.add(axis);
      this.press(axis, share);
    }
  }

  private letGo(): void {
    for (const axis of this.pushed) this.press(axis, 0);
    this.pushed.clear();
  }
}
