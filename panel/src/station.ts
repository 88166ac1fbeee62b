// An operator station: the panes of a layout file (docs/panel.md), each a part of the page or one of its own here.
import type { Arm, LogEntry } from "./api";
import { Channels } from "./channels";
import { h, setText, slider } from "./dom";
import type { Entry } from "./frames";
import { holdButton } from "./hold_button";
import type { Link } from "./link";
import { LiveCamera } from "./live_camera";
import { stick } from "./stick";

const WRITE_EVERY_MS = 40;
/** A page that was held up for longer has lost sight of the hand: it has to be pressed anew. */
const HELD_UP_MS = 200;
const FORCES_EVERY_S = 0.04;
const POSTURE_EVERY_S = 0.1;
const MOST_MESSAGES = 20;
const DEGREES = 180 / Math.PI;

interface Option {
  text: string;
  value: number;
}
interface Pane {
  show: string;
  title?: string;
  height?: number;
  camera: string;
  sensor: string;
  max_N: number;
  arm: string;
  channel: string;
  enable: string;
  options: Option[];
  linear_max_m_s: number;
  angular_max_deg_s: number;
  azimuth: string;
  elevation: string;
  distance: string;
  distance_min_m: number;
  distance_max_m: number;
  lamps: { text: string; channel: string }[];
  tabs: string[];
}
export interface LayoutFile {
  title?: string;
  columns: { width?: number; panes: Pane[] }[];
}
/** Parts of the page that a layout may show. */
export interface Parts {
  view3d: HTMLElement;
  tabs: (names: string[]) => HTMLElement;
}

export class Station {
  readonly element = h("div", { class: "station" });
  private readonly channels: Channels;
  private readonly said = h("p", { class: "said", role: "status" });
  private readonly control = h(
    "button",
    { type: "button", class: "control", click: () => void this.takeOrRelease() },
    "Take control",
  );
  private readonly needControl: HTMLElement[] = [];
  /** What a hand holds: written again and again, until it lets go. */
  private readonly held = new Map<string, () => [string, unknown][]>();
  private readonly messages = h("div", { class: "messages", role: "log" });
  private lastTick = 0;
  private heldBy = 0;

