// What happened, in words, the newest first.
import type { CellEvent, LogEntry } from "./api";
import { h } from "./dom";

const MOST = 500;

export class Events {
  readonly panel = h("div");
  private readonly list = h("ol", { class: "events" });

  constructor() {
    this.panel.append(this.list);
    this.clear();
  }

  clear(): void {
    this.list.replaceChildren(h("li", { class: "quiet" }, "Nothing has happened yet"));
  }

  hear(events: CellEvent[], period_s: number): void {
    this.add(
      events
        .slice(-MOST)
        .map((event) =>
          line(
            event.cycle * period_s,
            event.net ? `net ${event.net}` : "core",
            `${event.state ?? event.kind} ${event.text}`,
            event.kind === "refused" || event.kind === "stopped",
          ),
        ),
    );
  }

  read(entries: LogEntry[]): void {
    this.add(
      entries
        .slice(-MOST)
        .map((entry) =>
          line(
            entry.time_s,
            entry.source,
            `${entry.name} ${entry.text}`,
            entry.level === "warning" || entry.level === "error",
          ),
        ),
    );
  }

  private add(lines: HTMLLIElement[]): void {
    if (lines.length === 0) return;
    this.list.querySelector(".quiet")?.remove();
    this.list.prepend(...lines.reverse());
    while (this.list.childElementCount > MOST) this.list.lastElementChild?.remove();
  }
}

function line(time_s: number, who: string, what: string, bad: boolean): HTMLLIElement {
  const item = h(
    "li",
    {},
    h("span", { class: "time" }, `${time_s.toFixed(3)} s`),
    h("b", {}, who),
    h("span", {}, what),
  );
  item.toggleAttribute("data-bad", bad);
  return item;
}
