// Values over time: of arms, sensors, channels and ports of nets, any of them while the cell runs.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Channel, Device, Graph, Scene } from "./api";
import { h, setText } from "./dom";
import { partsOf } from "./format";
import type { Entry } from "./frames";
import type { Link, Watched } from "./link";
import type { TimeAxis } from "./time_axis";

const SAMPLE_EVERY_S = 0.02;
const MOST_SAMPLES = 6000; // two minutes
const DRAW_EVERY_MS = 80;
const HEIGHT = 116;
/** Told apart by people who see colours otherwise, too; on light and on dark. */
const COLORS = ["#4aa8ff", "#e8892b", "#2fb39a", "#d86bd0", "#b7a100", "#e5484d", "#8e8ce8", "#7a8a99"];
const ARM_VALUES = [
  ["q_measured", "position, measured"],
  ["q_commanded", "position, commanded"],
  ["dq_measured", "velocity"],
  ["tau_measured", "torque"],
] as const;

interface Source {
  title: string;
  watched: Watched;
}

export class Plots {
  readonly panel = h("div", { class: "plots" });
  private readonly cards = h("div", { class: "cards" });
  private readonly select = h("select", { "aria-label": "Value to plot" });
  private sources: Source[] = [];
  private readonly open = new Set<Plot>();

  constructor(
    private readonly link: Link,
    private readonly axis: TimeAxis,
  ) {
    const add = h("button", { type: "button", click: () => this.add() }, "Plot");
    const hold = h(
      "button",
      {
        type: "button",
        "aria-pressed": "false",
        click: () => {
          axis.hold(!axis.held);
          hold.setAttribute("aria-pressed", String(axis.held));
        },
      },
      "Hold",
    );
    const spans = h(
      "select",
      { "aria-label": "Time shown", change: () => axis.show(Number(spans.value)) },
      ...[5, 20, 60, 120].map((s) => h("option", { value: s, selected: s === axis.span }, `${s} s`)),
    );
    this.panel.append(
      h("div", { class: "fields", role: "toolbar", "aria-label": "Plots" }, this.select, add, spans, hold),
      this.cards,
    );
    let last = 0;
    axis.changed.on(() => {
      if (performance.now() - last < DRAW_EVERY_MS || !this.panel.checkVisibility()) return;
      last = performance.now();
      for (const plot of this.open) plot.draw();
    });
  }

  async load(scene: Scene): Promise<void> {
    const { devices } = await this.link.ask<{ devices: Device[] }>("GET", "/v1/devices");
    const { channels } = await this.link.ask<{ channels: Channel[] }>("GET", "/v1/channels");
    const arms = devices.filter((one) => one.kind === "arm");
    this.sources = [
      ...arms.flatMap(({ name }) =>
        ARM_VALUES.map(([value, words]): Source => ({ title: `${name}: ${words}`, watched: { arm: name, value } })),
      ),
      ...scene.sensors.map(({ name }): Source => ({ title: `${name}: wrench`, watched: { sensor: name } })),
      ...channels.map(({ name }): Source => ({ title: `channel ${name}`, watched: { channel: name } })),
    ];
    this.offer([]);
    if (this.open.size === 0) this.plot(this.sources.find((one) => "sensor" in one.watched) ?? this.sources[0]);
  }

  /** Ports of the net that runs may be plotted, too. */
  offerNet(graph: Graph | null): void {
    this.offer(
      graph === null
        ? []
        : graph.primitives.flatMap((primitive) =>
            primitive.outputs
              .filter((port) => port.type !== "String")
              .map((port): Source => ({
                title: `net ${graph.net}: ${primitive.id}.${port.name}`,
                watched: { net: graph.net, port: `${primitive.id}.${port.name}` },
              })),
          ),
    );
  }

  private offer(ports: Source[]): void {
    const all = [...this.sources, ...ports];
    const before = this.select.value;
    this.select.replaceChildren(...all.map((one, i) => h("option", { value: i }, one.title)));
    this.select.selectedIndex = Math.max(
      0,
      all.findIndex((_, i) => String(i) === before),
    );
    this.offered = all;
  }
  private offered: Source[] = [];

  private add(): void {
    this.plot(this.offered[Number(this.select.value)]);
  }

  private plot(source: Source | undefined): void {
    if (!source) return;
    const plot = new Plot(
      source.title,
      this.axis,
      (take, refused) => this.link.monitor(source.watched, SAMPLE_EVERY_S, take, refused),
      this.link,
      () => this.open.delete(plot),
    );
    this.open.add(plot);
    this.cards.prepend(plot.card);
  }
}

type Begin = (take: (entry: Entry) => void, refused: (why: string) => void) => () => void;

