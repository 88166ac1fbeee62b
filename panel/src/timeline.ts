// States of nets, steps of the program, faults and other events on the time that the plots show, too.
import type { CellEvent, LogEntry } from "./api";
import { h, setText } from "./dom";
import type { TimeAxis } from "./time_axis";

const LANES = ["steps", "nets", "events"] as const;
type Lane = (typeof LANES)[number];
interface Bar {
  lane: Lane;
  from: number;
  to: number;
  text: string;
  bad: boolean;
}

const MOST_BARS = 2000;
const LANE = 26;
const LABEL = 52;
const NEAR_PX = 6;
const STARTED = "Running";
const ENDED = new Set(["Terminated", "Ready"]);

function wordsOf({ from, to, text }: Bar): string {
  const end = to > from && to < Infinity ? ` to ${to.toFixed(3)} s` : "";
  return `${from.toFixed(3)} s${end} ${text}`;
}

export class Timeline {
  readonly panel = h("div", { class: "timeline" });
  private readonly canvas = h("canvas", {
    role: "img",
    "aria-label": "States of nets, steps and events over time; the list of events has the same in words",
  });
  private readonly told = h("output", { class: "told" });
  private bars: Bar[] = [];
  private readonly openNets = new Map<number, Bar>();
  private readonly openSteps = new Map<string, Bar>();
  private planned = false;

  constructor(private readonly axis: TimeAxis) {
    this.panel.append(this.canvas, this.told);
    axis.changed.on(() => this.draw());
    axis.cursorMoved.on(() => this.draw());
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("pointerleave", () => axis.setCursor(null));
    new ResizeObserver(() => this.draw()).observe(this.panel);
  }

  clear(): void {
    this.bars = [];
    this.openNets.clear();
    this.openSteps.clear();
    this.draw();
  }

  hear(events: CellEvent[], period_s: number): void {
    for (const event of events) {
      const time = event.cycle * period_s;
      if (event.kind === "state" && event.state === STARTED)
        this.begin(this.openNets, event.net, {
          lane: "nets",
          from: time,
          to: Infinity,
          text: `net ${event.net}`,
          bad: false,
        });
      if (event.kind === "state" && ENDED.has(event.state ?? ""))
        this.end(
          this.openNets,
          event.net,
          time,
          !["terminated", "cancelled", "taken over", "none"].includes(event.cause),
        );
      const bad = event.kind === "refused" || event.kind === "stopped";
      if (bad)
        this.add({ lane: "events", from: time, to: time, text: `${event.kind}: ${event.text || event.cause}`, bad });
    }
    this.draw();
  }

  read(entries: LogEntry[]): void {
    for (const { source, name, step, text, time_s, level } of entries) {
      if (source === "program" && name === "begin")
        this.begin(this.openSteps, step, {
          lane: "steps",
          from: time_s,
          to: Infinity,
          text: step.split(" / ").at(-1) ?? step,
          bad: false,
        });
      else if (source === "program" && (name === "end" || name === "failed"))
        this.end(this.openSteps, step, time_s, name === "failed");
      else
        this.add({
          lane: "events",
          from: time_s,
          to: time_s,
          text: `${source} ${name}: ${text}`,
          bad: level === "warning" || level === "error",
        });
    }
    this.draw();
  }

  private begin<K>(open: Map<K, Bar>, key: K, bar: Bar): void {
    open.set(key, bar);
    this.add(bar);
  }

  private end<K>(open: Map<K, Bar>, key: K, time: number, bad: boolean): void {
    const bar = open.get(key);
    if (!bar) return;
    bar.to = time;
    bar.bad = bad;
    open.delete(key);
  }

  private add(bar: Bar): void {
    this.bars.push(bar);
    if (this.bars.length > MOST_BARS) this.bars.splice(0, this.bars.length - MOST_BARS);
  }

  private xOf(time: number, width: number): number {
    return LABEL + ((time - this.axis.from) / this.axis.span) * (width - LABEL);
  }

  /** What goes on ends at the newest moment, for now. */
  private endOf(bar: Bar): number {
    return Math.min(bar.to, this.axis.now);
  }

  private point(event: PointerEvent): void {
    const box = this.canvas.getBoundingClientRect();
    const x = event.clientX - box.left;
    const lane = LANES[Math.floor((event.clientY - box.top) / LANE)];
    this.axis.setCursor(x < LABEL ? null : this.axis.from + ((x - LABEL) / (box.width - LABEL)) * this.axis.span);
    const hit = this.bars.findLast(
      (bar) =>
        bar.lane === lane &&
        x >= this.xOf(bar.from, box.width) - NEAR_PX &&
        x <= this.xOf(this.endOf(bar), box.width) + NEAR_PX,
    );
    setText(this.told, hit ? wordsOf(hit) : "");
  }

  private draw(): void {
    if (this.planned || !this.panel.checkVisibility()) return;
    this.planned = true;
    requestAnimationFrame(() => {
      this.planned = false;
      this.paint();
    });
  }

  private paint(): void {
    const width = this.panel.clientWidth;
    const height = LANE * LANES.length + 18;
    const scale = devicePixelRatio;
    if (this.canvas.width !== Math.round(width * scale)) {
      this.canvas.width = Math.round(width * scale);
      this.canvas.height = Math.round(height * scale);
      this.canvas.style.width = `${width}px`;
      this.canvas.style.height = `${height}px`;
    }
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const style = getComputedStyle(document.documentElement);
    const color = (name: string): string => style.getPropertyValue(name);
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "11px system-ui, sans-serif";
    context.textBaseline = "middle";
    LANES.forEach((lane, i) => {
      context.fillStyle = color("--quiet");
      context.fillText(lane, 4, LANE * (i + 0.5));
      context.fillStyle = color("--line");
      context.fillRect(LABEL, LANE * (i + 1) - 1, width - LABEL, 1);
    });
    for (const bar of this.bars) {
      if (bar.to < this.axis.from || bar.from > this.axis.to) continue;
      const y = LANE * LANES.indexOf(bar.lane) + 4;
      const from = Math.max(LABEL, this.xOf(bar.from, width));
      const to = this.xOf(this.endOf(bar), width);
      context.fillStyle = color(bar.bad ? "--bad" : bar.lane === "events" ? "--quiet" : "--accent");
      context.fillRect(from, y, Math.max(2, to - from - 1), LANE - 9);
      if (to - from < 30) continue;
      context.save();
      context.beginPath();
      context.rect(from, y, to - from - 4, LANE - 9);
      context.clip();
      context.fillStyle = color("--on-accent");
      context.fillText(bar.text, from + 4, y + (LANE - 9) / 2 + 0.5);
      context.restore();
    }
    context.fillStyle = color("--quiet");
    const tick = this.axis.span / 4;
    for (let time = Math.ceil(this.axis.from / tick) * tick; time <= this.axis.to; time += tick)
      context.fillText(`${time.toFixed(0)} s`, this.xOf(time, width), height - 8);
    if (this.axis.cursor === null) return;
    context.fillStyle = color("--text");
    context.fillRect(this.xOf(this.axis.cursor, width), 0, 1, height - 16);
  }
}
