// Which nets there are, why one was rejected, and one of them as a graph with live values and its certificate.
import { wordsOf, type CellEvent, type Graph, type NetState, type Reaction } from "./api";
import { h, setText, svg } from "./dom";
import { NULL, short } from "./format";
import { BOX, layout, type Box } from "./graph_layout";
import type { Link } from "./link";

const MOST_NETS = 40;
const MOST_VALUES = 40; // monitors of a stream are bounded
const VALUES_EVERY_S = 0.1;
const ACTIVE = new Set(["Running", "Canceling"]);

export class Nets {
  readonly panel = h("div", { class: "nets" });
  private readonly list = h("ul", { class: "netlist", "aria-label": "Nets, the newest first" });
  private readonly detail = h("div", { class: "netdetail" });
  private readonly states = new Map<number, NetState>();
  private stop: (() => void)[] = [];
  private chosen = 0;
  private visible = false;
  private planned = false;

  constructor(private readonly link: Link) {
    this.panel.append(this.list, this.detail);
    this.render();
  }

  show(visible: boolean): void {
    this.visible = visible;
    if (visible) void this.open(this.chosen || this.newest());
    else this.stopValues();
  }

  clear(): void {
    this.states.clear();
    this.chosen = 0;
    this.stopValues();
    this.detail.replaceChildren();
    this.render();
  }

  hear(events: CellEvent[]): void {
    for (const { net, kind, state, cause, text } of events) {
      if (!net || kind !== "state" || state === undefined) continue;
      this.states.set(net, { ...(this.states.get(net) ?? unknown(net)), state, cause, cause_text: text });
    }
    const numbers = [...this.states.keys()].sort((a, b) => b - a);
    for (const old of numbers.slice(MOST_NETS)) this.states.delete(old);
    if (this.planned) return;
    this.planned = true;
    // Many events come at once: what is still there after them is asked for, once.
    setTimeout(() => {
      this.planned = false;
      void this.refresh(
        [...this.states.values()].filter((one) => ACTIVE.has(one.state) && !one.name).map((one) => one.net),
      );
    }, 60);
  }

  /** Nets that a client loads make no event until they start. */
  async refreshList(): Promise<void> {
    const { nets } = await this.link.ask<{ nets: { net: number; state: string }[] }>("GET", "/v1/nets");
    const changed = nets.filter(({ net, state }) => this.states.get(net)?.state !== state);
    if (changed.length > 0) await this.refresh(changed.map(({ net }) => net));
  }

  private async refresh(nets: number[]): Promise<void> {
    for (const net of nets) {
      try {
        this.states.set(net, await this.link.ask<NetState>("GET", `/v1/nets/${net}`));
      } catch {
        // It was forgotten meanwhile: what the events said of it stays.
      }
    }
    this.render();
    const newest = this.newest();
    if (this.visible && newest !== this.chosen && !ACTIVE.has(this.states.get(this.chosen)?.state ?? ""))
      void this.open(newest);
  }

  /** The number of the newest net that runs; 0: none does. */
  private newest(): number {
    return Math.max(0, ...[...this.states.values()].filter((one) => ACTIVE.has(one.state)).map((one) => one.net));
  }

  private render(): void {
    const items = [...this.states.values()]
      .sort((a, b) => b.net - a.net)
      .map((one) => {
        const state = h("span", { class: "state", "data-state": one.state }, one.state);
        const button = h(
          "button",
          { type: "button", "aria-pressed": String(one.net === this.chosen), click: () => void this.open(one.net) },
          h("b", {}, String(one.net)),
          h("span", {}, one.name || "net"),
          state,
        );
        const why =
          one.state === "Rejected"
            ? one.diagnostics.map((each) =>
                h("p", { class: "why" }, `${each.pointer ?? ""} ${each.message ?? ""}. ${each.hint ?? ""}`),
              )
            : [];
        return h("li", {}, button, ...why);
      });
    this.list.replaceChildren(...(items.length ? items : [h("li", { class: "quiet" }, "No net has run yet")]));
  }

  private stopValues(): void {
    for (const end of this.stop.splice(0)) end();
  }

