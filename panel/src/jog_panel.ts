// The side of jogging that hands touch: which arm, which space, how fast; buttons, sticks, keys, a gamepad.
import { wordsOf, type Arm, type Device, type Scene } from "./api";
import { choice, h, setText, slider } from "./dom";
import { Gamepads } from "./gamepad";
import { holdButton } from "./hold_button";
import { JogDrive, type JogSetting, type Space } from "./jog_drive";
import type { Link } from "./link";
import { stick } from "./stick";

const LINEAR_MAX_M_S = 0.25;
const ANGULAR_MAX_RAD_S = Math.PI / 3;
const JOINT_SHARE = 0.25; // of a joint's own limit, at full speed
const AXES = ["x", "y", "z", "about x", "about y", "about z"];
/** Keys of the pad: axis and direction. They stand on the keyboard as the directions do in the room. */
const KEYS: Record<string, [number, number]> = {
  KeyW: [0, 1],
  KeyS: [0, -1],
  KeyA: [1, 1],
  KeyD: [1, -1],
  KeyR: [2, 1],
  KeyF: [2, -1],
  KeyU: [3, 1],
  KeyJ: [3, -1],
  KeyI: [4, 1],
  KeyK: [4, -1],
  KeyO: [5, 1],
  KeyL: [5, -1],
};
const STEPS = [
  { value: "0", text: "while pressed" },
  { value: "0.001", text: "step 1 mm, 0.1°" },
  { value: "0.01", text: "step 10 mm, 1°" },
  { value: "0.1", text: "step 100 mm, 10°" },
];
const RAD_PER_M = Math.PI / 1.8; // of a step: 10 mm go with 1 degree

/** What a share of the speed is, in words. */
function speedWords(share: number): string {
  const millimetres = Math.round(1000 * LINEAR_MAX_M_S * share);
  const degrees = Math.round((share * ANGULAR_MAX_RAD_S * 180) / Math.PI);
  return `${millimetres} mm/s, ${degrees}°/s`;
}

export class JogPanel {
  readonly panel = h("div", { class: "jog" });
  private readonly drive: JogDrive;
  private readonly control = h(
    "button",
    { type: "button", class: "control", click: () => void this.takeOrRelease() },
    "Take control",
  );
  private readonly said = h("p", { class: "said", role: "status" });
  private readonly axes = h("div", { class: "axes" });
  private readonly sticks = h("div", { class: "sticks" });
  private readonly pad = h("div", {
    class: "keypad",
    tabindex: 0,
    role: "application",
    "aria-label": "Jog with keys: W S along x, A D along y, R F along z, U J, I K, O L about them. Held keys move.",
  });
  private readonly arms: HTMLSelectElement;
  private readonly frames: HTMLSelectElement;
  private readonly frameField: HTMLElement;
  private readonly gamepads: Gamepads;
  private space: Space = "tool";
  private share = 0.2;
  private step = 0;
  private joints: string[] = [];
  private limits: number[] = [];
  private arm = "";
  private frame = "world";
  private heldBy = 0;
  private byProgram = false;

  constructor(private readonly link: Link) {
    this.drive = new JogDrive(link, () => this.setting());
    this.drive.changed.on((text) => {
      setText(this.said, text);
      if (!this.drive.isDriving) for (const held of this.axes.querySelectorAll(".held")) held.classList.remove("held");
    });
    link.leaseChanged.on(() => this.showControl());
    const arms = choice("Arm", [], (arm) => void this.choose(arm));
    const space = choice(
      "Space",
      [
        { value: "tool", text: "Tool" },
        { value: "joints", text: "Joints" },
      ],
      (value) => this.setSpace(value as Space),
    );
    const frames = choice("Along", [], (frame) => {
      this.drive.end();
      this.frame = frame;
    });
    const steps = choice("Moves", STEPS, (value) => {
      this.step = Number(value);
    });
    const speed = slider("Speed", { min: 0.02, max: 1, step: 0.02, value: this.share }, speedWords, (value) => {
      // The limits belong to the net that moves: a new speed takes a new one.
      this.drive.end();
      this.share = value;
    });
    this.arms = arms.select;
    this.frames = frames.select;
    this.frameField = frames.label;
    this.gamepads = new Gamepads((axis, share) => {
      if (this.space === "tool") this.drive.press(axis, share);
    });
    this.listenToKeys();
    this.panel.append(
      h("div", { class: "fields" }, this.control, arms.label, space.label, frames.label, steps.label),
      speed.label,
      this.said,
      this.axes,
      this.sticks,
      this.pad,
    );
    this.showControl();
  }