class Plot {
  readonly card: HTMLElement;
  private readonly place = h("div", { class: "plot" });
  private readonly note = h("p", { class: "quiet" }, "No value yet");
  private times: number[] = [];
  private columns: (number | null)[][] = [];
  private chart: uPlot | null = null;
  private readonly end: () => void;

  constructor(
    private readonly title: string,
    private readonly axis: TimeAxis,
    begin: Begin,
    private readonly link: Link,
    closed: () => void,
  ) {
    const close = h(
      "button",
      {
        type: "button",
        class: "close",
        "aria-label": `Close the plot of ${title}`,
        click: () => {
          this.close();
          closed();
        },
      },
      "×",
    );
    this.card = h(
      "section",
      { class: "card", "aria-label": title },
      h("header", {}, h("h2", {}, title), close),
      this.place,
      this.note,
    );
    const stopCursor = axis.cursorMoved.on((time) => this.showCursor(time));
    const stop = begin(
      (entry) => this.take(entry),
      (why) => setText(this.note, why),
    );
    const watch = new ResizeObserver(() => this.chart?.setSize({ width: this.place.clientWidth, height: HEIGHT }));
    watch.observe(this.place);
    this.end = () => {
      stop();
      stopCursor();
      watch.disconnect();
    };
  }

  draw(): void {
    if (!this.chart || this.times.length === 0) return;
    const { from, to } = this.axis;
    this.chart.batch(() => {
      this.chart?.setData([this.times, ...this.columns] as uPlot.AlignedData, false);
      this.chart?.setScale("x", { min: from, max: to });
    });
    if (this.axis.cursor !== null) this.showCursor(this.axis.cursor);
  }

  private take({ type, value, cycle }: Entry): void {
    const time = cycle * this.link.period_s;
    if (this.times.length > 0 && time < (this.times.at(-1) ?? 0)) this.forget();
    if (typeof value === "string") return setText(this.note, value);
    if (this.columns.length === 0) {
      if (value === null) return setText(this.note, "null");
      this.columns = value.map(() => []);
      this.begin(partsOf(type, value.length));
    }
    this.times.push(time);
    this.columns.forEach((column, i) => column.push(value === null ? null : (value[i] ?? null)));
    if (this.times.length > MOST_SAMPLES * 1.2) {
      this.times.splice(0, this.times.length - MOST_SAMPLES);
      for (const column of this.columns) column.splice(0, column.length - MOST_SAMPLES);
    }
  }

  private begin(parts: string[]): void {
    this.note.hidden = true;
    const text = (): string => getComputedStyle(document.documentElement).getPropertyValue("--quiet");
    const line = (): string => getComputedStyle(document.documentElement).getPropertyValue("--line");
    const axis = {
      stroke: text,
      grid: { stroke: line, width: 1 },
      ticks: { stroke: line, width: 1 },
      font: "11px system-ui, sans-serif",
    };
    this.chart = new uPlot(
      {
        width: this.place.clientWidth || 400,
        height: HEIGHT,
        scales: { x: { time: false } },
        axes: [
          { ...axis, size: 24 },
          { ...axis, size: 52 },
        ],
        legend: { live: true },
        cursor: { y: false, points: { size: 6 } },
        series: [
          { label: "s", value: (_, value) => (value === null ? "" : value.toFixed(2)) },
          ...parts.map((label, i) => ({
            label,
            stroke: COLORS[i % COLORS.length] ?? "",
            width: 1.5,
            points: { show: false },
            value: (_: uPlot, value: number | null) => (value === null ? "" : value.toPrecision(4)),
          })),
        ],
        hooks: {
          setCursor: [
            (chart) => {
              if (chart.root.matches(":hover"))
                this.axis.setCursor(
                  (chart.cursor.left ?? -1) >= 0 ? chart.posToVal(chart.cursor.left ?? 0, "x") : null,
                );
            },
          ],
        },
      },
      [[], ...this.columns.map(() => [])] as unknown as uPlot.AlignedData,
      this.place,
    );
    this.chart.root.setAttribute("aria-label", `Plot of ${this.title}`);
    this.chart.root.setAttribute("role", "img");
  }

  private showCursor(time: number | null): void {
    if (!this.chart || this.chart.root.matches(":hover")) return;
    this.chart.setCursor(
      { left: time === null ? -10 : this.chart.valToPos(time, "x"), top: time === null ? -10 : HEIGHT / 3 },
      false,
    );
  }

  private forget(): void {
    this.times = [];
    this.columns = this.columns.map(() => []);
  }

  private close(): void {
    this.end();
    this.chart?.destroy();
    this.card.remove();
  }
}