  private async open(net: number): Promise<void> {
    this.stopValues();
    this.chosen = net;
    this.render();
    if (!net) return;
    try {
      const graph = await this.link.ask<Graph>("GET", `/v1/nets/${net}/graph`);
      const { reactions } = await this.link.ask<{ reactions: Reaction[] }>("GET", `/v1/nets/${net}/report`);
      if (this.chosen === net)
        this.detail.replaceChildren(this.draw(graph), certificate(reactions, this.link.period_s));
    } catch (error) {
      this.detail.replaceChildren(h("p", { class: "quiet" }, wordsOf(error)));
    }
  }

  private draw(graph: Graph): HTMLElement {
    const { boxes, width, height } = layout(graph);
    const picture = svg("svg", {
      viewBox: `-8 -8 ${width + 16} ${height + 16}`,
      width: width + 16,
      height: height + 16,
      role: "img",
      "aria-label": `Net ${graph.net}: ${graph.primitives.length} primitives`,
    });
    for (const link of graph.links) {
      const from = boxes[link.from];
      const to = boxes[link.to];
      if (from && to)
        picture.append(
          svg("path", {
            d: path(from, to),
            class: `wire${link.delayed ? " delayed" : ""}${link.may_be_null ? " nullable" : ""}`,
          }),
        );
    }
    const running = ACTIVE.has(this.states.get(graph.net)?.state ?? "");
    graph.primitives.forEach((primitive, i) => {
      const box = boxes[i];
      if (!box) return;
      const value = svg("text", { x: 8, y: 51, class: "value" });
      const id = readable(primitive.id);
      picture.append(
        svg(
          "g",
          { transform: `translate(${box.x} ${box.y})`, class: "primitive" },
          svg("rect", { width: BOX.width, height: BOX.height, rx: 5 }),
          svg("text", { x: 8, y: 18, class: "id" }, id.length > 24 ? `…${id.slice(-23)}` : id),
          svg("text", { x: 8, y: 34, class: "type" }, primitive.type),
          value,
          svg("title", {}, `${id} (${primitive.type})`),
        ),
      );
      const output = primitive.outputs[0];
      if (!output || !running || !this.visible || this.stop.length >= MOST_VALUES) return;
      this.stop.push(
        this.link.monitor({ net: graph.net, port: `${primitive.id}.${output.name}` }, VALUES_EVERY_S, (entry) => {
          const text = short(entry);
          setText(value, text.length > 24 ? `${text.slice(0, 23)}…` : text);
          value.classList.toggle("null", text === NULL);
        }),
      );
    });
    const drives = graph.resources.length ? ` drives ${graph.resources.join(", ")}` : "";
    const title = (graph.name || `net ${graph.net}`) + drives;
    return h(
      "figure",
      { class: "graph" },
      h("figcaption", {}, title),
      h("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Graph, scrollable" }, picture),
    );
  }
}

/** Ids write what a name may not have as % and two digits. */
function readable(id: string): string {
  try {
    return decodeURIComponent(id);
  } catch {
    return id;
  }
}

const unknown = (net: number): NetState => ({
  net,
  name: "",
  state: "",
  cause: "",
  cause_text: "",
  first_cycle: -1,
  last_cycle: -1,
  diagnostics: [],
});

function path(from: Box, to: Box): string {
  const [x1, y1, x2, y2] = [from.x + BOX.width, from.y + BOX.height / 2, to.x, to.y + BOX.height / 2];
  const bend = Math.max(24, Math.abs(x2 - x1) / 2);
  return `M${x1} ${y1}C${x1 + bend} ${y1} ${x2 - bend} ${y2} ${x2} ${y2}`;
}

function certificate(reactions: Reaction[], period_s: number): HTMLElement {
  const ms = (cycles: number): string => `${cycles} (${(1000 * cycles * period_s).toFixed(1)} ms)`;
  const rows = reactions.map((one) =>
    h(
      "tr",
      {},
      h("td", {}, one.source),
      h("td", {}, one.sink),
      h("td", {}, one.data_dependent ? `${one.maximum_cycles} and more` : ms(one.maximum_cycles)),
    ),
  );
  if (rows.length === 0) return h("p", { class: "quiet" }, "The net reacts to nothing: it has no certificate.");
  const head = h("tr", {}, ...["From", "To", "At most, cycles"].map((text) => h("th", { scope: "col" }, text)));
  return h(
    "details",
    {},
    h("summary", {}, `Certificate: ${rows.length} reactions`),
    h("table", {}, h("thead", {}, head), h("tbody", {}, ...rows)),
  );
}