  constructor(
    private readonly link: Link,
    layout: LayoutFile,
    private readonly parts: Parts,
  ) {
    this.channels = new Channels(link);
    this.channels.refused.on((why) => {
      this.letGo();
      setText(this.said, why);
    });
    for (const column of layout.columns) {
      const place = h("div", { class: "column" });
      place.style.flexGrow = String(column.width ?? 1);
      for (const pane of column.panes) place.append(this.pane(pane));
      this.element.append(place);
    }
    link.leaseChanged.on(() => this.showControl());
    link.lost.on(() => this.letGo());
    // Whatever takes the hand away from the page lets go.
    addEventListener("blur", () => this.letGo());
    addEventListener("pagehide", () => this.letGo());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.letGo();
    });
    setInterval(() => this.tick(), WRITE_EVERY_MS);
    this.showControl();
  }

  /** @param holder  fence of whoever commands */
  show(holder: number): void {
    if (holder === this.heldBy) return;
    this.heldBy = holder;
    this.showControl();
  }

  /** What the program says: the newest first. */
  read(entries: LogEntry[]): void {
    for (const { time_s, level, name, text } of entries) {
      if (name !== "log" && name !== "told" && level !== "warning" && level !== "error") continue;
      const words = text.replace(/ \(cycle [^)]*\)$/, "");
      const line = h("p", {}, h("span", { class: "time" }, `${time_s.toFixed(1)} s`), words);
      line.toggleAttribute("data-bad", level === "error");
      this.messages.prepend(line);
      while (this.messages.childElementCount > MOST_MESSAGES) this.messages.lastElementChild?.remove();
    }
  }

  private pane(pane: Pane): HTMLElement {
    const [title, inside] = this.inside(pane);
    const place = h("section", { class: `pane pane-${pane.show}`, "aria-label": pane.title ?? title });
    place.style.flexGrow = String(pane.height ?? 1);
    if (!["view3d", "tabs", "hold"].includes(pane.show)) place.append(h("h2", {}, pane.title ?? title));
    place.append(...inside);
    return place;
  }

  private inside(pane: Pane): [string, HTMLElement[]] {
    switch (pane.show) {
      case "view3d":
        return ["3D view", [this.parts.view3d]];
      case "tabs":
        return ["More", [this.parts.tabs(pane.tabs)]];
      case "camera":
        return [`Camera ${pane.camera}`, [this.camera(pane)]];
      case "force":
        return [`Force at ${pane.sensor}`, [this.force(pane)]];
      case "posture":
        return [`Posture of ${pane.arm}`, [this.posture(pane)]];
      case "control":
        return ["Control", [this.control, this.said]];
      case "choice":
        return ["Mode", [this.choice(pane)]];
      case "sticks":
        return ["Drive", this.sticks(pane)];
      case "orbit":
        return ["Perspective", this.orbit(pane)];
      case "hold":
        return ["Hold", [this.holdButton(pane)]];
      case "messages":
        return ["What happens", [this.messages]];
      case "lamps":
        return ["State", [this.lamps(pane)]];
    }
    return [pane.show, [h("p", { class: "quiet" }, `This page has no pane '${pane.show}'.`)]];
  }

  private camera(pane: Pane): HTMLElement {
    const live = new LiveCamera(this.link);
    live.watch(pane.camera, 480, 360);
    return live.element;
  }

  private force(pane: Pane): HTMLElement {
    const sum = h("output", { class: "newton" }, "–");
    const bars = ["x", "y", "z"].map((axis) => {
      const bar = h("i", {});
      const value = h("span", {}, "–");
      return { bar, value, row: h("div", { class: "bar" }, h("span", {}, axis), h("div", {}, bar), value) };
    });
    const note = h("p", { class: "quiet" }, "as measured, with the weight of the tool");
    const place = h("div", { class: "force" }, sum, ...bars.map((one) => one.row), note);
    this.link.monitor({ sensor: pane.sensor }, FORCES_EVERY_S, ({ value }: Entry) => {
      const wrench = Array.isArray(value) ? value : null;
      place.toggleAttribute("data-bad", wrench === null);
      if (!wrench) return setText(sum, "no reading");
      const size = Math.hypot(wrench[0] ?? 0, wrench[1] ?? 0, wrench[2] ?? 0);
      setText(sum, `${size.toFixed(1)} N`);
      sum.toggleAttribute("data-bad", size > pane.max_N);
      bars.forEach(({ bar, value: text }, i) => {
        const share = Math.max(-1, Math.min(1, (wrench[i] ?? 0) / pane.max_N));
        bar.style.left = `${50 + Math.min(0, 50 * share)}%`;
        bar.style.width = `${Math.abs(50 * share)}%`;
        setText(text, (wrench[i] ?? 0).toFixed(1));
      });
    });
    return place;
  }

  private posture(pane: Pane): HTMLElement {
    const place = h("div", { class: "force" });
    void this.link.ask<Arm>("GET", `/v1/arms/${encodeURIComponent(pane.arm)}`).then(({ data_sheet }) => {
      const bars = data_sheet.joint_names.map((name) => {
        const bar = h("i", { class: "mark" });
        const value = h("span", {}, "–");
        place.append(h("div", { class: "bar" }, h("span", {}, name), h("div", {}, bar), value));
        return { bar, value };
      });
      this.link.monitor({ arm: pane.arm, value: "q_measured" }, POSTURE_EVERY_S, ({ value }) => {
        if (!Array.isArray(value)) return;
        bars.forEach(({ bar, value: text }, i) => {
          const [low = -1, high = 1, q = 0] = [data_sheet.lower[i], data_sheet.upper[i], value[i]];
          bar.style.left = `${(100 * (q - low)) / (high - low)}%`;
          setText(text, `${(q * DEGREES).toFixed(1)}°`);
        });
      });
    });
    return place;
  }

  private choice(pane: Pane): HTMLElement {
    const buttons = pane.options.map((option) =>
      h(
        "button",
        {
          type: "button",
          "aria-pressed": "false",
          click: () => {
            this.letGo();
            this.channels.write(pane.channel, option.value);
          },
        },
        option.text,
      ),
    );
    this.needControl.push(...buttons);
    this.link.monitor({ channel: pane.channel }, POSTURE_EVERY_S, ({ value }) => {
      const now = Array.isArray(value) ? value[0] : undefined;
      pane.options.forEach((option, i) => buttons[i]?.setAttribute("aria-pressed", String(option.value === now)));
    });
    return h("div", { class: "choices", role: "group", "aria-label": pane.title ?? "Mode" }, ...buttons);
  }

  private sticks(pane: Pane): HTMLElement[] {
    const pushed = [0, 0, 0, 0, 0, 0];
    let share = 0.5;
    const key = `stick ${pane.channel}`;
    const values = (): [string, unknown][] => {
      const of = (from: number, most: number): number[] =>
        pushed.slice(from, from + 3).map((one) => one * most * share);
      const velocity = { linear: of(0, pane.linear_max_m_s), angular: of(3, pane.angular_max_deg_s / DEGREES) };
      return [
        [pane.channel, velocity],
        [pane.enable, true],
      ];
    };
    const push = (axis: number, value: number): void => {
      pushed[axis] = value;
      if (pushed.some((one) => one !== 0)) this.hold(key, values);
      else this.release(key, [[pane.enable, false]]);
    };
    const places = h(
      "div",
      { class: "sticks" },
      stick("x y", (right, up) => {
        push(0, up);
        push(1, -right);
      }),
      stick("z, turn", (right, up) => {
        push(2, up);
        push(5, -right);
      }),
    );
    const keys: Record<string, [number, number]> = {
      KeyW: [0, 1],
      KeyS: [0, -1],
      KeyA: [1, 1],
      KeyD: [1, -1],
      KeyR: [2, 1],
      KeyF: [2, -1],
    };
    const pad = h(
      "div",
      { class: "keypad", tabindex: 0, role: "application", "aria-label": "Drive with keys: W S x, A D y, R F z, held" },
      h("b", {}, "Keys"),
      h("span", {}, "Focus here, hold: W S x · A D y · R F z"),
    );
    pad.addEventListener("keydown", (event) => {
      const found = keys[event.code];
      if (!found || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      push(found[0], found[1]);
    });
    pad.addEventListener("keyup", (event) => {
      const found = keys[event.code];
      if (found) push(found[0], 0);
    });
    pad.addEventListener("blur", () => [0, 1, 2, 3, 4, 5].forEach((axis) => push(axis, 0)));
    this.onLetGo.push(() => pushed.fill(0));
    const words = (value: number): string => `${Math.round(1000 * pane.linear_max_m_s * value)} mm/s`;
    const speed = slider("Speed", { min: 0.05, max: 1, step: 0.05, value: share }, words, (value) => {
      share = value;
    });
    this.needControl.push(places, pad);
    return [places, pad, speed.label];
  }

  private orbit(pane: Pane): HTMLElement[] {
    const angle = (name: string, channel: string, min: number, max: number, value: number): HTMLElement => {
      const one = slider(
        name,
        { min, max, step: 1, value },
        (degrees) => `${degrees}°`,
        (degrees) => this.channels.write(channel, degrees / DEGREES),
      );
      this.needControl.push(one.input);
      this.follow(channel, one.show, DEGREES);
      return one.label;
    };
    const { distance_min_m: min, distance_max_m: max } = pane;
    const distance = slider(
      "Distance",
      { min, max, step: 0.01, value: Math.min(max, Math.max(min, 0.45)) },
      (metres) => `${metres.toFixed(2)} m`,
      (metres) => this.channels.write(pane.distance, metres),
    );
    this.needControl.push(distance.input);
    this.follow(pane.distance, distance.show, 1);
    return [angle("Around", pane.azimuth, -180, 180, 0), angle("Above", pane.elevation, -10, 90, 35), distance.label];
  }

  /** Shows what a channel says, whoever wrote it. */
  private follow(channel: string, show: (value: number) => void, factor: number): void {
    this.link.monitor({ channel }, POSTURE_EVERY_S, ({ value }) => {
      if (Array.isArray(value) && value[0] !== undefined) show(value[0] * factor);
    });
  }

  private holdButton(pane: Pane): HTMLElement {
    const key = `hold ${pane.channel}`;
    const button = holdButton(
      pane.title ?? pane.channel,
      () => this.hold(key, () => [[pane.channel, true]]),
      () => this.release(key, [[pane.channel, false]]),
    );
    this.onLetGo.push(() => button.classList.remove("held"));
    this.needControl.push(button);
    return button;
  }

  private lamps(pane: Pane): HTMLElement {
    const rows = pane.lamps.map(({ text, channel }) => {
      const lamp = h("li", {}, text);
      this.link.monitor({ channel }, POSTURE_EVERY_S, ({ value }) => {
        const on = Array.isArray(value) && value[0] === 1;
        lamp.toggleAttribute("data-on", on);
        lamp.setAttribute("aria-label", `${text}: ${on ? "yes" : "no"}`);
      });
      return lamp;
    });
    return h("ul", { class: "lamps" }, ...rows);
  }

  // -- What a hand holds ----------------------------------------------------------------------------------------------

  private readonly onLetGo: (() => void)[] = [];

  private hold(key: string, values: () => [string, unknown][]): void {
    if (!this.link.fence) return setText(this.said, "Take control first.");
    if (this.held.size === 0) this.lastTick = performance.now();
    this.held.set(key, values);
    this.write(values());
  }

  private release(key: string, last: [string, unknown][]): void {
    if (this.held.delete(key)) this.write(last);
  }

  private letGo(): void {
    for (const one of this.onLetGo) one();
    for (const [key, values] of [...this.held])
      this.release(
        key,
        values().map(([channel]) => [channel, null]),
      );
  }

  private tick(): void {
    const now = performance.now();
    const heldUp = now - this.lastTick > HELD_UP_MS;
    this.lastTick = now;
    if (heldUp || !this.link.open) return this.letGo();
    for (const values of this.held.values()) this.write(values());
  }

  private write(values: [string, unknown][]): void {
    for (const [channel, value] of values) this.channels.write(channel, value);
  }

  private async takeOrRelease(): Promise<void> {
    try {
      this.letGo();
      if (this.link.fence) await this.link.releaseLease();
      else await this.link.takeLease(this.heldBy !== 0);
      setText(this.said, "");
    } catch (error) {
      setText(this.said, error instanceof Error ? error.message : String(error));
    }
  }

  private showControl(): void {
    const mine = this.link.fence !== 0;
    if (!mine) this.letGo();
    setText(this.control, mine ? "Release control" : this.heldBy ? "Take over control" : "Take control");
    this.control.disabled = this.link.role === "observer";
    this.element.toggleAttribute("data-mine", mine);
    for (const one of this.needControl) {
      if (one instanceof HTMLButtonElement || one instanceof HTMLInputElement) one.disabled = !mine;
      else one.toggleAttribute("inert", !mine);
    }
  }
}