  async load(scene: Scene): Promise<void> {
    const { devices } = await this.link.ask<{ devices: Device[] }>("GET", "/v1/devices");
    const arms = devices.filter((one) => one.kind === "arm").map((one) => one.name);
    this.arms.replaceChildren(...arms.map((name) => h("option", { value: name }, name)));
    const frames = [
      "world",
      "tcp",
      ...scene.frames.map((one) => one.name).filter((name) => name !== "world" && name !== "tcp"),
    ];
    this.frames.replaceChildren(
      ...frames.map((name) => h("option", { value: name }, name === "tcp" ? "tool (tcp)" : name)),
    );
    if (arms[0] !== undefined) await this.choose(arms[0]);
  }

  /** @param holder  fence of whoever commands; @param byProgram  nobody else may */
  show(holder: number, byProgram: boolean): void {
    if (holder === this.heldBy && byProgram === this.byProgram) return;
    this.heldBy = holder;
    this.byProgram = byProgram;
    this.showControl();
  }

  private setting(): JogSetting {
    return {
      arm: this.arm,
      space: this.space,
      in: this.frame,
      linear_m_s: LINEAR_MAX_M_S * this.share,
      angular_rad_s: ANGULAR_MAX_RAD_S * this.share,
      rates: this.limits.map((limit) => limit * JOINT_SHARE * this.share),
    };
  }

  private async choose(arm: string): Promise<void> {
    this.drive.end();
    const { data_sheet } = await this.link.ask<Arm>("GET", `/v1/arms/${encodeURIComponent(arm)}`);
    this.arm = arm;
    this.joints = data_sheet.joint_names;
    this.limits = data_sheet.velocity;
    this.build();
  }

  private setSpace(space: Space): void {
    this.drive.end();
    this.space = space;
    this.build();
  }

  private build(): void {
    const inTool = this.space === "tool";
    this.frameField.hidden = !inTool;
    this.sticks.hidden = this.pad.hidden = !inTool;
    const names = inTool ? AXES : this.joints;
    this.axes.replaceChildren(
      ...names.flatMap((name, axis) => [
        this.button(axis, -1, name),
        h("span", { class: "axis" }, name),
        this.button(axis, 1, name),
      ]),
    );
    if (inTool && this.sticks.childElementCount === 0) {
      this.sticks.append(
        stick("x y", (right, up) => {
          this.drive.press(0, up);
          this.drive.press(1, -right);
        }),
        stick("z, turn", (right, up) => {
          this.drive.press(2, up);
          this.drive.press(5, -right);
        }),
      );
      this.pad.append(
        h("b", {}, "Keys"),
        h("span", {}, "Focus here, hold: W S x · A D y · R F z · U J, I K, O L about x, y, z"),
      );
    }
    this.showControl();
  }

  /** Moves while it is held: by pointer, or by Space or Enter. */
  private button(axis: number, direction: 1 | -1, name: string): HTMLButtonElement {
    const sign = direction > 0 ? "+" : "−";
    return holdButton(
      sign,
      () => this.drive.press(axis, direction, this.distance(axis)),
      () => this.drive.release(axis),
      `${name} ${direction > 0 ? "plus" : "minus"}, hold to move`,
    );
  }

  private distance(axis: number): number {
    if (this.step === 0) return Infinity;
    const turns = this.space === "joints" || axis > 2;
    return turns ? this.step * RAD_PER_M : this.step;
  }

  private listenToKeys(): void {
    this.pad.addEventListener("keydown", (event) => {
      const key = KEYS[event.code];
      if (!key || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      this.drive.press(key[0], key[1], this.distance(key[0]));
    });
    this.pad.addEventListener("keyup", (event) => {
      const key = KEYS[event.code];
      if (key) this.drive.release(key[0]);
    });
    this.pad.addEventListener("blur", () => this.drive.releaseAll());
  }

  private async takeOrRelease(): Promise<void> {
    try {
      if (this.link.fence) {
        this.drive.end();
        await this.link.releaseLease();
      } else {
        await this.link.takeLease(this.heldBy !== 0);
      }
      setText(this.said, "");
    } catch (error) {
      setText(this.said, wordsOf(error));
    }
  }

  private showControl(): void {
    const observes = this.link.role === "observer";
    const mine = this.link.fence !== 0;
    setText(this.control, mine ? "Release control" : this.heldBy ? "Take over control" : "Take control");
    this.control.disabled = observes || this.byProgram;
    for (const button of this.axes.querySelectorAll("button")) button.disabled = !mine;
    this.sticks.toggleAttribute("inert", !mine);
    this.panel.toggleAttribute("data-mine", mine);
    if (observes) setText(this.said, "You may look and stop: this token is an observer's.");
    else if (this.byProgram) setText(this.said, "A program commands this cell: jog it with 'takt serve'.");
    if (mine) this.gamepads.begin();
    else this.gamepads.end();
  }
}
