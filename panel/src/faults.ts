// What stands in the way, and what went wrong: cause, time, what to do next.
import type { CellEvent, Fault, LogEntry } from "./api";
import { h } from "./dom";

const MOST = 200;
const HINTS: Record<string, string> = {
  aborted: "Find out who stopped it, then begin again",
  device: "Look at the device, remove the cause and reset it",
  guard: "Check what the guard watches before you go on",
  "null input": "Find out which value is missing: the certificate of the net shows its way",
  overrun: "Give the core a quieter machine, or a longer cycle",
  exception: "Look into the log of the server: a primitive has failed",
  conflict: "Let the net that has the device come to its end first",
  error: "Read the cause; the net has reported it itself",
};

export interface Trouble {
  time_s: number;
  what: string;
  cause: string;
  hint: string;
}

export class Faults {
  readonly panel = h("div");
  private readonly now = h("ul", { class: "faults", "aria-label": "Now" });
  private readonly before = h("ol", { class: "faults", "aria-label": "Before" });
  private active: Fault[] = [];

  /** @param count  hears how many there are now */
  constructor(
    private readonly period: () => number,
    private readonly count: (now: number) => void,
  ) {
    this.panel.append(h("h2", {}, "Now"), this.now, h("h2", {}, "Before"), this.before);
    this.render();
    this.empty();
  }

  show(active: Fault[]): void {
    if (JSON.stringify(active) === JSON.stringify(this.active)) return;
    this.active = active;
    this.render();
    this.count(active.length);
  }

  hear(events: CellEvent[]): void {
    for (const event of events) {
      const failed =
        event.kind === "refused" ||
        event.kind === "stopped" ||
        (event.kind === "state" && event.state === "Terminated" && event.cause in HINTS);
      if (!failed) continue;
      const what = event.kind === "refused" ? `request ${event.request}` : event.net ? `net ${event.net}` : "all nets";
      this.add({
        time_s: event.cycle * this.period(),
        what,
        cause: event.text || event.cause,
        hint: HINTS[event.cause] ?? "Read the cause, then ask again",
      });
    }
  }

  read(entries: LogEntry[]): void {
    for (const { level, time_s, source, step, text, name } of entries)
      if (level === "error" || level === "warning")
        this.add({
          time_s,
          what: step || source,
          cause: text || name,
          hint: level === "error" ? "The program has not held; read its findings" : "",
        });
  }

  clear(): void {
    this.before.replaceChildren();
    this.empty();
  }

  private render(): void {
    const items = this.active.map((one) =>
      item({ time_s: one.time_s, what: one.device, cause: one.cause, hint: one.hint }),
    );
    this.now.replaceChildren(...(items.length ? items : [h("li", { class: "quiet" }, "Nothing stands in the way")]));
  }

  private empty(): void {
    this.before.replaceChildren(h("li", { class: "quiet" }, "Nothing has gone wrong so far"));
  }

  private add(trouble: Trouble): void {
    this.before.querySelector(".quiet")?.remove();
    this.before.prepend(item(trouble));
    while (this.before.childElementCount > MOST) this.before.lastElementChild?.remove();
  }
}

function item({ time_s, what, cause, hint }: Trouble): HTMLLIElement {
  const parts = [h("span", { class: "time" }, `${time_s.toFixed(3)} s`), h("strong", {}, what), h("span", {}, cause)];
  if (hint) parts.push(h("em", {}, hint));
  return h("li", {}, ...parts);
}
