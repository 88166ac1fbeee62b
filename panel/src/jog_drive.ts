// Moving an arm by hand: what is pressed becomes velocities, and they flow only while somebody presses. It ends in the
// cycle as well: when nothing comes for TIMEOUT_S there, the arm comes to rest (docs/remote.md, "Jogging").
import type { Link, Message } from "./link";
import { Signal } from "./signal";

const TICK_MS = 25;
const TIMEOUT_S = 0.25;
/** A page that was held up for longer has lost sight of the hand: it has to be pressed anew. */
const HELD_UP_MS = 200;
/** So long zeros are sent after a release, before the arm is given back. */
const LINGER_MS = 300;

export type Space = "tool" | "joints";
export interface JogSetting {
  arm: string;
  space: Space;
  in: string;
  linear_m_s: number;
  angular_rad_s: number;
  rates: number[];
}
type Phase = "idle" | "asking" | "driving" | "ending";

export class JogDrive {
  readonly changed = new Signal<string>();
  private readonly pressed = new Map<number, number>();
  private phase: Phase = "idle";
  private jog = 0;
  private sequence = 0;
  private timer = 0;
  private lastTick = 0;
  private released = 0;
  private budget = Infinity;

  constructor(
    private readonly link: Link,
    private readonly setting: () => JogSetting,
  ) {
    link.messages.on((message) => this.hear(message));
    link.lost.on(() => this.ended("The connection is lost: the arm comes to rest."));
    link.leaseChanged.on(() => {
      if (!link.fence) this.releaseAll();
    });
    // Whatever takes the hand away from the page lets go.
    addEventListener("blur", () => this.releaseAll());
    addEventListener("pagehide", () => this.releaseAll());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.releaseAll();
    });
  }

  get isDriving(): boolean {
    return this.phase === "driving" && this.pressed.size > 0;
  }

  /**
   * Somebody presses an axis, or presses it otherwise.
   * @param axis  0 to 5: x, y, z, and about them; or a joint
   * @param share  -1 to 1 of the speed that is set; 0 lets go
   * @param distance  m or rad after which it stands, though pressed
   */
  press(axis: number, share: number, distance = Infinity): void {
    if (share === 0) return this.release(axis);
    if (!this.pressed.has(axis)) this.budget = distance;
    this.pressed.set(axis, Math.max(-1, Math.min(1, share)));
    if (this.phase === "idle") this.ask();
  }

  release(axis: number): void {
    this.pressed.delete(axis);
    if (this.pressed.size === 0) this.released = performance.now();
  }

  releaseAll(): void {
    if (this.pressed.size === 0) return;
    this.pressed.clear();
    this.released = performance.now();
    if (this.phase === "driving") this.move();
  }

  /** Gives the arm back, before something else is set. */
  end(): void {
    this.pressed.clear();
    if (this.phase !== "driving") return;
    this.phase = "ending";
    this.link.send({ op: "unjog", jog: this.jog });
  }

  private ask(): void {
    if (!this.link.fence) {
      this.pressed.clear();
      return this.changed.emit("Take control first.");
    }
    const { arm, space, linear_m_s, angular_rad_s, in: frame } = this.setting();
    this.phase = "asking";
    this.sequence = 0;
    const limits = {
      linear_max_m_s: Math.max(0.001, linear_m_s),
      angular_max_deg_s: Math.max(0.1, (angular_rad_s * 180) / Math.PI),
    };
    const message = {
      op: "jog",
      jog: ++this.jog,
      fence: this.link.fence,
      arm,
      space,
      timeout_cycles: Math.round(TIMEOUT_S / this.link.period_s),
      ...limits,
      ...(space === "tool" ? { in: frame } : {}),
    };
    if (!this.link.send(message)) this.ended("The server cannot be reached.");
  }

  private hear(message: Message): void {
    const mine = message["jog"] === this.jog || (message.op === "problem" && message["id"] === this.jog);
    if (!mine) return;
    if (message.op === "jogging") this.begin();
    else if (message.op === "jog_ended") this.ended(REASONS[String(message["reason"])] ?? "");
    else if (message.op === "problem" && message["for"] === "jog") {
      const diagnostics = (message["diagnostics"] ?? []) as { message?: string; hint?: string }[];
      this.ended(
        [String(message["detail"]), ...diagnostics.map((one) => `${one.message ?? ""} ${one.hint ?? ""}`)].join(": "),
      );
    }
  }

  private begin(): void {
    if (this.phase !== "asking") return;
    this.phase = "driving";
    this.lastTick = performance.now();
    this.changed.emit("moves");
    if (this.pressed.size === 0) this.released = this.lastTick;
    this.timer = window.setInterval(() => this.tick(), TICK_MS);
    this.move();
  }

  private tick(): void {
    const now = performance.now();
    const heldUp = now - this.lastTick > HELD_UP_MS;
    const passed = (now - this.lastTick) / 1000;
    this.lastTick = now;
    if (heldUp) this.releaseAll();
    this.spend(passed);
    if (this.pressed.size === 0 && now - this.released > LINGER_MS) return this.end();
    this.move();
  }

  /** A step: once its distance is travelled it stands until it is pressed anew. */
  private spend(seconds: number): void {
    if (this.budget === Infinity || this.pressed.size === 0) return;
    const [axis = 0, share = 0] = [...this.pressed][0] ?? [];
    const speed = Math.abs(share) * this.speedOf(axis);
    this.budget -= speed * seconds;
    if (this.budget <= 0) this.pressed.clear();
    if (this.pressed.size === 0) this.released = performance.now();
    else if (this.budget < (speed * TICK_MS) / 1000)
      this.pressed.set(axis, (Math.sign(share) * this.budget) / (TICK_MS / 1000) / this.speedOf(axis));
  }

  private speedOf(axis: number): number {
    const { space, linear_m_s, angular_rad_s, rates } = this.setting();
    return space === "joints" ? (rates[axis] ?? 0) : axis < 3 ? linear_m_s : angular_rad_s;
  }

  private move(): void {
    if (this.phase !== "driving") return;
    const { space, rates } = this.setting();
    const wanted = (axis: number): number => (this.pressed.get(axis) ?? 0) * this.speedOf(axis);
    const velocity =
      space === "joints"
        ? { rates: rates.map((_, joint) => wanted(joint)) }
        : { linear: [0, 1, 2].map(wanted), angular: [3, 4, 5].map(wanted) };
    this.link.send({ op: "move", jog: this.jog, sequence: ++this.sequence, ...velocity });
  }

  private ended(why: string): void {
    clearInterval(this.timer);
    const pressedMeanwhile = this.phase === "ending" && this.link.open && this.pressed.size > 0;
    this.phase = "idle";
    if (pressedMeanwhile) return this.ask();
    this.pressed.clear();
    this.changed.emit(why);
  }
}

const REASONS: Record<string, string> = {
  released: "at rest",
  silent: "At rest: the server heard nothing from this page for too long.",
  lease: "At rest: somebody else took control.",
  stopped: "At rest: it was stopped.",
};
